//! What must be kept: volume of each phase, momentum, positivity, bits.

use crate::scenes::{newtonian, settings};
use osteoflow::fluid::{Cement, PhaseMaterial};
use osteoflow::math::{Aabb, Stream, Vec3};
use osteoflow::sim::{
    Body, BodyShape, Scheme, SimError, SimSettings, Simulation, StressStep, TimeStep,
};
use osteoflow::solid::Solid;
use osteoflow::sph::WallParticles;

fn cement() -> Cement {
    Cement {
        liquid: PhaseMaterial {
            density: 940.0,
            viscosity: 0.01,
        },
        polymer: PhaseMaterial {
            density: 1180.0,
            viscosity: 8.0,
        },
        relaxation_time: 0.05,
        thinning: 0.5,
        rest_drag: 0.3,
        diffusion: 1e-5,
        ..newtonian(1000.0, 1.0)
    }
}

/// A periodic box, one half liquid with a little polymer, the other half polymer.
fn stirred_box(scheme: Scheme, stress: StressStep) -> SimSettings {
    let dx = 1e-3;
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::repeat(10.0 * dx),
    };
    let half = |low: f64, high: f64, polymer_fraction: f64| Body {
        shape: BodyShape::Box(Aabb {
            min: Vec3::new(low * 10.0 * dx, 0.0, 0.0),
            max: Vec3::new(high * 10.0 * dx, 10.0 * dx, 10.0 * dx),
        }),
        polymer_fraction,
        velocity: Vec3::zeros(),
        saturated: false,
    };
    let mut s = settings(dx, bounds);
    s.periodic = [true; 3];
    s.scheme = scheme;
    s.stress = stress;
    s.jitter = 0.1;
    s.cement = cement();
    s.bodies = vec![half(0.0, 0.5, 0.1), half(0.5, 1.0, 1.0)];
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: 1e-3,
        cfl: 0.3,
    };
    s
}

fn stir(s: SimSettings, end: f64) -> (Simulation, osteoflow::sim::Ledger, osteoflow::sim::Ledger) {
    let mut simulation = Simulation::new(s, Solid::default(), WallParticles::default()).unwrap();
    let mut random = Stream::new(7, "stir");
    let n = simulation.fluid.len();
    for i in 0..n {
        let x = simulation.fluid.position[i] * (std::f64::consts::TAU / 0.01);
        let swirl = Vec3::new(
            x.y.sin() + x.z.cos(),
            x.x.sin() + x.z.sin(),
            x.x.cos() + x.y.cos(),
        ) * 0.05;
        simulation.fluid.phase_velocity[i].liquid =
            swirl + random.cube() * 0.01 + Vec3::new(0.02, 0.0, 0.0);
        simulation.fluid.phase_velocity[i].polymer = swirl + random.cube() * 0.01;
    }
    let before = simulation.ledger();
    let mut steps = 0;
    let mut converged = 0;
    simulation
        .advance_to(end, |r| {
            steps += 1;
            converged += u32::from(r.converged);
        })
        .unwrap();
    let after = simulation.ledger();
    eprintln!(
        "{steps} steps, {converged} converged; stretch {:?} dt {:e} {:?} kinetic {:e} -> {:e}",
        after.stretch, after.dt, after.limit, before.kinetic, after.kinetic
    );
    (simulation, before, after)
}

#[test]
fn closed_box_keeps_volume_momentum_and_positivity() {
    for (scheme, stress) in [
        (Scheme::ImmCt, StressStep::Coupled),
        (Scheme::ImmCt, StressStep::Explicit),
        (Scheme::Imm, StressStep::Coupled),
        (Scheme::Dfsph, StressStep::Coupled),
    ] {
        let (simulation, before, after) = stir(stirred_box(scheme, stress), 0.02);
        let volume = before.inside.liquid + before.inside.polymer;
        eprintln!(
            "{scheme:?} {stress:?}: polymer {:e} liquid {:e} momentum {:e}",
            (after.inside.polymer - before.inside.polymer) / volume,
            (after.inside.liquid - before.inside.liquid) / volume,
            (after.momentum - before.momentum).norm() / before.momentum.norm(),
        );
        assert!((after.inside.polymer - before.inside.polymer).abs() < 1e-12 * volume);
        assert!((after.inside.liquid - before.inside.liquid).abs() < 1e-12 * volume);
        assert!((after.momentum - before.momentum).norm() < 1e-10 * before.momentum.norm());
        assert!(after.stretch[0] > 0.0);
        assert!(
            simulation
                .fluid
                .polymer_fraction
                .iter()
                .all(|a| (0.0..=1.0).contains(a))
        );
        if scheme != Scheme::Dfsph {
            // The transfer did something: fractions between those of the start exist.
            assert!(
                simulation
                    .fluid
                    .polymer_fraction
                    .iter()
                    .any(|a| (0.2..0.9).contains(a))
            );
        }
    }
}

