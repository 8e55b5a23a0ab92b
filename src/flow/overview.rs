//! The pictures of a run together: a contact sheet, and an animation of each view.

use super::{FlowError, Job, preview::png};
use crate::cache;
use crate::preview::{FELL_OVER, Row, WELL, animation, contact_sheet, shrunk};
use image::RgbImage;
use std::fs;

/// Columns of a contact sheet.
const TIMES: usize = 6;
/// Widest picture on a contact sheet, and in an animation [pixels].
const WIDEST: [u32; 2] = [320, 640];

/// Draws both out of the pictures that are there, in all frames.
pub(super) fn write(job: &Job) -> Result<(), FlowError> {
    let frames = job.folder.frames(None)?;
    let fell_over = fs::read(job.folder.simulation_report())
        .ok()
        .and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok())
        .is_some_and(|report| report["diverged"].is_string());
    let mut rows = Vec::new();
    for view in &job.scene.preview.views {
        let mut small = Vec::new();
        for n in &frames {
            let path = job.folder.picture(&view.name, *n);
            if path.exists() {
                let picture = image::open(&path)
                    .map_err(|e| FlowError::io(&path)(std::io::Error::other(e)))?
                    .into_rgb8();
                small.push((*n, fitting(&picture, WIDEST[1])));
            }
        }
        let Some(last) = small.len().checked_sub(1) else {
            continue;
        };
        let columns = TIMES.min(small.len());
        let pictures = (0..columns).map(|c| {
            let at = if columns > 1 {
                c * last / (columns - 1)
            } else {
                0
            };
            let ended_here = fell_over && at == last;
            let frame = if ended_here { FELL_OVER } else { WELL };
            (fitting(&small[at].1, WIDEST[0]), frame)
        });
        rows.push(Row {
            title: format!("{}: {}", job.scene.name, view.name),
            pictures: pictures.collect(),
        });
        let moving: Vec<RgbImage> = small.into_iter().map(|(_, picture)| picture).collect();
        let path = job.folder.animation(&view.name);
        let bytes = animation(&moving, job.scene.sim.frames_per_second);
        cache::write(&path, &bytes.map_err(FlowError::io(&path))?)?;
    }
    if rows.is_empty() {
        return Ok(());
    }
    let path = job.folder.contact_sheet();
    Ok(cache::write(&path, &png(&path, &contact_sheet(&rows))?)?)
}

fn fitting(picture: &RgbImage, widest: u32) -> RgbImage {
    shrunk(picture, picture.width().div_ceil(widest))
}
