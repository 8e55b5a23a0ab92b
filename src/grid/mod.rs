//! Sparse fields on a lattice, in bricks of 8³ nodes.

mod brick;
mod connected;
mod fit;
mod grow;
mod near;
mod patch;
mod points;
pub mod vdb;

pub use brick::{BRICK, BrickGrid};
pub use connected::{BrickMask, BrickNeighbours, count};
pub use near::{NearPoints, PlaceSums, kernel, kernel_slope};
pub use patch::{Between, Patch};
pub use points::{PointBricks, crowding};
