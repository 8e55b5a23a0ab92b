//! Real bones and volumes that are not part of the project: found through `OSTEOFLOW_SHARED`, and counted when
//! they are missing.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of the shared folder. Without the folder the test is to be skipped, which is noted in the file that
/// `OSTEOFLOW_SKIPPED` names: test harnesses swallow what passing tests print.
pub fn file(path: &str) -> Option<PathBuf> {
    if let Some(shared) = std::env::var_os("OSTEOFLOW_SHARED") {
        let file = Path::new(&shared).join(path);
        assert!(
            file.exists(),
            "OSTEOFLOW_SHARED is set, but {} is missing",
            file.display()
        );
        return Some(file);
    }
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let note = format!("skipped: {test} (needs {path})\n");
    eprint!("{note}");
    if let Some(notes) = std::env::var_os("OSTEOFLOW_SKIPPED") {
        let notes = OpenOptions::new().create(true).append(true).open(notes);
        notes
            .and_then(|mut notes| notes.write_all(note.as_bytes()))
            .expect("OSTEOFLOW_SKIPPED names a file that can be written");
    }
    None
}
