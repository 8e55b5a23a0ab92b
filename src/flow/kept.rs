//! Which frames' files are still what they would be if they were made again.

use super::{FlowError, Folder, stamp::checksum};
use crate::cache;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

/// The files that a stage left of each frame.
pub(super) struct Kept {
    path: PathBuf,
    frames: BTreeMap<u32, Files>,
}

/// What was made of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Files {
    /// Of everything that they depend on.
    id: u32,
    /// Path and length of each.
    files: Vec<(String, u64)>,
}

/// A number that changes with what is `said` and with the bytes of the `files`.
pub(super) fn id(said: &str, files: &[PathBuf]) -> Result<u32, FlowError> {
    let mut hash = crc32fast::Hasher::new();
    hash.update(said.as_bytes());
    for file in files {
        hash.update(format!(" {:?}", checksum(file)?).as_bytes());
    }
    Ok(hash.finalize())
}

impl Kept {
    /// What is noted in the file at `path`: nothing if it is not there or makes no sense.
    pub fn read(path: PathBuf) -> Self {
        let text = fs::read(&path).ok();
        let frames = text.and_then(|text| serde_json::from_slice(&text).ok());
        Self {
            path,
            frames: frames.unwrap_or_default(),
        }
    }

    /// Forgets frames that have another id now, or are no more, or whose files were touched; removes what is under
    /// the names that a stage `owns` and belongs to no other frame.
    pub fn retain(
        &mut self,
        folder: &Folder,
        owns: &[&str],
        ids: &BTreeMap<u32, u32>,
    ) -> Result<(), FlowError> {
        let there = folder.files_of(owns)?;
        let is_there = |file: &(String, u64)| there.binary_search(file).is_ok();
        self.frames
            .retain(|n, made| ids.get(n) == Some(&made.id) && made.files.iter().all(is_there));
        let kept = self.frames.values().flat_map(|made| &made.files);
        let kept: BTreeSet<_> = kept.collect();
        for file in there.iter().filter(|file| !kept.contains(file)) {
            folder.clear(&[&file.0])?;
        }
        self.write()
    }

    /// Forgets a frame that is about to be made.
    pub fn forget(&mut self, n: u32) -> Result<(), FlowError> {
        self.frames.remove(&n);
        self.write()
    }

    /// Whether the files of frame `n` are what they would be.
    pub fn has(&self, n: u32) -> bool {
        self.frames.contains_key(&n)
    }

    /// Notes what was made of some frames: of their `files` those that are there.
    pub fn add(
        &mut self,
        folder: &Folder,
        ids: &BTreeMap<u32, u32>,
        frames: &[u32],
        files: impl Fn(u32) -> [PathBuf; 4],
    ) -> Result<(), FlowError> {
        for &n in frames {
            let Some(&id) = ids.get(&n) else { continue };
            let names: Vec<String> = (files(n).iter()).map(|path| folder.name_of(path)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let files = folder.files_of(&names)?;
            self.frames.insert(n, Files { id, files });
        }
        self.write()
    }

    fn write(&self) -> Result<(), FlowError> {
        Ok(cache::write_json(&self.path, &self.frames)?)
    }
}
