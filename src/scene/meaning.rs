//! A scene: what a recipe means, in SI, complete and checked.

use super::Finding;
use super::bone::{BoneFrame, VolumeMeaning};
use super::show::{BoneLook, Shows};
use crate::bone::{BoneSettings, Channel};
use crate::export::ExportSettings;
use crate::math::{Real, Vec3};
use crate::mesh::{LengthUnit, UpAxis};
use crate::preview::PictureSettings;
use crate::sim::{Motion, Probe, SimSettings};
use crate::solid::Shape;
use crate::surface::SurfaceSettings;
use serde::Serialize;
use std::path::PathBuf;

/// Everything that the stages need to know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// What reports call it.
    pub name: String,
    /// What the solver needs.
    pub sim: SimSettings,
    /// How many particles there will be at most: bodies plus doses, walls and what fills meshes not
    /// counted.
    pub particles: u64,
    /// Walls with a closed formula, cannulas among them.
    pub shapes: Vec<Shape>,
    /// Cannulas as they are to look at: as thick as they are, where the walls that hold the cement may be thicker.
    pub tubes: Vec<Shape>,
    /// Walls given as meshes.
    pub meshes: Vec<MeshFile>,
    /// Meshes that bodies of fluid fill, in the order of these bodies.
    pub fillings: Vec<MeshFile>,
    /// Walls that move.
    pub movers: Vec<MovingWall>,
    /// Gauges.
    pub probes: Vec<Probe>,
    /// The bone.
    pub bone: Option<Bone>,
    /// How the cement's surface is drawn.
    pub surface: SurfaceSettings,
    /// How volumes are written.
    pub export: ExportSettings,
    /// Pictures.
    pub preview: Preview,
    /// What is allowed but unlikely to be meant.
    #[serde(skip)]
    pub warnings: Vec<Finding>,
}

impl Scene {
    /// Number of the last frame; 0 is the start.
    pub fn last_frame(&self) -> u32 {
        // A hair of tolerance: 0.3 s at 10 frames a second are 3, whatever the product rounds to.
        (self.sim.duration * self.sim.frames_per_second + 1e-9) as u32
    }
}

/// A mesh on disk and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshFile {
    /// OBJ file. Not part of what a scene means: results depend on what is in the file, not on where it lies.
    #[serde(skip)]
    pub path: PathBuf,
    /// What a 1 in the file is.
    pub unit: LengthUnit,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Where its origin is put [m].
    pub at: Vec3,
}

/// A wall that moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovingWall {
    /// What it is at the start.
    pub region: Region,
    /// How it moves.
    pub motion: Motion,
}

/// Something solid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Region {
    /// With a closed formula.
    Shape(Shape),
    /// The inside of a mesh.
    Mesh(MeshFile),
}

/// A bone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bone {
    /// Its outer surface.
    pub file: MeshFile,
    /// Where origin and axes lie in it.
    pub frame: BoneFrame,
    /// Shell and trabeculae.
    pub settings: BoneSettings,
    /// Where cannulas go through it.
    pub channels: Vec<Channel>,
    /// OBJ groups and materials that regions name, in the numbers that their places have.
    pub parts: Vec<String>,
    /// The volume that regions take their porosity from.
    pub volume: Option<VolumeFile>,
}

/// A volume on disk and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeFile {
    /// OpenVDB file.
    #[serde(skip)]
    pub path: PathBuf,
    /// Which of its grids; the first if not given.
    pub grid: Option<String>,
    /// What a 1 in it is.
    pub holds: VolumeMeaning,
    /// What a 1 in its coordinates is.
    pub unit: LengthUnit,
    /// Which axis of the file points up.
    pub up: UpAxis,
}

/// Pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preview {
    /// Size and finish.
    pub picture: PictureSettings,
    /// One sequence of pictures each.
    pub views: Vec<View>,
}

/// One camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct View {
    /// Its pictures are `preview/<name>.0001.png`.
    pub name: String,
    /// From −y towards +x, seen from above [rad].
    pub azimuth: Real,
    /// Above the horizon [rad].
    pub elevation: Real,
    /// 1 fits the scene into the picture.
    pub zoom: Real,
    /// What is in the centre [m]; the middle of the scene if not given.
    pub target: Option<Vec3>,
    /// Bone on the side of its normal is taken away or turned to glass.
    pub cut: Option<Plane>,
    /// Whether the plane cuts the cement as well.
    pub cut_cement: bool,
    /// How the bone is shown.
    pub bone: BoneLook,
    /// What the colours of the cement show.
    pub colour: Shows,
    /// Pictures of a turntable; 0: none.
    pub turntable: u32,
}

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plane {
    /// A point on it [m].
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}
