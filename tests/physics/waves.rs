//! Shear waves in a periodic box: no walls, exact for Newtonian and Oldroyd-B fluids.

use crate::scenes::{newtonian, run, settings};
use osteoflow::fluid::{Cement, PerPhase, PhaseMaterial};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Body, BodyShape, Scheme, SimSettings, Simulation, StressStep, TimeStep};

fn periodic(n: f64, wavelength: f64) -> SimSettings {
    let dx = wavelength / n;
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(7.0 * dx, wavelength, 7.0 * dx),
    };
    let mut s = settings(dx, bounds);
    s.periodic = [true; 3];
    s.bodies = vec![Body {
        shape: BodyShape::Box(bounds),
        polymer_fraction: 1.0,
        velocity: Vec3::zeros(),
    }];
    s
}

/// Starts u_x = U cos(qy), runs to `end`, and projects the velocity back on the wave.
fn amplitude(s: SimSettings, end: f64) -> f64 {
    let q = std::f64::consts::TAU / s.domain.max.y;
    let mut simulation = Simulation::new(s, Default::default(), Default::default()).unwrap();
    let speed = 0.01;
    for i in 0..simulation.fluid.len() {
        let v = Vec3::new(speed * (q * simulation.fluid.position[i].y).cos(), 0.0, 0.0);
        simulation.fluid.phase_velocity[i] = PerPhase {
            liquid: v,
            polymer: v,
        };
    }
    let simulation = run(simulation, end);
    let velocity = simulation.velocity();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (x, v) in simulation.fluid.position.iter().zip(&velocity) {
        let c = (q * x.y).cos();
        sum += v.x * c;
        weight += c * c;
    }
    sum / weight / speed
}

#[test]
fn newtonian_wave_decays_as_it_should() {
    for stress in [StressStep::Explicit, StressStep::Coupled] {
        let mut s = periodic(32.0, 0.05);
        s.cement = newtonian(1000.0, 8.0);
        s.stress = stress;
        s.time_step = TimeStep::Fixed(if stress == StressStep::Explicit {
            3e-6 * 5.0
        } else {
            1e-4
        });
        let nu_q2 = 8e-3 * (std::f64::consts::TAU / 0.05).powi(2);
        let end = 1.0 / nu_q2;
        let got = amplitude(s, end);
        let exact = (-1.0_f64).exp();
        eprintln!("{stress:?} {got} {exact}");
        assert!((got / exact - 1.0).abs() < 0.05, "{stress:?} {got} {exact}");
    }
}

fn oldroyd(stress: StressStep, dt: f64, jitter: f64) -> Vec<f64> {
    let exact = [
        (0.01, 0.882_670),
        (0.02, 0.588_755),
        (0.05, -0.394_344),
        (0.1, 0.006_181),
        (0.2, -0.132_251),
    ];
    exact
        .iter()
        .take(3)
        .map(|&(t, want)| {
            let mut s = periodic(32.0, 0.05);
            s.scheme = Scheme::ImmCt;
            s.stress = stress;
            s.jitter = jitter;
            s.cement = Cement {
                liquid: PhaseMaterial {
                    density: 1000.0,
                    viscosity: 0.01,
                },
                polymer: PhaseMaterial {
                    density: 1000.0,
                    viscosity: 8.0,
                },
                relaxation_time: 0.05,
                ..newtonian(1000.0, 8.0)
            };
            s.time_step = TimeStep::Fixed(dt);
            let got = amplitude(s, t);
            eprintln!("{stress:?} dt {dt} jitter {jitter}: t {t} got {got:.5} exact {want}");
            got - want
        })
        .collect()
}

#[test]
fn oldroyd_b_wave_swings_as_it_should() {
    for (stress, dt) in [
        (StressStep::Explicit, 2e-4),
        (StressStep::Coupled, 2e-4),
        (StressStep::Coupled, 1e-3),
    ] {
        for jitter in [0.0, 0.1] {
            for error in oldroyd(stress, dt, jitter) {
                assert!(error.abs() < 0.15, "{error}");
            }
        }
    }
}
