//! Files that are there whole or not at all: written beside their place, then renamed.

use super::CacheError;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file, making its folder if need be.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CacheError> {
    write_with(path, |file| file.write_all(bytes))
}

/// The same, as `fill` writes it.
pub(super) fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), CacheError> {
    let failed = |e| CacheError::io(path, e);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".partial");
    let written = File::create(&temporary).and_then(|mut file| {
        fill(&mut file)?;
        // On disk before it takes the place of what was there: not even a power cut leaves half of it.
        file.sync_data()?;
        fs::rename(&temporary, path)
    });
    written.map_err(|e| {
        // What is half written is of no use, and may be what fills the disk.
        let _ = fs::remove_file(&temporary);
        failed(e)
    })
}

/// Writes readable JSON.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), CacheError> {
    let mut text =
        serde_json::to_vec_pretty(value).map_err(|e| CacheError::damaged(path, e.to_string()))?;
    text.push(b'\n');
    write(path, &text)
}
