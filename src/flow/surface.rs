//! Frames → `surface/`: an OBJ each, and what they enclose.

use super::{FlowError, Job, Observer, each_frame};
use crate::cache::{self, Frame};
use crate::mesh::{inspect, write_obj};
use crate::preview::colour;
use crate::surface::{Surface, reconstruct};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;

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
}

pub(super) fn work(job: &Job, _: &mut Observer<'_>) -> Result<(), FlowError> {
    // With chosen frames, the others keep their entries.
    let path = job.folder.surface_report();
    let mut entries: BTreeMap<u32, Entry> = fs::read(&path)
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    entries.extend(each_frame(job, |frame| {
        let surface = reconstruct(frame, &job.scene.surface);
        let path = job.folder.surface(frame.index);
        let mut text = Vec::new();
        let mesh = &surface.mesh;
        let colours = colours(&surface);
        write_obj(&mut text, mesh, Some(&surface.normal), Some(&colours))
            .map_err(FlowError::io(&path))?;
        cache::write(&path, &text)?;
        Ok((frame.index, entry(frame, &surface)))
    })?);
    Ok(cache::write_json(&path, &entries)?)
}

/// sRGB, 0 to 1: what artists' tools take vertex colours for.
fn colours(surface: &Surface) -> Vec<[f32; 3]> {
    let bytes = surface
        .polymer_fraction
        .iter()
        .map(|&alpha| colour::to_srgb(&colour::polymer(alpha.into())));
    bytes
        .map(|colour| colour.map(|byte| f32::from(byte) / 255.0))
        .collect()
}

fn entry(frame: &Frame, surface: &Surface) -> Entry {
    let found = inspect(&surface.mesh);
    Entry {
        time_s: frame.time,
        vertices: surface.mesh.positions.len(),
        triangles: found.triangles,
        closed: found.is_closed() || frame.position.is_empty(),
        pieces: found.components,
        volume_m3: found.signed_volume,
        particle_volume_m3: frame.position.len() as f64 * frame.rest_volume,
    }
}
