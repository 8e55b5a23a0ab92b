//! Run time against error: what an error costs, and which settings are the cheapest for it.
//!
//! Reached with `--level quick` (three minutes on two cores, one run each), coupled imm_ct at 16 spacings across (spheres
//! 12, tank 20), CFL numbers of 0.8, 0.4, 0.1: Poiseuille 4.9, 2.7, 0.9 %, Waters-King 2.8, 2.1, 1.7 %, spheres 3.8, 0.3,
//! 3.3 %, in 0.6, 1 and 3 times the time. A tolerance of a tenth changes the first two by a thirtieth, one of ten makes them
//! 1.5 and 1.7 times as large; a support ratio of 2 costs 0.8 and makes Poiseuille 1.13 times as wrong, 3 costs 1.6 and makes
//! it 0.92 times as wrong.
//!
//! Explicit steps are no worse with a tight solver (Poiseuille 0.74 and 0.72 % at a tolerance of 1 and 10). Explicit imm_ct
//! in the stirred tank is at its limit: of three runs at a CFL number of 0.4 one falls over (three of three before pressure
//! acted while walls rub). In spheres errors of opposite sign cancel (of the step and of the spacing), so cheap settings
//! found there are luck. The tank is held against its own finest run, scheme by scheme, so its errors do not compare
//! schemes; none is below 4.5 %.

mod cases;
mod setting;

use super::{Bench, Findings, Level, Study, StudyError};
use crate::math::Real;
use crate::report::{Axis, Cell, Look, Plot, Series, Table};
use crate::sim::{Scheme, StressStep};
use cases::{FLOWS, Flow, Outcome};
use serde_json::json;
use setting::{Setting, Variant, tried};

pub(super) const STUDY: Study = Study {
    name: "accuracy",
    about: "run time against error: the cheapest settings for 5, 2 and 1 %",
    answer,
};

/// Errors that settings are looked for.
const TARGETS: [Real; 3] = [0.05, 0.02, 0.01];

/// A run and what it came to.
type Run = (Setting, Outcome);

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let mut runs = Table::new(&[
        "flow",
        "scheme",
        "spacings across",
        "cfl",
        "tolerance",
        "support ratio",
        "error",
        "seconds",
        "steps",
        "particles",
        "cheapest",
    ]);
    let mut recommended = Table::new(&[
        "flow",
        "error",
        "scheme",
        "spacings across",
        "cfl",
        "tolerance",
        "support ratio",
        "reached",
        "costs [s]",
    ]);
    let mut fronts = plot("What an error costs: the cheapest settings of each flow");
    let mut pictures = Vec::new();
    let mut knobs = Vec::new();
    let mut least = Vec::new();
    for (number, flow) in FLOWS.iter().enumerate() {
        let mut done: Vec<Run> = Vec::new();
        for variant in Variant::ALL {
            if (flow.takes)(variant) {
                done.extend(measured(bench, flow, variant)?);
            } else {
                let mut row = vec![flow.name.into(), variant.name().into()];
                row.resize(11, Cell::None);
                runs.row(row);
            }
        }
        let front = cheapest(&done);
        for (n, (setting, outcome)) in done.iter().enumerate() {
            runs.row(vec![
                flow.name.into(),
                setting.variant.name().into(),
                u64::from(setting.across).into(),
                setting.cfl.into(),
                setting.tolerance.into(),
                setting.support_ratio.into(),
                outcome
                    .error
                    .map_or_else(|| "fell over".into(), Cell::Number),
                outcome.seconds.into(),
                outcome.steps.into(),
                outcome.particles.into(),
                if front.contains(&n) { "yes" } else { "" }.into(),
            ]);
        }
        recommend(&mut recommended, flow, &done);
        let best = front.last().and_then(|&n| done[n].1.error);
        if let Some(best) = best {
            least.push(format!("{} {:.2} %", flow.name, 100.0 * best));
        }
        let line = front.iter().map(|&n| point(&done[n].1)).collect();
        fronts.series.push(Series {
            name: flow.name.into(),
            points: line,
            look: Look::Chain,
            colour: number,
        });
        pictures.push((flow.name.to_owned(), picture(flow, &done, &front).to_png()));
        knobs.extend(compared(flow, bench.level, &done));
    }
    pictures.insert(0, (String::new(), fronts.to_png()));
    let knobs = averaged(&knobs);
    Ok(Findings {
        summary: format!("least errors: {}", least.join(", ")),
        facts: json!({
            "targets": TARGETS,
            "runs": runs.len(),
            "errors": FLOWS.iter().map(|flow| (flow.name, flow.measure)).collect::<Vec<_>>(),
        }),
        tables: vec![
            (String::new(), runs),
            ("recommended".into(), recommended),
            ("knobs".into(), knobs),
        ],
        pictures,
    })
}

