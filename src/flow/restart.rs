//! Stopping a simulation and going on: `restart/` holds its state, the state before that, and what it was made from.

use super::leaks::Left;
use super::stamp::Inputs;
use super::{Event, FlowError, Folder, Job, Observer};
use crate::cache::{self, CacheError, Restart};
use crate::sim::Simulation;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::ErrorKind;
use std::time::{Duration, Instant};

/// What adds up over the frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// The frame being made.
    pub next: u32,
    pub steps: u64,
    pub converged: u64,
    pub most_in_walls: usize,
    /// Walls awake at each frame, added up.
    #[serde(default)]
    pub walls_awake: u64,
    #[serde(default)]
    pub left: Left,
}

/// Beside the states: what they belong to.
#[derive(Serialize, Deserialize)]
struct Origin {
    inputs: Inputs,
    /// It has come to its end, and is kept for a longer duration.
    finished: bool,
}

/// Settings that may differ when a simulation goes on; the rest would make another scene of it.
const FREE: [&str; 10] = [
    "duration",
    "time_step",
    "cement",
    "gravity",
    "scheme",
    "stress",
    "elastic_waves",
    "theta",
    "energy_balance",
    "skip_unneeded",
];

/// Writing states may take this share of the time.
const SHARE: u32 = 50;

/// Whether a simulation is to go on where one was stopped, rather than begin.
pub(super) fn goes_on(
    job: &Job,
    inputs: &Inputs,
    observer: &mut Observer<'_>,
) -> Result<bool, FlowError> {
    let Some(origin) = origin(&job.folder)? else {
        return Ok(false);
    };
    let changed = origin.inputs.changed(inputs);
    if !job.resume {
        let lost = !origin.finished && changed.is_empty() && !job.force;
        // A run of many hours must not be lost to a forgotten flag.
        return match newest(&job.folder).ok().flatten().filter(|_| lost) {
            Some(restart) => Err(FlowError::Unfinished {
                time: restart.state.progress.time,
            }),
            None => Ok(false),
        };
    }
    let is_free = |key: &&String| FREE.contains(&key.as_str());
    let fixed: Vec<_> = changed
        .iter()
        .filter(|key| !is_free(key))
        .cloned()
        .collect();
    if !fixed.is_empty() {
        return Err(FlowError::Changed { keys: fixed });
    }
    if !changed.is_empty() {
        let note = format!("goes on with other settings: {}", changed.join(", "));
        observer(Event::Note(&job.folder.restart_origin(), &note));
    }
    Ok(newest(&job.folder)?.is_some())
}

fn origin(folder: &Folder) -> Result<Option<Origin>, FlowError> {
    let path = folder.restart_origin();
    match fs::read(&path) {
        // Of another version, or no file of ours: nothing to go on from.
        Ok(text) => Ok(serde_json::from_slice(&text).ok()),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(FlowError::io(path)(e)),
    }
}

/// The newest state that is whole.
pub(super) fn newest(folder: &Folder) -> Result<Option<Restart<Record>>, FlowError> {
    let missing = |e: &CacheError| matches!(e, CacheError::Io { source, .. } if source.kind() == ErrorKind::NotFound);
    let newest = match cache::read_restart(&folder.restart()) {
        Ok(restart) => return Ok(Some(restart)),
        Err(error) => error,
    };
    match cache::read_restart(&folder.restart_before()) {
        Ok(restart) => Ok(Some(restart)),
        Err(e) if missing(&e) && missing(&newest) => Ok(None),
        Err(e) if missing(&newest) => Err(e.into()),
        Err(_) => Err(newest.into()),
    }
}

/// Writes states while a simulation runs.
pub(super) struct Saver<'a> {
    folder: &'a Folder,
    inputs: &'a Inputs,
    last: Instant,
    pause: Duration,
}

impl<'a> Saver<'a> {
    /// Notes what the states to come belong to.
    pub fn new(folder: &'a Folder, inputs: &'a Inputs) -> Result<Self, FlowError> {
        let saver = Self {
            folder,
            inputs,
            last: Instant::now(),
            pause: Duration::ZERO,
        };
        saver.note(false)?;
        Ok(saver)
    }

    fn note(&self, finished: bool) -> Result<(), FlowError> {
        let origin = Origin {
            inputs: self.inputs.clone(),
            finished,
        };
        Ok(cache::write_json(&self.folder.restart_origin(), &origin)?)
    }

    /// Writes the state unless that was done a short while ago.
    pub fn pass(&mut self, run: &Simulation, record: &Record) -> Result<(), FlowError> {
        if self.last.elapsed() < self.pause {
            return Ok(());
        }
        self.save(run, record)
    }

    /// Writes the state; the one before is kept.
    pub fn save(&mut self, run: &Simulation, record: &Record) -> Result<(), FlowError> {
        let started = Instant::now();
        let path = self.folder.restart();
        match fs::rename(&path, self.folder.restart_before()) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(FlowError::io(path)(e)),
            _ => {}
        }
        cache::write_restart(&path, &run.fluid, &run.progress(), record)?;
        self.last = Instant::now();
        self.pause = started.elapsed() * SHARE;
        Ok(())
    }

    /// The end has been reached.
    pub fn finish(&mut self, run: &Simulation, record: &Record) -> Result<(), FlowError> {
        self.save(run, record)?;
        let before = self.folder.restart_before();
        fs::remove_file(&before).or_else(|e| match e.kind() {
            ErrorKind::NotFound => Ok(()),
            _ => Err(FlowError::io(before)(e)),
        })?;
        self.note(true)
    }
}

/// Lets a run go on from a state, if the frames before it are there.
pub(super) fn restore(
    folder: &Folder,
    run: &mut Simulation,
    restart: Restart<Record>,
) -> Result<Record, FlowError> {
    let damaged = |path, what: &str| {
        let what = what.to_owned();
        FlowError::Cache(CacheError::Damaged { path, what })
    };
    if let Some(path) = (0..restart.record.next)
        .map(|n| folder.frame(n))
        .find(|path| !path.exists())
    {
        return Err(damaged(path, "is missing, but the simulation was past it"));
    }
    if !run.restore(restart.state) {
        return Err(damaged(folder.restart(), "is of another simulation"));
    }
    Ok(restart.record)
}
