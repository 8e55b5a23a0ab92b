//! Sparse fields on a lattice, in bricks of 8³ nodes.

mod brick;

pub use brick::{BRICK, BrickGrid};
