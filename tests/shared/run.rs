//! A run to look at: what benchmarks of surfaces read.

use osteoflow::cache::{Frame, read_frame, read_solid};
use osteoflow::solid::Solid;
use std::path::{Path, PathBuf};

/// The run that `OSTEOFLOW_RUN` names: its walls, and every frame or every `OSTEOFLOW_STEP`th.
pub struct Run {
    pub solid: Solid,
    frames: Vec<PathBuf>,
}

impl Run {
    /// None where no run is named: then there is nothing to look at.
    pub fn named() -> Option<Self> {
        let run = std::env::var("OSTEOFLOW_RUN").ok()?;
        let step: usize =
            std::env::var("OSTEOFLOW_STEP").map_or(1, |s| s.parse().expect("a number"));
        let run = Path::new(&run);
        let mut frames: Vec<_> = (std::fs::read_dir(run.join("frames")).expect("frames"))
            .map(|entry| entry.expect("a file").path())
            .collect();
        frames.sort();
        Some(Self {
            solid: read_solid(&run.join("boundary/solid.osf")).expect("walls"),
            frames: frames.into_iter().step_by(step).collect(),
        })
    }

    pub fn frames(&self) -> impl Iterator<Item = Frame> {
        (self.frames.iter()).map(|path| read_frame(path).expect("a frame"))
    }
}
