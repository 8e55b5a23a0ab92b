//! Energy: what gravity and moving walls give is held or lost, and nothing comes from nowhere.

use osteoflow::math::{Real, Vec3};
use osteoflow::sim::{BodyShape, Energy, Scheme, Simulation, StressStep, TimeStep};
use osteoflow::solid::Solid;
use osteoflow::sph::WallParticles;
use osteoflow::study::scenes::{
    Lie, body, boxed, flowing, newtonian, settings, shear_cell, viscoelastic,
};

const GAP: Real = 0.02;
const MEMORY: Real = 0.05;

/// The books at the end, and what is held then.
fn books(simulation: &mut Simulation) -> (Energy, Real) {
    let ledger = simulation.ledger();
    (
        ledger.energy.expect("kept"),
        ledger.kinetic + ledger.elastic,
    )
}

/// A cell of viscoelastic fluid under a plate that moves off at once, sheared for three memories.
fn sheared(wi: Real, thinning: Real, steps_per_memory: Real) -> (Energy, Real) {
    let lie = Lie {
        turned: true,
        seed: 4,
    };
    let speed = wi / MEMORY * GAP;
    let mut place = shear_cell(GAP, 12, lie, speed, 0.5 * MEMORY);
    let s = &mut place.settings;
    s.scheme = Scheme::ImmCt;
    s.energy_balance = true;
    s.cement = viscoelastic(1000.0, 0.4, 8.0, MEMORY, thinning);
    s.time_step = TimeStep::Fixed(MEMORY / steps_per_memory);
    let mut simulation = place.start("sheared").unwrap();
    simulation.advance_to(3.0 * MEMORY, |_| {}).unwrap();
    books(&mut simulation)
}

#[test]
fn work_of_a_plate_on_a_polymer_is_held_or_lost() {
    for (wi, thinning, steps) in [
        (1.0, 0.0, 50.0),
        (5.0, 0.0, 50.0),
        (5.0, 4.0, 50.0),
        (1.0, 0.0, 5.0),
    ] {
        let (e, held) = sheared(wi, thinning, steps);
        let residual = e.residual(held) / e.walls;
        eprintln!("Wi {wi}, gamma {thinning}, {steps} steps: {residual:.4} of {e:?}");
        assert!(residual.abs() < 0.03, "{residual}");
        // What the method takes is small where steps resolve the memory.
        let most = 0.04 * 50.0 / steps;
        assert!(e.numerical().abs() / e.walls < most, "{e:?}");
        assert!(e.slipped.abs() < 1e-9 * e.walls);
        assert!(e.viscous > 0.0 && e.relaxed > 0.0);
    }
}

/// A block of fluid in free fall: the work of gravity is its kinetic energy, to rounding, in every scheme.
#[test]
fn work_of_gravity_is_kinetic_energy() {
    for (scheme, stress) in [
        (Scheme::Dfsph, StressStep::Explicit),
        (Scheme::Imm, StressStep::Coupled),
        (Scheme::ImmCt, StressStep::Coupled),
        (Scheme::ImmCt, StressStep::Explicit),
    ] {
        let dx = 1e-3;
        let mut s = settings(dx, boxed(Vec3::new(8.0, 8.0, 40.0) * dx));
        s.scheme = scheme;
        s.stress = stress;
        s.energy_balance = true;
        s.gravity = -Vec3::z() * 9.81;
        s.cement = match scheme {
            Scheme::ImmCt => viscoelastic(1000.0, 0.4, 8.0, MEMORY, 0.0),
            _ => newtonian(1000.0, 1.0),
        };
        let mut block = boxed(Vec3::repeat(6.0 * dx));
        block.min += Vec3::new(1.0, 1.0, 30.0) * dx;
        block.max += Vec3::new(1.0, 1.0, 30.0) * dx;
        s.bodies = vec![body(BodyShape::Box(block), 1.0)];
        s.time_step = TimeStep::Fixed(1e-4);
        let mut simulation =
            Simulation::new(s, Solid::default(), WallParticles::default()).unwrap();
        let end = 0.04;
        simulation.advance_to(end, |_| {}).unwrap();
        // What the next step is expected to change; explicit ones ask for nothing.
        let fall = match stress {
            StressStep::Explicit => 0.0,
            _ => -9.81e-4,
        };
        let unlike = |change: &Vec3| (change - Vec3::z() * fall).norm();
        let worst = simulation
            .fluid
            .change
            .iter()
            .map(unlike)
            .fold(0.0, f64::max);
        assert!(worst < 0.02 * 9.81e-4, "{scheme:?} {stress:?}: {worst} m/s");
        let (e, held) = books(&mut simulation);
        let mass = 216.0 * 1000.0 * dx.powi(3);
        let exact = 0.5 * mass * (9.81 * end).powi(2);
        assert!((held / exact - 1.0).abs() < 1e-3, "{held} {exact}");
        // With the velocity at its end a step falls ½ g dt² too far, and the books say so.
        assert!((e.stepped / e.gravity - 1e-4 / end).abs() < 1e-3, "{e:?}");
        assert!(e.residual(held).abs() < 1e-6 * exact, "{e:?}");
        assert_eq!(e.carried, 0.0);
        assert!(
            (e.gravity - exact - e.stepped).abs() < 2e-3 * exact,
            "{e:?}"
        );
    }
}

/// A swirl dies by its own viscosity: what is lost is Φ = 2 η D:D and little else.
#[test]
fn kinetic_energy_of_a_swirl_is_lost_to_viscosity() {
    let dx = 1e-3;
    let across = 20;
    let size = Real::from(across) * dx;
    let mut s = settings(dx, boxed(Vec3::new(size, size, 7.0 * dx)));
    s.scheme = Scheme::Dfsph;
    s.energy_balance = true;
    s.periodic = [true; 3];
    let viscosity = 0.2;
    s.cement = newtonian(1000.0, viscosity);
    s.bodies = vec![body(BodyShape::Box(s.domain), 1.0)];
    let k = 2.0 * std::f64::consts::PI / size;
    let decay = 4.0 * viscosity / 1000.0 * k * k;
    s.time_step = TimeStep::Fixed(0.005 / decay);
    let speed = 0.1 * size * decay;
    let swirl = |x: &Vec3| {
        let (sx, cx) = (k * x.x).sin_cos();
        let (sy, cy) = (k * x.y).sin_cos();
        Vec3::new(sx * cy, -cx * sy, 0.0) * speed
    };
    let mut simulation = flowing("swirl", s, swirl).unwrap();
    simulation.advance_to(1.0 / decay, |_| {}).unwrap();
    let (e, held) = books(&mut simulation);
    eprintln!("{e:?} {held}");
    assert!((held / e.start / (-1.0_f64).exp() - 1.0).abs() < 0.05);
    assert!((e.viscous / (e.start - held) - 1.0).abs() < 0.02);
    assert!(e.residual(held).abs() < 1e-9 * e.start);
    assert_eq!(e.carried, 0.0);
}
