//! Fig. 9 of [IMM-CT]: the largest fixed step at which the mixing tank survives, scheme by scheme.
//!
//! Reached with `--level full` (2 mm, 1 s, brackets of 1.05; 68 min on two cores, shared), least of three seeds, in CFL steps of
//! 1.7 ms (2 is as far as the search goes; older than what coupled solves smooth pressure with and how particles move by them):
//!
//! | viscosity ratio | 1:1 | 1:10 | 1:100 | 1:1000 | 1:10 000 |
//! |---|---|---|---|---|---|
//! | dfsph, imm | 2 | 2 | 0.49 * | 0.125 | 0.012 |
//! | imm_ct explicit, λ = 50 ms | 2 | 1.6 | 0.59 * | 0.70 | 0.11 * |
//! | imm_ct explicit, 1 ms | 2 | 2 | 2 | 0.40 | 0.14 |
//! | imm, implicit viscosity; imm_ct coupled, 50 ms | 2 | 2 | 2 | 2 | 2 |
//! | imm_ct coupled, 1 ms | 2 | 2 | 2 | 2 | 1.6 |
//!
//! (*: in one seed not monotone: larger steps passed.) At 1 : 1000 by seed: imm 0.125, 0.131, 0.125, explicit imm_ct 0.77, 0.70,
//! 0.70: 5.6 times. At those steps a wave in the polymer is off the Newtonian answer by 0.7 % (imm), 63 and 11 % (explicit imm_ct),
//! 63 and 25 % (coupled), 15 % (imm coupled): 50 ms are another fluid, and 1 ms in a wave that lives for 3 ms is not quite the
//! same. With `--level quick` (0.4 s, one seed): 0.125, 0.71, 0.5 with 1 ms, coupled at least 2.

use super::bracket::{Bracket, Search, search};
use super::newtonian::Wave;
use super::scenes::SUPPORT;
use super::tank::{DENSITIES, Fan, Fate, LIQUID, Tank, cfl_step, tip_speed};
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

/// Distance between particles [m], and γ [1/s].
const SPACING: Real = 2e-3;
const THINNING: Real = 0.5;
/// Viscosity at which the summary compares [Pa·s].
const REFERENCE: Real = 10.0;

/// What has been tried of one scheme at one viscosity with one seed.
struct Found {
    seed: u64,
    bracket: Bracket,
    tries: Vec<Try>,
}

/// A tank, how it went, and how far off its step leaves the polymer alone from the Newtonian answer.
struct Try {
    share: Real,
    fate: Fate,
    off: Option<Real>,
}

/// A run ends after this many steps at the latest: explicit steps that are too long show it within some hundreds.
const MOST_STEPS: u64 = 10_000;

/// What is asked of each scheme at each viscosity.
struct Question {
    scheme: (&'static str, Scheme, StressStep, Real),
    viscosity: Real,
}

impl Question {
    /// Finds the largest step for every seed; the first one's is the next one's guess.
    fn answer(&self, bench: &Bench, fan: &Fan) -> Result<Vec<Found>, StudyError> {
        let (_, scheme, stress, relaxation_time) = self.scheme;
        let viscosity = self.viscosity;
        let seeds: &[(u64, &[Real])] = bench.level.pick(
            &[(1, &[0.5, 0.7])],
            &[(1, &[0.5]), (2, &[0.7]), (3, &[0.85])],
        );
        let narrow = bench.level.pick(1.3, 1.05);
        let cfl = cfl_step(SPACING);
        let mut guess: Option<Real> = None;
        let mut found = Vec::new();
        for &(seed, below) in seeds {
            let mut tries: Vec<Try> = Vec::new();
            let how = Search {
                // Explicit ones start under what their linear limits would say.
                first: guess.unwrap_or(match stress {
                    StressStep::Explicit => 0.25,
                    _ => 1.0,
                }),
                stride: if guess.is_some() { narrow } else { 2.0 },
                ratio: narrow,
                below,
            };
            let bracket = search(how, |share| {
                let tank = Tank {
                    scheme,
                    stress,
                    viscosity,
                    relaxation_time,
                    thinning: THINNING,
                    spacing: SPACING,
                    step: Some(share * cfl),
                    seed,
                    duration: bench.level.pick(0.4, 1.0),
                    most_steps: Some(MOST_STEPS),
                    tolerance: 1.0,
                    support_ratio: SUPPORT,
                };
                let run = format!("{}-{seed}-{share:.5}", self.name());
                let (fate, _) = bench.run(&run, &tank, || tank.run(&run, fan))?;
                let passed = fate.collapse.is_none();
                let off = match scheme {
                    Scheme::Dfsph => None,
                    _ if !passed => None,
                    _ => self.off(bench, share)?,
                };
                tries.push(Try { share, fate, off });
                Ok(passed)
            })?;
            guess = bracket.pass.or(guess);
            found.push(Found {
                seed,
                bracket,
                tries,
            });
        }
        Ok(found)
    }

    /// Its part of the names of runs.
    fn name(&self) -> String {
        format!("{}-{}", self.scheme.0, self.viscosity).replace([' ', ','], "_")
    }

