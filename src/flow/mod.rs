//! Stages: files in, files out, and only what is stale runs.

mod bone;
mod doubts;
mod error;
mod export;
mod fillings;
mod folder;
mod forecast;
mod frames;
mod golden;
mod kept;
mod leaks;
mod made;
mod movers;
mod overview;
mod permeability;
mod preview;
mod restart;
mod simulate;
mod slices;
mod stage;
mod stamp;
mod surface;
mod throats;
mod tint;
mod turntable;
mod voxelise;

pub use doubts::doubts;
pub use error::FlowError;
pub use folder::Folder;
pub use forecast::{Forecast, Outlook, StageForecast};
pub use frames::FrameRange;
pub use golden::Golden;
pub use made::{draw_three_sides, write_bone_section};
pub use overview::sheet;
pub use stage::Stage;

use crate::bone::BoneReport;
use crate::cache::{self, Frame};
use crate::scene::{self, Finding, Recipe, Scene};
use crate::sim::Simulation;
use rayon::prelude::*;
use serde_json::{Value, json};
use stamp::{Inputs, Stamp};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A recipe and the folder where its results go.
#[derive(Clone, Debug)]
pub struct Job {
    /// What is to be made.
    pub scene: Scene,
    /// Where it goes.
    pub folder: Folder,
    /// Only these frames, for the stages after the simulation.
    pub frames: Option<FrameRange>,
    /// Go on with a simulation that was stopped.
    pub resume: bool,
    /// Set from outside: stop as soon as what is done can be kept.
    pub stop: Arc<AtomicBool>,
    /// Draw the start in the first view as soon as it is there, while the simulation goes on.
    pub early_picture: bool,
    /// Run even what is fresh; chosen frames, even if the simulation did not reach its end.
    pub force: bool,
}

/// What there is to tell while a stage runs.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// What is allowed but unlikely to be meant.
    Warning(&'a Finding),
    /// Something about a file from outside that its owner should know.
    Note(&'a Path, &'a str),
    /// A bone was built from this file: what was asked and what was made.
    Bone(&'a Path, &'a BoneReport),
    /// A stage begins.
    Started(Stage),
    /// A stage has nothing to do: its results are what they would be.
    Fresh(Stage),
    /// A stage has finished.
    Finished {
        /// Which.
        stage: Stage,
        /// How long it took [s].
        seconds: f64,
    },
    /// The simulation has made a step towards a frame.
    Step(FrameReport),
    /// A frame is on disk.
    Frame(FrameReport),
    /// The start has been drawn, before the simulation has ended.
    Picture(&'a Path),
}

/// How a simulation stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameReport {
    /// The frame just written, or being made.
    pub frame: u32,
    /// The last frame there will be.
    pub last: u32,
    /// Simulated time [s].
    pub time: f64,
    /// The last step [s].
    pub dt: f64,
    /// What limited it.
    pub limit: &'static str,
    /// Iterations of the solvers in the last step.
    pub iterations: usize,
    /// Mean excess of density at the last frame [1].
    pub compression: f64,
    /// Simulated time at which this run began, and at which it will end [s].
    pub span: [f64; 2],
    /// Wall-clock time since it began [s].
    pub elapsed: f64,
}

/// Receives events; the only way in which stages speak.
pub type Observer<'a> = dyn FnMut(Event<'_>) + 'a;

impl Job {
    /// Reads the recipe (made coarser and shorter if `quick`), opens the folder and locks the recipe into it.
    pub fn open(
        recipe: &Path,
        overrides: &[String],
        quick: bool,
        out: &Path,
        force: bool,
        observer: &mut Observer<'_>,
    ) -> Result<Self, FlowError> {
        let alter = if quick { Recipe::quick } else { Recipe::clone };
        let (said, scene) = scene::load_as(recipe, overrides, alter)?;
        for warning in &scene.warnings {
            observer(Event::Warning(warning));
        }
        let folder = Folder::open(out, &scene.name, force)?;
        let anchored = said.anchored(recipe.parent().unwrap_or(Path::new("")));
        cache::write(&folder.lock(), anchored.to_toml().as_bytes())?;
        Ok(Self {
            scene,
            folder,
            frames: None,
            resume: false,
            stop: Arc::default(),
            early_picture: false,
            force,
        })
    }

    /// The simulation at its start, among the walls that `voxelise` left.
    pub fn simulation(&self) -> Result<Simulation, FlowError> {
        simulate::start(self)
    }

