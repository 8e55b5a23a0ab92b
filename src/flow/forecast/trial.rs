//! The stages after the simulation, tried on two frames: how long they take and what they leave.

use super::StageForecast;
use crate::flow::{FlowError, FrameRange, Job, Stage};
use std::fs;
use std::time::Instant;

/// What all frames are like, by those that are tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    /// How many there will be.
    pub count: f64,
    /// Their mean size in particles and surface, of the mean of the two.
    pub share: f64,
}

/// Frames 1 and 2 are those that are tried.
const TRIED: FrameRange = FrameRange { first: 1, last: 2 };

/// Makes what `stage` makes of the two frames.
pub(super) fn of(job: &Job, stage: Stage, frames: Frames) -> Result<StageForecast, FlowError> {
    let seconds = 0.5 * frames.count * frames.share * time(job, stage, TRIED)?;
    Ok(StageForecast {
        stage: stage.name(),
        seconds,
        bytes: weigh(job, stage, frames)?,
    })
}

/// Pictures cost the same whatever is on them, but what stands around the cement is prepared once, and a turntable's
/// pictures each prepare it anew.
pub(super) fn pictures(job: &Job, frames: Frames) -> Result<StageForecast, FlowError> {
    let stage = Stage::Preview;
    let mut plain = job.clone();
    plain
        .scene
        .preview
        .views
        .iter_mut()
        .for_each(|view| view.turntable = 0);
    let asked: u32 = job.scene.preview.views.iter().map(|v| v.turntable).sum();
    let (mut turning, mut turns) = (0.0, 0.0);
    let mut of_turntables = 0;
    if asked > 0 {
        let mut short = job.clone();
        let views = short.scene.preview.views.iter_mut();
        for view in views.filter(|view| view.turntable > 0) {
            view.turntable = 2;
            turns += 2.0;
        }
        turning = time(&short, stage, TRIED)?;
        let files = job.folder.files_of(stage.owns())?;
        let tables = files
            .iter()
            .filter(|(path, _)| path.contains(".turntable."));
        of_turntables = tables.map(|(_, length)| length).sum();
        job.folder.clear(stage.owns())?;
    }
    for n in [1, 2] {
        let copy = job.folder.frame(n + 2);
        fs::copy(job.folder.frame(n), &copy).map_err(FlowError::io(&copy))?;
    }
    let four = time(&plain, stage, FrameRange { first: 1, last: 4 })?;
    job.folder.clear(stage.owns())?;
    let two = time(&plain, stage, TRIED)?;
    let pair = (four - two).max(0.1 * two);
    let all = Frames {
        share: 1.0,
        ..frames
    };
    let times = f64::from(asked) / f64::max(turns, 1.0);
    Ok(StageForecast {
        stage: stage.name(),
        seconds: two
            + 0.5 * (frames.count - 2.0).max(0.0) * pair
            + times * (turning - two).max(0.0),
        bytes: weigh(&plain, stage, all)? + (of_turntables as f64 * times) as u64,
    })
}

fn time(job: &Job, stage: Stage, range: FrameRange) -> Result<f64, FlowError> {
    let mut job = job.clone();
    job.frames = Some(range);
    let began = Instant::now();
    job.run(stage, &mut |_| {})?;
    Ok(began.elapsed().as_secs_f64())
}

/// What the files of a stage will weigh: those of the two frames times the frames that there will be, and the others
/// as they are [bytes].
pub(super) fn weigh(job: &Job, stage: Stage, frames: Frames) -> Result<u64, FlowError> {
    let (mut of_frames, mut others) = (0, 0);
    for (path, length) in job.folder.files_of(stage.owns())? {
        let name = path.rsplit('/').next().unwrap_or_default();
        let numbered = |part: &str| part.len() >= 4 && part.bytes().all(|b| b.is_ascii_digit());
        if name.split('.').any(numbered) || name.contains(".animation.") {
            of_frames += length;
        } else {
            others += length;
        }
    }
    Ok(others + (of_frames as f64 * 0.5 * frames.count * frames.share) as u64)
}
