//! Bonding effect network: much polymer around a particle couples its phases.
//!
//! ```text
//! C_d = C_d⁰ + (1 − C_d⁰) Σ_{j≠i} V₀ α_j W_ij                                  [IMM-CT] (Eq. 10)
//! ```
//!
//! As printed the sum leaves i out and reaches only 0.68 to 0.96 in pure polymer, by the support radius; the
//! normalised form Σ_j V₀ α_j W_ij / Σ_j V₀ W_ij, with i, reaches 1.

use super::{Cement, FluidParticles};
use crate::math::Real;
use crate::sph::Neighbourhood;
use rayon::prelude::*;

/// C_d of every particle [1], in [0, 1].
pub fn drag(
    cement: &Cement,
    fluid: &FluidParticles,
    near: &Neighbourhood,
    own_weight: Real,
) -> Vec<Real> {
    (0..fluid.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|i| {
            let (mut bonded, mut all) = (0.0, 0.0);
            for pair in near.pairs(i) {
                bonded += Real::from(pair.weight) * fluid.polymer_fraction[pair.j as usize];
                all += Real::from(pair.weight);
            }
            if cement.normalised_bonding {
                bonded = (bonded + own_weight * fluid.polymer_fraction[i]) / (all + own_weight);
            }
            (cement.rest_drag + (1.0 - cement.rest_drag) * bonded).clamp(0.0, 1.0)
        })
        .collect()
}
