//! Deep and confined flow: iterations and cost against depth, and whether pressure knows the step or is proportional to
//! viscosity.
//!
//! How rows of particles pass a throat is as good as chance: the pressure of one run of 24 spacings is up to 0.5 % off that
//! of the next, whatever their steps. What is compared are means over several starts (one where steps are a hundredth of
//! the CFL step).
//!
//! Reached, run by run and not yet in one run of `--level full` (means of three starts, of six in the needle of 4.4 Pa·s, of
//! two in the array with a memory at 0.1):
//!
//! | pressure at the piston [Pa], CFL steps | 0.1 | 0.3 | 1 | spread |
//! |---|---|---|---|---|
//! | array of struts, 4.4 Pa·s | | | 7209 | |
//! | array of struts, 8 Pa·s, memory 50 ms | 9352 | | 9328 | 0.3 % |
//! | needle into closed pores, 4.4 Pa·s | 2764 | 2759 | 2750 | 0.5 % |
//! | needle into closed pores, 8 Pa·s, memory 50 ms | | | 3512 | |
//!
//! The last full run (45 min on two cores) is older than a pressure smoothed apart from the step (`sim::solves`, SETTLING)
//! and a way of second order (`sim::outlook`). Over a factor 100 in steps its pressures spread by 1.1 and 0.7 % (arrays),
//! 2.8 and 2.3 % (needles), flow by 0.3, 0.4, 2.1, 1.0 %. Pressure by viscosity over 1 : 1000: 0.5 %. A drop that creeps:
//! 0.49 % off at a hundredth of the step. Inflow unbalanced by at most 0.99 %. Pipes 20, 80, 320 deep took 21 to 36, 24 to
//! 33, 41 to 44 iterations a warm step (most 53, 67, 111; 46 to 51, 89 to 141, 106 to 132 cold), and a particle and step at
//! 320 cost 2.0 (cold) and 1.8 (warm) times that at 20.

mod creep;
mod scenes;

use super::{Bench, Findings, Study, StudyError};
use crate::math::Real;
use crate::report::{Axis, Look, Plot, Series, Table};
use scenes::{Pressed, Vessel};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::time::Instant;

pub(super) const STUDY: Study = Study {
    name: "pressure",
    about: "deep, confined flow: iterations against depth, pressure against step and viscosity",
    answer,
};

/// What a run shows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Reading {
    /// Mean pressure at the piston over the last half of the time [Pa].
    pressure: Real,
    /// Flow through the top of the fluid, of the inflow, over the same time.
    flow: Real,
    /// Iterations of the first step, which knows no pressure; mean and most of those after the fifth.
    first: u64,
    later: Real,
    most: u64,
    /// Largest share of the inflow that a step left unbalanced.
    balance: Real,
    steps: u64,
    unconverged: u64,
    particles: u64,
    /// Wall clock of a step and particle, the first one and the median of later ones [s].
    first_cost: Real,
    cost: Real,
}

/// Share of the time at the end over which pressure is read: rows of particles that pass a throat make it swing by a tenth.
const WINDOW: Real = 0.5;

