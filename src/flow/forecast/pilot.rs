//! Cement that moves by itself: the run as it is shows its beginning; a coarse run of all of it how fast it becomes, what
//! bounds its steps, how hard they are to solve, and how its surface grows.

use super::{Tried, keep};
use crate::flow::{Event, FlowError, FrameRange, Job, Observer, Stage};
use crate::math::Vec3;
use crate::sim::{Limit, SimError, Simulation, StepReport, TimeStep, bounds_at_start};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Time for the run as it is [s].
const OWN: f64 = 6.0;
/// Time for the coarse one [s].
const COARSE: f64 = 6.0;
/// Particles of the run as it is cost at most so many times what coarse ones do: few cost more each, but are sooner solved for.
const DEAREST: f64 = 1.5;

/// The run as it is to be: its particles, and how it begins.
pub(super) struct Fine {
    particles: usize,
    voyage: Voyage,
}

/// The start and the last state that there was time for are left as frames 1 and 2.
pub(super) fn start(job: &Job, mut run: Simulation) -> Result<Fine, FlowError> {
    keep(job, 1, &mut run)?;
    let particles = run.fluid.len();
    let mut voyage = Voyage::new(1.0, f64::INFINITY);
    // If it fails, so does the coarse one, which says so.
    let _ = voyage.sail(job, &mut run, OWN, &[])?;
    keep(job, 2, &mut run)?;
    Ok(Fine { particles, voyage })
}

/// Runs `coarse`, which is the job on larger particles. If it is too coarse to be set up, the rest is taken to be like
/// the last third of what was run.
pub(super) fn course(
    job: &Job,
    fine: &Fine,
    coarse: Result<Job, FlowError>,
    observer: &mut Observer<'_>,
) -> Result<Tried, FlowError> {
    let duration = f64::from(job.scene.last_frame()) / job.scene.sim.frames_per_second;
    let begun = coarse.and_then(|coarse| {
        let run = coarse.simulation()?;
        Ok((coarse, run))
    });
    let (coarse, mut run) = match begun {
        Ok((coarse, run)) if !run.fluid.is_empty() => (coarse, run),
        Err(FlowError::Stopped { time }) => return Err(FlowError::Stopped { time }),
        _ => {
            let whole = fine.voyage.at(duration);
            return Ok(Tried {
                steps: whole.steps,
                seconds: whole.seconds,
                end: fine.particles,
                particles: 1.0,
                surface: 1.0,
            });
        }
    };
    let few = run.fluid.len();
    keep(&coarse, 0, &mut run)?;
    let ratio = run.settings.spacing / job.scene.sim.spacing;
    let most = (bounds_at_start(&job.scene.sim).iter())
        .filter(|bound| !bound.lifted && bound.limit != Limit::Cfl)
        .map(|bound| bound.dt)
        .fold(f64::INFINITY, f64::min);
    let mut voyage = Voyage::new(ratio, most);
    let reached = fine.voyage.end().time;
    let marks = [reached, 0.5 * duration, duration];
    if let Err(error) = voyage.sail(&coarse, &mut run, COARSE, &marks)? {
        let note = format!("on particles {ratio:.1} times as large, {error}");
        observer(Event::Note(&job.folder.lock(), &note));
    }
    let by_number = fine.particles as f64 / few as f64;
    let whole = fine.voyage.and_on(&voyage, by_number, duration);
    let lasting = run.fluid.len() as f64 / few as f64;
    Ok(Tried {
        steps: whole.steps,
        seconds: whole.seconds,
        end: (fine.particles as f64 * lasting) as usize,
        particles: 0.5 * (1.0 + lasting),
        surface: growth(&coarse)?,
    })
}

/// How far a run has come: simulated time [s], and the steps of the fine one until then, with what they would take if
/// they cost as much as its own [s].
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    time: f64,
    steps: f64,
    seconds: f64,
}

struct Voyage {
    /// How much larger the particles are than those of the fine run.
    ratio: f64,
    /// No step of the fine run is longer [s].
    most: f64,
    log: Vec<Entry>,
}

impl Voyage {
    fn new(ratio: f64, most: f64) -> Self {
        Self {
            ratio,
            most,
            log: vec![Entry::default()],
        }
    }

    fn end(&self) -> Entry {
        self.log.last().copied().unwrap_or_default()
    }

