//! Phase transfer: drift and diffusion move volume between particles, and its momentum with it.
//!
//! ```text
//! v_k^drift = v_k − v_mix                                                         [IMM-CT] (Eq. 8)
//! Dα_k/Dt = −Σ_j V_j (α_i v_i^drift + α_j v_j^drift)·∇W_ij + Σ_j V_j 2 C_f (α_i − α_j) x_ij·∇W_ij/r²   (Eq. 9)
//! ```
//!
//! Each pair exchanges polymer one way and as much liquid the other way, so both volumes are kept to rounding. One
//! limiter per pair [Zalesak79] keeps fractions in [0, 1] without clamping; what flows takes the momentum of the
//! phase it comes from.

use super::mixture::{ALPHA_EPSILON, mixture_velocity, momentum_density};
use super::{Cement, FluidParticles, PerPhase};
use crate::math::{Real, Vec3};
use crate::sph::{Neighbourhood, Pair, Rows, vector};
use rayon::prelude::*;

const GRAIN: usize = 128;

/// Moves volume and momentum between the phases of neighbours for `dt` [s].
///
/// Diffusion is explicit: the caller keeps dt below its limit (see `most_diffusion_step`).
pub fn advance(cement: &Cement, fluid: &mut FluidParticles, near: &Neighbourhood, dt: Real) {
    let n = fluid.len();
    // α v_drift of the polymer; that of the liquid is its negative, since Σ α_k v_k^drift = 0.
    let flux: Vec<Vec3> = (0..n)
        .map(|i| {
            let alpha = fluid.polymer_fraction[i];
            (fluid.phase_velocity[i].polymer - mixture_velocity(&fluid.phase_velocity[i], alpha))
                * alpha
        })
        .collect();
    let alpha = &fluid.polymer_fraction;
    // Fraction of polymer that j gives to i in this step; antisymmetric in i and j. Diffusion is that of the compact
    // Laplacian (`operators::laplacian_weight`).
    let gain = |i: usize, pair: &Pair| -> Real {
        let j = pair.j as usize;
        let drift = (flux[i] + flux[j]).dot(&vector(pair.gradient));
        let diffusion = cement.diffusion * 2.0 * Real::from(pair.steepness) * (alpha[j] - alpha[i]);
        2.0 * dt / (near.trace[i] + near.trace[j]) * (diffusion - drift)
    };
    // In single precision it stays antisymmetric.
    let mut gains: Rows<f32> = Rows::default();
    gains.rebuild(n, |i, row| {
        row.extend(near.pairs(i).map(|pair| gain(i, &pair) as f32));
    });
    // How much of what a particle would give away it has: of polymer, and of liquid.
    let rations: Vec<PerPhase<Real>> = (0..n)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map(|i| {
            let (mut polymer_out, mut liquid_out) = (0.0, 0.0);
            for &g in gains.row(i) {
                let g = Real::from(g);
                polymer_out += (-g).max(0.0);
                liquid_out += g.max(0.0);
            }
            let ration = |have: Real, out: Real| if out > have { have / out } else { 1.0 };
            PerPhase {
                liquid: ration(1.0 - alpha[i], liquid_out),
                polymer: ration(alpha[i], polymer_out),
            }
        })
        .collect();
    let new: Vec<(Real, PerPhase<Vec3>)> = (0..n)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map(|i| {
            let own = fluid.phase_velocity[i];
            let mut gained = 0.0;
            // α_k v_k of each phase, exchanged with the velocity of the giver.
            let mut polymer = own.polymer * alpha[i];
            let mut liquid = own.liquid * (1.0 - alpha[i]);
            for (link, &g) in near.fluid.row(i).iter().zip(gains.row(i)) {
                let j = link.j as usize;
                let other = fluid.phase_velocity[j];
                let g = Real::from(g);
                let (g, polymer_from, liquid_from) = if g > 0.0 {
                    (
                        g * rations[j].polymer.min(rations[i].liquid),
                        other.polymer,
                        own.liquid,
                    )
                } else {
                    (
                        g * rations[i].polymer.min(rations[j].liquid),
                        own.polymer,
                        other.liquid,
                    )
                };
                gained += g;
                polymer += polymer_from * g;
                liquid -= liquid_from * g;
            }
            // The limiter leaves [0, 1] only by rounding; to cut that off keeps the sum to 1e-16.
            let fraction = (alpha[i] + gained).clamp(0.0, 1.0);
            if gained == 0.0 {
                return (alpha[i], own);
            }
            let velocity = if (ALPHA_EPSILON..=1.0 - ALPHA_EPSILON).contains(&fraction) {
                PerPhase {
                    liquid: liquid / (1.0 - fraction),
                    polymer: polymer / fraction,
                }
            } else {
                let momentum = liquid * cement.liquid.density + polymer * cement.polymer.density;
                let common = momentum / cement.density(fraction);
                PerPhase {
                    liquid: common,
                    polymer: common,
                }
            };
            (fraction, velocity)
        })
        .collect();
    for (i, (fraction, velocity)) in new.into_iter().enumerate() {
        fluid.polymer_fraction[i] = fraction;
        fluid.phase_velocity[i] = velocity;
    }
    unite_vanished_phases(cement, fluid);
}

/// A phase that is not there moves with the mixture; its last trace of momentum goes to the other.
pub fn unite_vanished_phases(cement: &Cement, fluid: &mut FluidParticles) {
    for (v, &alpha) in fluid.phase_velocity.iter_mut().zip(&fluid.polymer_fraction) {
        if !(ALPHA_EPSILON..=1.0 - ALPHA_EPSILON).contains(&alpha) && v.liquid != v.polymer {
            let common = if alpha == 0.0 {
                v.liquid
            } else if alpha == 1.0 {
                v.polymer
            } else {
                momentum_density(v, alpha, cement) / cement.density(alpha)
            };
            *v = PerPhase {
                liquid: common,
                polymer: common,
            };
        }
    }
}

/// Largest stable step of the diffusion [s].
pub fn most_diffusion_step(cement: &Cement, spacing: Real) -> Real {
    // The compact Laplacian's largest eigenvalue is near 6/dx² at every support ratio in use; half for safety.
    if cement.diffusion > 0.0 {
        spacing * spacing / (6.0 * cement.diffusion)
    } else {
        Real::INFINITY
    }
}
