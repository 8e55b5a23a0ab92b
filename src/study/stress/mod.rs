//! A matrix of short runs that ask for trouble: which of them fall over, and why. Steps that the program chooses itself
//! must never.
//!
//! Reached with `--level full` (666 runs, 18 of them refused before they begin, all of more dose than room): all of 216
//! runs with adaptive steps hold and none loses a particle: stirred pots at every viscosity ratio from 1 to 1e5, an
//! overlapping fan, a density ratio of 10, fluid started in walls, two bodies in one place, struts squeezed at ten times the
//! sane speed, also until full, lone particles, plates of four to half a spacing under 3 MPa; all goals of the solvers met
//! (36 steps were taken back), volumes kept to 1.5e-15, the energy's books closed to 0.01 %. Of 444 runs with fixed steps 142
//! fall.
//!
//! Not reached: what the method itself loses of the energy, which the books tell apart, is large in such scenes (up to 0.99
//! of all that was turned over where fluid falls on a plate: pressure undoes compression), and in 11 of the runs it gives
//! more than 5 %, up to 16 %. In a cell that is sheared steadily it is small (`tests/physics/energy.rs`).

mod map;
mod scenes;
mod trial;

use super::watch::Collapse;
use super::{Bench, Findings, Level, Study, StudyError};
use crate::math::{Real, Stream};
use crate::report::{Cell, Table};
use serde_json::json;
use std::collections::BTreeMap;
use trial::{End, Family, Fate, Mode, Trial};

pub(super) const STUDY: Study = Study {
    name: "stress",
    about: "hundreds of short runs that ask for trouble: which fall over, and why",
    answer,
};

/// Viscosities of the polymer by that of the liquid [1].
const RATIOS: [Real; 6] = [1.0, 10.0, 1e2, 1e3, 1e4, 1e5];
/// Speeds of the blade [m/s].
const SPEEDS: [Real; 2] = [0.1, 1.0];
/// λ [s].
const MEMORIES: [Real; 3] = [1e-3, 0.05, 1.0];
/// γ [1/s].
const THINNINGS: [Real; 2] = [0.0, 5.0];
/// Distances between particles [m].
const SPACINGS: [Real; 3] = [0.5e-3, 1e-3, 2e-3];
/// Speed in the needle [m/s]: ten times that of 0.2 ml/s through 11G.
const SQUEEZE: Real = 0.45;

/// Every trial. Spacings and seeds are dealt out to the settings, the same for all modes.
fn matrix() -> Vec<Trial> {
    let mut deal = Stream::new(1, "stress");
    let mut dealt = move || {
        let draw = deal.cube();
        let spacing = SPACINGS[(1.5 * (draw.x + 1.0)) as usize % 3];
        (spacing, if draw.y < 0.0 { 1 } else { 2 })
    };
    let mut settings = Vec::new();
    for ratio in RATIOS {
        for speed in SPEEDS {
            for relaxation_time in MEMORIES {
                for thinning in THINNINGS {
                    let (spacing, seed) = dealt();
                    settings.push(Trial {
                        family: Family::Stirred,
                        ratio,
                        speed,
                        relaxation_time,
                        thinning,
                        spacing,
                        seed,
                        mode: Mode::ALL[0],
                    });
                }
            }
        }
    }
    let special = [
        (Family::Overlapping, 0.5),
        (Family::Dense, 0.5),
        (Family::InWalls, 0.5),
        (Family::Doubled, 0.5),
        (Family::Squeezed, SQUEEZE),
        (Family::Filled, SQUEEZE),
        (Family::Overfilled, SQUEEZE),
        (Family::Single, 0.0),
        (Family::Cornered, 0.0),
        (Family::Plate(4.0), 0.0),
        (Family::Plate(2.0), 0.0),
        (Family::Plate(1.0), 0.0),
        (Family::Plate(0.5), 0.0),
    ];
    for (family, speed) in special {
        for ratio in [1.0, 1e3, 1e5] {
            let (spacing, seed) = dealt();
            settings.push(Trial {
                family,
                ratio,
                speed,
                relaxation_time: 0.05,
                thinning: 0.5,
                spacing,
                seed,
                mode: Mode::ALL[0],
            });
        }
    }
    let all = settings.into_iter();
    all.flat_map(|trial| Mode::ALL.map(|mode| Trial { mode, ..trial }))
        .collect()
}

