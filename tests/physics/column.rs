//! A column at rest.

use crate::scenes::{newtonian, run, settings, walls};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Body, BodyShape, Simulation, StressStep, TimeStep};
use osteoflow::solid::{Shape, Solid};

/// Fills a box to `layers` spacings and lets it stand; returns (bottom pressure / ρgh, fastest / √(gH), mean ψ−1).
fn rest(stress: StressStep, viscosity: f64, end: f64) -> (f64, f64) {
    let dx = 0.01;
    let layers = 20.0;
    let size = Vec3::new(10.0, 10.0, 30.0) * dx;
    let solid = Solid {
        shapes: vec![Shape::Box {
            min: Vec3::zeros(),
            max: size,
            hollow: true,
        }],
        grids: Vec::new(),
    };
    let region = Aabb {
        min: Vec3::zeros(),
        max: size,
    }
    .grown(3.0 * dx);
    let mut s = settings(dx, region);
    s.stress = stress;
    s.gravity = Vec3::new(0.0, 0.0, -9.81);
    s.cement = newtonian(1000.0, viscosity);
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: 5e-3,
        cfl: 0.4,
    };
    s.bodies = vec![Body {
        shape: BodyShape::Box(Aabb {
            min: Vec3::zeros(),
            max: Vec3::new(size.x, size.y, layers * dx),
        }),
        polymer_fraction: 0.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    let particles = walls(&solid, region, Vec3::zeros(), dx, 3.0 * dx);
    let simulation = run(Simulation::new(s, solid, particles).unwrap(), end);
    let depth = layers * dx;
    let speed = simulation
        .velocity()
        .iter()
        .map(Vec3::norm)
        .fold(0.0, f64::max);
    // Slope of pressure against height over the lower half.
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, p) in simulation
        .fluid
        .position
        .iter()
        .zip(&simulation.fluid.pressure)
    {
        if x.z < 0.75 * depth && x.z > 2.0 * dx {
            sum += p[0] / (1000.0 * 9.81 * (depth - x.z));
            count += 1.0;
        }
    }
    eprintln!(
        "{stress:?}: pressure {:.4}, speed {:.4}",
        sum / count,
        speed / (9.81 * depth).sqrt()
    );
    (sum / count, speed / (9.81 * depth).sqrt())
}

#[test]
fn split_column_rests_on_hydrostatic_pressure() {
    let (pressure, speed) = rest(StressStep::Explicit, 0.5, 1.0);
    assert!((pressure - 1.0).abs() < 0.05, "{pressure}");
    assert!(speed < 0.05, "{speed}");
}

#[test]
fn coupled_column_rests_on_hydrostatic_pressure() {
    let (pressure, speed) = rest(StressStep::Coupled, 10.0, 1.0);
    assert!((pressure - 1.0).abs() < 0.05, "{pressure}");
    assert!(speed < 0.02, "{speed}");
}
