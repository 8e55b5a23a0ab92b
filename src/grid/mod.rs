//! Sparse fields on a lattice, in bricks of 8³ nodes.

mod brick;
mod points;

pub use brick::{BRICK, BrickGrid};
pub use points::{NearPoints, PointBricks, kernel, kernel_slope};
