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
                cells.near(x, |other, _, squared| {
                    sum += particles.volume[other] * kernel.w(squared.sqrt());
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

/// Wall particles that move: rigid walls, and the pistons of inlets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingWalls {
    /// Positions [m].
    pub position: Vec<Vec3>,
    /// Volume of each [m³].
    pub volume: Vec<Real>,
    /// Velocities [m/s].
    pub velocity: Vec<Vec3>,
    /// The inlet whose piston each is part of, if it is one.
    pub inlet: Vec<Option<u16>>,
    /// ω of the body that each belongs to [rad/s].
    pub spin: Vec<Vec3>,
    /// How deep inside its solid each lies [m]; none: part of a piston, which carries its velocity to the fluid as
    /// it is.
    pub depth: Vec<Option<Real>>,
    /// Σ_b V_b W over the walls that move with it [1].
    pub own_sum: Vec<Real>,
}

impl MovingWalls {
    /// Adds a particle of a piston.
    pub fn push_piston(&mut self, inlet: u16, position: Vec3, velocity: Vec3, volume: Real) {
        self.position.push(position);
        self.volume.push(volume);
        self.velocity.push(velocity);
        self.spin.push(Vec3::zeros());
        self.depth.push(None);
        self.own_sum.push(0.0);
        self.inlet.push(Some(inlet));
    }
}
