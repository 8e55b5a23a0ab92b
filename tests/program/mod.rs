//! The program as a user starts it, from the project's folder.

use std::process::{Command, Output};

/// Runs it to its end.
pub fn osteoflow(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_osteoflow"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program starts")
}
