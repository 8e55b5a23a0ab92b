//! Why a stage did not finish.

use super::Stage;
use crate::bone::{BoneError, landmarks::LandmarkError};
use crate::cache::CacheError;
use crate::grid::vdb::VdbError;
use crate::mesh::{ObjError, OpenMesh};
use crate::scene::SceneError;
use crate::sim::SimError;
use std::path::PathBuf;

/// Why a stage did not finish.
#[derive(Debug, thiserror::Error)]
pub enum FlowError {
    /// The recipe is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file of ours cannot be read or written.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// The output folder belongs to something else.
    #[error("{folder} {why}: choose another folder with --out, or give --force to use this one")]
    Occupied {
        /// The folder.
        folder: PathBuf,
        /// Whose it is.
        why: String,
    },
    /// A stage was asked for before what it reads is there.
    #[error(
        "{stage} needs the results of {needed}, which are missing or out of date: run it first"
    )]
    Missing {
        /// What was asked for.
        stage: Stage,
        /// What has to come before.
        needed: Stage,
    },
    /// A simulation that was stopped, and is asked for again as if it had not been.
    #[error(
        "this simulation was stopped at t = {time:.4} s: give --resume to go on, or --force to begin again"
    )]
    Unfinished {
        /// How far it came [s].
        time: f64,
    },
    /// Another simulation than the one that was stopped.
    #[error(
        "the stopped simulation was another one: {} changed since; without --resume it begins again",
        .keys.join(", ")
    )]
    Changed {
        /// What differs.
        keys: Vec<String>,
    },
    /// A signal asked for it.
    #[error("stopped{}; what is done is kept, --resume goes on", .time.map_or(String::new(), |t| format!(" at t = {t:.4} s")))]
    Stopped {
        /// How far the simulation came [s], if it was that.
        time: Option<f64>,
    },
    /// `--frames` that selects nothing.
    #[error("--frames {range}: there are frames {first} to {last}")]
    NoFrames {
        /// As asked.
        range: super::FrameRange,
        /// The first that there is.
        first: u32,
        /// The last that there is.
        last: u32,
    },
    /// A folder that was to be shown beside others.
    #[error("{0} holds no results (no recipe.lock.toml): run a recipe with -o {0} first")]
    NoResults(PathBuf),
    /// A view that a run has no pictures of.
    #[error(
        "{folder} has no pictures of a view `{view}`: run `preview` there first, or name another with --view"
    )]
    NoPictures {
        /// The run's folder.
        folder: PathBuf,
        /// The view.
        view: String,
    },
    /// A mesh that the recipe names cannot be read.
    #[error("cannot read {path}, which the recipe names")]
    Input {
        /// The mesh.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A mesh that makes no sense.
    #[error(transparent)]
    Mesh(#[from] ObjError),
    /// A mesh that does not enclose a volume.
    #[error("{path}")]
    Open {
        /// The mesh.
        path: PathBuf,
        /// What is wrong with it.
        source: OpenMesh,
    },
    /// A volume that cannot be read.
    #[error(transparent)]
    Volume(#[from] VdbError),
    /// A file that lacks what the recipe wants of it.
    #[error("{path} {problem}")]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        problem: String,
    },
    /// A bone whose front and back cannot be told.
    #[error("{path} (with frame = \"as is\" its own axes are used)")]
    NoFrame {
        /// The bone's mesh.
        path: PathBuf,
        /// Why.
        source: LandmarkError,
    },
    /// A bone that cannot be built.
    #[error(transparent)]
    Bone(#[from] BoneError),
    /// The simulation fell over.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// Nothing to compare with.
    #[error("{0} holds no picture of these frames and views: make some with --bless")]
    NoGolden(PathBuf),
    /// Pictures that are not as they were.
    #[error(
        "{count} of {of} pictures differ, the first is {first}; see {page}, or accept them with --bless"
    )]
    Differs {
        /// How many.
        count: usize,
        /// Of how many.
        of: usize,
        /// The first, and how.
        first: String,
        /// Where they are shown side by side.
        page: PathBuf,
    },
    /// A file or folder that cannot be used.
    #[error("{path}")]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl FlowError {
    pub(super) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, source }
    }
}