impl Pressed {
    fn run(&self, name: &str) -> Result<Reading, StudyError> {
        let mut simulation = self.place().start(name)?;
        let end = self.duration();
        let from = (1.0 - WINDOW) * end;
        let above = |simulation: &mut crate::sim::Simulation| {
            let escaped = simulation.ledger().escaped;
            let level = self.level();
            let high = simulation.fluid.position.iter().filter(|x| x.z > level);
            high.count() as Real * simulation.rest_volume + escaped.liquid + escaped.polymer
        };
        let mut reading = Reading::default();
        let (mut sum, mut time, mut then) = (0.0, 0.0, None);
        let (mut later, mut costs) = (Vec::new(), Vec::new());
        while simulation.time < end * (1.0 - 1e-9) {
            let clock = Instant::now();
            let report = simulation
                .step_towards(end)
                .map_err(StudyError::run(name))?;
            let particles = simulation.fluid.len() as Real;
            let cost = clock.elapsed().as_secs_f64() / particles;
            reading.steps += 1;
            reading.unconverged += u64::from(!report.converged);
            reading.balance = reading.balance.max(report.balance);
            if reading.steps == 1 {
                (reading.first, reading.first_cost) = (report.iterations as u64, cost);
            } else if reading.steps > 5 {
                later.push(report.iterations as u64);
                costs.push(cost);
            }
            if simulation.time > from {
                if then.is_none() {
                    then = Some((simulation.time, above(&mut simulation)));
                }
                sum += simulation.inlets[0].pressure * report.dt;
                time += report.dt;
            }
        }
        if let Some((start, volume)) = then {
            let inflow = simulation.inlets[0].settings.flow_rate * (simulation.time - start);
            reading.flow = (above(&mut simulation) - volume) / inflow;
        }
        costs.sort_by(Real::total_cmp);
        reading.cost = costs.get(costs.len() / 2).copied().unwrap_or_default();
        reading.later = later.iter().sum::<u64>() as Real / later.len().max(1) as Real;
        reading.most = later.iter().copied().max().unwrap_or_default();
        reading.pressure = sum / time;
        reading.particles = simulation.fluid.len() as u64;
        Ok(reading)
    }
}

impl Pressed {
    /// Its reading, as kept or made now.
    fn read(&self, bench: &Bench) -> Result<Reading, StudyError> {
        let name = format!(
            "{}-{}-{}-{}-{}",
            self.vessel.name().replace(' ', "_"),
            self.viscosity,
            self.relaxation_time,
            self.step,
            self.seed,
        );
        Ok(bench.run(&name, self, || self.run(&name))?.0)
    }
}

/// A table of readings.
struct Readings(Table);

impl Readings {
    fn new() -> Self {
        Self(Table::new(&[
            "vessel",
            "viscosity [Pa s]",
            "relaxation time [s]",
            "step / CFL step",
            "seed",
            "pressure at the piston [Pa]",
            "outflow / inflow",
            "iterations of the first step",
            "iterations later",
            "most",
            "unbalanced inflow",
            "steps",
            "unconverged",
            "particles",
            "seconds a particle, first step",
            "seconds a particle and step",
        ]))
    }

    fn add(&mut self, pressed: &Pressed, reading: &Reading) {
        self.0.row(vec![
            pressed.vessel.name().into(),
            pressed.viscosity.into(),
            pressed.relaxation_time.into(),
            pressed.step.into(),
            pressed.seed.into(),
            reading.pressure.into(),
            reading.flow.into(),
            reading.first.into(),
            reading.later.into(),
            reading.most.into(),
            reading.balance.into(),
            reading.steps.into(),
            reading.unconverged.into(),
            reading.particles.into(),
            reading.first_cost.into(),
            reading.cost.into(),
        ]);
    }
}

/// A run of the study, but for what differs.
const RUN: Pressed = Pressed {
    vessel: Vessel::Pores,
    viscosity: 4.4,
    relaxation_time: 0.0,
    step: 1.0,
    travel: 24.0,
    seed: 0,
};

/// Step, in CFL steps, from which one start has to do: it takes an hour.
const LONG_RUN: Real = 0.05;

/// The mean over several starts.
struct Answer {
    pressure: Real,
    flow: Real,
    /// Its standard error, of the pressure, by how far apart starts are in all that was asked.
    doubt: Real,
}

