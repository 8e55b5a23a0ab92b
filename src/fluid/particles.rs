//! The state of the cement: what a step reads and leaves for the next.

use super::PerPhase;
use crate::math::{Real, Sym3, Vec3};

/// One row per particle; all vectors equally long, but for a conformation that nobody needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidParticles {
    /// x_i [m].
    pub position: Vec<Vec3>,
    /// v_{i,k} [m/s].
    pub phase_velocity: Vec<PerPhase<Vec3>>,
    /// α of the polymer phase, in [0, 1]; the liquid is the rest, so that Σ α = 1 holds by itself (Eq. 3).
    pub polymer_fraction: Vec<Real>,
    /// U_i [1]; symmetric positive definite, I when relaxed. Empty as long as all are relaxed.
    pub conformation: Vec<Sym3>,
    /// Warm starts [Pa]: of the constant-volume and of the divergence solve.
    pub pressure: Vec<[Real; 2]>,
    /// What the last coupled step changed v_mix by [m/s]; 0 after an explicit one.
    pub change: Vec<Vec3>,
    /// Identity, given in the order of appearance.
    pub id: Vec<u32>,
    /// Where it came from: 0 a body at the start, n the n-th inlet.
    pub origin: Vec<u16>,
}

impl FluidParticles {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// What one of the solves found last [Pa]: 0 that of constant volume, 1 that of the divergence.
    pub fn multiplier(&self, solve: usize) -> Vec<Real> {
        self.pressure.iter().map(|k| k[solve]).collect()
    }

    /// Adds a relaxed particle.
    pub fn push(
        &mut self,
        position: Vec3,
        velocity: Vec3,
        polymer_fraction: Real,
        id: u32,
        origin: u16,
    ) {
        self.position.push(position);
        self.phase_velocity.push(PerPhase {
            liquid: velocity,
            polymer: velocity,
        });
        self.polymer_fraction.push(polymer_fraction);
        if !self.conformation.is_empty() {
            self.conformation.push(Sym3::IDENTITY);
        }
        self.pressure.push([0.0; 2]);
        self.change.push(Vec3::zeros());
        self.id.push(id);
        self.origin.push(origin);
    }

    /// U_i [1].
    pub fn conformation(&self, i: usize) -> Sym3 {
        *self.conformation.get(i).unwrap_or(&Sym3::IDENTITY)
    }

    /// Gives every particle a conformation of its own, relaxed where none was held.
    pub fn hold_conformation(&mut self) {
        self.conformation.resize(self.len(), Sym3::IDENTITY);
    }

    /// Becomes a copy of `other` in its own memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.position.clone_from(&other.position);
        self.phase_velocity.clone_from(&other.phase_velocity);
        self.polymer_fraction.clone_from(&other.polymer_fraction);
        self.conformation.clone_from(&other.conformation);
        self.pressure.clone_from(&other.pressure);
        self.change.clone_from(&other.change);
        self.id.clone_from(&other.id);
        self.origin.clone_from(&other.origin);
    }

    /// Keeps the particles for which `keep` holds, in order.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        fn only<T: Copy>(values: &mut Vec<T>, keep: &impl Fn(usize) -> bool) {
            let mut i = 0;
            values.retain(|_| {
                i += 1;
                keep(i - 1)
            });
        }
        only(&mut self.position, &keep);
        only(&mut self.phase_velocity, &keep);
        only(&mut self.polymer_fraction, &keep);
        only(&mut self.conformation, &keep);
        only(&mut self.pressure, &keep);
        only(&mut self.change, &keep);
        only(&mut self.id, &keep);
        only(&mut self.origin, &keep);
    }
}
