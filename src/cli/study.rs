//! `verify` and `study`: what they say on the terminal.

use super::args::StudyArguments;
use super::{Failure, print, put};
use crate::study::verify::{self, CASES};
use crate::study::{self, STUDIES, StudyError};
use std::fmt::Write;
use std::path::Path;

/// Runs the cases; worse than recorded is a failure, after everything has been said.
pub(super) fn verify(
    cases: &[String],
    work: &StudyArguments,
    quiet: bool,
    json: bool,
) -> Result<(), Failure> {
    if work.list {
        return print(&list(CASES.iter().map(|case| (case.name, case.about))));
    }
    let folder = work.out.clone();
    let folder = folder.unwrap_or_else(|| Path::new("out").join("verify"));
    let note = &mut move |text: &str| say(quiet, text);
    let verdict = verify::run(cases, work.level.into(), &folder, note)?;
    if json {
        print(&format!("{:#}\n", verdict.report))?;
    } else {
        print(&verdict.table.to_text())?;
    }
    if verdict.worse.is_empty() {
        Ok(())
    } else {
        Err(StudyError::Worse(verdict.worse).into())
    }
}

/// Runs a study.
pub(super) fn study(
    name: &str,
    work: &StudyArguments,
    quiet: bool,
    json: bool,
) -> Result<(), Failure> {
    if work.list {
        return print(&list(STUDIES.iter().map(|study| (study.name, study.about))));
    }
    let folder = work.out.clone();
    let folder = folder.unwrap_or_else(|| Path::new("out").join(format!("study-{name}")));
    let note = &mut move |text: &str| say(quiet, text);
    let (findings, report) = study::run(name, work.level.into(), &folder, note)?;
    if json {
        return print(&format!("{report:#}\n"));
    }
    for (_, table) in findings
        .tables
        .iter()
        .filter(|(_, table)| table.len() <= 60)
    {
        print(&format!("{}\n", table.to_text()))?;
    }
    print(&format!("{}\n{}\n", findings.summary, folder.display()))
}

fn say(quiet: bool, text: &str) {
    if !quiet {
        put(&format!("{text}\n"));
    }
}

fn list(entries: impl Iterator<Item = (&'static str, &'static str)>) -> String {
    let mut text = String::new();
    for (name, about) in entries {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{name:<14} {about}");
    }
    text
}
