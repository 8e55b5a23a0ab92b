//! Particle shifting: strain draws a packing out into strings and gaps; shifting evens it as fast as strain spoils it.
//!
//! δx = −A Δx² ‖D‖ dt ∇C with C = Σ_j V W over fluid and walls [Lind12], in strain rate D instead of speed, so that a
//! body which rests or turns rigidly is left alone and a steady flow does not know dt. What a particle carries becomes
//! that of its new place to first order, v + L δx. Only in closed bodies: elsewhere pressure, which cannot pull, evens
//! the packing, and ∇C points out of the fluid.

use super::stepper::Stepper;
use crate::math::{Real, Vec3, ordered_sum};
use rayon::prelude::*;

/// A.
const STRENGTH: Real = 4.0;
/// Largest shift in a step, in spacings.
const MOST: Real = 0.1;

impl Stepper<'_> {
    /// Shift of each particle [m], none where the body is not closed; velocities become those of the new places.
    pub(super) fn shift(&mut self) -> Vec<Vec3> {
        if !self.closed {
            return vec![Vec3::zeros(); self.fluid.len()];
        }
        self.refresh_gradient();
        let near = &*self.near;
        let gradient = &self.gradient;
        let n = self.fluid.len();
        let dx = self.settings.spacing;
        let shift: Vec<Vec3> = (0..n)
            .into_par_iter()
            .with_min_len(128)
            .map(|i| {
                let strain = 0.5 * (gradient[i] + gradient[i].transpose()).norm();
                let shift = near.crowding(i) * (-STRENGTH * dx * dx * (strain * self.dt).min(1.0));
                shift * (MOST * dx / shift.norm().max(MOST * dx))
            })
            .collect();
        let open = near.wall.entries() == 0;
        let mut change: Vec<Vec3> = (0..n).map(|i| gradient[i] * shift[i]).collect();
        if open && n > 0 {
            let cement = &self.settings.cement;
            let density = |i: usize| cement.density(self.fluid.polymer_fraction[i]);
            let all: Real = ordered_sum(n, density);
            let mean = Vec3::from_fn(|a, _| ordered_sum(n, |i| density(i) * change[i][a]) / all);
            for c in &mut change {
                *c -= mean;
            }
        }
        for (v, change) in self.fluid.phase_velocity.iter_mut().zip(&change) {
            v.liquid += change;
            v.polymer += change;
        }
        shift
    }
}
