//! Cement that moves by itself: a coarse run of all of it shows how fast it becomes, what bounds its steps, how hard
//! they are to solve, and how its surface grows.

use super::pace::{self, Pace};
use super::{Tried, keep};
use crate::flow::{Event, FlowError, FrameRange, Job, Observer, Stage};
use crate::math::Vec3;
use crate::sim::{Limit, SimError, Simulation, StepReport, TimeStep, bounds_at_start};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Time after which the rest is taken to be like the last third of what was run [s].
const PATIENCE: f64 = 6.0;

/// The run as it is to be: its particles, and a few of its steps.
pub(super) struct Fine {
    particles: usize,
    pace: Option<Pace>,
}

/// The start and the state some steps after it are left as frames 1 and 2.
pub(super) fn start(job: &Job, mut run: Simulation) -> Result<Fine, FlowError> {
    keep(job, 1, &run)?;
    let particles = run.fluid.len();
    let pace = pace::measure(&mut run, &job.stop);
    keep(job, 2, &run)?;
    Ok(Fine { particles, pace })
}

/// Runs `coarse`, which is the job on larger particles. If it is too coarse to be set up, all steps are taken to be
/// like the first.
pub(super) fn course(
    job: &Job,
    fine: &Fine,
    coarse: Result<Job, FlowError>,
    observer: &mut Observer<'_>,
) -> Result<Tried, FlowError> {
    let begun = coarse.and_then(|coarse| {
        let run = coarse.simulation()?;
        Ok((coarse, run))
    });
    let (coarse, mut run) = match begun {
        Ok((coarse, run)) if !run.fluid.is_empty() => (coarse, run),
        Err(FlowError::Stopped { time }) => return Err(FlowError::Stopped { time }),
        _ => {
            let (dt, seconds) = fine
                .pace
                .map_or((f64::INFINITY, 0.0), |p| (p.dt, p.seconds));
            let steps = job.scene.sim.duration / dt;
            return Ok(Tried {
                steps,
                seconds: steps * seconds,
                end: fine.particles,
                particles: 1.0,
                surface: 1.0,
            });
        }
    };
    let few = run.fluid.len();
    keep(&coarse, 0, &run)?;
    let more = dearer(fine, &coarse, &mut run);
    let ratio = run.settings.spacing / job.scene.sim.spacing;
    let mut voyage = Voyage {
        ratio,
        most: (bounds_at_start(&job.scene.sim).iter())
            .filter(|bound| !bound.lifted)
            .map(|bound| bound.dt)
            .fold(f64::INFINITY, f64::min),
        log: vec![Entry::default()],
    };
    if let Err(error) = voyage.sail(&coarse, &mut run)? {
        let note = format!("on particles {ratio:.1} times as large, {error}");
        observer(Event::Note(&job.folder.lock(), &note));
    }
    keep(&coarse, 2, &run)?;
    let whole = voyage.whole(f64::from(job.scene.last_frame()) / job.scene.sim.frames_per_second);
    let lasting = run.fluid.len() as f64 / few as f64;
    Ok(Tried {
        steps: whole.steps,
        seconds: whole.seconds * more,
        end: (fine.particles as f64 * lasting) as usize,
        particles: 0.5 * (1.0 + lasting),
        // A splash of larger particles is larger.
        surface: 1.0 + (growth(&coarse)? - 1.0) / ratio,
    })
}

/// How much more a step of the fine run costs than one of the coarse run, with as many iterations: by their first steps.
/// Few particles cost more each, so it is not more than their numbers say.
fn dearer(fine: &Fine, coarse: &Job, run: &mut Simulation) -> f64 {
    let by_number = fine.particles as f64 / run.fluid.len() as f64;
    let start = run.state();
    let pace = pace::measure(run, &coarse.stop);
    let cost = |pace: &Pace| pace.seconds / pace.passes;
    let measured = (fine.pace.as_ref().zip(pace.as_ref())).map(|(a, b)| cost(a) / cost(b));
    if run.restore(start) {
        measured.unwrap_or(by_number).min(1.2 * by_number)
    } else {
        by_number
    }
}

/// How far a coarse run has come: simulated time [s], and the steps of the fine one until then, with what they would
/// take if they cost as much as coarse ones [s].
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    time: f64,
    steps: f64,
    seconds: f64,
}

struct Voyage {
    /// How much larger the particles are.
    ratio: f64,
    /// No step of the fine run is longer [s].
    most: f64,
    log: Vec<Entry>,
}

impl Voyage {
    /// Runs until the end, or as long as there is patience; the state in the middle is left as frame 1.
    fn sail(
        &mut self,
        coarse: &Job,
        run: &mut Simulation,
    ) -> Result<Result<(), SimError>, FlowError> {
        let scene = &coarse.scene;
        let started = Instant::now();
        let last = scene.last_frame();
        keep(coarse, 1, run)?;
        let mut now = Entry::default();
        for frame in 1..=last {
            let end = f64::from(frame) / scene.sim.frames_per_second;
            let before = now.steps;
            while run.time < end {
                if coarse.stop.load(Ordering::Relaxed) || started.elapsed().as_secs_f64() > PATIENCE
                {
                    return Ok(Ok(()));
                }
                let began = Instant::now();
                let step = match run.step_towards(end) {
                    Ok(step) => step,
                    Err(error) => return Ok(Err(error)),
                };
                let seconds = began.elapsed().as_secs_f64();
                let times = step.dt / finer(&step, run, self.ratio).min(self.most);
                now.time = run.time;
                now.steps += times;
                now.seconds += times * seconds;
                self.log.push(now);
            }
            // No frame has less than a step.
            now.steps = now.steps.max(before + 1.0);
            if frame == last.div_ceil(2) {
                keep(coarse, 1, run)?;
            }
        }
        Ok(Ok(()))
    }

    /// What all of it takes; if the log ends before `duration` [s], the rest is like its last third.
    fn whole(&self, duration: f64) -> Entry {
        let end = self.log.last().copied().unwrap_or_default();
        if end.time >= duration || end.time <= 0.0 {
            return end;
        }
        let before = self
            .log
            .iter()
            .rfind(|then| then.time <= end.time * 2.0 / 3.0);
        let before = before.copied().unwrap_or_default();
        let more = (duration - end.time) / (end.time - before.time);
        Entry {
            time: duration,
            steps: end.steps + more * (end.steps - before.steps),
            seconds: end.seconds + more * (end.seconds - before.seconds),
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

/// Mean size of the surfaces at the start, in the middle and at the end, of that at the start.
fn growth(coarse: &Job) -> Result<f64, FlowError> {
    let mut job = coarse.clone();
    job.frames = Some(FrameRange { first: 0, last: 2 });
    job.run(Stage::Surface, &mut |_| {})?;
    let size = |n| std::fs::metadata(job.folder.surface(n)).map_or(0.0, |file| file.len() as f64);
    let [start, middle, end] = [0, 1, 2].map(size);
    Ok((start + 4.0 * middle + end) / (6.0 * start.max(1.0)))
}
