//! The conformation tensor alone, in homogeneous flow: (Eq. 12) against closed forms.

use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::fluid::conformation::{advance, linear_relaxation_time};
use crate::math::{Mat3, Real, Stream, Sym3};
use crate::report::{Axis, Look, Plot, Series};
use crate::study::exact::{extension, steady_shear};
use crate::study::shear_cell::{alone, shear};

pub(super) const CASE: Case = Case {
    name: "conformation",
    about: "conformation tensor in homogeneous shear, start-up, extension and rotation",
    measure,
};

/// λ [s] and γ [1/s] of the points: with six shear rates each, 60 in all.
const FLUIDS: [(Real, Real); 10] = [
    (0.5, 0.0),
    (0.5, 0.1),
    (0.5, 0.25),
    (0.5, 0.5),
    (0.5, 0.75),
    (0.5, 1.0),
    (0.01, 0.5),
    (0.1, 1.0),
    (0.05, 0.5),
    (0.9, 0.2),
];
const RATES: [Real; 6] = [0.01, 0.1, 1.0, 10.0, 100.0, 1000.0];

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let settings = ("conformation", FLUIDS, RATES);
    let (results, seconds) = bench.run("conformation", &settings, || {
        Ok((
            points(),
            start_up(),
            extended(),
            rotated(),
            order(),
            least_stretch(),
        ))
    })?;
    let (points, start_up, extended, rotated, order, least) = results;
    let worst = points.iter().map(|p| p.2).fold(0.0, largest);
    let figure = |what: &str, resolution: &str, reached: Real, goal: Goal| Figure {
        what: what.into(),
        resolution: resolution.into(),
        reached,
        goal,
        seconds,
    };
    let tenth = "dt = λ'/10";
    let figures = vec![
        figure("steady shear, 60 points", tenth, worst, Goal::AtMost(1e-9)),
        figure("start-up of shear", tenth, start_up, Goal::AtMost(1e-9)),
        figure("uniaxial extension", tenth, extended, Goal::AtMost(1e-9)),
        figure("rigid rotation", "one turn", rotated, Goal::AtMost(1e-9)),
        figure(
            "order for unsteady flow",
            "dt, dt/2",
            order,
            Goal::AtLeast(1.9),
        ),
        figure(
            "least eigenvalue, violent flow",
            "10000 steps",
            least,
            Goal::AtLeast(0.0),
        ),
    ];
    Ok(Measured {
        figures,
        plot: plot(&points),
    })
}

fn plot(points: &[(Real, Real, Real, [Real; 2])]) -> Plot {
    let mut plot = Plot {
        title: "First normal stress difference in steady shear".into(),
        x: Axis::log("shear rate [1/s]"),
        y: Axis::log("U_xx − U_yy"),
        series: Vec::new(),
    };
    for (colour, (lambda, gamma)) in FLUIDS.into_iter().enumerate() {
        let exact = (-40..=60).map(|k| {
            let rate = libm::pow(10.0, 0.05 * Real::from(k));
            [rate, steady_shear(lambda, gamma, rate).first]
        });
        plot.series.push(Series {
            name: format!("{lambda} s, {gamma} /s"),
            points: exact.collect(),
            look: Look::Curve,
            colour,
        });
        let computed = points.iter().filter(|p| (p.0, p.1) == (lambda, gamma));
        plot.series.push(Series {
            name: String::new(),
            points: computed.map(|p| p.3).collect(),
            look: Look::Dots,
            colour,
        });
    }
    plot
}

/// NaN stays.
fn largest(a: Real, b: Real) -> Real {
    if a.is_nan() || a > b { a } else { b }
}

/// λ, γ, largest relative error of U_xy, N₁ and N₂ over G, and (rate, N₁/G), after 40 λ' from rest.
fn points() -> Vec<(Real, Real, Real, [Real; 2])> {
    let mut points = Vec::new();
    for (lambda, gamma) in FLUIDS {
        let step = 0.1 * linear_relaxation_time(lambda, gamma);
        for rate in RATES {
            let sheared = alone(lambda, gamma, rate, step).take(400);
            let u = sheared.fold(Sym3::IDENTITY, |_, u| u);
            let exact = steady_shear(lambda, gamma, rate);
            let (first, second) = (u.xx - u.yy, u.yy - u.zz);
            // Stresses that rounding of U = I + … leaves without digits count against U itself.
            let off = |got: Real, want: Real| (got - want).abs() / want.abs().max(1e-3);
            let error = off(u.xy, exact.xy);
            let error = largest(error, off(first, exact.first));
            let error = largest(error, off(second, exact.second));
            points.push((lambda, gamma, error, [rate, first]));
        }
    }
    points
}

