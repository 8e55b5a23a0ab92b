//! A folder for what is only rehearsed: gone when it is dropped.

use crate::flow::FlowError;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of its own among the system's temporary ones.
pub(super) struct Scratch(PathBuf);

impl Scratch {
    pub fn new() -> Result<Self, FlowError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let (process, n) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("osteoflow-check-{process}-{n}"));
        fs::create_dir(&path).map_err(FlowError::io(&path))?;
        Ok(Self(path))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed lies among other temporary files.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Copies the files of a folder.
pub(super) fn copy(from: &Path, to: &Path) -> Result<(), FlowError> {
    fs::create_dir_all(to).map_err(FlowError::io(to))?;
    for entry in fs::read_dir(from).map_err(FlowError::io(from))? {
        let entry = entry.map_err(FlowError::io(from))?;
        let path = entry.path();
        fs::copy(&path, to.join(entry.file_name())).map_err(FlowError::io(&path))?;
    }
    Ok(())
}
