//! What is solid: signed distance of shapes and grids, and wall particles from it.
//!
//! The distance φ [m] is positive in the open, negative inside the solid.

use crate::grid::BrickGrid;
use crate::math::{Real, Vec3};

pub mod fan;
mod mesh_grid;
mod shape;
pub mod syringe;
mod walls;

pub use mesh_grid::mesh_grid;
pub use shape::Shape;
pub use walls::wall_particles;

/// The union of everything solid.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    /// Solids with a closed formula.
    pub shapes: Vec<Shape>,
    /// Solids sampled on a grid (bones, meshes): φ at its nodes [m].
    pub grids: Vec<BrickGrid>,
}

impl Solid {
    /// φ at `x` [m], and its unit gradient, which points into the open (zero where φ has none).
    pub fn distance(&self, x: &Vec3) -> (Real, Vec3) {
        let mut nearest = (Real::INFINITY, Vec3::zeros());
        for shape in &self.shapes {
            let candidate = shape.distance(x);
            if candidate.0 < nearest.0 {
                nearest = candidate;
            }
        }
        for grid in &self.grids {
            let (phi, gradient) = grid.sample(x);
            if phi < nearest.0 {
                nearest = (phi, gradient.try_normalize(1e-6).unwrap_or_default());
            }
        }
        nearest
    }

    /// φ at `x` [m] alone.
    pub fn phi(&self, x: &Vec3) -> Real {
        let shapes = self.shapes.iter().map(|shape| shape.distance(x).0);
        let grids = self.grids.iter().map(|grid| grid.value(x));
        shapes.chain(grids).fold(Real::INFINITY, Real::min)
    }
}