fn ask(
    bench: &Bench,
    table: &mut Readings,
    questions: &[Pressed],
) -> Result<Vec<Answer>, StudyError> {
    let starts = |question: &Pressed| {
        if question.step < LONG_RUN {
            1
        } else {
            bench.level.pick(2, 3)
        }
    };
    let runs: Vec<Pressed> = questions
        .iter()
        .flat_map(|question| (1..=starts(question)).map(|seed| Pressed { seed, ..*question }))
        .collect();
    let readings = bench.side_by_side(&runs, |pressed| pressed.read(bench))?;
    for (pressed, reading) in runs.iter().zip(&readings) {
        table.add(pressed, reading);
    }
    let mut rest = &readings[..];
    let (mut squares, mut freedoms) = (0.0, 0.0);
    let mut answers = Vec::new();
    for question in questions {
        let (of_question, later) = rest.split_at(starts(question) as usize);
        rest = later;
        let n = of_question.len() as Real;
        let mean = |of: fn(&Reading) -> Real| of_question.iter().map(of).sum::<Real>() / n;
        let pressure = mean(|r| r.pressure);
        let off = of_question.iter().map(|r| r.pressure / pressure - 1.0);
        squares += off.map(|off| off * off).sum::<Real>();
        freedoms += n - 1.0;
        answers.push(Answer {
            pressure,
            flow: mean(|r| r.flow),
            doubt: n.sqrt().recip(),
        });
    }
    let deviation = (squares / freedoms).sqrt();
    for answer in &mut answers {
        answer.doubt *= deviation;
    }
    Ok(answers)
}

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let mut table = Readings::new();
    let mut plot = Plot {
        title: "Iterations a step against depth".into(),
        x: Axis::log("depth / spacing"),
        y: Axis::log("iterations (rings: first step, chains: later)"),
        series: Vec::new(),
    };
    let depths: &[u32] = bench.level.pick(&[20, 80], &[20, 80, 320]);
    let mut worst_balance: Real = 0.0;
    let (mut cold, mut warm): (Real, Real) = (0.0, 0.0);
    for (colour, viscosity) in [0.01, 1.0, 100.0].into_iter().enumerate() {
        let mut first = Vec::new();
        let mut later = Vec::new();
        let mut costs = Vec::new();
        for &depth in depths {
            let pressed = Pressed {
                vessel: Vessel::Pipe { radius: 4.0, depth },
                viscosity,
                ..RUN
            };
            let reading = pressed.read(bench)?;
            table.add(&pressed, &reading);
            let depth = Real::from(depth);
            first.push([depth, reading.first as Real]);
            later.push([depth, reading.later]);
            costs.push([reading.first_cost, reading.cost]);
            worst_balance = worst_balance.max(reading.balance);
        }
        if let (Some(shallow), Some(deep)) = (costs.first(), costs.last()) {
            cold = cold.max(deep[0] / shallow[0]);
            warm = warm.max(deep[1] / shallow[1]);
        }
        plot.series.push(Series {
            name: format!("{viscosity} Pa s"),
            points: later,
            look: Look::Chain,
            colour,
        });
        plot.series.push(Series {
            name: String::new(),
            points: first,
            look: Look::Rings,
            colour,
        });
    }

    // The dearest first, so that no thread waits for the last.
    let steps: &[Real] = bench.level.pick(&[0.1, 1.0], &[0.01, 0.1, 1.0]);
    let scenes = [Vessel::Array, Vessel::Pores].map(|vessel| {
        [(8.0, 0.05), (4.4, 0.0)].map(|(viscosity, relaxation_time)| Pressed {
            vessel,
            viscosity,
            relaxation_time,
            ..RUN
        })
    });
    let scenes = scenes.as_flattened();
    let questions: Vec<Pressed> = scenes
        .iter()
        .flat_map(|scene| steps.iter().map(|&step| Pressed { step, ..*scene }))
        .collect();
    let answers = ask(bench, &mut table, &questions)?;
    let of_steps: Vec<_> = scenes
        .iter()
        .zip(answers.chunks(steps.len()))
        .map(|(scene, answers)| {
            let all = |of: fn(&Answer) -> Real| answers.iter().map(of).collect::<Vec<Real>>();
            let (pressure, flow) = (all(|a| a.pressure), all(|a| a.flow));
            json!({
                "vessel": scene.vessel.name(), "relaxation_time": scene.relaxation_time, "steps": steps,
                "pressure": pressure, "pressure_spread": spread(&pressure),
                "pressure_error": all(|a| a.doubt), "flow": flow, "flow_spread": spread(&flow),
            })
        })
        .collect();
    let doubt = answers
        .iter()
        .map(|answer| answer.doubt)
        .fold(0.0, Real::max);
    let widest = |key: &str| {
        let spreads = of_steps.iter().filter_map(|found| found[key].as_f64());
        spreads.fold(0.0, Real::max)
    };
    let (spread_of_steps, spread_of_flow) = (widest("pressure_spread"), widest("flow_spread"));
    let questions = [0.44, 4.4, 44.0, 440.0].map(|viscosity| Pressed { viscosity, ..RUN });
    let answers = ask(bench, &mut table, &questions)?;
    let proportion = answers.iter().zip(&questions);
    let proportion: Vec<Real> = proportion.map(|(a, q)| a.pressure / q.viscosity).collect();
    let (creep, creep_table, creep_plot) = creep::answer(bench)?;
    let of_viscosity = spread(&proportion);
    let deepest = depths.last().copied().unwrap_or_default();
    Ok(Findings {
        summary: format!(
            "inflow unbalanced by at most {:.2} %; a particle and step at depth {deepest} costs {cold:.1} (cold) and \
             {warm:.1} (warm) times that at 20; pressure changes by {:.1} %, flow by {:.1} %, \
             over steps x {:.0} (each pressure known to {:.1} %), pressure by viscosity by {:.1} % over 1:1000; a drop that creeps ends {:.2} % off at a hundredth of the step",
            100.0 * worst_balance,
            100.0 * spread_of_steps,
            100.0 * spread_of_flow,
            steps[steps.len() - 1] / steps[0],
            100.0 * doubt,
            100.0 * of_viscosity,
            100.0 * creep,
        ),
        tables: vec![(String::new(), table.0), ("creep".into(), creep_table)],
        pictures: vec![
            (String::new(), plot.to_png()),
            ("creep".into(), creep_plot.to_png()),
        ],
        facts: json!({
            "worst_balance": worst_balance, "cost_of_depth": { "depth": deepest, "cold": cold, "warm": warm },
            "over_steps": of_steps, "spread_over_steps": spread_of_steps, "flow_over_steps": spread_of_flow,
            "spread_over_viscosity": of_viscosity, "creep": creep,
        }),
    })
}

