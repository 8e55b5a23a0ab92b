//! What a recipe will cost: particles, steps, time, memory and disk, by doing a little of everything.
//!
//! The walls are made as a run makes them, and particles placed. Where cement is pressed in, half the dose and the whole
//! are laid into the pores nearest to the opening, and some steps of each are timed; without inlets, a run on particles
//! twice as large shows how speed and effort change in its course. From these states surfaces, volumes and pictures are
//! made as after a run, in a temporary folder, and timed and weighed. So the machine's speed and the memory's peak are
//! measured, not assumed; what is assumed is that the rest is like what was tried.

mod cuts;
mod doses;
mod pace;
mod pilot;
mod scratch;
mod spread;
mod trial;

use super::stamp::Stamp;
use super::{Event, FlowError, Folder, Job, Observer, Stage, simulate};
use crate::bone::BoneReport;
use crate::cache;
use crate::math::Real;
use crate::scene::{self, Recipe, Scene};
use crate::sim::Simulation;
use scratch::{Scratch, copy};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use trial::Frames;

/// How much larger particles of a coarse run are.
const COARSER: Real = 2.0;

/// What to look ahead at.
#[derive(Clone, Debug)]
pub struct Outlook<'a> {
    /// The recipe.
    pub recipe: &'a Path,
    /// Overrides of its keys.
    pub overrides: &'a [String],
    /// Coarser and shorter.
    pub quick: bool,
    /// Where walls are to be kept, as `voxelise` would leave them.
    pub out: Option<&'a Path>,
    /// Set from outside: stop.
    pub stop: Arc<AtomicBool>,
}

/// What a run is expected to be.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Forecast {
    /// Particles of cement at the start and at the end.
    pub particles: [usize; 2],
    /// Particles left out because a wall is there.
    pub carved_at_start: usize,
    /// Particles that walls consist of, at rest and moving.
    pub wall_particles: usize,
    /// Steps of the simulation.
    pub steps: u64,
    /// Each stage.
    pub stages: Vec<StageForecast>,
    /// All stages [s].
    pub seconds: f64,
    /// What the output folder will hold [bytes].
    pub disk_bytes: u64,
    /// Most memory at any time [bytes]; none where the system does not tell.
    pub memory_bytes: Option<u64>,
    /// The bone as it was built.
    pub bone: Option<BoneReport>,
}

/// What a stage is expected to take.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StageForecast {
    /// Its verb.
    pub stage: &'static str,
    /// Time [s].
    pub seconds: f64,
    /// What it leaves [bytes].
    pub bytes: u64,
}

/// What became of trying the simulation, with two states of it left as frames 1 and 2.
#[derive(Clone, Copy, Debug)]
struct Tried {
    steps: f64,
    seconds: f64,
    /// Particles at the end.
    end: usize,
    /// Particles of a mean frame, of those that the two hold.
    particles: f64,
    /// Extent of a mean frame's surface, of those of the two.
    surface: f64,
}

