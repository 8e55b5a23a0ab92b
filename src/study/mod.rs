//! Studies: one question, one table, one picture; and `verify`, which holds the program against exact solutions.

mod accuracy;
mod bench;
mod bracket;
mod error;
pub mod exact;
mod max_step;
mod mixing;
mod newtonian;
mod pressure;
pub mod scenes;
mod shear_cell;
mod stress;
mod tank;
mod thinning;
pub mod verify;
mod watch;

pub use bench::{Bench, Level, Voice};
pub use error::StudyError;

use crate::cache;
use crate::report::Table;
use serde_json::{Value, json};
use std::path::Path;

/// A question that can be asked by name.
pub struct Study {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What it answers, in a line.
    pub about: &'static str,
    /// Finds the answer.
    pub answer: fn(&Bench) -> Result<Findings, StudyError>,
}

/// Every study.
pub const STUDIES: &[Study] = &[
    max_step::STUDY,
    mixing::STUDY,
    thinning::STUDY,
    accuracy::STUDY,
    stress::STUDY,
    pressure::STUDY,
];

/// What a study found. The first table and the first picture carry its name alone.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// The answer in words, for the terminal.
    pub summary: String,
    /// Tables by name.
    pub tables: Vec<(String, Table)>,
    /// Pictures by name, as the bytes of PNG files.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// What programs want to know beside the tables.
    pub facts: Value,
}

/// Runs a study, or the part of it that is not done yet, and writes its tables (CSV and JSON) and pictures (PNG)
/// to `folder`; `note` hears how it goes.
pub fn run(
    name: &str,
    level: Level,
    folder: &Path,
    note: &mut Voice,
) -> Result<(Findings, Value), StudyError> {
    let study = STUDIES.iter().find(|study| study.name == name);
    let study =
        study.ok_or_else(|| StudyError::unknown("study", name, STUDIES.iter().map(|s| s.name)))?;
    let bench = Bench::open(folder, level, note)?;
    let findings = (study.answer)(&bench)?;
    let file = |part: &str, ending: &str| {
        let stem = if part.is_empty() {
            name.to_owned()
        } else {
            format!("{name}-{part}")
        };
        folder.join(format!("{stem}.{ending}"))
    };
    for (part, table) in &findings.tables {
        cache::write(&file(part, "csv"), table.to_csv().as_bytes())?;
    }
    for (part, picture) in &findings.pictures {
        cache::write(&file(part, "png"), picture)?;
    }
    let tables = findings.tables.iter().map(|(part, table)| {
        let part = if part.is_empty() { name } else { part };
        (part.to_owned(), table.to_json())
    });
    let report = json!({
        "study": name,
        "version": env!("CARGO_PKG_VERSION"),
        "level": level.name(),
        "facts": findings.facts,
        "tables": tables.collect::<serde_json::Map<_, _>>(),
    });
    cache::write_json(&file("", "json"), &report)?;
    Ok((findings, report))
}
