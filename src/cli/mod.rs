//! Arguments, progress, exit codes: the only room that prints.

mod args;
mod check;
mod make;
mod progress;
mod report;
mod study;

use crate::flow::{self, Event, FlowError, Folder, Forecast, Golden, Job, Outlook, Stage};
use crate::scene::{self, Recipe};
use crate::sim::SimError;
use crate::study::StudyError;
use args::{
    Arguments, BoneArguments, CheckArguments, Common, PreviewArguments, Verb, WorkArguments,
};
use clap::Parser;
use progress::{Progress, put};
use std::error::Error;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs the command line; usage errors end the process with 2, as clap has it.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match with_threads(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", chain(&error));
            ExitCode::from(code(&error))
        }
    }
}

/// What can go wrong, by who says so.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Flow(#[from] FlowError),
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Stack of a thread, as the first one of a program has it.
const STACK: usize = 8 << 20;

/// Runs among the threads that share the work, as one of them: work handed in from outside waits for two of them to wake.
fn with_threads(arguments: &Arguments) -> Result<(), Failure> {
    let threads = arguments.common.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK)
        .build()
        .map_err(|e| FlowError::Io {
            path: "threads".into(),
            source: io::Error::other(e),
        })?;
    pool.install(|| run(arguments))
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    let mut progress = Progress::new(common.quiet);
    match &arguments.verb {
        Verb::Check(what) if check::is_other(&what.recipe.recipe) => {
            check::check(what, common.json)
        }
        Verb::Check(what) => {
            let recipe = &what.recipe;
            let path = &recipe_of(&recipe.recipe)?;
            let alter = if recipe.quick {
                Recipe::quick
            } else {
                Recipe::clone
            };
            let (recipe, scene) =
                scene::load_as(path, &recipe.overrides, alter).map_err(FlowError::from)?;
            for warning in &scene.warnings {
                progress.show(&Event::Warning(warning));
            }
            for doubt in flow::doubts(&scene)? {
                progress.show(&Event::Note(path, &doubt));
            }
            let forecast = if what.brief {
                None
            } else {
                Some(ahead(what, &mut progress)?)
            };
            if common.json {
                return print(&report::json(&scene, forecast.as_ref()));
            }
            print(&report::text(&scene, forecast.as_ref()))?;
            if common.verbose {
                print(&format!("\n{}", recipe.to_toml()))?;
            }
            Ok(())
        }
        Verb::Voxelise(bone) => with_bone(bone, &[Stage::Voxelise], common, &mut progress),
        Verb::Simulate(work) => stages(work, &[Stage::Simulate], common, &mut progress),
        Verb::Surface(work) => stages(work, &[Stage::Surface], common, &mut progress),
        Verb::Export(work) => stages(work, &[Stage::Export], common, &mut progress),
        Verb::Preview(preview) => pictures(preview, common, &mut progress),
        Verb::Run(bone) => with_bone(bone, &Stage::ALL, common, &mut progress),
        Verb::Sheet(what) => Ok(flow::sheet(
            &what.folders,
            what.view.as_deref(),
            what.times.into(),
            &what.out,
        )?),
        Verb::Schema => print(&format!("{:#}\n", scene::schema())),
        Verb::Make(shape) => Ok(make::make(shape)?),
        Verb::Verify { cases, work } => study::verify(cases, work, common.quiet, common.json),
        Verb::Study { name, work } => {
            let name = name.as_deref().unwrap_or_default();
            study::study(name, work, common.quiet, common.json)
        }
    }
}

