//! Walls → `frames/`, `stats.csv` and `simulation.json`; a state to go on from, now and then, in `restart/`.

use super::leaks::Leaks;
use super::restart::{self, Record, Saver};
use super::stamp::Inputs;
use super::{Event, FlowError, FrameReport, Job, Observer, Stage, fillings, movers, preview};
use crate::cache::{self, Frame, Table};
use crate::sim::{Ledger, Limit, Probe, Simulation, StepReport};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

pub(super) fn work(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let mut run = start(job)?;
    let mut record = Record::default();
    if run.carved > 0 {
        let kept = run.fluid.len();
        let note = format!(
            "{} particles overlap with walls or an earlier body at the start and are left out, {kept} stay",
            run.carved
        );
        observer(Event::Note(&job.folder.walls(), &note));
    }
    let restart = restart::newest(&job.folder)?;
    let goes_on = restart.is_some();
    if let Some(restart) = restart {
        record = restart::restore(&job.folder, &mut run, restart)?;
    }
    let table = |path: &Path, columns: &[&str]| {
        if goes_on {
            Table::resume(path, columns, record.next as usize)
        } else {
            Table::create(path, columns)
        }
    };
    let columns: Vec<&str> = ["frame"].into_iter().chain(Ledger::COLUMNS).collect();
    let stats = table(&job.folder.stats(), &columns)?;
    let probes = &job.scene.probes;
    let names: Vec<String> = probes.iter().flat_map(Probe::columns).collect();
    let columns: Vec<&str> = ["frame", "time_s"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .collect();
    let readings = (!probes.is_empty()).then(|| table(&job.folder.probes(), &columns));
    let readings = readings.transpose()?;
    let inputs = Inputs::of(Stage::Simulate, &job.scene, &job.folder)?;
    let mut course = Course {
        job,
        saver: Saver::new(&job.folder, &inputs)?,
        stats,
        readings,
        leaks: Leaks::of(job)?,
        record,
    };
    let ended = course.frames(&mut run, observer);
    if let Err(FlowError::Stopped { .. } | FlowError::Cache(_)) = &ended {
        return ended;
    }
    let diverged = ended.as_ref().err().map(ToString::to_string);
    let summary = summary(&mut run, &course, diverged.as_deref());
    cache::write_json(&job.folder.simulation_report(), &summary)?;
    ended
}

/// A simulation at its start, among the walls that `voxelise` left.
pub(super) fn start(job: &Job) -> Result<Simulation, FlowError> {
    let solid = cache::read_solid(&job.folder.solid())?;
    let walls = cache::read_walls(&job.folder.walls())?;
    let mut settings = job.scene.sim.clone();
    fillings::read(job, &mut settings)?;
    Ok(Simulation::with_movers(
        settings,
        solid,
        walls,
        movers::read(job)?,
    )?)
}

/// A simulation on its way.
struct Course<'a> {
    job: &'a Job,
    saver: Saver<'a>,
    stats: Table,
    readings: Option<Table>,
    leaks: Option<Leaks>,
    record: Record,
}

