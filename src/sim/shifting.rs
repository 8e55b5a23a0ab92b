//! Particle shifting: strain draws a packing out into strings and gaps; shifting evens it as fast as strain spoils it.
//!
//! δx = −A Δx² ‖D‖ dt ∇C with C = Σ_j V W over fluid and walls [Lind12], in strain rate D instead of speed, so that a
//! body which rests or turns rigidly is left alone and a steady flow does not know dt. What a particle carries becomes
//! that of its new place to first order, v + L δx. Elsewhere pressure, which cannot pull, evens the packing, and at the
//! surface ∇C points out of the fluid.
//!
//! But where polymer pulls harder than pressure presses, particles in rows clump as fast as an elastic wave crosses a
//! spacing: shifting then goes at that pace, but for those at the surface. Without it a viscoelastic drop tore along the
//! planes of its lattice on impact, at any step; at the pace of 1 to 3 such waves, and with the stress of
//! `stress::above_least`, it stays whole; with either alone it does not. Where viscosity damps such waves it does not go at
//! their pace: shifting does not keep ψ, and a creeping drop sank by it, 18 % off between steps of 2 and 20 ms (now 0.7 %).

use super::settings::ElasticWaves;
use super::stepper::Stepper;
use crate::fluid::stress::stabiliser_viscosity;
use crate::math::{Real, Vec3, ordered_sum};
use rayon::prelude::*;

/// A.
const STRENGTH: Real = 4.0;
/// Pace where fluid is pulled, in elastic waves that cross a spacing.
const PULLED: Real = 2.0;
/// ν/w from which a wave counts as damped. It is 2 to 7 in a drop of 4 Pa·s that falls, which needs all of the shift, and
/// 250 in one of 100 Pa·s that creeps, which shifting at the pace of waves would stir and fling apart: 200 times as fast as
/// it creeps.
const DAMPED: Real = 32.0;
/// Largest shift in a step, in spacings.
const MOST: Real = 0.1;

impl Stepper<'_> {
    /// Shift of each particle [m], none where pressure does it; velocities become those of the new places.
    pub(super) fn shift(&mut self) -> Vec<Vec3> {
        let pulled = self.may_be_pulled();
        if !self.closed && !pulled {
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
                let share = if pulled {
                    (PULLED * self.snapping(i) * self.dt).min(1.0)
                } else {
                    let strain = 0.5 * (gradient[i] + gradient[i].transpose()).norm();
                    STRENGTH * (strain * self.dt).min(1.0)
                };
                let shift = near.crowding(i) * (-share * dx * dx);
                shift * (MOST * dx / shift.norm().max(MOST * dx))
            })
            .collect();
        let open = near.wall.entries() == 0;
        let mut change: Vec<Vec3> = (0..n)
            .into_par_iter()
            .with_min_len(128)
            .map(|i| self.within_neighbours(i, gradient[i] * shift[i]))
            .collect();
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

    /// A change of velocity [m/s], no more than takes particle i to the neighbour that is farthest ahead that way [Barth89].
    ///
    /// In a linear field that is no bound. But L is steep where a particle lies in a wall, and one that is pressed in and
    /// shifted out again would gain speed each time, without end: in a stirred tank a third in a step.
    fn within_neighbours(&self, i: usize, change: Vec3) -> Vec3 {
        let square = change.norm_squared();
        if square == 0.0 {
            return change;
        }
        let own = self.mix.velocity[i];
        let fluid = self.near.fluid.row(i).iter();
        let fluid = fluid.map(|link| self.mix.velocity[link.j as usize]);
        let walls = self.near.wall.row(i).iter();
        let walls = walls.map(|pair| self.near.surface_velocity(i, pair));
        let ahead = |v: Vec3| (v - own).dot(&change);
        let most = fluid.chain(walls).map(ahead).fold(0.0, Real::max);
        change * (most / square).min(1.0)
    }

    /// Elastic waves that cross a spacing in a second where the polymer pulls, w = √(σ/ρ)/Δx with σ = G (λ_max − λ_min) − p
    /// [1/s], and few where the friction ν = η/(ρ Δx²) of what resists at once damps them well before ([`DAMPED`]); 0 where
    /// nothing pulls, and at the surface.
    fn snapping(&self, i: usize) -> Real {
        let cement = &self.settings.cement;
        let dx = self.settings.spacing;
        let [least, _, most] = self.fluid.conformation(i).eigenvalues();
        let modulus = cement.modulus(self.fluid.polymer_fraction[i]);
        let tension = modulus * (most - least) - self.fluid.pressure[i][0];
        if tension <= 0.0 || self.near.one_sided(i) {
            return 0.0;
        }
        let density = self.mix.density[i];
        let resolved = self.settings.elastic_waves == ElasticWaves::Resolved;
        let viscosity = cement.liquid.viscosity
            + stabiliser_viscosity(cement, modulus, density, most, dx, resolved);
        let wave = (tension / density).sqrt() / dx;
        let damping = viscosity / (density * dx * dx * DAMPED * wave);
        wave / (1.0 + damping.powi(4))
    }
}
