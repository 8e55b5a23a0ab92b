//! Fig. 9 of [IMM-CT]: the largest fixed step at which the mixing tank survives, scheme by scheme.
//!
//! Reached with `--level quick` (2 mm, 0.4 s, one seed) at 1 : 1000, in CFL steps of 1.7 ms: imm 0.125, explicit imm_ct 0.71
//! with λ = 50 ms and 0.35 with 1 ms, everything coupled at least 2, which is as far as the search goes.

use super::scenes::SUPPORT;
use super::tank::{Fate, LIQUID, Tank, cfl_step, tip_speed};
use super::{Bench, Findings, Study, StudyError};
use crate::math::Real;
use crate::report::{Axis, Cell, Look, Plot, Series, Table};
use crate::sim::{Scheme, StressStep};
use serde_json::json;

pub(super) const STUDY: Study = Study {
    name: "max-step",
    about: "largest stable step of each scheme against the viscosity ratio (Fig. 9)",
    answer,
};

/// A scheme as compared: name, scheme, how stress is stepped, λ [s].
const SCHEMES: [(&str, Scheme, StressStep, Real); 7] = [
    ("dfsph", Scheme::Dfsph, StressStep::Explicit, 0.0),
    ("imm", Scheme::Imm, StressStep::Explicit, 0.0),
    (
        "imm, implicit viscosity",
        Scheme::Imm,
        StressStep::Coupled,
        0.0,
    ),
    ("imm_ct explicit", Scheme::ImmCt, StressStep::Explicit, 0.05),
    (
        "imm_ct explicit, 1 ms",
        Scheme::ImmCt,
        StressStep::Explicit,
        1e-3,
    ),
    ("imm_ct coupled", Scheme::ImmCt, StressStep::Coupled, 0.05),
    (
        "imm_ct coupled, 1 ms",
        Scheme::ImmCt,
        StressStep::Coupled,
        1e-3,
    ),
];

/// Distance between particles [m].
const SPACING: Real = 2e-3;

/// Where the search ended: the largest step that passed and the least that failed above it, in CFL steps.
#[derive(Clone, Debug, Default, PartialEq)]
struct Bracket {
    pass: Option<Real>,
    fail: Option<Real>,
    /// A step below the largest that passed fails.
    ragged: bool,
}

/// Steps tried lie between these, in CFL steps.
const LEAST: Real = 1.0 / 4096.0;
const MOST: Real = 2.0;

fn search(
    first: Real,
    ratio: Real,
    mut passes: impl FnMut(Real) -> Result<bool, StudyError>,
) -> Result<Bracket, StudyError> {
    let mut bracket = Bracket::default();
    let mut step = first;
    while (LEAST..=MOST).contains(&step) {
        if passes(step)? {
            bracket.pass = Some(step);
            if bracket.fail.is_some() {
                break;
            }
            step *= 2.0;
        } else {
            bracket.fail = Some(step);
            if bracket.pass.is_some() {
                break;
            }
            step *= 0.5;
        }
    }
    while let Bracket {
        pass: Some(pass),
        fail: Some(fail),
        ..
    } = bracket
    {
        if fail / pass <= ratio {
            break;
        }
        let middle = (pass * fail).sqrt();
        if passes(middle)? {
            bracket.pass = Some(middle);
        } else {
            bracket.fail = Some(middle);
        }
    }
    // Stability need not be monotone: a step that fails below one that passed counts.
    let Some(found) = bracket.pass else {
        return Ok(bracket);
    };
    let mut shares = vec![0.5, 0.7];
    while let Some(share) = shares.pop() {
        let step = share * found;
        if passes(step)? {
            bracket.pass = bracket.pass.or(Some(step));
        } else {
            (bracket.pass, bracket.fail, bracket.ragged) = (None, Some(step), true);
        }
        if shares.is_empty() && bracket.pass.is_none() && step >= LEAST {
            shares.push(0.5 * share);
        }
    }
    Ok(bracket)
}

