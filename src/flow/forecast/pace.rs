//! How long a step is and what it costs on this machine: a few steps, timed.

use crate::sim::{Simulation, StepReport};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Most steps that are timed,
const STEPS: usize = 24;
/// and the time after which no further one is begun [s].
const PATIENCE: f64 = 2.0;
/// The first steps of so many solve from a cold start.
const COLD: usize = 3;

/// A mean step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Particles that it moves.
    pub particles: f64,
    /// Its length [s].
    pub dt: f64,
    /// What it takes [s].
    pub seconds: f64,
}

/// Some steps from the state as it is; none if the first fails.
pub(super) fn measure(run: &mut Simulation, stop: &AtomicBool) -> Option<Pace> {
    let started = Instant::now();
    let mut steps: Vec<(StepReport, f64)> = Vec::new();
    // Far from the end of a frame, which would cut them short.
    let end = run.time + 2.0 * run.settings.duration;
    while steps.len() < STEPS
        && (steps.len() <= COLD || started.elapsed().as_secs_f64() < PATIENCE)
        && !stop.load(Ordering::Relaxed)
    {
        let began = Instant::now();
        let Ok(report) = run.step_towards(end) else {
            break;
        };
        steps.push((report, began.elapsed().as_secs_f64()));
    }
    let warm = &steps[steps.len().saturating_sub(1).min(COLD)..];
    let count = warm.len() as f64;
    (count > 0.0).then(|| Pace {
        particles: run.fluid.len() as f64,
        dt: warm.iter().map(|(report, _)| report.dt).sum::<f64>() / count,
        seconds: warm.iter().map(|(_, seconds)| seconds).sum::<f64>() / count,
    })
}
