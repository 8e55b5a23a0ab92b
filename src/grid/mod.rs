//! Sparse fields on a lattice, in bricks of 8³ nodes.

mod brick;
mod connected;

pub use brick::{BRICK, BrickGrid};
pub use connected::{BrickMask, connected_share};