fn answer(bench: &mut Bench) -> Result<Findings, StudyError> {
    let viscosities: &[Real] = bench
        .level
        .pick(&[0.1, 1.0, 10.0], &[0.01, 0.1, 1.0, 10.0, 100.0]);
    let seeds = bench.level.pick(1, 3);
    let narrow = bench.level.pick(1.3, 1.05);
    let duration = bench.level.pick(0.4, 1.2);
    let cfl = cfl_step(SPACING);
    let mut table = Table::new(&[
        "scheme",
        "relaxation time [s]",
        "viscosity ratio",
        "seed",
        "largest stable step [s]",
        "of the CFL step",
        "least step that failed [s]",
        "why",
        "monotone",
        "seconds a simulated second there",
    ]);
    let mut plot = Plot {
        title: "Largest stable step of the mixing tank".into(),
        x: Axis::log("viscosity of the polymer / of the liquid"),
        y: Axis::log("step [s]"),
        series: vec![Series {
            name: "CFL".into(),
            points: viscosities.iter().map(|v| [v / LIQUID, cfl]).collect(),
            look: Look::Dashes,
            colour: 7,
        }],
    };
    let mut costs = Plot {
        title: "What a simulated second costs".into(),
        x: Axis::log("step [s]"),
        y: Axis::log("seconds of wall clock a simulated second"),
        series: Vec::new(),
    };
    let mut facts = Vec::new();
    let mut at_most: Vec<(&str, Option<Real>)> = Vec::new();
    for (colour, (name, scheme, stress, relaxation_time)) in SCHEMES.into_iter().enumerate() {
        let mut points = Vec::new();
        let mut prices = Vec::new();
        for &viscosity in viscosities {
            let mut least: Option<Real> = Some(Real::INFINITY);
            for seed in 1..=seeds {
                let mut fates: Vec<(Real, Fate)> = Vec::new();
                // Explicit ones start under what their linear limits would say.
                let first = match stress {
                    StressStep::Explicit => 0.25,
                    _ => 1.0,
                };
                let bracket = search(first, narrow, |share| {
                    let tank = Tank {
                        scheme,
                        stress,
                        viscosity,
                        relaxation_time,
                        thinning: 0.5,
                        spacing: SPACING,
                        step: Some(share * cfl),
                        seed,
                        duration,
                        tolerance: 1.0,
                        support_ratio: SUPPORT,
                    };
                    let run =
                        format!("{name}-{viscosity}-{seed}-{share:.5}").replace([' ', ','], "_");
                    let (fate, _) = bench.run(&run, &tank, || tank.run(&run))?;
                    let passed = fate.collapse.is_none();
                    fates.push((share, fate));
                    Ok(passed)
                })?;
                let at =
                    |share: Option<Real>| fates.iter().find(|f| Some(f.0) == share).map(|f| &f.1);
                prices.extend(
                    fates
                        .iter()
                        .filter(|f| f.1.collapse.is_none())
                        .map(|f| [f.0 * cfl, f.1.cost]),
                );
                let step = |share: Option<Real>| share.map_or(Cell::None, |s| (s * cfl).into());
                table.row(vec![
                    name.into(),
                    relaxation_time.into(),
                    (viscosity / LIQUID).into(),
                    Real::from(seed as u32).into(),
                    step(bracket.pass),
                    bracket.pass.map_or(Cell::None, Into::into),
                    step(bracket.fail),
                    at(bracket.fail)
                        .and_then(|f| f.collapse)
                        .map_or("none failed".to_owned(), |why| why.to_string())
                        .into(),
                    if bracket.ragged { "no" } else { "yes" }.into(),
                    at(bracket.pass).map_or(Cell::None, |f| f.cost.into()),
                ]);
                least = least.zip(bracket.pass).map(|(a, b)| a.min(b));
            }
            if let Some(least) = least {
                points.push([viscosity / LIQUID, least * cfl]);
            }
            if Some(&viscosity) == viscosities.last() {
                at_most.push((name, least));
            }
            facts.push(json!({
                "scheme": name, "ratio": viscosity / LIQUID, "cfl_steps": least,
            }));
        }
        for (plot, points, look) in [
            (&mut plot, points, Look::Chain),
            (&mut costs, prices, Look::Dots),
        ] {
            plot.series.push(Series {
                name: name.to_owned(),
                points,
                look,
                colour,
            });
        }
    }
    let of = |wanted: &str| at_most.iter().find(|(name, _)| *name == wanted)?.1;
    let times = |name: &str| match (of(name), of("imm")) {
        (Some(step), Some(imm)) => format!("{:.1}", step / imm),
        _ => "unknown".into(),
    };
    Ok(Findings {
        summary: format!(
            "the CFL step is {:.2} ms; at the highest ratio explicit imm_ct takes {} times the step of imm, coupled \
             imm_ct at least {} times",
            cfl * 1e3,
            times("imm_ct explicit"),
            times("imm_ct coupled")
        ),
        tables: vec![(String::new(), table)],
        pictures: vec![
            (String::new(), plot.to_png()),
            ("cost".to_owned(), costs.to_png()),
        ],
        facts: json!({ "cfl_step": cfl, "tip_speed": tip_speed(), "largest": facts }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_brackets_a_limit_wherever_it_is() {
        for limit in [0.001, 0.02, 0.25, 0.9, 1.7] {
            let bracket = search(0.25, 1.05, |step| Ok(step <= limit)).expect("no run fails");
            let (pass, fail) = (bracket.pass.expect("passes"), bracket.fail.expect("fails"));
            assert!(
                pass <= limit && limit < fail && fail / pass <= 1.05,
                "{limit}"
            );
            assert!(!bracket.ragged);
        }
        let always = search(0.25, 1.05, |_| Ok(true)).expect("no run fails");
        assert_eq!((always.pass, always.fail), (Some(MOST), None));
        assert_eq!(
            search(0.25, 1.05, |_| Ok(false))
                .expect("no run fails")
                .pass,
            None
        );
    }

    #[test]
    fn a_limit_with_a_hole_below_is_called_ragged_and_the_smaller_step_counts() {
        let holed = |step: Real| Ok(step <= 1.0 && !(0.6..0.8).contains(&step));
        let bracket = search(0.25, 1.05, holed).expect("no run fails");
        assert!(bracket.ragged);
        assert_eq!(bracket.pass, Some(0.5));
        let lower = |step: Real| Ok(step <= 1.0 && !(0.3..0.6).contains(&step));
        let bracket = search(1.0, 1.05, lower).expect("no run fails");
        assert!(bracket.ragged);
        assert_eq!((bracket.pass, bracket.fail), (Some(0.25), Some(0.5)));
    }
}