/// Largest relative error of U_xy and N₁/G in start-up without thinning: λγ̇(1 − e^{−t/λ}) and
/// 2(λγ̇)²[1 − e^{−t/λ}(1 + t/λ)].
fn start_up() -> Real {
    let (lambda, rate) = (0.2, 3.0);
    let wi = lambda * rate;
    let mut worst = 0.0;
    for (step, u) in (1..=100).zip(alone(lambda, 0.0, rate, 0.1 * lambda)) {
        let t = 0.1 * Real::from(step);
        let left = libm::exp(-t);
        worst = largest(worst, (u.xy / (wi * (1.0 - left)) - 1.0).abs());
        let first = 2.0 * wi * wi * (1.0 - left * (1.0 + t));
        worst = largest(worst, ((u.xx - u.yy) / first - 1.0).abs());
    }
    worst
}

/// Largest relative error of the eigenvalues in steady extension.
fn extended() -> Real {
    let mut worst = 0.0;
    for (lambda, gamma, rate) in [
        (0.5, 0.5, 0.2),
        (0.5, 1.0, 10.0),
        (0.5, 0.0, 0.9),
        (0.05, 0.3, 100.0),
    ] {
        let flow = Mat3::from_diagonal(&[rate, -0.5 * rate, -0.5 * rate].into());
        let step = 0.1 * linear_relaxation_time(lambda, gamma);
        let mut u = Sym3::IDENTITY;
        // Without thinning it settles as slowly as 1/(s − 2 e).
        for _ in 0..6000 {
            u = advance(&u, &flow, lambda, gamma, step);
        }
        let [along, across] = extension(lambda, gamma, rate);
        worst = largest(worst, (u.xx / along - 1.0).abs());
        worst = largest(worst, (u.yy / across - 1.0).abs());
    }
    worst
}

/// Error of U after a full turn in ten steps without relaxation: it comes back.
fn rotated() -> Real {
    let spin = Mat3::new(0.0, -1.0, 0.4, 1.0, 0.0, -0.2, -0.4, 0.2, 0.0);
    let rate = (1.0_f64 + 0.4 * 0.4 + 0.2 * 0.2).sqrt();
    let start = Sym3 {
        xx: 2.0,
        yz: 0.3,
        ..Sym3::IDENTITY
    };
    let mut u = start;
    for _ in 0..10 {
        u = advance(&u, &spin, 1e15, 0.0, std::f64::consts::TAU / rate / 10.0);
    }
    (u - start).to_matrix().norm()
}

/// Observed order in unsteady flow, with the gradient of the middle of each step.
fn order() -> Real {
    let gradient = |t: Real| {
        shear(2.0 * libm::sin(3.0 * t)) + Mat3::new(0.3, 0.0, 0.1, 0.2, -0.1, 0.0, 0.0, 0.0, -0.2)
    };
    let end = |steps: u32| {
        let dt = 1.0 / Real::from(steps);
        (0..steps).fold(Sym3::IDENTITY, |u, n| {
            advance(&u, &gradient((Real::from(n) + 0.5) * dt), 0.3, 0.4, dt)
        })
    };
    let exact = end(20_000);
    let error = |steps| (end(steps) - exact).to_matrix().norm();
    libm::log2(error(50) / error(100))
}

/// Least eigenvalue over 10 000 steps with |L| dt up to a hundred.
fn least_stretch() -> Real {
    let mut random = Stream::new(8, "violent");
    let mut u = Sym3::IDENTITY;
    let mut least = Real::INFINITY;
    for _ in 0..10_000 {
        let size = libm::pow(10.0, random.between(-1.0, 2.0));
        let l = Mat3::from_fn(|_, _| random.between(-1.0, 1.0)) * size;
        let lambda = libm::pow(10.0, random.between(-3.0, 0.0));
        u = advance(&u, &l, lambda, random.unit(), random.between(0.0, 1.0));
        least = -largest(-least, -u.to_matrix().symmetric_eigenvalues().min());
        if u.trace() > 1e8 {
            u = Sym3::IDENTITY;
        }
    }
    least
}