/// What a run of the recipe will take.
fn ahead(what: &CheckArguments, progress: &mut Progress) -> Result<Forecast, Failure> {
    let outlook = Outlook {
        recipe: &recipe_of(&what.recipe.recipe)?,
        overrides: &what.recipe.overrides,
        quick: what.recipe.quick,
        out: what.out.as_deref(),
        stop: Arc::default(),
    };
    heed_signals(&outlook.stop);
    Ok(outlook.forecast(&mut |event: Event<'_>| progress.show(&event))?)
}

fn stages(
    work: &WorkArguments,
    stages: &[Stage],
    common: &Common,
    progress: &mut Progress,
) -> Result<(), Failure> {
    run_stages(work, stages, common, progress).map(|_| ())
}

fn with_bone(
    bone: &BoneArguments,
    stages: &[Stage],
    common: &Common,
    progress: &mut Progress,
) -> Result<(), Failure> {
    let job = run_stages(&bone.work, stages, common, progress)?;
    if bone.permeability {
        job.measure_permeability(&mut |event: Event<'_>| progress.show(&event))?;
    }
    Ok(())
}

fn pictures(
    preview: &PreviewArguments,
    common: &Common,
    progress: &mut Progress,
) -> Result<(), Failure> {
    let job = run_stages(&preview.work, &[Stage::Preview], common, progress)?;
    if let Some(folder) = &preview.golden {
        let golden = Golden {
            folder: folder.clone(),
            exact: preview.exact,
        };
        if preview.bless {
            job.bless(&golden)?;
        } else {
            job.compare(&golden)?;
        }
    }
    Ok(())
}

fn run_stages(
    work: &WorkArguments,
    stages: &[Stage],
    common: &Common,
    progress: &mut Progress,
) -> Result<Job, Failure> {
    let given = &work.recipe.recipe;
    let recipe = &recipe_of(given)?;
    let mut name = recipe.file_stem().unwrap_or(recipe.as_os_str()).to_owned();
    let quick = work.recipe.quick;
    if quick {
        name.push("-quick");
    }
    let usual = || {
        if given.is_dir() {
            given.clone()
        } else {
            Path::new("out").join(name)
        }
    };
    let out = work.out.clone().unwrap_or_else(usual);
    let show = &mut |event: Event<'_>| progress.show(&event);
    let mut job = Job::open(
        recipe,
        &work.recipe.overrides,
        quick,
        &out,
        work.force,
        show,
    )?;
    job.frames = work.frames;
    job.resume = work.resume;
    job.early_picture = stages.contains(&Stage::Preview);
    heed_signals(&job.stop);
    for &stage in stages {
        job.run(stage, show)?;
    }
    if common.json {
        let path = job.folder.run_info();
        print(&fs::read_to_string(&path).map_err(failed(&path))?)?;
    }
    Ok(job)
}

/// The recipe's file: of a folder of results the recipe that they were made of.
fn recipe_of(given: &Path) -> Result<PathBuf, FlowError> {
    if given.is_dir() {
        Ok(Folder::existing(given)?.lock())
    } else {
        Ok(given.to_owned())
    }
}

/// The first signal lets a step or a frame come to its end and be kept; the second ends the program at once.
fn heed_signals(stop: &Arc<AtomicBool>) {
    let stop = stop.clone();
    let handler = move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    // Without a handler a signal ends the program: the state that was written last is kept.
    let _ = ctrlc::set_handler(handler);
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> FlowError {
    let path = path.to_owned();
    move |source| FlowError::Io { path, source }
}

/// Data on stdout; a reader that has left, such as `head`, is not an error.
fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(FlowError::Io {
            path: "stdout".into(),
            source: e,
        }
        .into()),
        _ => Ok(()),
    }
}

/// 0 done, 1 other, 2 usage, 3 bad recipe or mesh, 4 the simulation diverged, 5 worse than it was or looks different,
/// 75 stopped by a signal.
fn code(error: &Failure) -> u8 {
    let error = match error {
        Failure::Flow(error) => error,
        Failure::Study(StudyError::Unknown { .. }) => return 2,
        Failure::Study(StudyError::Run { .. }) => return 4,
        Failure::Study(StudyError::Worse(_)) => return 5,
        Failure::Study(StudyError::Cache(_) | StudyError::Occupied(_) | StudyError::Scene(_)) => {
            return 1;
        }
    };
    match error {
        FlowError::NoFrames { .. }
        | FlowError::NoGolden(_)
        | FlowError::NoResults(_)
        | FlowError::NoPictures { .. } => 2,
        FlowError::Differs { .. } => 5,
        FlowError::Scene(_)
        | FlowError::Input { .. }
        | FlowError::Mesh(_)
        | FlowError::Open { .. }
        | FlowError::Volume(_)
        | FlowError::Unfit { .. }
        | FlowError::NoFrame { .. }
        | FlowError::Bone(_)
        | FlowError::Sim(SimError::TooMany(..) | SimError::NoRoom { .. }) => 3,
        FlowError::Sim(SimError::Diverged { .. } | SimError::Unconverged { .. }) => 4,
        FlowError::Stopped { .. } => 75,
        FlowError::Cache(_)
        | FlowError::Unfinished { .. }
        | FlowError::Changed { .. }
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