impl Course<'_> {
    /// Runs frame by frame; each is on disk before the next begins.
    fn frames(
        &mut self,
        run: &mut Simulation,
        observer: &mut Observer<'_>,
    ) -> Result<(), FlowError> {
        let (job, sim) = (self.job, &self.job.scene.sim);
        let last = job.scene.last_frame();
        let moment = |frame: u32| f64::from(frame) / sim.frames_per_second;
        let started = Instant::now();
        let mut report = FrameReport {
            frame: 0,
            last,
            time: run.time,
            dt: 0.0,
            limit: "start",
            iterations: 0,
            compression: 0.0,
            span: [run.time, moment(last)],
            elapsed: 0.0,
        };
        for index in self.record.next..=last {
            report.frame = index;
            let end = moment(index);
            while run.time < end {
                let step = match run.step_towards(end) {
                    Ok(step) => step,
                    Err(error) => {
                        // The state before the step that failed: with other settings it may go on from there.
                        self.saver.save(run, &self.record)?;
                        self.enter(index, run)?;
                        return Err(error.into());
                    }
                };
                note(&mut report, run.time, &step);
                report.elapsed = started.elapsed().as_secs_f64();
                observer(Event::Step(report));
                if job.stop.load(Ordering::Relaxed) {
                    self.saver.save(run, &self.record)?;
                    job.heed(Some(run.time))?;
                }
                self.saver.pass(run, &self.record)?;
            }
            report.compression = self.enter(index, run)?.compression[0];
            let pressure = run.pressure();
            self.read_probes(index, run, &pressure)?;
            cache::write_frame(&job.folder.frame(index), &frame(index, run, &pressure))?;
            if index == 0 && job.early_picture {
                draw_start(job, observer);
            }
            observer(Event::Frame(report));
            self.record.next = index + 1;
        }
        self.saver.finish(run, &self.record)
    }

    fn read_probes(
        &mut self,
        frame: u32,
        run: &Simulation,
        pressure: &[f64],
    ) -> Result<(), FlowError> {
        let Some(table) = &mut self.readings else {
            return Ok(());
        };
        let velocity = run.velocity();
        let sample = run.sample(&velocity, pressure);
        let mut row = vec![frame.to_string(), run.time.to_string()];
        for probe in &self.job.scene.probes {
            let readings = probe.read(sample).into_iter();
            row.extend(readings.map(|v| v.map_or(String::new(), |v| format!("{v:e}"))));
        }
        Ok(table.row(&row)?)
    }

    fn enter(&mut self, frame: u32, run: &mut Simulation) -> Result<Ledger, FlowError> {
        let ledger = run.ledger();
        let record = &mut self.record;
        if let Some(leaks) = &self.leaks {
            leaks.note(&run.fluid.position, &run.fluid.id, &mut record.left);
        }
        record.steps += ledger.window[0];
        record.converged += ledger.window[1];
        record.most_in_walls = record.most_in_walls.max(ledger.in_walls);
        record.walls_awake += ledger.awake as u64;
        let mut row = vec![frame.to_string()];
        row.extend(ledger.row());
        self.stats.row(&row)?;
        Ok(ledger)
    }
}

/// A picture to look at while the simulation runs. It is drawn again with the others: that it fails stops nothing.
fn draw_start(job: &Job, observer: &mut Observer<'_>) {
    match preview::draw_start(job) {
        Ok(Some(path)) => observer(Event::Picture(&path)),
        Ok(None) => {}
        Err(error) => observer(Event::Note(&job.folder.frame(0), &error.to_string())),
    }
}

fn note(report: &mut FrameReport, time: f64, step: &StepReport) {
    report.time = time;
    report.dt = step.dt;
    report.limit = step.limit.map_or("none", Limit::name);
    report.iterations = step.iterations;
}

/// The cement as the stages after the simulation read it; `pressure` [Pa] as `Simulation::pressure` gives it.
pub(super) fn frame(index: u32, run: &Simulation, pressure: &[f64]) -> Frame {
    let fluid = &run.fluid;
    let single = |v: &crate::math::Vec3| [v.x as f32, v.y as f32, v.z as f32];
    Frame {
        index,
        time: run.time,
        spacing: run.settings.spacing,
        support_radius: run.support_radius(),
        rest_volume: run.rest_volume,
        position: fluid.position.iter().map(single).collect(),
        velocity: run.velocity().iter().map(single).collect(),
        polymer_fraction: fluid.polymer_fraction.iter().map(|&a| a as f32).collect(),
        pressure: pressure.iter().map(|&p| p as f32).collect(),
        id: fluid.id.clone(),
    }
}

/// How it went, in a few numbers.
fn summary(run: &mut Simulation, course: &Course<'_>, diverged: Option<&str>) -> Value {
    let ledger = run.ledger();
    let record = &course.record;
    let flows = !run.fluid.is_empty();
    let whereabouts = (course.leaks.as_ref().filter(|_| flows))
        .map(|leaks| leaks.report(&run.fluid.position, &record.left, run.rest_volume));
    let volume = |phases: crate::fluid::PerPhase<f64>| phases.liquid + phases.polymer;
    let awake = record.walls_awake as f64 / f64::from(record.next.max(1));
    let asleep = 1.0 - awake / run.wall_count().max(1) as f64;
    json!({
        "diverged": diverged,
        "time_s": run.time,
        "steps": record.steps,
        "converged_share": record.converged as f64 / record.steps.max(1) as f64,
        "particles": run.fluid.len(),
        "wall_particles": run.wall_count(),
        "walls_asleep_share": asleep,
        "carved_at_start": run.carved,
        "most_particles_in_walls": record.most_in_walls,
        "volume_inside_m3": volume(ledger.inside),
        "volume_injected_m3": volume(ledger.injected),
        "volume_escaped_m3": volume(ledger.escaped),
        "inside_bone_share": whereabouts.as_ref().map(|w| w["inside_share"].clone()),
        "leaked_m3": whereabouts.as_ref().map(|w| w["leaked_m3"].clone()),
    })
}