    /// How far off the Newtonian answer a wave in the polymer is at this step.
    fn off(&self, bench: &Bench, share: Real) -> Result<Option<Real>, StudyError> {
        let (_, scheme, stress, relaxation_time) = self.scheme;
        let viscosity = self.viscosity;
        let wave = Wave {
            scheme,
            stress,
            density: DENSITIES[1],
            solvent: LIQUID,
            polymer: viscosity,
            relaxation_time,
            thinning: THINNING,
            spacing: SPACING,
            step: share * cfl_step(SPACING),
            speed: tip_speed(),
            longest: bench.level.pick(0.1, 0.4),
        };
        let run = format!("wave-{}-{share:.5}", self.name());
        let (off, _) = bench.run(&run, &wave, || wave.error(&run))?;
        Ok(off)
    }
}

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let viscosities: &[Real] = bench
        .level
        .pick(&[0.1, 1.0, 10.0], &[0.01, 0.1, 1.0, 10.0, 100.0]);
    let cfl = cfl_step(SPACING);
    let fan = Fan::new(SPACING, SUPPORT)?;
    let questions: Vec<Question> = SCHEMES
        .into_iter()
        .flat_map(|scheme| {
            viscosities
                .iter()
                .map(move |&viscosity| Question { scheme, viscosity })
        })
        .collect();
    let answers = bench.side_by_side(&questions, |question| question.answer(bench, &fan))?;
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
        "off the Newtonian answer there",
        "seconds a simulated second there",
    ]);
    let mut steps = Table::new(&[
        "scheme",
        "relaxation time [s]",
        "viscosity ratio",
        "seed",
        "step [s]",
        "of the CFL step",
        "how it ended",
        "time reached [s]",
        "off the Newtonian answer",
        "seconds a simulated second",
    ]);
    let mut plot = Plot {
        title: "Largest stable step of the mixing tank".into(),
        x: Axis::log("viscosity of the polymer / of the liquid"),
        y: Axis::log("step [s]"),
        series: vec![Series {
            name: "CFL".into(),
            points: viscosities.iter().map(|v| [v / LIQUID, cfl]).collect(),
            look: Look::Dashes,
            colour: SCHEMES.len(),
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
    let mut answers = questions.iter().zip(&answers);
    for (colour, (name, _, _, relaxation_time)) in SCHEMES.into_iter().enumerate() {
        let mut points = Vec::new();
        let mut prices = Vec::new();
        for (question, found) in answers.by_ref().take(viscosities.len()) {
            let ratio = question.viscosity / LIQUID;
            let mut least: Option<Real> = Some(Real::INFINITY);
            for Found {
                seed,
                bracket,
                tries,
            } in found
            {
                let about = || -> Vec<Cell> {
                    let seed = Real::from(*seed as u32);
                    vec![
                        name.into(),
                        relaxation_time.into(),
                        ratio.into(),
                        seed.into(),
                    ]
                };
                let at = |share: Option<Real>| tries.iter().find(|t| Some(t.share) == share);
                let number = |value: Option<Real>| value.map_or(Cell::None, Into::into);
                let (pass, fail) = (at(bracket.pass), at(bracket.fail));
                table.row(
                    [
                        about(),
                        vec![
                            number(bracket.pass.map(|share| share * cfl)),
                            number(bracket.pass),
                            number(bracket.fail.map(|share| share * cfl)),
                            (fail.and_then(|t| t.fate.collapse))
                                .map_or("none failed".to_owned(), |why| why.to_string())
                                .into(),
                            if bracket.ragged { "no" } else { "yes" }.into(),
                            number(pass.and_then(|t| t.off)),
                            number(pass.map(|t| t.fate.cost)),
                        ],
                    ]
                    .concat(),
                );
                for Try { share, fate, off } in tries {
                    let ended = fate.collapse.map(|why| why.to_string());
                    steps.row(
                        [
                            about(),
                            vec![
                                (share * cfl).into(),
                                (*share).into(),
                                ended.unwrap_or_else(|| "stable".into()).into(),
                                fate.time.into(),
                                number(*off),
                                fate.cost.into(),
                            ],
                        ]
                        .concat(),
                    );
                    if fate.collapse.is_none() {
                        prices.push([share * cfl, fate.cost]);
                    }
                }
                least = least.zip(bracket.pass).map(|(a, b)| a.min(b));
            }
            if let Some(least) = least {
                points.push([ratio, least * cfl]);
            }
            if question.viscosity == REFERENCE {
                at_most.push((name, least));
            }
            facts.push(json!({ "scheme": name, "ratio": ratio, "cfl_steps": least }));
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
            "the CFL step is {:.2} ms; at 1 : 1000 explicit imm_ct takes {} times the step of imm, coupled imm_ct at \
             least {} times",
            cfl * 1e3,
            times("imm_ct explicit"),
            times("imm_ct coupled")
        ),
        tables: vec![(String::new(), table), ("steps".into(), steps)],
        pictures: vec![
            (String::new(), plot.to_png()),
            ("cost".to_owned(), costs.to_png()),
        ],
        facts: json!({ "cfl_step": cfl, "tip_speed": tip_speed(), "largest": facts }),
    })
}
