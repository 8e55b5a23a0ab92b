//! Fluid that is stretched the same everywhere: its stress has no divergence, so it stays as it is.

use crate::scenes::{flowing, settings, walls};
use osteoflow::math::{Aabb, Sym3, Vec3};
use osteoflow::sim::{BodyShape, Scheme, SimSettings, Simulation, StressStep, TimeStep};
use osteoflow::solid::{Shape, Solid};
use osteoflow::study::scenes::{body, boxed, viscoelastic};

const SPACING: f64 = 1e-3;
/// With what may be moved on a floor [m/s].
const STRESS_STEPS: [(StressStep, f64); 2] =
    [(StressStep::Coupled, 3e-4), (StressStep::Explicit, 2e-3)];

/// A box full of particles that lie unevenly, this many spacings high.
fn uneven(stress: StressStep, height: f64) -> SimSettings {
    let size = Vec3::new(8.0, 8.0, height) * SPACING;
    let mut s = settings(SPACING, boxed(size));
    s.scheme = Scheme::ImmCt;
    s.stress = stress;
    s.jitter = 0.2;
    s.cement = viscoelastic(1000.0, 0.01, 8.0, 0.5, 0.1);
    s.time_step = TimeStep::Fixed(2e-5);
    s.bodies = vec![body(BodyShape::Box(s.domain), 1.0)];
    s
}

/// Fastest particle [m/s] below this height after ten steps, the fluid stretched to U_xx.
fn fastest(mut simulation: Simulation, stretch: f64, below: f64) -> f64 {
    let uniform = Sym3 {
        xx: stretch,
        ..Sym3::IDENTITY
    };
    simulation.fluid.conformation = vec![uniform; simulation.fluid.len()];
    simulation.advance_to(2e-4, |_| {}).unwrap();
    let fluid = &simulation.fluid;
    let deep = |i: &usize| fluid.position[*i].z < below;
    let within: Vec<usize> = (0..fluid.len()).filter(deep).collect();
    let held = |&i: &usize| fluid.conformation[i].xx > 0.9 * stretch;
    assert!(!within.is_empty() && within.iter().all(held));
    let velocity = simulation.velocity();
    let speeds = within.iter().map(|&i| velocity[i].norm());
    speeds.fold(0.0, f64::max)
}

#[test]
fn uniform_stretch_does_not_move_an_uneven_packing() {
    for (stress, _) in STRESS_STEPS {
        let [relaxed, stretched] = [1.0, 40.0].map(|stretch| {
            let mut s = uneven(stress, 8.0);
            s.periodic = [true; 3];
            let start = flowing("stretched", s, |_| Vec3::zeros()).unwrap();
            fastest(start, stretch, f64::INFINITY)
        });
        eprintln!("{stress:?}: {relaxed:e} m/s relaxed, {stretched:e} stretched");
        // 0.08 m/s with the mean of the stress left in.
        assert!(stretched < 1.2 * relaxed + 1e-9);
    }
}

/// Stretched along a floor it lies on, fluid pulls at no surface; beneath that nothing moves it. (With sums of
/// the stress everywhere it moves at 0.02 m/s there.)
#[test]
fn uniform_stretch_does_not_move_an_uneven_packing_on_a_floor() {
    for (stress, most) in STRESS_STEPS {
        let [relaxed, stretched] = [1.0, 40.0].map(|stretch| {
            let mut s = uneven(stress, 16.0);
            s.periodic = [true, true, false];
            let deep = 3.0 * SPACING;
            let floor = Aabb {
                min: Vec3::new(0.0, 0.0, -deep),
                max: Vec3::new(s.domain.max.x, s.domain.max.y, 0.0),
            };
            s.domain.min.z = -deep;
            s.domain.max.z += deep;
            let solid = Solid {
                shapes: vec![Shape::HalfSpace {
                    point: Vec3::zeros(),
                    normal: Vec3::z(),
                }],
                grids: Vec::new(),
            };
            let walls = walls(&solid, floor, Vec3::zeros(), SPACING, deep);
            let start = Simulation::new(s, solid, walls).unwrap();
            fastest(start, stretch, 4.0 * SPACING)
        });
        eprintln!("{stress:?}: {relaxed:e} m/s relaxed, {stretched:e} stretched");
        assert!(stretched < relaxed + most);
    }
}
