//! Volumes for artists: grids of the cement, and OpenVDB files. Everything here is Y-up, in metres.

pub mod grids;
pub mod vdb;

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
}

impl Default for ExportSettings {
    fn default() -> Self {
        Self {
            voxel: 1.0,
            smoothing: 2.0,
            active_above: 0.01,
            velocity_name: "velocity".into(),
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
        if ["", "density", "polymer"].contains(&self.velocity_name.as_str()) {
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
    /// Values, z running fastest; those of inactive voxels are not written.
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

/// A sparse volume: 0 wherever no voxel is active.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What clients call it; unique in a file.
    pub name: String,
    /// Position of voxel (0, 0, 0) [m].
    pub origin: Vec3,
    /// Distance between voxels [m].
    pub voxel: Real,
    /// Its active voxels lie in these; no two at the same place.
    pub leaves: Leaves,
}
