//! A scene: what a recipe means, in SI, complete and checked.

use super::Finding;
use super::place::BoneFrame;
use super::recipe::Axis;
use super::show::BoneLook;
use crate::math::{Aabb, Real, Vec3};
use crate::sim::SimSettings;
use crate::solid::Shape;
use serde::Serialize;
use std::path::PathBuf;

/// Everything that the stages need to know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// What reports call it.
    pub name: String,
    /// What the solver needs.
    pub sim: SimSettings,
    /// How many particles there will be at most: bodies plus doses, walls not counted.
    pub particles: u64,
    /// Walls with a closed formula, cannulas among them.
    pub shapes: Vec<Shape>,
    /// Walls given as meshes.
    pub meshes: Vec<MeshFile>,
    /// The bone.
    pub bone: Option<Bone>,
    /// How the cement's surface is drawn.
    pub surface: Surface,
    /// How volumes are written.
    pub export: Export,
    /// Pictures.
    pub preview: Preview,
    /// What is allowed but unlikely to be meant.
    #[serde(skip)]
    pub warnings: Vec<Finding>,
}

/// A mesh on disk and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshFile {
    /// OBJ file. Not part of what a scene means: results depend on what is in the file, not on where it lies.
    #[serde(skip)]
    pub path: PathBuf,
    /// What a 1 in the file is [m].
    pub unit: Real,
    /// Which axis of the file points up.
    pub up: Axis,
}

/// A bone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bone {
    /// Its outer surface.
    pub file: MeshFile,
    /// Where origin and axes lie in it.
    pub frame: BoneFrame,
    /// Thickness of the cortical shell [m].
    pub cortex: Real,
    /// Trabecular regions; the first that holds a point counts there.
    pub regions: Vec<Region>,
    /// Where bone is cleared away for cannulas.
    pub channels: Vec<Channel>,
}

/// Trabecular bone somewhere inside.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// What the report calls it.
    pub name: String,
    /// Where.
    pub place: Place,
    /// Distance from strut to strut [m].
    pub strut_period: Real,
    /// How thick the struts are.
    pub fill: Fill,
}

/// A part of a bone, in the recipe's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Place {
    /// Wherever no region before it is.
    Elsewhere,
    /// A box [m].
    Box(Aabb),
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// Centre [m].
        centre: Vec3,
        /// Half axes [m].
        radii: Vec3,
    },
}

/// How thick struts are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Fill {
    /// This thick [m].
    StrutDiameter(Real),
    /// So that this fraction stays open [1].
    Porosity(Real),
}

/// A drilled hole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// Centre of its first end [m].
    pub base: Vec3,
    /// Unit vector along it.
    pub axis: Vec3,
    /// Length [m].
    pub length: Real,
    /// Radius [m].
    pub radius: Real,
}

/// How the cement's surface is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// Edge of a marching cube [m].
    pub cube: Real,
    /// Smoothing passes over the finished mesh.
    pub smoothing: u32,
    /// Value of the colour field at the surface [1].
    pub threshold: Real,
}

/// How volumes are written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Export {
    /// Edge of a voxel [m].
    pub voxel: Real,
    /// Axis that points up in the files.
    pub up: Axis,
    /// Name of the velocity grid.
    pub velocity_grid: String,
}

/// Pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preview {
    /// Width [pixels].
    pub width: u32,
    /// Height [pixels].
    pub height: u32,
    /// Samples along each edge of a pixel.
    pub samples: u32,
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
    /// What lies on the side of its normal is left out.
    pub cut: Option<Plane>,
    /// How the bone is shown.
    pub bone: BoneLook,
}

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plane {
    /// A point on it [m].
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}
