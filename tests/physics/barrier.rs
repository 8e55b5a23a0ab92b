//! A wall one spacing thin holds the greatest pressure of an injection back.

use crate::scenes::{newtonian, run, settings};
use osteoflow::math::{Aabb, Real, Vec3};
use osteoflow::sim::{Body, BodyShape, SimError, Simulation, StressStep, Symptom, TimeStep};
use osteoflow::solid::{Shape, Solid, wall_particles};

/// Cement stands on a plate between two chambers, and its weight presses with 3 MPa, more than was ever measured in a
/// patient: nothing gets through, no particle is pressed deeper than half a spacing into the plate, and none of the
/// plate is left bare. The plate lies askew of the voxels that its wall particles come from.
#[test]
fn a_plate_of_one_spacing_holds_three_megapascals() {
    let dx = 0.5e-3;
    let size = Vec3::new(8.0, 8.0, 20.0) * dx;
    let [low, high] = [5.37 * dx, 6.37 * dx];
    let solid = Solid {
        shapes: vec![
            Shape::Box {
                min: Vec3::zeros(),
                max: size,
                hollow: true,
            },
            Shape::Box {
                min: Vec3::new(-1.0, -1.0, low),
                max: Vec3::new(1.0, 1.0, high),
                hollow: false,
            },
        ],
        grids: Vec::new(),
    };
    let region = Aabb {
        min: Vec3::zeros(),
        max: size,
    }
    .grown(3.0 * dx);
    let depth = 12.0 * dx;
    let (density, pressure) = (1000.0, 3e6);
    let mut s = settings(dx, region);
    s.gravity = Vec3::new(0.0, 0.0, -pressure / (density * depth));
    s.cement = newtonian(density, 10.0);
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: 2e-6,
        cfl: 0.4,
    };
    s.bodies = vec![Body {
        shape: BodyShape::Box(Aabb {
            min: Vec3::new(0.0, 0.0, high),
            max: Vec3::new(size.x, size.y, high + depth),
        }),
        polymer_fraction: 0.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    let walls = wall_particles(&solid, &region, dx, 2.0 * dx);
    // A particle that nothing held would be through the plate in 45 µs.
    let simulation = run(Simulation::new(s, solid, walls).unwrap(), 4e-4);
    let fluid = &simulation.fluid;
    let lowest = fluid
        .position
        .iter()
        .map(|x| x.z)
        .fold(Real::MAX, Real::min);
    assert!(lowest > high - 0.5 * dx, "{}", (lowest - high) / dx);
    let bottom = fluid.position.iter().zip(&fluid.pressure);
    let bottom: Vec<Real> = bottom
        .filter(|(x, _)| x.z < high + dx)
        .map(|(x, p)| p[0] * depth / (high + depth - x.z))
        .collect();
    let mean = bottom.iter().sum::<Real>() / bottom.len() as Real;
    assert!((mean / pressure - 1.0).abs() < 0.1, "{mean:e}");
    for column in 0..64 {
        let middle = Vec3::new(
            (Real::from(column / 8) + 0.5) * dx,
            (Real::from(column % 8) + 0.5) * dx,
            high + 0.5 * dx,
        );
        let bare = fluid.position.iter().map(|x| (x - middle).norm());
        assert!(bare.fold(Real::MAX, Real::min) < dx, "{middle:?}");
    }
}

/// A path beyond all measure past a wall is not looked at piece by piece: the step is at fault, and says so.
#[test]
fn a_speed_beyond_all_measure_ends_the_run_at_once() {
    let dx = 1e-3;
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(6.0, 6.0, 6.0) * dx,
    };
    let region = bounds.grown(3.0 * dx);
    let solid = Solid {
        shapes: vec![Shape::Box {
            min: bounds.min,
            max: bounds.max,
            hollow: true,
        }],
        grids: Vec::new(),
    };
    let mut s = settings(dx, region);
    s.stress = StressStep::Explicit;
    s.gravity = Vec3::x() * 1e12;
    s.time_step = TimeStep::Fixed(1.0);
    s.bodies = vec![Body {
        shape: BodyShape::Box(bounds),
        polymer_fraction: 0.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    let walls = wall_particles(&solid, &region, dx, 2.0 * dx);
    let mut simulation = Simulation::new(s, solid, walls).unwrap();
    let ended = simulation.step_towards(10.0);
    let runaway = |error: &SimError| {
        matches!(
            error,
            SimError::Diverged {
                what: Symptom::Runaway,
                ..
            }
        )
    };
    assert!(ended.as_ref().is_err_and(runaway), "{ended:?}");
}
