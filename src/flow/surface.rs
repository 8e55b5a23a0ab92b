//! Frames → `surface/`: an OBJ each, and what they enclose.

use super::{Event, FlowError, Job, Observer, each_frame};
use crate::cache::{self, Frame};
use crate::mesh::{inspect, write_obj};
use crate::preview::colour;
use crate::surface::{Surface, reconstruct};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;

/// Error of the volume that is worth a word [1].
const LARGE_ERROR: f64 = 0.02;

/// One surface, in `surface.json`.
#[derive(Serialize, Deserialize)]
struct Entry {
    time_s: f64,
    vertices: usize,
    triangles: usize,
    closed: bool,
    pieces: usize,
    /// What the surface encloses.
    volume_m3: f64,
    /// What the particles stand for.
    particle_volume_m3: f64,
    /// How much more the surface encloses.
    volume_error: f64,
    /// Pieces that were too small to be shown, and what they enclosed.
    pieces_left_out: usize,
    left_out_m3: f64,
}

pub(super) fn work(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let solid = cache::read_solid(&job.folder.solid())?;
    // With chosen frames, the others keep their entries.
    let path = job.folder.surface_report();
    let mut entries: BTreeMap<u32, Entry> = fs::read(&path)
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    let made = each_frame(job, &job.folder.frames(job.frames)?, |frame| {
        let surface = reconstruct(frame, Some(&solid), &job.scene.surface);
        let path = job.folder.surface(frame.index);
        let mut text = Vec::new();
        let mesh = &surface.mesh;
        let colours = colours(&surface);
        write_obj(&mut text, mesh, Some(&surface.normal), Some(&colours))
            .map_err(FlowError::io(&path))?;
        cache::write(&path, &text)?;
        Ok((frame.index, entry(frame, &surface)))
    })?;
    tell(job, &made, observer);
    entries.extend(made);
    Ok(cache::write_json(&path, &entries)?)
}

/// Says what no surface should be.
fn tell(job: &Job, made: &[(u32, Entry)], observer: &mut Observer<'_>) {
    let mut note = |n: u32, text: &str| observer(Event::Note(&job.folder.surface(n), text));
    for (n, _) in made.iter().filter(|(_, entry)| !entry.closed) {
        note(
            *n,
            "the surface is not closed, which is a fault of this program",
        );
    }
    let wrong = |entry: &Entry| entry.volume_error.abs();
    let worst = made
        .iter()
        .max_by(|a, b| wrong(&a.1).total_cmp(&wrong(&b.1)));
    if let Some((n, entry)) = worst.filter(|(_, entry)| wrong(entry) > LARGE_ERROR) {
        let text = format!(
            "encloses {:+.1} % more than the particles' volume, the most of all frames",
            100.0 * entry.volume_error
        );
        note(*n, &text);
    }
}

/// sRGB, 0 to 1: what artists' tools take vertex colours for.
fn colours(surface: &Surface) -> Vec<[f32; 3]> {
    let bytes = surface
        .polymer_fraction
        .iter()
        .map(|&alpha| colour::to_srgb(&colour::scale(alpha.into())));
    bytes
        .map(|colour| colour.map(|byte| f32::from(byte) / 255.0))
        .collect()
}

fn entry(frame: &Frame, surface: &Surface) -> Entry {
    let found = inspect(&surface.mesh);
    let particle_volume = frame.position.len() as f64 * frame.rest_volume;
    let volume_error = if particle_volume > 0.0 {
        found.signed_volume / particle_volume - 1.0
    } else {
        0.0
    };
    Entry {
        time_s: frame.time,
        vertices: surface.mesh.positions.len(),
        triangles: found.triangles,
        closed: found.is_closed() || frame.position.is_empty(),
        pieces: found.components,
        volume_m3: found.signed_volume,
        particle_volume_m3: particle_volume,
        volume_error,
        pieces_left_out: surface.left_out.pieces,
        left_out_m3: surface.left_out.volume,
    }
}
