//! Smoothed particle hydrodynamics that knows no phases: kernel, neighbour rows, walls, operators, solvers.

use crate::math::{Real, Vec3};

/// Wall particles: points that stand for the solid near the fluid.
#[derive(Clone, Debug, Default)]
pub struct WallParticles {
    /// Centre of the solid part of its voxel [m].
    pub position: Vec<Vec3>,
    /// Volume of that part [m³].
    pub volume: Vec<Real>,
}
