//! Permeability of a cubic array of spheres, given as a mesh like any bone [Zick82].
//!
//! The gap between spheres of 0.343 is four spacings wide at 32 a cell, and stays `short`, 3.2 % too permeable: the velocity
//! is carried on behind a wall along a straight line, which leaves out what the driving force bends it by, as if the wall
//! lay 0.05 to 0.08 spacings further back (at 16, 24, 32 a cell 3.8, 2.3, 1.3 % at 0.125, and 7.6, 3.9, 3.2 % at 0.343). With
//! β up to 64 and distances down to 0.02 spacings it is 3.1 %.

use super::series::{Refined, curve};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::mesh::{TriMesh, surface_nets};
use crate::report::{Axis, Look, Plot, Series};
use crate::sim::TimeStep;
use crate::solid::{Solid, mesh_grid};
use crate::study::exact::{SIMPLE_CUBIC, permeability, sphere_radius};
use crate::study::scenes::{around, boxed, newtonian};
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "spheres",
    about: "permeability of a cubic array of spheres (Zick and Homsy), from a mesh",
    measure,
};

/// Edge of the cell [m].
const CELL: Real = 0.01;
const DENSITY: Real = 1000.0;
const VISCOSITY: Real = 10.0;
/// What of the start may be left at the end.
const UNSETTLED: Real = 1e-3;
/// Fewest steps, each L²/(4π² ν).
const STEPS: u32 = 18;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![12, 16], vec![16, 24, 32]);
    let fractions = bench.level.pick(1..2, 0..3);
    let mut plot = Plot {
        title: "Permeability of a cubic array of spheres".into(),
        x: Axis::linear("volume fraction of the spheres"),
        y: Axis::log("permeability / cell²"),
        series: vec![curve(
            "Zick and Homsy",
            0,
            SIMPLE_CUBIC.map(|(p, k)| [p, permeability(p, k)]).to_vec(),
        )],
    };
    let mut figures = Vec::new();
    for (fraction, factor) in &SIMPLE_CUBIC[fractions] {
        let exact = permeability(*fraction, *factor);
        let steps = steps_to_settle(exact);
        let mut refined = Refined::default();
        for (colour, &across) in sizes.iter().enumerate() {
            let run = format!("spheres-{fraction}-{across}");
            let (k, seconds) = bench.run(&run, &(fraction, across, steps), || {
                flow(&run, *fraction, across, steps)
            })?;
            refined.add(across, k / exact - 1.0, seconds);
            plot.series.push(Series {
                name: format!("{across} spacings a cell"),
                points: vec![[*fraction, k]],
                look: Look::Dots,
                colour: colour + 1,
            });
        }
        // Falling on refinement: an order above 0.
        figures.extend(refined.figures(
            &format!("permeability at {fraction}"),
            "a cell",
            0.02,
            Some(0.0),
        ));
    }
    Ok(Measured { figures, plot })
}

/// The sphere in the middle of the cell as triangles, turned a little from any axis.
fn sphere(fraction: Real) -> TriMesh {
    let (radius, centre) = (sphere_radius(fraction) * CELL, Vec3::repeat(0.5 * CELL));
    let bounds = boxed(Vec3::repeat(CELL));
    let mut mesh = surface_nets(&bounds, radius / 24.0, |x| (x - centre).norm() - radius);
    for vertex in &mut mesh.positions {
        let out = *vertex - centre;
        *vertex = centre + out * (radius / out.norm());
    }
    // Flat facets cut off volume: give it back.
    let exact = fraction * CELL.powi(3);
    let grow = libm::cbrt(exact / mesh.signed_volume().abs());
    for vertex in &mut mesh.positions {
        *vertex = centre + (*vertex - centre) * grow;
    }
    mesh
}

/// How many steps leave little of the start in a flow that settles as exp(−ν t/k): sparse spheres hold it back late.
fn steps_to_settle(permeability: Real) -> u32 {
    let a_step = 1.0 / (4.0 * PI * PI * permeability);
    let needed = (-libm::log(UNSETTLED) / libm::log1p(a_step)).ceil();
    STEPS.max(needed as u32)
}

/// k/L² from the mean velocity under a small force, after it has settled.
fn flow(name: &str, fraction: Real, across: u32, steps: u32) -> Result<Real, StudyError> {
    let dx = CELL / Real::from(across);
    let solid = Solid {
        shapes: Vec::new(),
        grids: vec![mesh_grid(&sphere(fraction), 0.5 * dx, 8.0 * dx)],
    };
    let mut place = around(Vec3::repeat(CELL), dx, solid);
    place.settings.cement = newtonian(DENSITY, VISCOSITY);
    let dt = CELL * CELL * DENSITY / VISCOSITY / (4.0 * PI * PI);
    // The fastest fluid moves by about a spacing in all.
    let speed = dx / (dt * Real::from(steps));
    let force = speed * VISCOSITY / (0.1 * CELL * CELL);
    place.settings.gravity = Vec3::x() * (force / DENSITY);
    place.settings.time_step = TimeStep::Fixed(dt);
    let mut simulation = place.start_full(name)?;
    simulation
        .advance_to(dt * Real::from(steps), |_| {})
        .map_err(StudyError::run(name))?;
    let sum: Real = simulation.velocity().iter().map(|v| v.x).sum();
    let superficial = sum * simulation.rest_volume / CELL.powi(3);
    Ok(VISCOSITY * superficial / force / (CELL * CELL))
}
