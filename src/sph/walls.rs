//! Walls: the particles that stand for the solid, which of them the fluid feels, and how they move.

use super::{Cells, Domain, Kernel};
use crate::math::{Real, Vec3};
use rayon::prelude::*;

/// Wall particles: points that stand for the solid near the fluid.
#[derive(Clone, Debug, Default)]
pub struct WallParticles {
    /// Centre of the solid part of its voxel [m].
    pub position: Vec<Vec3>,
    /// Volume of that part [m³].
    pub volume: Vec<Real>,
}

/// Walls at rest, sorted once, with all that does not change from step to step.
#[derive(Clone, Debug)]
pub struct Walls {
    /// The particles.
    pub particles: WallParticles,
    /// How deep inside the solid each lies: −φ [m].
    pub depth: Vec<Real>,
    /// Σ_b V_b W over the other walls [1].
    pub own_sum: Vec<Real>,
    pub(super) cells: Cells,
}

impl Walls {
    /// Sorts the particles; `depth(x)` is the depth of a point below the solid's true surface [m].
    pub fn new(
        particles: WallParticles,
        kernel: &Kernel,
        domain: &Domain,
        depth: impl Fn(&Vec3) -> Real + Sync + Send,
    ) -> Self {
        let cells = Cells::new(&particles.position, kernel.support_radius, domain);
        let own_sum = (0..particles.position.len())
            .into_par_iter()
            .map(|b| {
                let x = &particles.position[b];
                let mut sum = 0.0;
                cells.near(x, |other| {
                    let r = domain.shortest(x - particles.position[other]).norm();
                    sum += particles.volume[other] * kernel.w(r);
                });
                sum
            })
            .collect();
        let depth = particles.position.par_iter().map(depth).collect();
        Self {
            particles,
            depth,
            own_sum,
            cells,
        }
    }
}

/// Wall particles that move with a prescribed velocity and carry it to the fluid as it is: an inlet's piston.
#[derive(Clone, Debug, Default)]
pub struct Pistons {
    /// Positions [m].
    pub position: Vec<Vec3>,
    /// Velocities [m/s].
    pub velocity: Vec<Vec3>,
    /// Which inlet each belongs to.
    pub inlet: Vec<u16>,
    /// Volume of each [m³].
    pub volume: Real,
}