impl Outlook<'_> {
    /// Makes the walls, tries a little of each stage, and reckons what all of it will take.
    pub fn forecast(&self, observer: &mut Observer<'_>) -> Result<Forecast, FlowError> {
        let scene = self.scene(1.0)?;
        let scratch = Scratch::new()?;
        let job = self.job(&scene, &scratch.path().join("fine"))?;
        let voxelise = self.walls(&job, observer)?;
        let run = job.simulation()?;
        let mut forecast = Forecast {
            carved_at_start: run.carved,
            wall_particles: run.wall_count(),
            bone: bone(&job)?,
            ..Forecast::default()
        };
        cuts::warn(&job, observer)?;
        let start = run.fluid.len();
        let tried = if scene.sim.inlets.is_empty() {
            let fine = pilot::start(&job, run)?;
            let coarse = scratch.path().join("coarse");
            let coarse = self.scene(COARSER).and_then(|scene| {
                let job = self.job(&scene, &coarse)?;
                job.run(Stage::Voxelise, &mut |_| {})?;
                Ok(job)
            });
            pilot::course(&job, &fine, coarse, observer)?
        } else {
            doses::course(&job, run, observer)?
        };
        forecast.particles = [start, tried.end];
        forecast.steps = tried.steps.ceil() as u64;
        job.heed(None)?;

        let count = f64::from(scene.last_frame() + 1);
        let frames = |share| Frames { count, share };
        let [particles, surface] = [tried.particles, tried.surface].map(frames);
        forecast.stages = vec![
            voxelise,
            StageForecast {
                stage: Stage::Simulate.name(),
                seconds: tried.seconds,
                bytes: trial::weigh(&job, Stage::Simulate, particles)?
                    + fs::metadata(job.folder.restart()).map_or(0, |file| file.len()),
            },
            trial::of(&job, Stage::Surface, surface)?,
            trial::of(&job, Stage::Export, surface)?,
            trial::pictures(&job, particles)?,
        ];
        forecast.seconds = forecast.stages.iter().map(|s| s.seconds).sum();
        forecast.disk_bytes = forecast.stages.iter().map(|s| s.bytes).sum();
        forecast.memory_bytes = peak_memory();
        Ok(forecast)
    }

    /// What the recipe means, on particles so many times as large.
    fn scene(&self, times: Real) -> Result<Scene, FlowError> {
        let alter = |recipe: &Recipe| {
            let quick = self.quick.then(|| recipe.quick());
            let recipe = quick.unwrap_or_else(|| recipe.clone());
            if times == 1.0 {
                recipe
            } else {
                recipe.coarsened(times)
            }
        };
        Ok(scene::load_as(self.recipe, self.overrides, alter)?.1)
    }

    fn job(&self, scene: &Scene, root: &Path) -> Result<Job, FlowError> {
        Ok(Job {
            scene: scene.clone(),
            folder: Folder::open(root, &scene.name, false)?,
            frames: None,
            resume: false,
            stop: self.stop.clone(),
            early_picture: false,
            force: true,
        })
    }

    /// Walls in the job's folder; in the folder for results, if there is one, as well.
    fn walls(&self, job: &Job, observer: &mut Observer<'_>) -> Result<StageForecast, FlowError> {
        let stage = Stage::Voxelise;
        let mut only_notes = |event: Event<'_>| {
            if let Event::Note(..) = event {
                observer(event);
            }
        };
        if let Some(out) = self.out {
            let (recipe, sets) = (self.recipe, self.overrides);
            let mut kept = Job::open(recipe, sets, self.quick, out, false, &mut |_| {})?;
            kept.stop = self.stop.clone();
            kept.run(stage, &mut only_notes)?;
            for part in ["boundary", "stamps"] {
                copy(&out.join(part), &job.folder.root().join(part))?;
            }
        } else {
            job.run(stage, &mut only_notes)?;
        }
        let files = job.folder.files_of(stage.owns())?;
        Ok(StageForecast {
            stage: stage.name(),
            seconds: Stamp::read(stage, &job.folder).map_or(0.0, |stamp| stamp.seconds),
            bytes: files.iter().map(|(_, length)| length).sum(),
        })
    }
}

fn bone(job: &Job) -> Result<Option<BoneReport>, FlowError> {
    if job.scene.bone.is_none() {
        return Ok(None);
    }
    let path = job.folder.bone_report();
    let text = fs::read(&path).map_err(FlowError::io(&path))?;
    let mut report: BTreeMap<String, serde_json::Value> =
        serde_json::from_slice(&text).map_err(|e| FlowError::io(&path)(e.into()))?;
    let made = report.remove("made").unwrap_or_default();
    serde_json::from_value(made).map_err(|e| FlowError::io(&path)(e.into()))
}

/// Most memory that this process has had so far [bytes].
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

/// Leaves a state as a frame, and as what a run goes on from.
fn keep(job: &Job, n: u32, run: &mut Simulation) -> Result<(), FlowError> {
    let pressure = run.pressure();
    cache::write_frame(&job.folder.frame(n), &simulate::frame(n, run, &pressure))?;
    let restart = job.folder.restart();
    Ok(cache::write_restart(
        &restart,
        &run.fluid,
        &run.progress(),
        &(),
    )?)
}
