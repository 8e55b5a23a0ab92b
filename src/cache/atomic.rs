//! Files that are there whole or not at all: written beside their place, then renamed.

use super::CacheError;
use serde::Serialize;
use std::fs;
use std::path::Path;

/// Writes a file, making its folder if need be.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CacheError> {
    let failed = |e| CacheError::io(path, e);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".partial");
    fs::write(&temporary, bytes).map_err(failed)?;
    fs::rename(&temporary, path).map_err(failed)
}

/// Writes readable JSON.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), CacheError> {
    let mut text =
        serde_json::to_vec_pretty(value).map_err(|e| CacheError::damaged(path, e.to_string()))?;
    text.push(b'\n');
    write(path, &text)
}
