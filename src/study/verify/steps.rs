//! The steady flow rate must not depend on the time step: a channel and an array of cylinders.

use super::series::{curve, dots};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{StressStep, TimeStep};
use crate::solid::{Shape, Solid};
use crate::study::scenes::{Lie, Place, around, channel, newtonian};

pub(super) const CASE: Case = Case {
    name: "steps",
    about: "steady flow rate of a channel and a cylinder array, from the explicit limit to 1000 times it",
    measure,
};

const SIZE: Real = 0.01;
const DENSITY: Real = 1000.0;
const VISCOSITY: Real = 10.0;
/// Steps by the explicit viscous limit 0.12 ρ dx²/η; the first is explicit, the others are coupled.
const STEPS: [Real; 5] = [1.0, 5.0, 20.0, 50.0, 1000.0];

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let across = bench.level.pick(12, 24);
    let mut plot = Plot {
        title: "Flow rate against time step".into(),
        x: Axis::log("time step / explicit viscous limit"),
        y: Axis::linear("flow rate / flow rate at the explicit limit").between(0.9, 1.1),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (colour, what, place) in [
        (0, "channel", plates as fn(u32) -> Place),
        (1, "cylinders", cylinders as fn(u32) -> Place),
    ] {
        let mut rates = Vec::new();
        let mut seconds = 0.0;
        for step in STEPS {
            let run = format!("steps-{what}-{step}");
            let (rate, took) = bench.run(&run, &(what, across, step), || {
                steady(&run, place(across), step)
            })?;
            seconds += took;
            rates.push([step, rate]);
        }
        let first = rates[0][1];
        let shares: Vec<_> = rates.iter().map(|r| [r[0], r[1] / first]).collect();
        let change = shares.iter().map(|r| (r[1] - 1.0).abs());
        figures.push(Figure {
            what: format!("{what}: largest change of the flow rate"),
            resolution: format!("{across} across"),
            reached: change.fold(0.0, Real::max),
            goal: Goal::AtMost(0.01),
            seconds,
        });
        plot.series.push(curve(what, colour, shares.clone()));
        plot.series.push(dots(colour, shares));
    }
    Ok(Measured { figures, plot })
}

fn plates(across: u32) -> Place {
    let lie = Lie {
        turned: false,
        seed: 4,
    };
    channel(SIZE, across, lie)
}

/// One cylinder a square cell, porosity 0.8.
fn cylinders(across: u32) -> Place {
    let dx = SIZE / Real::from(across);
    let size = Vec3::new(SIZE, SIZE, 7.0 * dx);
    let solid = Solid {
        shapes: vec![Shape::Cylinder {
            base: Vec3::new(0.5 * SIZE, 0.5 * SIZE, -SIZE),
            axis: Vec3::z(),
            length: 4.0 * SIZE,
            radius: (0.2 / std::f64::consts::PI).sqrt() * SIZE,
            hollow: false,
        }],
        grids: Vec::new(),
    };
    around(size, dx, solid)
}

/// Mean velocity [m/s] once it is steady.
fn steady(name: &str, mut place: Place, step: Real) -> Result<Real, StudyError> {
    let s = &mut place.settings;
    let limit = 0.12 * DENSITY * s.spacing * s.spacing / VISCOSITY;
    let settled = 0.6 * SIZE * SIZE * DENSITY / VISCOSITY;
    let dt = step * limit;
    let end = settled.max(8.0 * dt);
    s.cement = newtonian(DENSITY, VISCOSITY);
    s.stress = if step > 1.0 {
        StressStep::Coupled
    } else {
        StressStep::Explicit
    };
    s.time_step = TimeStep::Fixed(dt);
    // Particles move by a spacing or so: less would be under the solvers' tolerance in the longest steps.
    let speed = s.spacing / end;
    s.gravity = Vec3::x() * (speed * VISCOSITY / (0.1 * SIZE * SIZE) / DENSITY);
    let gravity = s.gravity.x;
    let mut simulation = place.start_full(name)?;
    simulation
        .advance_to(end, |_| {})
        .map_err(StudyError::run(name))?;
    let velocity = simulation.velocity();
    let mean = velocity.iter().map(|v| v.x).sum::<Real>() / velocity.len() as Real;
    Ok(mean / gravity)
}
