//! What separates and mixes the phases: diffusion, and drift under a pressure gradient.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{Body, BodyShape, Scheme, Simulation, TimeStep};
use crate::solid::Solid;
use crate::sph::WallParticles;
use crate::study::scenes::{Lie, Norm, body, channel, newtonian, settings};

pub(super) const CASE: Case = Case {
    name: "phases",
    about: "phase diffusion, and the drift of heavy polymer in a light liquid",
    measure,
};

const DIFFUSION: Real = 1e-5;
const LENGTH: Real = 0.02;
/// √(4 D t) [m] at the end.
const SPREAD: Real = 0.1 * LENGTH;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![32, 64], vec![32, 64, 128]);
    let mut plot = Plot {
        title: "Two layers diffuse into each other".into(),
        x: Axis::linear("height / length"),
        y: Axis::linear("polymer fraction"),
        series: Vec::new(),
    };
    let mut profile_error = Refined::default();
    for &across in &sizes {
        let run = format!("diffusion-{across}");
        let (profile, seconds) =
            bench.run(&run, &(across, DIFFUSION, SPREAD), || diffuse(&run, across))?;
        let mut norm = Norm::default();
        for [y, alpha] in &profile {
            norm.add(*alpha, layers(*y));
        }
        profile_error.add(across, norm.relative(), seconds);
        if Some(&across) == sizes.last() {
            let line = (0..=200).map(|k| 0.005 * Real::from(k));
            let line = line.map(|y| [y, layers(y * LENGTH)]).collect();
            plot.series.push(curve("exact", 0, line));
            let points = profile.into_iter().map(|[y, alpha]| [y / LENGTH, alpha]);
            plot.series.push(dots(1, thinned(points.collect(), 90)));
        }
    }
    let mut figures = profile_error.figures("diffusion, L2 of the profile", "across", 0.01, None);
    let mut worst: Real = 0.0;
    let (mut united, mut seconds) = (0.0, 0.0);
    for drag in [0.0, 0.3, 0.7, 1.0] {
        let run = format!("drift-{drag}");
        let (slip, took) = bench.run(&run, &(drag, DRIFT_TIME), || {
            drift(&run, FRACTION, Friction::Given(drag))
        })?;
        seconds += took;
        let exact = drift_slip(FRACTION, drag);
        if exact == 0.0 {
            united = slip.abs();
        } else {
            worst = worst.max((slip / exact - 1.0).abs());
        }
    }
    // The more polymer, the more of it is bound to the liquid: C_d of the network is c itself where c is even.
    let (mut bound, mut rise, mut before) = (0.0_f64, Real::NEG_INFINITY, None);
    for fraction in [0.2, 0.4, 0.6, 0.8] {
        let run = format!("drift-bound-{fraction}");
        let (slip, took) = bench.run(&run, &(fraction, DRIFT_TIME), || {
            drift(&run, fraction, Friction::Network)
        })?;
        seconds += took;
        bound = bound.max((slip / drift_slip(fraction, fraction) - 1.0).abs());
        if let Some(before) = before.replace(slip) {
            rise = rise.max(slip / before - 1.0);
        }
    }
    for (what, reached, most) in [
        ("drift without friction, slip velocity", worst, 0.01),
        ("slip at C_d = 1 [m/s]", united, 1e-12),
        ("drift in a bonding network, slip velocity", bound, 0.01),
        ("drift in a bonding network, rise with c", rise, 0.0),
    ] {
        figures.push(Figure {
            what: what.into(),
            resolution: "20 high".into(),
            reached,
            goal: Goal::AtMost(most),
            seconds,
        });
    }
    Ok(Measured { figures, plot })
}

/// α at height y [m] after the layers, polymer in the upper half and periodic, have met for SPREAD²/4D.
fn layers(y: Real) -> Real {
    let step = |at: Real| 0.5 * (1.0 + libm::erf((y - at) / SPREAD));
    (-2..=2).fold(0.0, |sum, k| {
        let base = LENGTH * Real::from(k);
        sum + step(base + 0.5 * LENGTH) - step(base + LENGTH)
    })
}

