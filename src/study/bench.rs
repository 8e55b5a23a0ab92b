//! The bench that studies work at: how thorough to be, runs that are kept, and a voice.

use super::StudyError;
use crate::report::Runs;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    note: Mutex<&'a mut Voice>,
}

/// What hears how a study goes.
pub type Voice = dyn FnMut(&str) + Send;

impl<'a> Bench<'a> {
    /// A bench that keeps its runs in `folder`, which has to be empty or hold such runs.
    pub fn open(folder: &Path, level: Level, note: &'a mut Voice) -> Result<Self, StudyError> {
        let kept = folder.join("runs");
        let foreign = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        if foreign && !kept.is_dir() {
            return Err(StudyError::Occupied(folder.to_owned()));
        }
        Ok(Self {
            level,
            runs: Runs::open(&kept),
            note: Mutex::new(note),
        })
    }

    /// The result of a run and its seconds, as kept or made now; `name` is a file name, and `settings` is all that
    /// the result depends on beside the program.
    pub fn run<S, T>(
        &self,
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

    /// The answers to questions that need nothing of each other, in their order: as many at a time as there are threads,
    /// each on one thread of its own.
    pub fn side_by_side<Q: Sync, A: Send>(
        &self,
        questions: &[Q],
        answer: impl Fn(&Q) -> Result<A, StudyError> + Sync,
    ) -> Result<Vec<A>, StudyError> {
        let next = AtomicUsize::new(0);
        let work = || -> Result<Vec<(usize, A)>, StudyError> {
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
            let alone = alone.map_err(|error| StudyError::Scene(error.to_string()))?;
            let mut answers = Vec::new();
            while let number = next.fetch_add(1, Ordering::Relaxed)
                && let Some(question) = questions.get(number)
            {
                let given = alone.install(|| answer(question));
                if given.is_err() {
                    // Nobody takes up another.
                    next.store(questions.len(), Ordering::Relaxed);
                }
                answers.push((number, given?));
            }
            Ok(answers)
        };
        let mut answers = std::thread::scope(|scope| {
            let threads = rayon::current_num_threads().min(questions.len());
            let working: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            let mut answers = Vec::new();
            for thread in working {
                match thread.join() {
                    Ok(given) => answers.extend(given?),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            Ok::<_, StudyError>(answers)
        })?;
        answers.sort_by_key(|(number, _)| *number);
        Ok(answers.into_iter().map(|(_, answer)| answer).collect())
    }

    /// Says something about how it goes.
    pub fn note(&self, text: &str) {
        if let Ok(mut note) = self.note.lock() {
            note(text);
        }
    }
}
