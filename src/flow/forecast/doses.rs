//! Cement that is pressed in: steps at the start, with half of the dose and with all of it.

use super::pace::{self, Pace};
use super::spread::Cells;
use super::{Tried, keep};
use crate::cache;
use crate::flow::{Event, FlowError, Job, Observer};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::sim::Simulation;
use crate::solid::Solid;
use std::collections::HashSet;

/// Cement that came there has this much more surface than what is laid there evenly: 1.2 to 1.6 times in the main job,
/// its quick version and a puddle under a needle.
const ROUGHER: f64 = 1.35;
/// And it is less quiet, so that its steps are shorter: 1.04 times as many in the main job, 1.3 and 1.6 times as many of
/// 0.45 : 0.55 and 0.8 : 0.2, which are thin enough to drip from pore to pore.
const RESTLESS: f64 = 1.25;

/// Half of the dose and all of it are left as frames 1 and 2.
pub(super) fn course(
    job: &Job,
    mut run: Simulation,
    observer: &mut Observer<'_>,
) -> Result<Tried, FlowError> {
    let solid = cache::read_solid(&job.folder.solid())?;
    let first = run.state();
    let mut paces = Vec::new();
    let mut shown = [0; 2];
    for (n, dose) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        job.heed(None)?;
        if !run.restore(first.clone()) {
            break;
        }
        lay(&mut run, &solid, dose);
        if n > 0 {
            shown[n - 1] = run.fluid.len();
            keep(job, n as u32, &mut run)?;
        }
        match pace::measure(&mut run, &job.stop) {
            Some(pace) => paces.push(pace),
            None => observer(Event::Note(
                &job.folder.frame(n as u32),
                "the first step with cement laid into the pores failed: the time expected does without it",
            )),
        }
    }
    let [start, end] = [first.fluid.len() as f64, shown[1] as f64];
    let (steps, seconds) = over_the_dose(&job.scene, &paces, start, end);
    let share = mean_particles(&job.scene, start, end) * 2.0 / (shown[0] + shown[1]).max(1) as f64;
    Ok(Tried {
        steps,
        seconds,
        end: shown[1],
        particles: share,
        surface: share * ROUGHER,
    })
}

fn mean_particles(scene: &Scene, start: f64, end: f64) -> f64 {
    let frames = scene.last_frame() + 1;
    let dosed = |n: u32| dosed(scene, f64::from(n) / scene.sim.frames_per_second);
    let sum: f64 = (0..frames).map(|n| start + (end - start) * dosed(n)).sum();
    sum / f64::from(frames)
}

/// Share of all doses that is in at `time` [s], of what is in at the end.
fn dosed(scene: &Scene, time: f64) -> f64 {
    let inlets = &scene.sim.inlets;
    let by = |time: f64| -> f64 {
        let each = inlets
            .iter()
            .map(|inlet| inlet.dose.min(inlet.flow_rate * time));
        each.sum()
    };
    by(time) / by(scene.sim.duration).max(f64::MIN_POSITIVE)
}

/// Steps and seconds of a whole run, from what they are with so many particles.
fn over_the_dose(scene: &Scene, paces: &[Pace], start: f64, end: f64) -> (f64, f64) {
    let at = |particles: f64, of: &dyn Fn(&Pace) -> f64| {
        let after = paces.partition_point(|pace| pace.particles < particles);
        let (a, b) = match (paces.get(after.wrapping_sub(1)), paces.get(after)) {
            (Some(a), Some(b)) => (a, b),
            (Some(a), None) | (None, Some(a)) => (a, a),
            (None, None) => return 0.0,
        };
        let along = (particles - a.particles) / (b.particles - a.particles).max(1.0);
        of(a) + (of(b) - of(a)) * along.clamp(0.0, 1.0)
    };
    let frame = 1.0 / scene.sim.frames_per_second;
    let (mut steps, mut seconds) = (0.0, 0.0);
    for n in 0..scene.last_frame() {
        let middle = (f64::from(n) + 0.5) * frame;
        let particles = start + (end - start) * dosed(scene, middle);
        let rate = RESTLESS * at(particles, &|pace| 1.0 / pace.dt);
        let of_frame = (rate * frame).max(1.0);
        steps += of_frame;
        seconds += of_frame * at(particles, &|pace| pace.seconds);
    }
    (steps, seconds)
}

/// Lays a share of every dose into the open cells nearest to its opening, on the way there.
fn lay(run: &mut Simulation, solid: &Solid, share: f64) {
    let settings = run.settings.clone();
    let mut cells = Cells::new(&settings, solid);
    let mut taken: HashSet<_> = run.fluid.position.iter().map(|x| cells.of(x)).collect();
    for n in 0..run.inlets.len() {
        let inlet = run.inlets[n].settings.clone();
        let pushed = share * inlet.dose.min(inlet.flow_rate * settings.duration);
        let missing = ((pushed - run.inlets[n].emitted) / run.rest_volume).max(0.0) as usize;
        let mut laid: Vec<Vec3> = Vec::new();
        cells.visit(&inlet, |reached| {
            if laid.len() < missing && taken.insert(reached.cell) {
                laid.push(reached.x);
            }
            laid.len() < missing
        });
        for x in &laid {
            let id = run.fluid.len() as u32;
            let fraction = inlet.polymer_fraction;
            run.fluid
                .push(*x, Vec3::zeros(), fraction, id, n as u16 + 1);
        }
        let state = &mut run.inlets[n];
        state.emitted += run.rest_volume * laid.len() as f64;
        // With all of it in, a step would no longer press.
        state.pushed = pushed.min(0.9 * inlet.dose);
    }
}
