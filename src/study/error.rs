//! Why a study did not finish.

use crate::cache::CacheError;
use crate::sim::SimError;
use std::path::PathBuf;

/// Why a study did not finish, or what it found wanting.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// There is none of that name.
    #[error("there is no {kind} `{name}`; there are: {known}")]
    Unknown {
        /// Case or study.
        kind: &'static str,
        /// As asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// The folder belongs to something else.
    #[error("{0} is not empty and holds no runs of a study: choose another folder with --out")]
    Occupied(PathBuf),
    /// A file cannot be read or written.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// A run that has to finish fell over.
    #[error("{run}")]
    Run {
        /// Which.
        run: String,
        /// Why.
        source: SimError,
    },
    /// A scene that cannot be built.
    #[error("the scene cannot be built: {0}")]
    Scene(String),
    /// Figures that are worse than those recorded in the project.
    #[error("worse than recorded: {}", .0.join("; "))]
    Worse(Vec<String>),
}

impl StudyError {
    pub(super) fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> Self {
        Self::Unknown {
            kind,
            name: name.to_owned(),
            known: known.collect::<Vec<_>>().join(", "),
        }
    }

    /// A failed run, by its name.
    pub(super) fn run(run: &str) -> impl FnOnce(SimError) -> Self {
        let run = run.to_owned();
        move |source| Self::Run { run, source }
    }
}
