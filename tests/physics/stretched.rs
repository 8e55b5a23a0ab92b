//! Fluid that is stretched the same everywhere: its stress has no divergence, so it stays as it is.

use crate::scenes::{flowing, settings};
use osteoflow::math::{Aabb, Sym3, Vec3};
use osteoflow::sim::{Body, BodyShape, Scheme, StressStep, TimeStep};
use osteoflow::study::scenes::viscoelastic;

/// Fastest particle [m/s] after ten steps of a closed box whose particles lie unevenly, its fluid stretched to U_xx.
fn fastest(stress: StressStep, stretch: f64) -> f64 {
    let dx = 1e-3;
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::repeat(8.0 * dx),
    };
    let mut s = settings(dx, bounds);
    s.periodic = [true; 3];
    s.scheme = Scheme::ImmCt;
    s.stress = stress;
    s.jitter = 0.2;
    s.cement = viscoelastic(1000.0, 0.01, 8.0, 0.5, 0.1);
    s.time_step = TimeStep::Fixed(2e-5);
    s.bodies = vec![Body {
        shape: BodyShape::Box(bounds),
        polymer_fraction: 1.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    let mut simulation = flowing("stretched", s, |_| Vec3::zeros()).unwrap();
    let uniform = Sym3 {
        xx: stretch,
        ..Sym3::IDENTITY
    };
    simulation.fluid.conformation = vec![uniform; simulation.fluid.len()];
    simulation.advance_to(2e-4, |_| {}).unwrap();
    let held = |u: &Sym3| u.xx > 0.9 * stretch;
    assert!(simulation.fluid.conformation.iter().all(held));
    let speeds = simulation.velocity().into_iter().map(|v| v.norm());
    speeds.fold(0.0, f64::max)
}

#[test]
fn uniform_stretch_does_not_move_an_uneven_packing() {
    for stress in [StressStep::Coupled, StressStep::Explicit] {
        let [relaxed, stretched] = [1.0, 40.0].map(|stretch| fastest(stress, stretch));
        eprintln!("{stress:?}: {relaxed:e} m/s relaxed, {stretched:e} stretched");
        assert!(stretched < 1.2 * relaxed + 1e-9);
    }
}
