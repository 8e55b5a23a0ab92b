//! Fig. 6 of [IMM-CT]: how the polymer's viscosity falls with the shear rate, for γ from 0 to 1.
//!
//! Reached with `--level full`: 2e-12 in homogeneous flow, at most 0.31 % in the 39 cells of particles (γ 0.1, 100/s).

use super::exact::steady_shear;
use super::shear_cell;
use super::{Bench, Findings, Level, Study, StudyError};
use crate::fluid::conformation;
use crate::math::Real;
use crate::report::{Axis, Look, Plot, Series, Table};
use serde_json::json;

pub(super) const STUDY: Study = Study {
    name: "thinning",
    about: "viscosity against shear rate for six thinning factors (Fig. 6)",
    answer,
};

/// γ of the paper's curves [1/s].
const THINNING: [Real; 6] = [0.0, 0.1, 0.25, 0.5, 0.75, 1.0];
/// λ [s].
const RELAXATION: Real = 0.5;

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let per_decade = bench.level.pick(3, 10);
    let mut table = Table::new(&[
        "flow",
        "thinning [1/s]",
        "shear rate [1/s]",
        "viscosity ratio",
        "exact",
        "relative error",
    ]);
    let mut plot = Plot {
        title: "Shear thinning: exact (curves), alone (dots), in particles (rings)".into(),
        x: Axis::log("shear rate [1/s]"),
        y: Axis::log("polymer viscosity at rate / at rest without thinning"),
        series: Vec::new(),
    };
    let (mut worst, mut worst_cell): (Real, Real) = (0.0, 0.0);
    for (colour, gamma) in THINNING.into_iter().enumerate() {
        let ratio = |rate: Real, xy: Real| xy / (RELAXATION * rate);
        let curve = (-40..=60).map(|k| {
            let rate = libm::pow(10.0, 0.05 * Real::from(k));
            [rate, ratio(rate, steady_shear(RELAXATION, gamma, rate).xy)]
        });
        let curve = curve.collect();
        plot.series.push(Series {
            name: format!("thinning {gamma} /s"),
            points: curve,
            look: Look::Curve,
            colour,
        });
        let name = format!("homogeneous-{gamma}");
        let settings = ("homogeneous", RELAXATION, gamma, per_decade);
        let (points, _) = bench.run(&name, &settings, || Ok(homogeneous(gamma, per_decade)))?;
        let mut dots = Vec::new();
        for [rate, xy] in points {
            let exact = steady_shear(RELAXATION, gamma, rate).xy;
            let error = xy / exact - 1.0;
            worst = worst.max(error.abs());
            dots.push([rate, ratio(rate, xy)]);
            table.row(vec![
                "homogeneous".into(),
                gamma.into(),
                rate.into(),
                ratio(rate, xy).into(),
                ratio(rate, exact).into(),
                error.into(),
            ]);
        }
        plot.series.push(Series {
            name: String::new(),
            points: dots,
            look: Look::Dots,
            colour,
        });
        let rates = rates(bench.level, gamma);
        let readings = bench.side_by_side(rates, |&rate| {
            let name = format!("cell-{gamma}-{rate}");
            let settings = ("cell", RELAXATION, gamma, rate);
            let read = || shear_cell::read(&name, RELAXATION, gamma, rate);
            Ok(bench.run(&name, &settings, read)?.0)
        })?;
        let mut rings = Vec::new();
        for (&rate, reading) in rates.iter().zip(readings) {
            let exact = steady_shear(RELAXATION, gamma, rate).xy;
            let error = reading.xy / exact - 1.0;
            worst_cell = worst_cell.max(error.abs());
            rings.push([rate, ratio(rate, reading.xy)]);
            table.row(vec![
                "particles".into(),
                gamma.into(),
                rate.into(),
                ratio(rate, reading.xy).into(),
                ratio(rate, exact).into(),
                error.into(),
            ]);
        }
        plot.series.push(Series {
            name: String::new(),
            points: rings,
            look: Look::Rings,
            colour,
        });
    }
    Ok(Findings {
        summary: format!(
            "largest relative error of the viscosity: {worst:.1e} in homogeneous flow, {:.2} % in a cell of particles",
            100.0 * worst_cell
        ),
        tables: vec![(String::new(), table)],
        pictures: vec![(String::new(), plot.to_png())],
        facts: json!({
            "largest_error_homogeneous": worst,
            "largest_error_particles": worst_cell,
        }),
    })
}

/// Shear rates [1/s] of the cells of particles. Without thinning the stretch grows with the square of the rate: at
/// 10 1/s it is 50.
fn rates(level: Level, gamma: Real) -> &'static [Real] {
    match level {
        Level::Quick if gamma == 0.0 => &[0.1, 1.0],
        Level::Quick => &[0.1, 1.0, 10.0],
        Level::Full if gamma == 0.0 => &[0.1, 0.3, 1.0, 3.0, 10.0],
        Level::Full => &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0],
    }
}

/// Steady U_xy at shear rates from 0.01 to 1000 1/s, stepped with a tenth of λ' from rest.
fn homogeneous(gamma: Real, per_decade: i32) -> Vec<[Real; 2]> {
    let step = 0.1 * conformation::linear_relaxation_time(RELAXATION, gamma);
    (0..=5 * per_decade)
        .map(|k| {
            let rate = libm::pow(10.0, Real::from(k) / Real::from(per_decade) - 2.0);
            let sheared = shear_cell::alone(RELAXATION, gamma, rate, step).take(400);
            [rate, sheared.fold(0.0, |_, u| u.xy)]
        })
        .collect()
}
