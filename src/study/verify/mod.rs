//! `verify`: the program against exact solutions, case by case, against targets and against its own record.

mod bonding;
mod channel;
mod column;
mod conformation;
mod couette;
mod dam;
mod figure;
mod ledger;
mod needle;
mod phases;
mod record;
mod series;
mod shear;
mod spheres;
mod steps;
mod thinning_channel;
mod waters_king;
mod waves;

pub use figure::{Figure, Goal};

use super::{Bench, Level, StudyError, Voice};
use crate::cache;
use crate::report::{Cell, Plot, Table};
use record::Record;
use serde_json::{Value, json};
use std::path::Path;

/// A case: a flow whose answer is known.
pub struct Case {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What it measures, in a line.
    pub about: &'static str,
    /// Measures.
    measure: fn(&Bench) -> Result<Measured, StudyError>,
}

/// What a case measured.
pub struct Measured {
    figures: Vec<Figure>,
    /// Computed points over exact curves.
    plot: Plot,
}

/// Every case, in the order of the table.
pub const CASES: &[Case] = &[
    conformation::CASE,
    waves::CASE,
    channel::CASE,
    couette::CASE,
    waters_king::CASE,
    thinning_channel::CASE,
    needle::CASE,
    shear::CASE,
    bonding::CASE,
    column::CASE,
    spheres::CASE,
    phases::CASE,
    dam::CASE,
    steps::CASE,
    ledger::CASE,
];

/// How the cases went.
pub struct Verdict {
    /// A row for each figure.
    pub table: Table,
    /// The same for programs.
    pub report: Value,
    /// What is worse than recorded.
    pub worse: Vec<String>,
}

/// Runs the named cases (all if none is named) and writes verify.csv, verify.json and a plot a case to `folder`.
/// A case that falls over is short and worse.
pub fn run(
    names: &[String],
    level: Level,
    folder: &Path,
    note: &mut Voice,
) -> Result<Verdict, StudyError> {
    let mut cases = Vec::new();
    for name in names {
        let case = CASES.iter().find(|case| case.name == name);
        cases.push(
            case.ok_or_else(|| StudyError::unknown("case", name, CASES.iter().map(|c| c.name)))?,
        );
    }
    if cases.is_empty() {
        cases = CASES.iter().collect();
    }
    let record = Record::of_the_project();
    let mut reached = Record::default();
    let bench = Bench::open(folder, level, note)?;
    let mut table = Table::new(&[
        "case",
        "figure",
        "resolution",
        "reached",
        "target",
        "verdict",
        "recorded",
        "seconds",
    ]);
    let mut worse = Vec::new();
    for case in cases {
        bench.note(&format!("{} …", case.name));
        let measured = match (case.measure)(&bench) {
            Ok(measured) => measured,
            Err(StudyError::Run { run, source }) => {
                worse.push(format!("{}: {run}: {source}", case.name));
                continue;
            }
            Err(other) => return Err(other),
        };
        let picture = folder.join(format!("{}.png", case.name));
        cache::write(&picture, &measured.plot.to_png())?;
        for figure in measured.figures {
            let key = format!("{}: {}: {}", level.name(), case.name, figure.what);
            let recorded = record.get(&key);
            if recorded.is_some_and(|r| figure.goal.is_worse(figure.reached, r)) {
                worse.push(format!(
                    "{} {}: {:.3e}",
                    case.name, figure.what, figure.reached
                ));
            }
            reached.set(key, figure.goal.rounded(figure.reached));
            let verdict = if figure.goal.is_met(figure.reached) {
                "met"
            } else {
                "short"
            };
            table.row(vec![
                case.name.into(),
                figure.what.into(),
                figure.resolution.into(),
                figure.reached.into(),
                figure.goal.to_string().into(),
                verdict.into(),
                recorded.map_or(Cell::None, Cell::Number),
                figure.seconds.into(),
            ]);
        }
    }
    let report = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "level": level.name(),
        "figures": table.to_json(),
        "worse_than_recorded": worse,
    });
    cache::write(&folder.join("verify.csv"), table.to_csv().as_bytes())?;
    cache::write_json(&folder.join("verify.json"), &report)?;
    // What the project's own record would say: for whoever makes a figure better.
    cache::write(&folder.join("recorded.toml"), reached.to_toml().as_bytes())?;
    Ok(Verdict {
        table,
        report,
        worse,
    })
}
