//! Shear waves in a periodic box: no walls, exact for Newtonian and Oldroyd-B fluids.

use crate::scenes::{flowing, newtonian, run, settings};
use osteoflow::math::Vec3;
use osteoflow::sim::{BodyShape, ElasticWaves, Scheme, SimSettings, StressStep, TimeStep};
use osteoflow::study::scenes::{body, boxed, viscoelastic};

fn periodic(n: f64, wavelength: f64) -> SimSettings {
    let dx = wavelength / n;
    let mut s = settings(dx, boxed(Vec3::new(7.0 * dx, wavelength, 7.0 * dx)));
    s.periodic = [true; 3];
    s.bodies = vec![body(BodyShape::Box(s.domain), 1.0)];
    s
}

/// Starts u_x = U cos(qy), runs to `end`, and projects the velocity back on the wave.
fn amplitude(s: SimSettings, end: f64) -> f64 {
    let q = std::f64::consts::TAU / s.domain.max.y;
    let speed = 0.01;
    let start = flowing("wave", s, |x| Vec3::x() * speed * (q * x.y).cos()).unwrap();
    let simulation = run(start, end);
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

/// Left to itself a step is explicit where the explicit limits allow it and coupled where they bind: same bits.
#[test]
fn a_step_solves_only_where_explicit_limits_bind() {
    let with = |stress, dt| {
        let mut s = periodic(32.0, 0.05);
        s.cement = newtonian(1000.0, 8.0);
        s.stress = stress;
        s.time_step = TimeStep::Fixed(dt);
        amplitude(s, 20.0 * dt)
    };
    // 0.12 ρ Δx²/η is 37 µs.
    for (dt, same) in [(30e-6, StressStep::Explicit), (45e-6, StressStep::Coupled)] {
        assert_eq!(with(StressStep::Auto, dt), with(same, dt), "{same:?}");
    }
    assert_ne!(
        with(StressStep::Explicit, 30e-6),
        with(StressStep::Coupled, 30e-6)
    );
}

/// Amplitude at 0.05 s less the exact one, −0.394344.
fn oldroyd(stress: StressStep, dt: f64) -> f64 {
    let mut s = periodic(32.0, 0.05);
    s.scheme = Scheme::ImmCt;
    s.stress = stress;
    s.elastic_waves = ElasticWaves::Resolved;
    s.cement = viscoelastic(1000.0, 0.01, 8.0, 0.05, 0.0);
    s.time_step = TimeStep::Fixed(dt);
    let got = amplitude(s, 0.05);
    eprintln!("{stress:?} dt {dt}: {got:.5}, exact -0.39434");
    got + 0.394_344
}

/// The elastic wave has swung through: explicit within 2 % of the start, fully implicit with its damping.
#[test]
fn oldroyd_b_wave_swings_as_it_should() {
    assert!(oldroyd(StressStep::Explicit, 2e-4).abs() < 0.02);
    assert!(oldroyd(StressStep::Coupled, 2e-4).abs() < 0.05);
    assert!(oldroyd(StressStep::Coupled, 1e-3).abs() < 0.12);
}
