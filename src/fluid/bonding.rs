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
use crate::sph::{Domain, Kernel, Neighbourhood};
use rayon::prelude::*;

/// C_d of every particle [1], in [0, 1]; `near` is of where the particles are now.
pub fn drag(
    cement: &Cement,
    fluid: &FluidParticles,
    near: &Neighbourhood,
    kernel: &Kernel,
    domain: &Domain,
) -> Vec<Real> {
    let weight = |r: Real| near.rest_volume * kernel.w(r);
    let own = weight(0.0);
    (0..fluid.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|i| {
            let (mut bonded, mut all) = (0.0, 0.0);
            for link in near.fluid.row(i) {
                let j = link.j as usize;
                // The pairs know W too, but in single precision.
                let x_ij = domain.shortest(fluid.position[i] - fluid.position[j]);
                let w = weight(x_ij.norm());
                bonded += w * fluid.polymer_fraction[j];
                all += w;
            }
            if cement.normalised_bonding {
                bonded = (bonded + own * fluid.polymer_fraction[i]) / (all + own);
            }
            (cement.rest_drag + (1.0 - cement.rest_drag) * bonded).clamp(0.0, 1.0)
        })
        .collect()
}