/// How far apart the ends are, of the mean.
fn spread(values: &[Real]) -> Real {
    let largest = values.iter().copied().fold(Real::NEG_INFINITY, Real::max);
    let least = values.iter().copied().fold(Real::INFINITY, Real::min);
    let mean = values.iter().sum::<Real>() / values.len() as Real;
    (largest - least) / mean
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pressure is 40 times the stress of the flow at the foot. If its level acts on the packing whole, that grows stiff: the
    /// gradient is then 15 % steeper below than above, and twice as steep where the pipe is half as deep again.
    #[test]
    fn pressure_falls_evenly_along_a_deep_pipe() {
        let depth = 160;
        let pressed = Pressed {
            vessel: Vessel::Pipe { radius: 4.0, depth },
            viscosity: 1.0,
            relaxation_time: 0.0,
            step: 1.0,
            travel: 12.0,
            seed: 0,
        };
        let end = pressed.duration();
        let levels = [0.08, 0.5, 0.92].map(|share| share * Real::from(depth) * scenes::SPACING);
        let mut simulation = pressed.place().start("pipe").unwrap();
        let mut sums = [[0.0; 2]; 3];
        while simulation.time < end * (1.0 - 1e-9) {
            simulation.step_towards(end).unwrap();
            if simulation.time < 0.5 * end {
                continue;
            }
            let fluid = &simulation.fluid;
            for (x, pressure) in fluid.position.iter().zip(&fluid.pressure) {
                for (sum, level) in sums.iter_mut().zip(levels) {
                    if (x.z - level).abs() < 5.0 * scenes::SPACING {
                        *sum = [sum[0] + pressure[0], sum[1] + 1.0];
                    }
                }
            }
        }
        let [foot, middle, mouth] = sums.map(|[sum, count]| sum / count);
        let [below, above] = [foot - middle, middle - mouth];
        assert!((below / above - 1.0).abs() < 0.05, "{below} Pa, {above} Pa");
        // 8 η u/R².
        let radius = 4.0 * scenes::SPACING;
        let gradient = 8.0 * pressed.viscosity * scenes::SPEED / (radius * radius);
        let ratio = (foot - mouth) / (gradient * (levels[2] - levels[0]));
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
}
