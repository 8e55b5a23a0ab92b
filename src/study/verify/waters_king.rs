//! Oldroyd-B flow that starts between plates [Waters70]: it overshoots, swings back, and settles.

use super::series::{curve, dots, thinned};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
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

fn measure(bench: &mut Bench) -> Result<Measured, StudyError> {
    let across = bench.level.pick(30, 40);
    let memories = bench.level.pick(3, 8);
    let steps = bench.level.pick(110, 200);
    let mut plot = Plot {
        title: "Start-up of an Oldroyd-B fluid: velocity in the middle".into(),
        x: Axis::linear("time / relaxation time"),
        y: Axis::linear("velocity / (f h² / 3 mu)"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (colour, (beta, elasticity)) in FLUIDS.into_iter().enumerate() {
        let fluid = fluid(beta, elasticity);
        let run = format!("waters-king-{colour}");
        let settings = (beta, elasticity, across, memories, steps, SPEED, SAMPLES);
        let ((swing, error), seconds) = bench.run(&run, &settings, || {
            swing(&run, &fluid, across, memories, steps)
        })?;
        let exact: Vec<[Real; 2]> = swing
            .iter()
            .map(|p| {
                [
                    p[0],
                    exact(&fluid, 0.0, p[0] * fluid.relaxation_time) / SPEED,
                ]
            })
            .collect();
        let name = format!("beta {beta:.2}, E {elasticity}");
        let (got, want) = (peak(&swing), peak(&exact));
        for (what, reached) in [
            ("L2 over time", error),
            ("overshoot, height", (got[1] / want[1] - 1.0).abs()),
            ("overshoot, time", (got[0] / want[0] - 1.0).abs()),
        ] {
            figures.push(Figure {
                what: format!("{name}: {what}"),
                resolution: format!("{across} across"),
                reached,
                goal: Goal::AtMost(0.02),
                seconds,
            });
        }
        plot.series.push(curve(&name, colour, exact));
        plot.series.push(dots(colour, thinned(swing, 40)));
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