    /// Runs until the end, or for so many seconds. The states at the times `marks` [s] are left as frames from 1 on; where it
    /// does not come that far, its last.
    fn sail(
        &mut self,
        job: &Job,
        run: &mut Simulation,
        patience: f64,
        marks: &[f64],
    ) -> Result<Result<(), SimError>, FlowError> {
        let scene = &job.scene;
        let started = Instant::now();
        let mut ended = Ok(());
        let mut now = Entry::default();
        let mut kept = 0;
        'all: for frame in 1..=scene.last_frame() {
            let end = f64::from(frame) / scene.sim.frames_per_second;
            let before = now.steps;
            while run.time < end {
                if job.stop.load(Ordering::Relaxed) || started.elapsed().as_secs_f64() > patience {
                    break 'all;
                }
                let began = Instant::now();
                let step = match run.step_towards(end) {
                    Ok(step) => step,
                    Err(error) => {
                        ended = Err(error);
                        break 'all;
                    }
                };
                let seconds = began.elapsed().as_secs_f64();
                let times = step.dt / finer(&step, run, self.ratio).min(self.most);
                now.time = run.time;
                now.steps += times;
                now.seconds += times * seconds;
                self.log.push(now);
                while marks.get(kept).is_some_and(|mark| *mark <= run.time) {
                    kept += 1;
                    keep(job, kept as u32, run)?;
                }
            }
            // No frame has less than a step.
            now.steps = now.steps.max(before + 1.0);
        }
        for n in kept..marks.len() {
            keep(job, n as u32 + 1, run)?;
        }
        Ok(ended)
    }

    /// What it took until `time` [s]; beyond its end, the rest is like its last third.
    fn at(&self, time: f64) -> Entry {
        let end = self.end();
        let until = |time: f64| {
            let after = self.log.partition_point(|entry| entry.time < time);
            self.log.get(after).copied().unwrap_or(end)
        };
        if end.time >= time || end.time <= 0.0 {
            return until(time);
        }
        let before = self
            .log
            .iter()
            .rfind(|then| then.time <= end.time * 2.0 / 3.0);
        let before = before.copied().unwrap_or_default();
        let more = (time - end.time) / (end.time - before.time);
        Entry {
            time,
            steps: end.steps + more * (end.steps - before.steps),
            seconds: end.seconds + more * (end.seconds - before.seconds),
        }
    }

    /// What all of it takes: this run, and from where it ended, what the coarse one says. Its steps are cheaper: by as
    /// much as they were until then, but not much more than `by_number` of the particles.
    fn and_on(&self, coarse: &Self, by_number: f64, duration: f64) -> Entry {
        let mine = self.end();
        if mine.time >= duration || coarse.end().time <= mine.time {
            return self.at(duration);
        }
        let there = coarse.at(mine.time);
        let whole = coarse.at(duration);
        let measured = mine.seconds / mine.steps * there.steps / there.seconds;
        let dearer = if measured.is_finite() {
            measured.min(DEAREST * by_number)
        } else {
            by_number
        };
        Entry {
            time: duration,
            steps: mine.steps + whole.steps - there.steps,
            seconds: mine.seconds + dearer * (whole.seconds - there.seconds),
        }
    }
}

/// The step that particles smaller by `ratio` would make there [s].
fn finer(step: &StepReport, run: &Simulation, ratio: f64) -> f64 {
    let cfl = match run.settings.time_step {
        TimeStep::Fixed(dt) => return dt,
        TimeStep::Adaptive { cfl, .. } => cfl,
    };
    let velocity = run.velocity();
    let fastest = velocity.iter().map(Vec3::norm).fold(1e-12, f64::max);
    let by_speed = cfl * run.settings.spacing / ratio / fastest;
    let own = match step.limit {
        Some(Limit::Cfl | Limit::Packing | Limit::Retry | Limit::Elastic) => step.dt / ratio,
        Some(Limit::Acceleration) => step.dt / ratio.sqrt(),
        Some(Limit::Viscous | Limit::Diffusion) => step.dt / (ratio * ratio),
        Some(Limit::Fixed | Limit::Largest | Limit::Strain | Limit::Frame | Limit::Dose) | None => {
            step.dt
        }
    };
    own.min(by_speed)
}

/// Mean size of the surfaces of the coarse run, of that of those at its start and where the fine one ended.
fn growth(coarse: &Job) -> Result<f64, FlowError> {
    let mut job = coarse.clone();
    job.frames = Some(FrameRange { first: 0, last: 3 });
    job.run(Stage::Surface, &mut |_| {})?;
    let size = |n| std::fs::metadata(job.folder.surface(n)).map_or(0.0, |file| file.len() as f64);
    let [start, reached, middle, end] = [0, 1, 2, 3].map(size);
    Ok((start + 4.0 * middle + end) / 6.0 / (0.5 * (start + reached)).max(1.0))
}
