//! Volumes for artists: grids of the cement, and OpenVDB files. Everything here is Y-up, in metres.

mod codec;
pub mod grids;
pub mod level_set;
mod motion;
pub mod ply;
pub mod usd;
pub mod vdb;
pub mod vtp;

pub use codec::Codec;
pub use motion::mean_velocity;
pub use ply::Column;

use crate::math::{Real, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which volumes are made of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExportSettings {
    /// Distance between voxels [spacings].
    pub voxel: Real,
    /// Support radius of the kernel that spreads particles over voxels [spacings].
    pub smoothing: Real,
    /// Voxels of larger density are active [1].
    pub active_above: Real,
    /// Name of the velocity grid: Blender looks for `velocity`, Houdini for `vel`.
    pub velocity_name: String,
    /// How values are packed: "blosc", "zip" or "none".
    pub codec: Codec,
    /// Whether values are stored as halves: three digits in half the space.
    pub half: bool,
    /// What is written beside the volumes.
    pub formats: Vec<Format>,
}

/// What else is written of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// The surface with all attributes: `ply/`, for Blender.
    Ply,
    /// The particles: `vtp/`, for ParaView.
    Vtp,
    /// The take as one scene: `scene.usda` and `usd/`, for Blender, Houdini and others.
    Usd,
}

impl Default for ExportSettings {
    fn default() -> Self {
        Self {
            voxel: 1.0,
            smoothing: 2.0,
            active_above: 0.01,
            velocity_name: "velocity".into(),
            codec: Codec::default(),
            half: false,
            formats: vec![Format::Ply, Format::Vtp, Format::Usd],
        }
    }
}

impl ExportSettings {
    /// What is out of range, if anything: outside it, memory explodes or voxels miss the particles.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, range) in [
            ("voxel", self.voxel, 0.2..=2.0),
            ("smoothing", self.smoothing, 1.0..=4.0),
            ("active_above", self.active_above, 0.0..=0.5),
        ] {
            if !range.contains(&value) {
                let (low, high) = range.into_inner();
                return Err(format!(
                    "{key}: expected a number from {low} to {high}, found {value}"
                ));
            }
        }
        if ["", "density", "polymer", "surface"].contains(&self.velocity_name.as_str()) {
            return Err(format!(
                "velocity_name: expected a name such as \"velocity\" that no other grid has, found \"{}\"",
                self.velocity_name
            ));
        }
        Ok(())
    }
}

/// 8³ voxels, as in a leaf of OpenVDB.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf<T> {
    /// The first voxel; multiples of 8.
    pub first: [i32; 3],
    /// Voxel i is active if bit i & 63 of word i >> 6 is set.
    pub active: [u64; 8],
    /// Values, z running fastest. Of inactive voxels of a level set only the sign matters, of others nothing.
    pub values: Box<[T; 512]>,
}

/// What a grid holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Leaves {
    /// Numbers.
    Float(Vec<Leaf<f32>>),
    /// Vectors that turn with the grid, such as velocities.
    Vec3(Vec<Leaf<[f32; 3]>>),
}

/// What the values of a grid mean to clients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Class {
    /// 0 wherever no voxel is active.
    Fog,
    /// A signed distance [m], negative inside; ±`background` wherever no voxel is active.
    LevelSet {
        /// Half the width of the active band [m].
        background: f32,
    },
}

/// A sparse volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What clients call it; unique in a file.
    pub name: String,
    /// What its values mean.
    pub class: Class,
    /// Position of voxel (0, 0, 0) [m].
    pub origin: Vec3,
    /// Distance between voxels [m].
    pub voxel: Real,
    /// Its active voxels lie in these; no two at the same place.
    pub leaves: Leaves,
}

/// World (z up) to file (y up).
fn y_up([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, -y]
}

/// A script that opens the take in Blender; `velocity` is the name of the velocity grid.
pub fn blender_script(take: &usd::Take, velocity: &str) -> String {
    let said = serde_json::json!({
        "frames": take.frames,
        "frames_per_second": take.frames_per_second,
        "numbers": take.numbers,
        "velocity": velocity,
    });
    include_str!("blender_import.py").replace("@TAKE@", &said.to_string().replace('\\', "\\\\"))
}

/// How to open the take in Houdini.
pub fn houdini_note(take: &usd::Take, velocity: &str) -> String {
    let number = |n: Option<&u32>| n.copied().unwrap_or(0).to_string();
    include_str!("houdini.txt")
        .replace("@FPS@", &take.frames_per_second.to_string())
        .replace("@VELOCITY@", velocity)
        .replace("@FIRST@", &number(take.frames.first()))
        .replace("@LAST@", &number(take.frames.last()))
}
