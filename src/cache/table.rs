//! A table that grows by a row at a time and can be read while it does.

use super::CacheError;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A CSV file being written: a header, then rows, each on disk before the next.
pub struct Table {
    path: PathBuf,
    file: File,
    columns: usize,
}

impl Table {
    /// Starts a table anew.
    pub fn create(path: &Path, columns: &[&str]) -> Result<Self, CacheError> {
        let mut table = Self {
            path: path.to_owned(),
            file: File::create(path).map_err(|e| CacheError::io(path, e))?,
            columns: columns.len(),
        };
        table.line(&columns.join(","))?;
        Ok(table)
    }

    /// Adds a row: one value a column, as text without commas.
    pub fn row(&mut self, values: &[String]) -> Result<(), CacheError> {
        assert_eq!(values.len(), self.columns, "one value a column");
        self.line(&values.join(","))
    }

    fn line(&mut self, text: &str) -> Result<(), CacheError> {
        let whole = format!("{text}\n");
        let written = self
            .file
            .write_all(whole.as_bytes())
            .and_then(|()| self.file.flush());
        written.map_err(|e| CacheError::io(&self.path, e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_on_disk_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stats.csv");
        let mut table = Table::create(&path, &["frame", "volume"]).unwrap();
        table.row(&["1".into(), "3e-7".into()]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "frame,volume\n1,3e-7\n");
        table.row(&["2".into(), "none".into()]).unwrap();
        assert!(
            std::fs::read_to_string(&path)
                .unwrap()
                .ends_with("2,none\n")
        );
    }
}
