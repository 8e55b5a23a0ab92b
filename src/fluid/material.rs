//! What the cement is made of.

use super::conformation;
use crate::math::Real;
use serde::{Deserialize, Serialize};

/// One value for each of the two phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerPhase<T> {
    /// Of the solvent (k₁).
    pub liquid: T,
    /// Of the solute (k₂).
    pub polymer: T,
}

/// The material: a solvent and a polymer phase that mix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cement {
    /// The solvent (monomer).
    pub liquid: PhaseMaterial,
    /// The solute (polymer powder).
    pub polymer: PhaseMaterial,
    /// λ: how long the polymer remembers [s]; 0 makes it a Newtonian fluid.
    pub relaxation_time: Real,
    /// γ: thinning factor of (Eq. 12) [1/s].
    pub thinning: Real,
    /// C_d⁰ of (Eq. 10) [1].
    pub rest_drag: Real,
    /// C_f: phase diffusion coefficient [m²/s].
    pub diffusion: Real,
    /// Bonding network divided by the kernel sum, so that it reaches 1 in pure polymer.
    pub normalised_bonding: bool,
    /// Modulus c η of the printed (Eq. 13) instead of c η/λ.
    pub literal_modulus: bool,
    /// Time in which interphase friction halts the slip between the phases [s]; `None`: the paper's model, in
    /// which slip under gravity grows without bound.
    pub slip_relaxation: Option<Real>,
}

/// One phase at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseMaterial {
    /// ρ_k⁰ [kg/m³].
    pub density: Real,
    /// η_k [Pa·s].
    pub viscosity: Real,
}

impl Cement {
    /// ρ_mix (Eq. 5) [kg/m³] at polymer fraction `alpha`.
    pub fn density(&self, alpha: Real) -> Real {
        (1.0 - alpha) * self.liquid.density + alpha * self.polymer.density
    }

    /// Newtonian viscosity of the mixture, Σ α_k η_k [Pa·s]: what `imm` and `dfsph` flow with.
    pub fn mixture_viscosity(&self, alpha: Real) -> Real {
        (1.0 - alpha) * self.liquid.viscosity + alpha * self.polymer.viscosity
    }

    /// G = c η/λ [Pa] with c = α of the polymer, so that λ → 0 leaves the Newtonian stress 2 c η D (Eq. 13,
    /// which prints c η; `literal_modulus` keeps that, with λ = 1 s understood).
    pub fn modulus(&self, alpha: Real) -> Real {
        let memory = if self.literal_modulus {
            1.0
        } else {
            self.relaxation_time
        };
        alpha * self.polymer.viscosity / memory
    }

    /// λ' [s], see [`conformation::linear_relaxation_time`].
    pub fn linear_relaxation_time(&self) -> Real {
        conformation::linear_relaxation_time(self.relaxation_time, self.thinning)
    }
}
