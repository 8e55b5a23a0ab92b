//! A drop of stiff cement on a floor, which creeps under its weight: as it does at a hundredth of the step?

use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Aabb, Real, Vec3, ordered_sum};
use crate::report::{Axis, Look, Plot, Series, Table};
use crate::sim::{BodyShape, Scheme, Simulation, TimeStep};
use crate::solid::{Shape, Solid, wall_particles};
use crate::study::scenes::{body, newtonian, settings};
use crate::study::{Bench, StudyError};

/// Distance between particles, and radius of the drop [m].
const SPACING: Real = 0.5e-3;
const RADIUS: Real = 4e-3;
/// η of the cement [Pa·s] and λ [s].
const VISCOSITY: Real = 100.0;
const MEMORY: Real = 0.05;
/// Simulated time [s], and moments at which the drop is looked at.
const DURATION: Real = 2.0;
const LOOKS: u32 = 10;
/// The long step [s].
const STEP: Real = 0.02;

/// Height of the centre of mass by the start's, at every look.
fn run(name: &str, step: Real) -> Result<Vec<Real>, StudyError> {
    let dx = SPACING;
    let domain = Aabb {
        min: Vec3::new(-3.0, -3.0, -1.0) * RADIUS,
        max: Vec3::new(3.0, 3.0, 3.0) * RADIUS,
    };
    let mut s = settings(dx, domain);
    s.scheme = Scheme::ImmCt;
    s.gravity = -Vec3::z() * 9.81;
    s.cement = Cement {
        polymer: PhaseMaterial {
            density: 1180.0,
            viscosity: VISCOSITY,
        },
        relaxation_time: MEMORY,
        thinning: 0.5,
        ..newtonian(1180.0, 0.01)
    };
    s.bodies = vec![body(
        BodyShape::Sphere {
            centre: Vec3::z() * 0.8 * RADIUS,
            radius: RADIUS,
        },
        1.0,
    )];
    s.time_step = TimeStep::Fixed(step);
    let solid = Solid {
        shapes: vec![Shape::HalfSpace {
            point: Vec3::zeros(),
            normal: Vec3::z(),
        }],
        grids: Vec::new(),
    };
    let walls = wall_particles(&solid, &domain, dx, (s.support_ratio - 0.4) * dx);
    let mut simulation =
        Simulation::with_movers(s, solid, walls, Vec::new()).map_err(StudyError::run(name))?;
    let height = |run: &Simulation| {
        let n = run.fluid.len();
        ordered_sum(n, |i| run.fluid.position[i].z) / n as Real
    };
    let start = height(&simulation);
    let mut heights = Vec::new();
    for look in 1..=LOOKS {
        let end = DURATION * Real::from(look) / Real::from(LOOKS);
        simulation
            .advance_to(end, |_| {})
            .map_err(StudyError::run(name))?;
        heights.push(height(&simulation) / start);
    }
    Ok(heights)
}

/// Largest difference of how far the drop has sunk, of all that it sinks; the courses as a table and a picture.
pub fn answer(bench: &Bench) -> Result<(Real, Table, Plot), StudyError> {
    let steps: &[Real] = bench.level.pick(&[1.0, 0.1], &[1.0, 0.1, 0.01]);
    let mut table = Table::new(&[
        "step [s]",
        "time [s]",
        "height of the middle / at the start",
    ]);
    let mut plot = Plot {
        title: "A drop of 100 Pa s creeps".into(),
        x: Axis::linear("time [s]"),
        y: Axis::linear("height of its middle / at the start"),
        series: Vec::new(),
    };
    let mut courses = Vec::new();
    for (colour, share) in steps.iter().enumerate() {
        let step = share * STEP;
        let name = format!("creep-{step}");
        let settings = ("creep", step, DURATION, LOOKS);
        let (heights, _) = bench.run(&name, &settings, || run(&name, step))?;
        let time = |k: usize| DURATION * (k + 1) as Real / Real::from(LOOKS);
        let points: Vec<[Real; 2]> = heights
            .iter()
            .enumerate()
            .map(|(k, h)| [time(k), *h])
            .collect();
        for point in &points {
            table.row(vec![step.into(), point[0].into(), point[1].into()]);
        }
        plot.series.push(Series {
            name: format!("step {step} s"),
            points,
            look: Look::Chain,
            colour,
        });
        courses.push(heights);
    }
    let (longest, shortest) = (&courses[0], &courses[courses.len() - 1]);
    let sunk = 1.0 - shortest[shortest.len() - 1];
    let pairs = longest.iter().zip(shortest);
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, Real::max) / sunk;
    Ok((off, table, plot))
}