fn bits(simulation: &Simulation) -> Vec<u64> {
    let fluid = &simulation.fluid;
    let vectors = fluid.position.iter().chain(
        fluid
            .phase_velocity
            .iter()
            .flat_map(|v| [&v.liquid, &v.polymer]),
    );
    vectors
        .flat_map(|v| v.iter().map(|c| c.to_bits()).collect::<Vec<_>>())
        .chain(fluid.pressure.iter().map(|p| p[0].to_bits()))
        .chain(fluid.conformation.iter().map(|u| u.xy.to_bits()))
        .collect()
}

#[test]
fn same_bits_on_one_two_and_three_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bits(&stir(stirred_box(Scheme::ImmCt, StressStep::Coupled), 0.005).0))
    };
    let one = on(1);
    assert!(one == on(2));
    assert!(one == on(3));
}

#[test]
fn skipping_the_mixture_work_of_a_single_phase_changes_no_bit() {
    for alpha in [0.0, 1.0] {
        let run = |skip: bool| {
            let mut s = stirred_box(Scheme::ImmCt, StressStep::Coupled);
            s.skip_unneeded = skip;
            for body in &mut s.bodies {
                body.polymer_fraction = alpha;
                body.velocity = Vec3::new(0.01, 0.0, 0.0);
            }
            let mut simulation =
                Simulation::new(s, Solid::default(), WallParticles::default()).unwrap();
            for i in 0..simulation.fluid.len() {
                let x = simulation.fluid.position[i] * (std::f64::consts::TAU / 0.01);
                let swirl = Vec3::new(x.y.sin(), x.x.sin(), 0.0) * 0.05;
                simulation.fluid.phase_velocity[i].liquid = swirl;
                simulation.fluid.phase_velocity[i].polymer = swirl;
            }
            simulation.advance_to(0.01, |_| {}).unwrap();
            bits(&simulation)
        };
        assert!(run(true) == run(false), "alpha {alpha}");
    }
}

/// Falling over is an answer: it says who, where and when, and keeps the state.
#[test]
fn a_step_far_too_long_is_noticed() {
    let mut s = stirred_box(Scheme::ImmCt, StressStep::Explicit);
    s.time_step = TimeStep::Fixed(0.2);
    let mut simulation = Simulation::new(s, Solid::default(), WallParticles::default()).unwrap();
    for v in &mut simulation.fluid.phase_velocity {
        v.liquid.x = 1.0;
        v.polymer.x = 1.0;
    }
    let error = simulation.advance_to(10.0, |_| {}).unwrap_err();
    let SimError::Diverged { step, term, .. } = &error else {
        panic!("{error}")
    };
    assert!(*step >= 1 && !term.is_empty());
    assert!(error.to_string().contains("particle"), "{error}");
    assert!(!simulation.fluid.is_empty());
}

/// With steps that are let grow far too long, a run takes back those that fail, says so, and comes through; a fixed
/// step that fails leaves the state before it.
#[test]
fn a_step_that_fails_is_taken_back() {
    let mut s = stirred_box(Scheme::ImmCt, StressStep::Coupled);
    s.cement.diffusion = 0.0;
    s.time_step = TimeStep::Adaptive {
        min: 1e-7,
        max: 0.02,
        cfl: 60.0,
    };
    let mut simulation =
        Simulation::new(s.clone(), Solid::default(), WallParticles::default()).unwrap();
    for v in &mut simulation.fluid.phase_velocity {
        v.liquid.x = 1.0;
        v.polymer.x = 1.0;
    }
    let mut retries = 0;
    simulation
        .advance_to(0.05, |report| {
            assert!(report.converged);
            retries += report.retries;
        })
        .unwrap();
    assert!(retries > 0);
    let ledger = simulation.ledger();
    assert_eq!(u64::from(retries), ledger.retries);
    assert!(ledger.speed < 2.0 && ledger.stretch[0] > 0.0);

    s.time_step = TimeStep::Fixed(0.02);
    let mut fixed = Simulation::new(s, Solid::default(), WallParticles::default()).unwrap();
    for v in &mut fixed.fluid.phase_velocity {
        v.liquid.x = 1.0;
        v.polymer.x = 1.0;
    }
    let before = fixed.state();
    assert!(fixed.advance_to(0.05, |_| {}).is_err());
    assert!(fixed.state() == before);
}
