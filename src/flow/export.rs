//! Frames → `vdb/`, `ply/`, `vtp/`, and the scene that ties them together.

use super::{FlowError, Job, Observer, each_frame};
use crate::cache::{self, Frame};
use crate::export::{
    self, Column, Format, Grid, Leaves, grids, level_set, ply,
    usd::{self, Take},
    vdb, vtp,
};
use crate::grid::BrickGrid;
use crate::math::{Real, Vec3};
use crate::preview::colour;
use crate::solid::Solid;
use crate::surface::{Surface, reconstruct};
use std::io;
use std::path::Path;

/// What the vertices carry beside colour, normal and velocity.
const NUMBERS: [&str; 5] = [
    "polymer_fraction",
    "speed",
    "pressure",
    "shear_rate",
    "millilitre",
];

pub(super) fn work(job: &Job, _: &mut Observer<'_>) -> Result<(), FlowError> {
    let solid = cache::read_solid(&job.folder.solid())?;
    let settings = &job.scene.export;
    each_frame(job, |frame| {
        let surface = reconstruct(frame, Some(&solid), &job.scene.surface);
        let mut volumes = grids::from_frame(frame, settings);
        volumes.push(level_set(job, &surface, &volumes[0], &solid));
        write(&job.folder.vdb(frame.index), |out| {
            vdb::write(out, &volumes, settings.into())
        })?;
        let rows = Rows::new(&surface);
        let columns = rows.columns(&surface);
        if settings.formats.contains(&Format::Ply) {
            write(&job.folder.ply(frame.index), |out| {
                ply::write(out, &surface.mesh, &columns)
            })?;
        }
        if settings.formats.contains(&Format::Vtp) {
            write(&job.folder.vtp(frame.index), |out| particles(out, frame))?;
        }
        if settings.formats.contains(&Format::Usd) {
            let layer = usd::layer(frame.index, &surface.mesh, &columns);
            cache::write(&job.folder.usd_layer(frame.index), &layer)?;
        }
        Ok(())
    })?;
    scripts(job)
}

fn write(path: &Path, put: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<(), FlowError> {
    let mut bytes = Vec::new();
    put(&mut bytes).map_err(FlowError::io(path))?;
    Ok(cache::write(path, &bytes)?)
}

/// The surface's own distance, on the voxels of the other grids.
fn level_set(job: &Job, surface: &Surface, density: &Grid, solid: &Solid) -> Grid {
    let mut known = BrickGrid::new(Vec3::zeros(), density.voxel, 0.0);
    let mut filled = Vec::new();
    if let Leaves::Float(leaves) = &density.leaves {
        for leaf in leaves {
            known.insert_brick(leaf.first, leaf.values.clone());
            filled.push(leaf.first);
        }
    }
    let threshold = job.scene.surface.threshold as f32;
    let inside = |at: [i32; 3]| {
        let [x, y, z] = at.map(|n| Real::from(n) * density.voxel);
        known.get(at) > threshold && solid.phi(&Vec3::new(x, -z, y)) > 0.0
    };
    level_set::from_surface(
        &surface.mesh,
        &surface.normal,
        density.voxel,
        &filled,
        inside,
    )
}

/// Columns that a surface does not hold as they are written.
struct Rows {
    normal: Vec<[f32; 3]>,
    speed: Vec<f32>,
    colour: Vec<[u8; 3]>,
}

impl Rows {
    fn new(surface: &Surface) -> Self {
        let alpha = surface.polymer_fraction.iter();
        Self {
            normal: surface
                .normal
                .iter()
                .map(|n| (*n).map(|c| c as f32).into())
                .collect(),
            speed: surface.speed(),
            colour: alpha
                .map(|&a| colour::to_srgb(&colour::scale(a.into())))
                .collect(),
        }
    }

    fn columns<'a>(&'a self, surface: &'a Surface) -> [Column<'a>; 8] {
        let numbers = [
            &surface.polymer_fraction,
            &self.speed,
            &surface.pressure,
            &surface.shear_rate,
            &surface.millilitre,
        ];
        let [alpha, speed, pressure, shear, age] =
            std::array::from_fn(|i| Column::Number(NUMBERS[i], numbers[i]));
        [
            Column::Vector("normal", &self.normal),
            Column::Colour(&self.colour),
            Column::Vector("velocity", &surface.velocity),
            alpha,
            speed,
            pressure,
            shear,
            age,
        ]
    }
}

fn particles(out: &mut Vec<u8>, frame: &Frame) -> io::Result<()> {
    let id: Vec<f32> = frame.id.iter().map(|&id| id as f32).collect();
    let columns = [
        Column::Vector("velocity", &frame.velocity),
        Column::Number("polymer_fraction", &frame.polymer_fraction),
        Column::Number("pressure", &frame.pressure),
        Column::Number("id", &id),
    ];
    vtp::write(out, &frame.position, &columns)
}

/// What opens the take in other programs: all frames that there are, whichever were exported last.
fn scripts(job: &Job) -> Result<(), FlowError> {
    let frames = job.folder.frames(None)?;
    let settings = &job.scene.export;
    let take = Take {
        frames: &frames,
        frames_per_second: job.scene.sim.frames_per_second,
        grids: &["density", "polymer", &settings.velocity_name, "surface"],
        numbers: &NUMBERS,
    };
    let folder = &job.folder;
    let script = export::blender_script(&take, &settings.velocity_name);
    cache::write(&folder.blender_script(), script.as_bytes())?;
    let note = export::houdini_note(&take, &settings.velocity_name);
    cache::write(&folder.houdini_note(), note.as_bytes())?;
    if settings.formats.contains(&Format::Usd) {
        cache::write(&folder.usd_scene(), usd::scene(&take).as_bytes())?;
        cache::write(&folder.usd_manifest(), usd::manifest(&take).as_bytes())?;
    }
    Ok(())
}
