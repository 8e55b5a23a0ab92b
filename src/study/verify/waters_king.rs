//! Oldroyd-B flow that starts between plates [Waters70]: it overshoots, swings back, and settles.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{ElasticWaves, Scheme, TimeStep};
use crate::study::exact::{Fluid, plane_poiseuille};
use crate::study::scenes::{Lie, Norm, channel, viscoelastic};

pub(super) const CASE: Case = Case {
    name: "waters-king",
    about: "start-up of an Oldroyd-B fluid between plates: overshoot and swing",
    measure,
};

const GAP: Real = 0.02;
const DENSITY: Real = 1000.0;
/// η_s + η_p [Pa·s].
const VISCOSITY: Real = 1.0;
/// β = η_s/μ₀ and E = λ μ₀/(ρ h²).
const FLUIDS: [(Real, Real); 3] = [(1.0 / 9.0, 1.0), (0.5, 1.0), (1.0 / 9.0, 2.0)];
/// f h²/(3 μ₀) [m/s]: fluid in the middle moves by a few spacings in all.
const SPEED: Real = 2e-3;
/// Samples in a relaxation time.
const SAMPLES: u32 = 20;

/// What a run leaves: time in λ and velocity in the middle in SPEED; and the relative L2 error over space and time.
type Swing = (Vec<[Real; 2]>, Real);

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    // Spacings across, and steps a relaxation time.
    let sizes = bench
        .level
        .pick(vec![(30, 110)], vec![(20, 100), (30, 150), (40, 200)]);
    let memories = bench.level.pick(3, 8);
    let mut plot = Plot {
        title: "Start-up of an Oldroyd-B fluid: velocity in the middle".into(),
        x: Axis::linear("time / relaxation time"),
        y: Axis::linear("velocity / (f h² / 3 mu)"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (colour, (beta, elasticity)) in FLUIDS.into_iter().enumerate() {
        let fluid = fluid(beta, elasticity);
        let name = format!("beta {beta:.2}, E {elasticity}");
        let [mut whole, mut height, mut time] = [(); 3].map(|()| Refined::default());
        let mut finest = Vec::new();
        for &(across, steps) in &sizes {
            let run = format!("waters-king-{colour}-{across}");
            let settings = (beta, elasticity, across, memories, steps, SPEED, SAMPLES);
            let ((swing, error), seconds) = bench.run(&run, &settings, || {
                swing(&run, &fluid, across, memories, steps)
            })?;
            let (got, want) = (peak(&swing), peak(&exact_swing(&fluid, &swing)));
            whole.add(across, error, seconds);
            height.add(across, got[1] / want[1] - 1.0, seconds);
            time.add(across, got[0] / want[0] - 1.0, seconds);
            finest = swing;
        }
        for (what, refined, order) in [
            ("L2 over time", whole, Some(0.0)),
            ("overshoot, height", height, None),
            ("overshoot, time", time, None),
        ] {
            figures.extend(refined.figures(&format!("{name}: {what}"), "across", 0.02, order));
        }
        let exact = exact_swing(&fluid, &finest);
        plot.series.push(curve(&name, colour, exact));
        plot.series.push(dots(colour, thinned(finest, 40)));
    }
    Ok(Measured { figures, plot })
}

fn fluid(beta: Real, elasticity: Real) -> Fluid {
    Fluid {
        density: DENSITY,
        solvent: beta * VISCOSITY,
        polymer: (1.0 - beta) * VISCOSITY,
        relaxation_time: elasticity * DENSITY * 0.25 * GAP * GAP / VISCOSITY,
    }
}

fn force() -> Real {
    3.0 * VISCOSITY * SPEED / (0.25 * GAP * GAP)
}

fn exact(fluid: &Fluid, y: Real, t: Real) -> Real {
    plane_poiseuille(fluid, force(), 0.5 * GAP, y, t)
}

/// The exact velocities at the times of a run.
fn exact_swing(fluid: &Fluid, swing: &[[Real; 2]]) -> Vec<[Real; 2]> {
    let velocity = |time: Real| exact(fluid, 0.0, time * fluid.relaxation_time) / SPEED;
    swing.iter().map(|p| [p[0], velocity(p[0])]).collect()
}

/// Vertex of the parabola through the largest sample and its neighbours.
fn peak(samples: &[[Real; 2]]) -> [Real; 2] {
    let top = (1..samples.len().saturating_sub(1))
        .max_by(|&a, &b| samples[a][1].total_cmp(&samples[b][1]))
        .unwrap_or(0);
    let (Some(before), Some(after)) = (samples.get(top.wrapping_sub(1)), samples.get(top + 1))
    else {
        return [Real::NAN; 2];
    };
    let at = samples[top];
    let (slope, bend) = (
        0.5 * (after[1] - before[1]),
        after[1] - 2.0 * at[1] + before[1],
    );
    let shift = -slope / bend;
    [
        at[0] + shift * (after[0] - at[0]),
        at[1] + 0.5 * slope * shift,
    ]
}

/// `steps` steps a relaxation time, over `memories` of them.
fn swing(
    name: &str,
    fluid: &Fluid,
    across: u32,
    memories: u32,
    steps: u32,
) -> Result<Swing, StudyError> {
    let lie = Lie {
        turned: false,
        seed: 3,
    };
    let mut place = channel(GAP, across, lie);
    place.settings.scheme = Scheme::ImmCt;
    place.settings.elastic_waves = ElasticWaves::Resolved;
    place.settings.theta = ElasticWaves::Resolved.theta();
    place.settings.cement = viscoelastic(
        DENSITY,
        fluid.solvent,
        fluid.polymer,
        fluid.relaxation_time,
        0.0,
    );
    place.settings.gravity = Vec3::x() * (force() / DENSITY);
    place.settings.time_step = TimeStep::Fixed(fluid.relaxation_time / Real::from(steps));
    let mut simulation = place.start(name)?;
    let mut norm = Norm::default();
    let mut samples = vec![[0.0, 0.0]];
    for k in 1..=memories * SAMPLES {
        let t = Real::from(k) / Real::from(SAMPLES);
        simulation
            .advance_to(t * fluid.relaxation_time, |_| {})
            .map_err(StudyError::run(name))?;
        let (mut middle, mut weight) = (0.0, 0.0);
        for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
            norm.add(v.x, exact(fluid, x.y, simulation.time));
            // Fluid near the middle, brought there along the steady parabola.
            let y = x.y / (0.5 * GAP);
            if y.abs() < 0.15 {
                middle += v.x / (1.0 - y * y);
                weight += 1.0;
            }
        }
        samples.push([t, middle / weight / SPEED]);
    }
    Ok((samples, norm.relative()))
}
