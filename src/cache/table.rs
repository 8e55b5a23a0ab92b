//! A table that grows by a row at a time and can be read while it does.

use super::{CacheError, atomic};
use std::fs::{self, File};
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

    /// Goes on with a table of the same columns after its first `rows` rows; what follows is dropped, and so is a row
    /// that was cut short.
    pub fn resume(path: &Path, columns: &[&str], rows: usize) -> Result<Self, CacheError> {
        let text = fs::read_to_string(path).map_err(|e| CacheError::io(path, e))?;
        let mut lines = text.split_inclusive('\n');
        // Cut short of its end it would take the next row into its line.
        let header = columns.join(",") + "\n";
        let found = lines.next().unwrap_or_default();
        let kept: Vec<&str> = lines.filter(|l| l.ends_with('\n')).take(rows).collect();
        let whole = |row: &&str| row.split(',').count() == columns.len();
        if found.trim_end() != header.trim_end() || kept.len() != rows || !kept.iter().all(whole) {
            let what = format!("it has not the {rows} rows that it should have by now");
            return Err(CacheError::damaged(path, what));
        }
        atomic::write(
            path,
            [&[&header[..]], &kept[..]].concat().concat().as_bytes(),
        )?;
        let file = File::options().append(true).open(path);
        Ok(Self {
            path: path.to_owned(),
            file: file.map_err(|e| CacheError::io(path, e))?,
            columns: columns.len(),
        })
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
        fs::write(&path, "frame,volume\n1,3e-7\n2,4\n3,").unwrap();
        let columns = ["frame", "volume"];
        assert!(Table::resume(&path, &columns, 3).is_err());
        assert!(Table::resume(&path, &["frame", "other"], 1).is_err());
        let mut table = Table::resume(&path, &columns, 1).unwrap();
        table.row(&["2".into(), "none".into()]).unwrap();
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            "frame,volume\n1,3e-7\n2,none\n"
        );
        assert!(
            std::fs::read_to_string(&path)
                .unwrap()
                .ends_with("2,none\n")
        );
    }
}
