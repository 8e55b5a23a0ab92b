//! Arguments, progress, exit codes: the only room that prints.

mod args;
mod progress;
mod report;

use crate::flow::{Event, FlowError};
use crate::scene;
use args::{Arguments, Verb};
use clap::Parser;
use progress::Progress;
use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

/// Runs the command line; usage errors end the process with 2, as clap has it.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", chain(&error));
            ExitCode::from(code(&error))
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), FlowError> {
    if let Some(threads) = arguments.common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().map_err(|e| FlowError::Io {
            path: "threads".into(),
            source: io::Error::other(e),
        })?;
    }
    let common = &arguments.common;
    let mut progress = Progress::new(common.quiet);
    match &arguments.verb {
        Verb::Check { recipe } => {
            let (recipe, scene) = scene::load(&recipe.recipe, &recipe.overrides)?;
            for warning in &scene.warnings {
                progress.show(&Event::Warning(warning));
            }
            if common.json {
                return print(&report::json(&scene));
            }
            print(&report::text(&scene))?;
            if common.verbose {
                print(&format!("\n{}", recipe.to_toml()))?;
            }
            Ok(())
        }
    }
}

/// Data on stdout; a reader that has left, such as `head`, is not an error.
fn print(text: &str) -> Result<(), FlowError> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(FlowError::Io {
            path: "stdout".into(),
            source: e,
        }),
        _ => Ok(()),
    }
}

/// 0 done, 1 other, 2 usage, 3 bad recipe or mesh, 4 the simulation diverged, 5 a check differs, 75 stopped by a
/// signal and resumable.
fn code(error: &FlowError) -> u8 {
    match error {
        FlowError::NoFrames { .. } => 2,
        FlowError::Scene(_) | FlowError::Input { .. } => 3,
        FlowError::Cache(_)
        | FlowError::Occupied { .. }
        | FlowError::Missing { .. }
        | FlowError::Io { .. } => 1,
    }
}

/// The error and its causes in one line each.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}
