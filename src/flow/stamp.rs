//! What a stage read and wrote when it last finished: whether it has to run again.

use super::{FlowError, Folder, Stage};
use crate::cache;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Everything that a stage's results depend on. Kept in full, not as a hash: a stamp can be read, and two that
/// differ say where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Inputs {
    version: String,
    settings: Value,
    /// Length and CRC-32 of each file from outside.
    files: Vec<(u64, u32)>,
    /// What the stages before it were, by name.
    upstream: BTreeMap<String, u32>,
}

/// Inputs and outputs of a finished stage.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Stamp {
    inputs: Inputs,
    /// Path and length of each file that it left.
    outputs: Vec<(String, u64)>,
    /// How long it took [s].
    pub seconds: f64,
}

impl Inputs {
    /// What the stage would depend on if it ran now.
    pub fn of(stage: Stage, scene: &Scene, folder: &Folder) -> Result<Self, FlowError> {
        let mut upstream = BTreeMap::new();
        for &needed in stage.needs() {
            let stamp =
                fresh(needed, scene, folder)?.ok_or(FlowError::Missing { stage, needed })?;
            upstream.insert(needed.name().to_owned(), stamp.id());
        }
        let files = stage.files(scene);
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            settings: stage.settings(scene),
            files: files.into_iter().map(checksum).collect::<Result<_, _>>()?,
            upstream,
        })
    }
}

impl Inputs {
    /// Names of what differs in `now`: keys of the settings, or `files`, `walls`, `version`.
    pub fn changed(&self, now: &Self) -> Vec<String> {
        let mut changed = Vec::new();
        differing("", &self.settings, &now.settings, &mut changed);
        let others = [
            ("files", self.files != now.files),
            ("walls", self.upstream != now.upstream),
            ("version", self.version != now.version),
        ];
        changed.extend(others.iter().filter(|o| o.1).map(|o| o.0.to_owned()));
        changed
    }
}

/// The topmost keys whose values differ; lists are looked into, so that their members' keys are named.
fn differing(key: &str, a: &Value, b: &Value, changed: &mut Vec<String>) {
    match (a, b) {
        _ if a == b => {}
        (Value::Array(a), Value::Array(b)) if key.is_empty() && a.len() == b.len() => {
            for (a, b) in a.iter().zip(b) {
                differing(key, a, b, changed);
            }
        }
        (Value::Object(a), Value::Object(b)) if key.is_empty() => {
            let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                if a.get(key) != b.get(key) {
                    changed.push(key.clone());
                }
            }
        }
        _ => changed.push("moving walls or probes".to_owned()),
    }
}

impl Stamp {
    /// Notes what the stage left.
    pub fn write(
        stage: Stage,
        folder: &Folder,
        inputs: Inputs,
        seconds: f64,
    ) -> Result<(), FlowError> {
        let stamp = Self {
            inputs,
            outputs: folder.files_of(stage.owns())?,
            seconds,
        };
        Ok(cache::write_json(&folder.stamp(stage), &stamp)?)
    }

    /// The stamp of a stage; none if it never finished or the file makes no sense.
    pub fn read(stage: Stage, folder: &Folder) -> Option<Self> {
        let text = fs::read(folder.stamp(stage)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// Differs when inputs or outputs do; not when only the time taken does.
    pub fn id(&self) -> u32 {
        let mut hash = crc32fast::Hasher::new();
        hash.update(format!("{:?} {:?}", self.inputs, self.outputs).as_bytes());
        hash.finalize()
    }
}

/// The stamp of a stage whose results are what they would be if it ran now.
pub(super) fn fresh(
    stage: Stage,
    scene: &Scene,
    folder: &Folder,
) -> Result<Option<Stamp>, FlowError> {
    let Some(stamp) = Stamp::read(stage, folder) else {
        return Ok(None);
    };
    let inputs = match Inputs::of(stage, scene, folder) {
        Ok(inputs) => inputs,
        Err(FlowError::Missing { .. }) => return Ok(None),
        Err(other) => return Err(other),
    };
    let same = stamp.inputs == inputs && stamp.outputs == folder.files_of(stage.owns())?;
    Ok(same.then_some(stamp))
}

pub(super) fn checksum(path: &Path) -> Result<(u64, u32), FlowError> {
    let failed = |source| FlowError::Input {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(failed)?;
    let mut hash = crc32fast::Hasher::new();
    let mut length = 0;
    let mut block = vec![0; 1 << 16];
    loop {
        let read = file.read(&mut block).map_err(failed)?;
        if read == 0 {
            return Ok((length, hash.finalize()));
        }
        length += read as u64;
        hash.update(&block[..read]);
    }
}
