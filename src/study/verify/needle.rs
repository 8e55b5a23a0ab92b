//! Hagen-Poiseuille flow in a needle: flow rate under a given gradient, with particles that move.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::TimeStep;
use crate::study::exact::{Fluid, pipe_poiseuille};
use crate::study::scenes::{Lie, Norm, newtonian, pipe};
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "needle",
    about: "flow rate and profile in a round needle under a given gradient",
    measure,
};

/// Inner radius of an 11G needle [m].
const RADIUS: Real = 1.195e-3;
const FLUID: Fluid = Fluid {
    density: 1070.0,
    solvent: 4.4,
    polymer: 0.0,
    relaxation_time: 0.0,
};
/// ν t/R² at the end: e^{−5.78 · 1.5} of the start is left.
const END: Real = 1.5;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![10, 20], vec![10, 20, 40]);
    let mut plot = Plot {
        title: "Flow in a needle".into(),
        x: Axis::linear("distance from the axis / radius"),
        y: Axis::linear("velocity / steady velocity on the axis"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (what, lie) in [
        (
            "",
            Lie {
                turned: false,
                seed: 5,
            },
        ),
        (
            ", turned voxels",
            Lie {
                turned: true,
                seed: 6,
            },
        ),
    ] {
        let (mut flow, mut shape) = (Refined::default(), Refined::default());
        for &across in &sizes {
            if lie.turned && across == 40 {
                continue;
            }
            let run = format!(
                "needle-{}-{across}",
                if lie.turned { "turned" } else { "straight" }
            );
            let settings = (across, lie.turned, lie.seed, END, STEPS);
            let ((rate, profile), seconds) =
                bench.run(&run, &settings, || steady(&run, across, lie))?;
            let exact_rate = PI * force(across) * RADIUS.powi(4) / (8.0 * FLUID.solvent);
            let exact = |r: Real| {
                let t = END * RADIUS * RADIUS * FLUID.density / FLUID.solvent;
                pipe_poiseuille(&FLUID, force(across), RADIUS, r, t)
            };
            let mut norm = Norm::default();
            for [r, u] in &profile {
                norm.add(*u, exact(*r));
            }
            flow.add(across, rate / exact_rate - 1.0, seconds);
            shape.add(across, norm.relative(), seconds);
            if !lie.turned && Some(&across) == sizes.last() {
                let top = force(across) * RADIUS * RADIUS / (4.0 * FLUID.solvent);
                let line = (0..=50).map(|k| 0.02 * Real::from(k));
                let line = line.map(|r| [r, exact(r * RADIUS) / top]);
                plot.series.push(curve("exact", 0, line.collect()));
                let points = profile.into_iter().map(|[r, u]| [r / RADIUS, u / top]);
                plot.series.push(dots(1, thinned(points.collect(), 120)));
            }
        }
        figures.extend(flow.figures(&format!("flow rate{what}"), "across", 0.02, Some(1.5)));
        figures.extend(shape.figures(&format!("profile, L2{what}"), "across", 0.02, None));
    }
    Ok(Measured { figures, plot })
}

/// Steps to the end.
const STEPS: Real = 30.0;

/// Force [N/m³] under which the axis moves by six spacings in R²/ν.
fn force(across: u32) -> Real {
    let nu = FLUID.solvent / FLUID.density;
    let speed = 6.0 * 2.0 * RADIUS / Real::from(across) * nu / (RADIUS * RADIUS);
    4.0 * FLUID.solvent * speed / (RADIUS * RADIUS)
}

/// Flow rate [m³/s], and (r, u) of every particle, in the end.
fn steady(name: &str, across: u32, lie: Lie) -> Result<(Real, Vec<[Real; 2]>), StudyError> {
    let mut place = pipe(RADIUS, across, lie);
    place.settings.cement = newtonian(FLUID.density, FLUID.solvent);
    place.settings.gravity = Vec3::z() * (force(across) / FLUID.density);
    let end = END * RADIUS * RADIUS * FLUID.density / FLUID.solvent;
    place.settings.time_step = TimeStep::Fixed(end / STEPS);
    let mut simulation = place.start_full(name)?;
    simulation
        .advance_to(end, |_| {})
        .map_err(StudyError::run(name))?;
    let places = simulation.fluid.position.iter().zip(simulation.velocity());
    let mut profile: Vec<_> = places.map(|(x, v)| [x.x.hypot(x.y), v.z]).collect();
    profile.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let sum: Real = profile.iter().map(|p| p[1]).sum();
    // The mean over the section times its area: particles stand for equal parts of it.
    let rate = sum / profile.len() as Real * PI * RADIUS * RADIUS;
    Ok((rate, profile))
}