fn diffuse(name: &str, across: u32) -> Result<Vec<[Real; 2]>, StudyError> {
    let dx = LENGTH / Real::from(across);
    let domain = crate::study::scenes::boxed(Vec3::new(7.0 * dx, LENGTH, 7.0 * dx));
    let mut s = settings(dx, domain);
    s.periodic = [true; 3];
    s.scheme = Scheme::Imm;
    s.cement = newtonian(1000.0, 1.0);
    s.cement.diffusion = DIFFUSION;
    let layer = |low: Real, high: Real, alpha: Real| -> Body {
        let mut bounds = domain;
        bounds.min.y = low * LENGTH;
        bounds.max.y = high * LENGTH;
        body(BodyShape::Box(bounds), alpha)
    };
    s.bodies = vec![layer(0.0, 0.5, 0.0), layer(0.5, 1.0, 1.0)];
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: 1.0,
        cfl: 0.4,
    };
    let mut simulation = Simulation::new(s, Solid::default(), WallParticles::default())
        .map_err(StudyError::run(name))?;
    simulation
        .advance_to(SPREAD * SPREAD / (4.0 * DIFFUSION), |_| {})
        .map_err(StudyError::run(name))?;
    let fluid = &simulation.fluid;
    let rows = fluid.position.iter().zip(&fluid.polymer_fraction);
    let mut profile: Vec<_> = rows.map(|(x, &alpha)| [x.y, alpha]).collect();
    profile.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(profile)
}

/// α of the polymer in the drift case.
const FRACTION: Real = 0.4;
const DRIFT_TIME: Real = 5e-3;
const GRAVITY: Real = 9.81;

fn light_and_heavy(drag: Real) -> Cement {
    let phase = |density: Real| PhaseMaterial {
        density,
        viscosity: 1.0,
    };
    Cement {
        liquid: phase(940.0),
        polymer: phase(1180.0),
        rest_drag: drag,
        ..newtonian(1000.0, 1.0)
    }
}

/// What holds the phases of a drifting layer together.
#[derive(Clone, Copy)]
enum Friction {
    /// C_d.
    Given(Real),
    /// The bonding network, C_d⁰ = 0 (Eq. 10), in its normalised form.
    Network,
}

/// v_polymer − v_liquid along gravity [m/s] at the end: pressure holds the mixture, M = ρ_mix g/c with
/// c = Σ α_k (C_d + (1 − C_d) ρ_mix/ρ_k), and moves a phase by M (C_d/ρ_mix + (1 − C_d)/ρ_k) against gravity.
fn drift_slip(fraction: Real, drag: Real) -> Real {
    let cement = light_and_heavy(drag);
    let (liquid, polymer) = (cement.liquid.density, cement.polymer.density);
    let mixture = cement.density(fraction);
    let compliance =
        drag + (1.0 - drag) * mixture * ((1.0 - fraction) / liquid + fraction / polymer);
    let force = mixture * GRAVITY / compliance;
    force * (1.0 - drag) * (1.0 / liquid - 1.0 / polymer) * DRIFT_TIME
}

/// The same from a run: a uniform mixture between two plates, gravity across.
fn drift(name: &str, fraction: Real, friction: Friction) -> Result<Real, StudyError> {
    let gap = 0.02;
    let lie = Lie {
        turned: false,
        seed: 2,
    };
    let mut place = channel(gap, 20, lie);
    let s = &mut place.settings;
    match friction {
        Friction::Given(drag) => {
            s.scheme = Scheme::Imm;
            s.cement = light_and_heavy(drag);
        }
        Friction::Network => {
            s.scheme = Scheme::ImmCt;
            s.cement = light_and_heavy(0.0);
            s.cement.relaxation_time = DRIFT_TIME;
            s.cement.normalised_bonding = true;
        }
    }
    s.gravity = -Vec3::y() * GRAVITY;
    for body in &mut s.bodies {
        body.polymer_fraction = fraction;
    }
    s.time_step = TimeStep::Fixed(DRIFT_TIME / 10.0);
    let mut simulation = place.start(name)?;
    simulation
        .advance_to(DRIFT_TIME, |_| {})
        .map_err(StudyError::run(name))?;
    let (mut slip, mut weight) = (0.0, 0.0);
    let fluid = &simulation.fluid;
    for (x, v) in fluid.position.iter().zip(&fluid.phase_velocity) {
        if x.y.abs() < 0.25 * gap {
            slip += v.liquid.y - v.polymer.y;
            weight += 1.0;
        }
    }
    Ok(slip / weight)
}