/// All runs of a variant in a flow.
fn measured(bench: &Bench, flow: &Flow, variant: Variant) -> Result<Vec<Run>, StudyError> {
    let level = bench.level;
    let across = (flow.across)(level);
    let steps: &[Real] = level.pick(&[0.8, 0.4, 0.1], &[0.8, 0.4, 0.2, 0.1, 0.05]);
    let settings = tried(variant, across, steps, across[1]);
    let file = |setting: &Setting| format!("{}-{}", flow.name, setting.name());
    let mut runs = Vec::new();
    let Some(run) = flow.run else {
        let finest = cases::finest(variant, level);
        let key = |setting: &Setting| (flow.name, *setting, level.name());
        let (reference, _) = bench.run(&file(&finest), &key(&finest), || {
            cases::stirred(&finest, level)
        })?;
        for setting in settings {
            let (mixed, _) = bench.run(&file(&setting), &key(&setting), || {
                cases::stirred(&setting, level)
            })?;
            runs.push((setting, cases::against(&mixed, &reference)));
        }
        return Ok(runs);
    };
    for setting in settings {
        let (outcome, _) = bench.run(&file(&setting), &(flow.name, setting), || run(&setting))?;
        runs.push((setting, outcome));
    }
    Ok(runs)
}

/// The runs that no other beats in both time and error, by time (the Pareto front).
fn cheapest(runs: &[Run]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..runs.len())
        .filter(|&n| runs[n].1.error.is_some())
        .collect();
    order.sort_by(|&a, &b| runs[a].1.seconds.total_cmp(&runs[b].1.seconds));
    let mut least = Real::INFINITY;
    order.retain(|&n| {
        let error = runs[n].1.error.unwrap_or(Real::INFINITY);
        let better = error < least;
        least = least.min(error);
        better
    });
    order
}

/// For each target the cheapest run that reaches it, or that none does.
fn recommend(table: &mut Table, flow: &Flow, runs: &[Run]) {
    for target in TARGETS {
        let reaches = |(_, outcome): &&Run| outcome.error.is_some_and(|error| error <= target);
        let best = runs.iter().filter(reaches);
        let best = best.min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
        let Some((setting, outcome)) = best else {
            let mut row = vec![flow.name.into(), target.into(), "none reaches it".into()];
            row.resize(9, Cell::None);
            table.row(row);
            continue;
        };
        table.row(vec![
            flow.name.into(),
            target.into(),
            setting.variant.name().into(),
            u64::from(setting.across).into(),
            setting.cfl.into(),
            setting.tolerance.into(),
            setting.support_ratio.into(),
            outcome.error.into(),
            outcome.seconds.into(),
        ]);
    }
}

/// What a knob does at a given spacing: error and time by those of the usual settings.
struct Knob {
    flow: &'static str,
    setting: Setting,
    error: Real,
    seconds: Real,
}

/// The knobs of coupled imm_ct at the spacing where all of them were tried.
fn compared(flow: &Flow, level: Level, runs: &[Run]) -> Vec<Knob> {
    let variant = Variant {
        scheme: Scheme::ImmCt,
        stress: StressStep::Coupled,
    };
    let usual = Setting::usual(variant, (flow.across)(level)[1]);
    let Some((_, base)) = runs.iter().find(|(setting, _)| *setting == usual) else {
        return Vec::new();
    };
    let alike = runs
        .iter()
        .filter(|(setting, _)| setting.variant == variant && setting.across == usual.across);
    alike
        .map(|(setting, outcome)| Knob {
            flow: flow.name,
            setting: *setting,
            error: match (outcome.error, base.error) {
                (Some(error), Some(base)) => error / base,
                _ => Real::INFINITY,
            },
            seconds: outcome.seconds / base.seconds,
        })
        .collect()
}

