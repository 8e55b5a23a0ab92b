//! OpenVDB files in: the float grids of format versions 222 to 224, with any codec that OpenVDB writes [Museth13].
//!
//! A tree has a root, nodes of 32³ and of 16³ children, and leaves of 8³ voxels. A grid's topology comes first, then
//! the values of all leaves in the same order. Nothing in a file is believed: every length is held against what is
//! left of the file, and what a grid unpacks to is bounded.
//!
//! Does not: read grids of other trees than `float` and `double` 5-4-3 (they are passed over and named), or the
//! codecs that Blosc has beside LZ4 and zlib, which OpenVDB does not write.

mod codec;
mod read;
mod transform;

pub use read::{MAX_BRICKS, parse_vdb, read_vdb};
pub use transform::Affine;

use super::BrickGrid;
use crate::math::{Real, Vec3};

/// A file's grids.
#[derive(Clone, Debug, Default)]
pub struct VdbFile {
    /// Those that could be read.
    pub grids: Vec<VdbGrid>,
    /// Names and types of those that were passed over.
    pub passed_over: Vec<(String, String)>,
}

/// A scalar volume.
#[derive(Clone, Debug)]
pub struct VdbGrid {
    /// Its name.
    pub name: String,
    /// `fog volume`, `level set`, or what else the file calls it.
    pub class: String,
    /// How it was packed.
    pub packing: String,
    /// From voxel indices to the file's own space.
    pub to_world: Affine,
    /// Values by voxel index: origin 0, edge 1.
    pub values: BrickGrid,
    /// Active voxels.
    pub active: u64,
    /// Lowest and highest index of an active voxel.
    pub bounds: ([i32; 3], [i32; 3]),
    /// Least, mean and greatest value of active voxels.
    pub range: [Real; 3],
}

impl VdbGrid {
    /// The value at a point of the file's own space, trilinear between voxels.
    pub fn value(&self, x: &Vec3) -> Real {
        self.values.value(&self.to_world.back(x))
    }

    /// Edges of a voxel in the file's own space.
    pub fn voxel_size(&self) -> Vec3 {
        self.to_world.edges()
    }

    /// The box around the active voxels in the file's own space.
    pub fn world_bounds(&self) -> crate::math::Aabb {
        let (low, high) = self.bounds;
        let corner = |c: usize| {
            let at: [Real; 3] = std::array::from_fn(|axis| {
                if c >> axis & 1 == 0 {
                    Real::from(low[axis]) - 0.5
                } else {
                    Real::from(high[axis]) + 0.5
                }
            });
            self.to_world.there(&Vec3::from(at))
        };
        crate::math::Aabb::around(&(0..8).map(corner).collect::<Vec<_>>())
    }
}

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum VdbError {
    /// It could not be read.
    #[error("{file}: {source}")]
    Read {
        /// Path as given.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// It makes no sense, or is more than can be read.
    #[error("{file}: {problem} (at byte {at})")]
    Damaged {
        /// Path as given.
        file: String,
        /// What is wrong.
        problem: String,
        /// Where.
        at: usize,
    },
    /// It holds no grid that can be read.
    #[error("{file}: no grid of floats found ({found}): expected a density or porosity volume")]
    Nothing {
        /// Path as given.
        file: String,
        /// What it does hold.
        found: String,
    },
}

#[cfg(test)]
mod tests;