    /// Runs one stage if its results are missing or stale.
    pub fn run(&self, stage: Stage, observer: &mut Observer<'_>) -> Result<(), FlowError> {
        let work = match stage {
            Stage::Voxelise => voxelise::work,
            Stage::Simulate => simulate::work,
            Stage::Surface => surface::work,
            Stage::Export => export::work,
            Stage::Preview => preview::work,
        };
        self.perform(stage, observer, work)
    }

    /// Runs one stage if its results are missing or stale. `work` writes the stage's files.
    ///
    /// With `frames` chosen, a stage after the simulation writes these only and leaves the others, and the stage
    /// counts as stale or fresh as before.
    fn perform(
        &self,
        stage: Stage,
        observer: &mut Observer<'_>,
        work: impl FnOnce(&Self, &mut Observer<'_>) -> Result<(), FlowError>,
    ) -> Result<(), FlowError> {
        let partial = self.frames.is_some() && stage > Stage::Simulate;
        let inputs = match Inputs::of(stage, &self.scene, &self.folder) {
            Err(FlowError::Missing { .. }) if partial && self.force => None,
            inputs => Some(inputs?),
        };
        if !self.force && !partial && stamp::fresh(stage, &self.scene, &self.folder)?.is_some() {
            observer(Event::Fresh(stage));
            return Ok(());
        }
        self.heed(None)?;
        let goes_on = match &inputs {
            Some(inputs) if stage == Stage::Simulate => restart::goes_on(self, inputs, observer)?,
            _ => false,
        };
        observer(Event::Started(stage));
        let started = Instant::now();
        if !partial {
            // Stamp first: results that are being replaced must not count as finished.
            self.folder.clear(&[&format!("stamps/{stage}.json")])?;
        }
        // What is exported of a frame stays where it is what it would be again.
        let keeps = stage == Stage::Export && !self.force;
        if !partial && !goes_on && !keeps {
            self.folder.clear(stage.owns())?;
            if stage == Stage::Simulate {
                self.folder.clear(&["restart"])?;
            }
        }
        work(self, observer)?;
        let seconds = started.elapsed().as_secs_f64();
        if let Some(inputs) = inputs.filter(|_| !partial) {
            Stamp::write(stage, &self.folder, inputs, seconds)?;
            self.write_run_info()?;
        }
        observer(Event::Finished { stage, seconds });
        Ok(())
    }

    /// Ends the work if a stop was asked for; `time` [s] is how far a simulation came.
    fn heed(&self, time: Option<f64>) -> Result<(), FlowError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(FlowError::Stopped { time });
        }
        Ok(())
    }

    /// `run.json`: what made these files, on what machine, how long it took.
    fn write_run_info(&self) -> Result<(), FlowError> {
        let stamps = Stage::ALL.into_iter().filter_map(|stage| {
            let stamp = Stamp::read(stage, &self.folder)?;
            let id = format!("{:08x}", stamp.id());
            Some((stage.name(), json!({ "seconds": stamp.seconds, "id": id })))
        });
        let simulation: Option<Value> = std::fs::read(self.folder.simulation_report())
            .ok()
            .and_then(|text| serde_json::from_slice(&text).ok());
        let info = json!({
            "program": env!("CARGO_PKG_NAME"),
            "version": env!("CARGO_PKG_VERSION"),
            "recipe": self.scene.name,
            "seed": self.scene.sim.seed,
            "machine": {
                "system": std::env::consts::OS,
                "architecture": std::env::consts::ARCH,
                "threads": rayon::current_num_threads(),
            },
            "simulation": simulation,
            "stages": stamps.collect::<BTreeMap<_, _>>(),
        });
        Ok(cache::write_json(&self.folder.run_info(), &info)?)
    }
}

/// Does `work` for each of the `frames`, in their order. Two at a time: what one frame cannot spread over
/// threads is hidden by the other, and no more than two are in memory.
fn each_frame<T: Send>(
    job: &Job,
    frames: &[u32],
    work: impl Fn(&Frame) -> Result<T, FlowError> + Sync,
) -> Result<Vec<T>, FlowError> {
    let mut results = Vec::new();
    for pair in frames.chunks(2) {
        job.heed(None)?;
        let done = pair
            .par_iter()
            .map(|&n| work(&cache::read_frame(&job.folder.frame(n))?))
            .collect::<Result<Vec<_>, FlowError>>()?;
        results.extend(done);
    }
    Ok(results)
}

#[cfg(test)]
mod tests;