/// Error and time of each knob by the usual ones: flow by flow, and the geometric mean.
fn averaged(knobs: &[Knob]) -> Table {
    let mut columns = vec!["cfl", "tolerance", "support ratio", "error", "time"];
    let names: Vec<String> = FLOWS
        .iter()
        .map(|flow| format!("error, {}", flow.name))
        .collect();
    columns.extend(names.iter().map(String::as_str));
    let mut table = Table::new(&columns);
    let mut seen: Vec<Setting> = Vec::new();
    for knob in knobs {
        let same = |other: &Setting| {
            (other.cfl, other.tolerance, other.support_ratio)
                == (
                    knob.setting.cfl,
                    knob.setting.tolerance,
                    knob.setting.support_ratio,
                )
        };
        if seen.iter().any(same) {
            continue;
        }
        seen.push(knob.setting);
        let of: Vec<&Knob> = knobs.iter().filter(|other| same(&other.setting)).collect();
        let mean = |pick: &dyn Fn(&Knob) -> Real| {
            let sum: Real = of.iter().map(|knob| libm::log(pick(knob))).sum();
            libm::exp(sum / of.len() as Real)
        };
        let mut row = vec![
            knob.setting.cfl.into(),
            knob.setting.tolerance.into(),
            knob.setting.support_ratio.into(),
            mean(&|knob| knob.error).into(),
            mean(&|knob| knob.seconds).into(),
        ];
        for flow in &FLOWS {
            let here = of.iter().find(|knob| knob.flow == flow.name);
            row.push(here.map(|knob| knob.error).into());
        }
        table.row(row);
    }
    table
}

fn plot(title: &str) -> Plot {
    Plot {
        title: title.into(),
        x: Axis::log("seconds"),
        y: Axis::log("relative error"),
        series: Vec::new(),
    }
}

fn point(outcome: &Outcome) -> [Real; 2] {
    [outcome.seconds, outcome.error.unwrap_or(Real::NAN)]
}

fn picture(flow: &Flow, runs: &[Run], front: &[usize]) -> Plot {
    let mut plot = plot(&format!(
        "{}: error against time; rings: the cheapest",
        flow.name
    ));
    for (colour, variant) in Variant::ALL.into_iter().enumerate() {
        let of = runs
            .iter()
            .filter(|(setting, _)| setting.variant == variant);
        plot.series.push(Series {
            name: variant.name(),
            points: of.map(|(_, outcome)| point(outcome)).collect(),
            look: Look::Dots,
            colour,
        });
    }
    let line: Vec<_> = front.iter().map(|&n| point(&runs[n].1)).collect();
    for look in [Look::Rings, Look::Dashes] {
        plot.series.push(Series {
            name: String::new(),
            points: line.clone(),
            look,
            colour: 7,
        });
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seconds: Real, error: Option<Real>) -> Run {
        let outcome = Outcome {
            error,
            seconds,
            steps: 1,
            particles: 1,
        };
        (Setting::usual(Variant::ALL[0], 8), outcome)
    }

    #[test]
    fn the_front_holds_what_nothing_beats_in_both() {
        let runs = [
            run(4.0, Some(0.01)),
            run(1.0, Some(0.1)),
            run(2.0, Some(0.2)),
            run(0.5, None),
            run(3.0, Some(0.03)),
            run(5.0, Some(0.02)),
        ];
        assert_eq!(cheapest(&runs), [1, 4, 0]);
        let mut table = Table::new(&["", "", "", "", "", "", "", "", "reached"]);
        recommend(&mut table, &FLOWS[0], &runs);
        let rows = table.to_json();
        let costs: Vec<_> = (0..3).map(|n| rows[n]["reached"].as_f64()).collect();
        assert_eq!(costs, [Some(3.0), Some(4.0), Some(4.0)]);
    }

    /// On sixteen spacings Poiseuille's start-up comes out better than on eight where steps are short, and short steps
    /// better than long ones.
    #[test]
    fn an_error_falls_on_refinement() {
        let error = |across, cfl| {
            let usual = Setting::usual(Variant::ALL[5], across);
            let outcome = FLOWS[0].run.unwrap()(&Setting { cfl, ..usual }).unwrap();
            outcome.error.unwrap()
        };
        let (coarse, long, fine) = (error(8, 0.1), error(16, 0.4), error(16, 0.1));
        assert!(fine < 0.8 * coarse, "{coarse} {fine}");
        assert!(fine < 0.5 * long && fine < 0.02, "{long} {fine}");
    }
}
