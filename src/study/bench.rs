//! The bench that studies work at: how thorough to be, runs that are kept, and a voice.

use super::StudyError;
use crate::report::Runs;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// How thorough a study is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Minutes: coarse and short.
    Quick,
    /// An hour or more: fine enough for orders of convergence.
    Full,
}

impl Level {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }

    /// One value for each level.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// Where a study's runs are made and kept.
pub struct Bench<'a> {
    /// How thorough to be.
    pub level: Level,
    runs: Runs,
    note: &'a mut dyn FnMut(&str),
}

impl<'a> Bench<'a> {
    /// A bench that keeps its runs in `folder`, which has to be empty or hold such runs.
    pub fn open(
        folder: &Path,
        level: Level,
        note: &'a mut dyn FnMut(&str),
    ) -> Result<Self, StudyError> {
        let kept = folder.join("runs");
        let foreign = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        if foreign && !kept.is_dir() {
            return Err(StudyError::Occupied(folder.to_owned()));
        }
        Ok(Self {
            level,
            runs: Runs::open(&kept),
            note,
        })
    }

    /// The result of a run and its seconds, as kept or made now; `name` is a file name, and `settings` is all that
    /// the result depends on beside the program.
    pub fn run<S, T>(
        &mut self,
        name: &str,
        settings: &S,
        work: impl FnOnce() -> Result<T, StudyError> + Send,
    ) -> Result<(T, f64), StudyError>
    where
        S: Serialize,
        T: Serialize + DeserializeOwned + Send,
    {
        let mut made = false;
        let result = self.runs.keep(name, settings, || {
            made = true;
            // Inside the pool a parallel loop need not wake anyone to start it.
            rayon::scope(|_| work())
        })?;
        let how = if made { "took" } else { "kept, took" };
        self.note(&format!("{name}: {how} {:.1} s", result.1));
        Ok(result)
    }

    /// Says something about how it goes.
    pub fn note(&mut self, text: &str) {
        (self.note)(text);
    }
}
