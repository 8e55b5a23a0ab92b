//! Pictures together: a contact sheet and an animation of each view, and sheets over several runs.

use super::{FlowError, Folder, FrameRange, Job, preview::png};
use crate::cache;
use crate::preview::{FELL_OVER, LEAKED, Row, WELL, animation, contact_sheet, shrunk};
use crate::scene;
use image::RgbImage;
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

/// Columns of a contact sheet.
const TIMES: usize = 6;
/// Widest picture on a contact sheet, and in an animation [pixels].
pub(super) const WIDEST: [u32; 2] = [320, 640];

/// Draws both out of the pictures that are there, in all frames.
pub(super) fn write(job: &Job) -> Result<(), FlowError> {
    let views: Vec<&str> = (job.scene.preview.views.iter())
        .map(|view| view.name.as_str())
        .collect();
    let ended = Ended::of(&job.folder);
    let rows = (views.par_iter())
        .map(|view| {
            let mut small = pictures(&job.folder, view, None)?;
            let Some(size) = small.last().map(|(_, picture)| picture.dimensions()) else {
                return Ok(None);
            };
            // Frames drawn earlier, at another size, are no part of it.
            small.retain(|(_, picture)| picture.dimensions() == size);
            let moving: Vec<&RgbImage> = small.iter().map(|(_, picture)| picture).collect();
            let path = job.folder.animation(view);
            let bytes = animation(&moving, job.scene.sim.frames_per_second);
            cache::write(&path, &bytes.map_err(FlowError::io(&path))?)?;
            Ok(Some(row(&job.scene.name, view, &small, ended, TIMES)))
        })
        .collect::<Result<Vec<_>, FlowError>>()?;
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    if rows.is_empty() {
        return Ok(());
    }
    let path = job.folder.contact_sheet();
    Ok(cache::write(&path, &png(&path, &contact_sheet(&rows))?)?)
}

/// A contact sheet with a row for each run and view: of those named `view`, or of the first that each run has. Columns
/// are `times` moments from the start to the end of each run. The frame around the last picture says how it ended.
pub fn sheet(
    folders: &[PathBuf],
    view: Option<&str>,
    times: usize,
    path: &Path,
) -> Result<(), FlowError> {
    let rows = (folders.par_iter())
        .map(|root| {
            let folder = Folder::existing(root)?;
            let (_, scene) = scene::load(&folder.lock(), &[])?;
            let first = scene.preview.views.first().map(|view| view.name.as_str());
            let name = view.or(first).unwrap_or_default();
            let small = pictures(&folder, name, Some(times))?;
            if small.is_empty() {
                return Err(FlowError::NoPictures {
                    folder: root.clone(),
                    view: name.to_owned(),
                });
            }
            Ok(row(&scene.name, name, &small, Ended::of(&folder), times))
        })
        .collect::<Result<Vec<Row>, FlowError>>()?;
    Ok(cache::write(path, &png(path, &contact_sheet(&rows))?)?)
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    Well,
    Leaked,
    FellOver,
}

impl Ended {
    fn of(folder: &Folder) -> Self {
        let report = fs::read(folder.simulation_report())
            .ok()
            .and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok())
            .unwrap_or_default();
        if report["diverged"].is_string() {
            return Self::FellOver;
        }
        let leaked = report["leaked_m3"].as_object();
        let leaks = leaked.is_some_and(|l| l.values().any(|v| v.as_f64().is_some_and(|v| v > 0.0)));
        if leaks { Self::Leaked } else { Self::Well }
    }

    fn frame(self) -> [u8; 3] {
        match self {
            Self::Well => WELL,
            Self::Leaked => LEAKED,
            Self::FellOver => FELL_OVER,
        }
    }
}

/// The pictures of a view with their frames, small; if `times` is given, no more than that, evenly over time.
fn pictures(
    folder: &Folder,
    view: &str,
    times: Option<usize>,
) -> Result<Vec<(u32, RgbImage)>, FlowError> {
    let mut frames = folder.frames(None::<FrameRange>)?;
    frames.retain(|n| folder.picture(view, *n).exists());
    if let Some(times) = times {
        frames = moments(frames.len(), times).map(|at| frames[at]).collect();
    }
    frames
        .par_iter()
        .map(|n| {
            let path = folder.picture(view, *n);
            let picture = image::open(&path)
                .map_err(|e| FlowError::io(&path)(std::io::Error::other(e)))?
                .into_rgb8();
            Ok((*n, fitting(&picture, WIDEST[1])))
        })
        .collect()
}

/// `times` places among `count`, evenly, with both ends; fewer if there are not so many.
fn moments(count: usize, times: usize) -> impl Iterator<Item = usize> {
    let columns = times.min(count);
    (0..columns).map(move |c| c * (count - 1) / (columns - 1).max(1))
}

fn row(scene: &str, view: &str, small: &[(u32, RgbImage)], ended: Ended, times: usize) -> Row {
    let pictures = moments(small.len(), times).map(|at| {
        let last = at + 1 == small.len();
        let frame = if last { ended.frame() } else { WELL };
        (fitting(&small[at].1, WIDEST[0]), frame)
    });
    Row {
        title: format!("{scene}: {view}"),
        pictures: pictures.collect(),
    }
}

fn fitting(picture: &RgbImage, widest: u32) -> RgbImage {
    shrunk(picture, picture.width().div_ceil(widest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_hold_both_ends_and_are_evenly_spread() {
        let all = |count, times| moments(count, times).collect::<Vec<_>>();
        assert_eq!(all(11, 6), [0, 2, 4, 6, 8, 10]);
        assert_eq!(all(3, 6), [0, 1, 2]);
        assert_eq!(all(5, 1), [0]);
        assert!(all(0, 6).is_empty());
    }
}
