//! Fluid at rest: hydrostatic pressure, height and quiet, of one fluid and of two layers.
//!
//! Under pressure the cubic lattice of the start turns into an irregular packing, from 0.4 s on and over seconds (at a
//! support of 2.6 spacings it stays). That stirs the fluid, lets its centre sink by 0.3 % (other packings with ψ = 1 are
//! 0.3 to 0.6 % denser), and the row at the surface, which ψ < 1 does not hold, by a third of a spacing: at 10 s the height
//! is 0.9 % low and stays `short`. 12 wide at 10 s: bottom pressure 0.90 and 0.74 % off, speeds 1.4e-3 and 1.5e-3. 6 wide at
//! 1 s the column is in the midst of it, and carried by its walls' lattices: bottom pressure 0.6 and 1.9 % off.

use super::series::{curve, dots, thinned};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Aabb, Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{BodyShape, TimeStep};
use crate::solid::{Shape, Solid, wall_particles};
use crate::study::scenes::{Place, body, newtonian, settings};

pub(super) const CASE: Case = Case {
    name: "column",
    about: "a resting column of one fluid and of two layers: pressure, height, quiet",
    measure,
};

const DX: Real = 0.01;
const LAYERS: u32 = 40;
const GRAVITY: Real = 9.81;

/// Heights [m] and pressures [Pa], heights of the top row [m], largest speed [m/s].
type Rest = (Vec<[Real; 2]>, Real, Real);

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let end = bench.level.pick(1.0, 10.0);
    // In a narrow one the lattice of the walls carries, or presses on, more than a hundredth of the weight.
    let width = bench.level.pick(6.0, 12.0);
    let depth = Real::from(LAYERS) * DX;
    let mut plot = Plot {
        title: "Columns at rest".into(),
        x: Axis::linear("height [m]"),
        y: Axis::linear("pressure [Pa]"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (colour, what, lower) in [(0, "one fluid", 1000.0), (1, "two layers", 1400.0)] {
        let run = format!("column-{colour}");
        let ((rows, height, speed), seconds) =
            bench.run(&run, &(lower, LAYERS, width, end), || {
                rest(&run, lower, width, end)
            })?;
        let exact = |z: Real| {
            let (above, below) = (
                (depth - z).clamp(0.0, 0.5 * depth),
                (0.5 * depth - z).max(0.0),
            );
            GRAVITY * (1000.0 * above + lower * below)
        };
        // Least squares over the lowest quarter, carried down to the floor.
        let low = rows.iter().filter(|r| r[0] > DX && r[0] < 0.25 * depth);
        let (mut n, mut z, mut p, mut zz, mut zp) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for r in low {
            n += 1.0;
            z += r[0];
            p += r[1];
            zz += r[0] * r[0];
            zp += r[0] * r[1];
        }
        let slope = (n * zp - z * p) / (n * zz - z * z);
        let bottom = (p - slope * z) / n;
        for (figure, reached, most) in [
            ("bottom pressure", (bottom / exact(0.0) - 1.0).abs(), 0.01),
            ("height", (height / depth - 1.0).abs(), 0.003),
            (
                "speed left / sqrt(g H)",
                speed / (GRAVITY * depth).sqrt(),
                2e-3,
            ),
        ] {
            figures.push(Figure {
                what: format!("{what}: {figure}"),
                resolution: format!("{LAYERS} deep, {end} s"),
                reached,
                goal: Goal::AtMost(most),
                seconds,
            });
        }
        let line = [0.0, 0.5 * depth, depth].map(|z| [z, exact(z)]).to_vec();
        plot.series.push(curve(what, colour, line));
        plot.series.push(dots(colour, thinned(rows, 60)));
    }
    Ok(Measured { figures, plot })
}

fn rest(name: &str, lower: Real, width: Real, end: Real) -> Result<Rest, StudyError> {
    let depth = Real::from(LAYERS) * DX;
    let size = Vec3::new(width * DX, width * DX, depth + 8.0 * DX);
    let solid = Solid {
        shapes: vec![Shape::Box {
            min: Vec3::zeros(),
            max: size,
            hollow: true,
        }],
        grids: Vec::new(),
    };
    let domain = Aabb {
        min: Vec3::zeros(),
        max: size,
    }
    .grown(3.0 * DX);
    let mut s = settings(DX, domain);
    s.gravity = Vec3::z() * -GRAVITY;
    let phase = |density: Real| PhaseMaterial {
        density,
        viscosity: 10.0,
    };
    s.cement = Cement {
        liquid: phase(1000.0),
        polymer: phase(lower),
        ..newtonian(1000.0, 10.0)
    };
    let layer = |low: Real, high: Real, alpha: Real| {
        let bounds = Aabb {
            min: Vec3::z() * low * depth,
            max: Vec3::new(size.x, size.y, high * depth),
        };
        body(BodyShape::Box(bounds), alpha)
    };
    s.bodies = vec![layer(0.0, 0.5, 1.0), layer(0.5, 1.0, 0.0)];
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: 5e-3,
        cfl: 0.4,
    };
    let walls = wall_particles(&solid, &domain, DX, (s.support_ratio - 0.4) * DX);
    let place = Place {
        settings: s,
        solid,
        walls,
        moving: Vec::new(),
    };
    let mut simulation = place.start(name)?;
    simulation
        .advance_to(end, |_| {})
        .map_err(StudyError::run(name))?;
    let pressure = simulation.pressure();
    let rows = simulation.fluid.position.iter().zip(pressure);
    let mut rows: Vec<_> = rows.map(|(x, p)| [x.z, p]).collect();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // The top row lies half a spacing under the surface.
    let top = &rows[rows.len() - (width * width) as usize..];
    let height = top.iter().map(|r| r[0]).sum::<Real>() / top.len() as Real + 0.5 * DX;
    let speed = simulation
        .velocity()
        .iter()
        .map(Vec3::norm)
        .fold(0.0, Real::max);
    Ok((rows, height, speed))
}
