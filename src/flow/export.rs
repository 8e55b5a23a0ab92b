//! Frames → `vdb/`, `ply/`, `vtp/`, and the scene that ties them together.

use super::kept::{self, Kept};
use super::{FlowError, Job, Observer, Stage, each_frame};
use crate::cache::{self, Frame};
use crate::export::{
    self, Column, Format, Grid, Leaves, grids, level_set, mean_velocity, ply,
    usd::{self, Take},
    vdb, vtp,
};
use crate::grid::BrickGrid;
use crate::math::{Real, Vec3};
use crate::preview::colour;
use crate::solid::Solid;
use crate::surface::{Surface, reconstruct_moving};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

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
    let all = job.folder.frames(None)?;
    let ids = ids(job, &all)?;
    let mut kept = Kept::read(job.folder.exported());
    let mut chosen = job.folder.frames(job.frames)?;
    if job.frames.is_none() {
        kept.retain(&job.folder, Stage::Export.owns(), &ids)?;
        chosen.retain(|&n| !kept.has(n));
    } else {
        chosen.iter().try_for_each(|&n| kept.forget(n))?;
    }
    each_frame(job, &chosen, |frame| {
        let n = frame.index;
        let next = (ids.contains_key(&(n + 1)))
            .then(|| cache::read_frame(&job.folder.frame(n + 1)))
            .transpose()?;
        volumes_and_meshes(job, frame, next.as_ref(), &solid)
    })?;
    kept.add(&job.folder, &ids, &chosen, |n| files(job, n))?;
    scripts(job)
}

/// What each frame's files depend on, as a number: itself, the next one, the walls, the settings.
fn ids(job: &Job, frames: &[u32]) -> Result<BTreeMap<u32, u32>, FlowError> {
    let sim = &job.scene.sim;
    let settings = Stage::Export.settings(&job.scene);
    let version = env!("CARGO_PKG_VERSION");
    let said = format!("{version} {settings} {:?} {:?}", sim.periodic, sim.domain);
    let id = |&n: &u32| {
        let mut read = vec![job.folder.solid(), job.folder.frame(n)];
        if frames.binary_search(&(n + 1)).is_ok() {
            read.push(job.folder.frame(n + 1));
        }
        Ok((n, kept::id(&said, &read)?))
    };
    frames.iter().map(id).collect()
}

/// Where the files of a frame are, if they are made.
fn files(job: &Job, n: u32) -> [PathBuf; 4] {
    let folder = &job.folder;
    [
        folder.vdb(n),
        folder.ply(n),
        folder.vtp(n),
        folder.usd_layer(n),
    ]
}

fn volumes_and_meshes(
    job: &Job,
    frame: &Frame,
    next: Option<&Frame>,
    solid: &Solid,
) -> Result<(), FlowError> {
    let settings = &job.scene.export;
    let sim = &job.scene.sim;
    let size = sim.domain.max - sim.domain.min;
    let period = [0, 1, 2].map(|axis| sim.periodic[axis].then_some(size[axis]));
    let velocity = mean_velocity(frame, next, period);
    let surface = reconstruct_moving(frame, &velocity, Some(solid), &job.scene.surface);
    let moving = Frame {
        velocity,
        ..frame.clone()
    };
    let mut volumes = grids::from_frame(&moving, settings);
    volumes.push(level_set(job, &surface, &volumes[0], solid));
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