/// A share of the trials, drawn by lot, each family among them.
fn some(trials: Vec<Trial>, share: Real) -> Vec<Trial> {
    let mut lot = Stream::new(7, "stress");
    trials.into_iter().filter(|_| lot.unit() < share).collect()
}

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let trials = match bench.level {
        Level::Quick => some(matrix(), 0.12),
        Level::Full => matrix(),
    };
    let fates = bench.side_by_side(&trials, |trial| {
        let (fate, _) = bench.run(&trial.name(), trial, || trial.run())?;
        Ok((*trial, fate))
    })?;
    let table = table(&fates);
    let count = |of: &dyn Fn(&Trial, &Fate) -> bool| {
        fates.iter().filter(|(trial, fate)| of(trial, fate)).count()
    };
    let adaptive = count(&|trial, _| trial.mode.is_adaptive());
    let fixed = fates.len() - adaptive;
    let fell = |fate: &Fate| matches!(fate.end, End::Collapsed(_));
    let collapsed = count(&|trial, fate| trial.mode.is_adaptive() && fell(fate));
    let collapsed_fixed = count(&|trial, fate| !trial.mode.is_adaptive() && fell(fate));
    let escaped = count(&|trial, fate| trial.mode.is_adaptive() && fate.escaped > 0);
    let not_finite = count(&|trial, fate| {
        trial.mode.is_adaptive() && fate.end == End::Collapsed(Collapse::NonFinite)
    });
    let refused = count(&|_, fate| matches!(fate.end, End::Refused(_)));
    let drift = fates.iter().filter(|(trial, _)| trial.mode.is_adaptive());
    let drift = drift.map(|(_, fate)| fate.drift).fold(0.0, Real::max);
    let imbalance = fates
        .iter()
        .filter(|(trial, _)| trial.mode.is_adaptive())
        .filter_map(|(_, fate)| Some(fate.imbalance?[0].abs()))
        .fold(0.0, Real::max);
    let mut reasons: BTreeMap<String, u64> = BTreeMap::new();
    for (trial, fate) in &fates {
        if let End::Collapsed(why) = fate.end {
            *reasons
                .entry(format!("{}: {why}", trial.mode.name()))
                .or_default() += 1;
        }
    }
    Ok(Findings {
        summary: format!(
            "{adaptive} runs with adaptive steps: {collapsed} collapsed, {escaped} lost particles, {not_finite} not finite, \
             volume kept to {drift:.1e}, energy to {:.1} %; {fixed} with fixed steps: {collapsed_fixed} collapsed; {refused} of all refused",
            100.0 * imbalance
        ),
        tables: vec![(String::new(), table)],
        pictures: vec![(String::new(), map::draw(&fates)?)],
        facts: json!({
            "runs": fates.len(),
            "adaptive": { "runs": adaptive, "collapsed": collapsed, "escaped": escaped, "not_finite": not_finite,
                          "volume_drift": drift, "energy_imbalance": imbalance },
            "fixed": { "runs": fixed, "collapsed": collapsed_fixed },
            "refused": refused,
            "reasons": reasons,
        }),
    })
}

fn table(fates: &[(Trial, Fate)]) -> Table {
    let mut table = Table::new(&[
        "family",
        "steps",
        "viscosity ratio",
        "speed [m/s]",
        "relaxation time [s]",
        "thinning [1/s]",
        "spacing [m]",
        "seed",
        "how it ended",
        "time reached / asked for",
        "particles",
        "steps made",
        "retries",
        "unconverged",
        "least step / CFL step",
        "escaped",
        "in walls",
        "volume drift",
        "energy imbalance",
        "energy lost to the method",
    ]);
    for (trial, fate) in fates {
        let ended: Cell = match &fate.end {
            End::Stable => "stable".into(),
            End::Refused(why) => format!("refused: {why}").into(),
            End::Collapsed(why) => why.to_string().into(),
        };
        let share = |k: usize| match fate.imbalance {
            Some(shares) => shares[k].into(),
            None => Cell::from(""),
        };
        table.row(vec![
            trial.family.name().into(),
            trial.mode.name().into(),
            trial.ratio.into(),
            trial.speed.into(),
            trial.relaxation_time.into(),
            trial.thinning.into(),
            trial.spacing.into(),
            trial.seed.into(),
            ended,
            fate.reached.into(),
            fate.particles.into(),
            fate.steps.into(),
            fate.retries.into(),
            fate.unconverged.into(),
            fate.least_step.into(),
            fate.escaped.into(),
            fate.in_walls.into(),
            fate.drift.into(),
            share(0),
            share(1),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::StressStep;

    #[test]
    fn the_matrix_is_large_and_no_two_trials_share_a_name() {
        let trials = matrix();
        assert!(trials.len() >= 300);
        let names: std::collections::BTreeSet<String> = trials.iter().map(Trial::name).collect();
        assert_eq!(names.len(), trials.len());
    }

    /// A subset of the matrix, drawn by lot: what the program steps by itself stands, what is stepped explicitly at the
    /// CFL limit falls. With them every plate of half a spacing, which is the hardest to stand on.
    #[test]
    fn adaptive_steps_survive_what_fixed_explicit_ones_do_not() {
        let thin = |trial: &Trial| trial.family == Family::Plate(0.5);
        let plates = matrix().into_iter().filter(thin);
        let mut adaptive = 0;
        for trial in some(matrix(), 0.05).into_iter().chain(plates) {
            if trial.mode == Mode::ALL[0] {
                let fate = trial.run().unwrap();
                adaptive += 1;
                assert!(!matches!(fate.end, End::Collapsed(_)), "{trial:?} {fate:?}");
                assert_eq!((fate.escaped, fate.unconverged), (0, 0), "{trial:?}");
                assert!(fate.drift < 1e-12, "{trial:?} {fate:?}");
                let off = fate.imbalance.map_or(Real::NAN, |[off, _]| off.abs());
                assert!(off < 0.02, "{trial:?} {fate:?}");
            }
        }
        assert!(adaptive >= 3, "{adaptive}");
        let stiffest = |trial: &&Trial| {
            trial.mode == Mode::Fixed(StressStep::Explicit, 1.0)
                && (trial.ratio, trial.relaxation_time) == (1e5, 1e-3)
        };
        let trials = matrix();
        let trial = trials.iter().find(stiffest).unwrap();
        assert!(matches!(trial.run().unwrap().end, End::Collapsed(_)));
    }
}
