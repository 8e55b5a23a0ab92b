//! The mixture and its two phases: what they share, and how a force on the mixture moves each.
//!
//! ```text
//! v_mix = Σ α_k v_k                                                             [IMM-CT] (Eq. 4)
//! ρ_mix = Σ α_k ρ_k⁰                                                            [IMM-CT] (Eq. 5)
//! Dv_k/Dt = (M/ρ_mix) (C_d + (1 − C_d) ρ_mix/ρ_k⁰)                              [IMM-CT] (Eqs 6, 7, 16)
//! ```
//!
//! M is the force per volume. (Eq. 7) takes the phases' share M_k = α_k M, as (Eq. 15) does for the stress; then
//! pressure, viscosity and stress share one bounded form, and (Eq. 16) loses its division by α_k. Momentum is
//! exact: Σ α_k ρ_k Dv_k/Dt = M. The volume-averaged velocity gains c M/ρ_mix with the compliance
//! c = Σ α_k (C_d + (1 − C_d) ρ_mix/ρ_k) ≥ 1, so solvers work with the effective mass V ρ_mix/c.

use super::{Cement, FluidParticles, PerPhase};
use crate::math::{Real, Vec3};
use rayon::prelude::*;

/// Particles that one task works on at least.
const GRAIN: usize = 4096;

/// Below this fraction a phase has no velocity of its own.
pub const ALPHA_EPSILON: Real = 1e-6;

/// Fields of the mixture, rebuilt in every step.
#[derive(Clone, Debug, Default)]
pub struct MixtureFields {
    /// ρ_mix [kg/m³] (Eq. 5).
    pub density: Vec<Real>,
    /// v_mix [m/s] (Eq. 4).
    pub velocity: Vec<Vec3>,
    /// C_d [1] (Eq. 10).
    pub drag: Vec<Real>,
    /// Effective mass V ρ_mix/c [kg].
    pub mass: Vec<Real>,
}

/// v_mix of one particle (Eq. 4).
#[inline]
pub fn mixture_velocity(v: &PerPhase<Vec3>, alpha: Real) -> Vec3 {
    v.liquid * (1.0 - alpha) + v.polymer * alpha
}

/// Momentum of one particle per volume, Σ α_k ρ_k v_k [kg/(m² s)].
pub fn momentum_density(v: &PerPhase<Vec3>, alpha: Real, cement: &Cement) -> Vec3 {
    v.liquid * ((1.0 - alpha) * cement.liquid.density)
        + v.polymer * (alpha * cement.polymer.density)
}

/// C_d + (1 − C_d) ρ_mix/ρ_k, written so that it is exactly 1 for a pure phase.
#[inline]
fn share(drag: Real, density: Real, phase_density: Real) -> Real {
    1.0 + (1.0 - drag) * ((density - phase_density) / phase_density)
}

impl MixtureFields {
    /// Density, velocity and effective mass from the phases (Eqs 4, 5); `drag` is C_d of each particle.
    pub fn refresh(
        &mut self,
        cement: &Cement,
        fluid: &FluidParticles,
        rest_volume: Real,
        drag: Vec<Real>,
    ) {
        let n = fluid.len();
        self.drag = drag;
        self.density = fluid
            .polymer_fraction
            .iter()
            .map(|&a| cement.density(a))
            .collect();
        self.refresh_velocity(fluid);
        self.mass = (0..n)
            .map(|i| {
                let alpha = fluid.polymer_fraction[i];
                let (c_d, rho) = (self.drag[i], self.density[i]);
                let compliance = 1.0
                    + (1.0 - c_d)
                        * ((1.0 - alpha) * ((rho - cement.liquid.density) / cement.liquid.density)
                            + alpha * ((rho - cement.polymer.density) / cement.polymer.density));
                rest_volume * rho / compliance
            })
            .collect();
    }

    /// v_mix from the phase velocities (Eq. 4).
    pub fn refresh_velocity(&mut self, fluid: &FluidParticles) {
        fluid
            .phase_velocity
            .par_iter()
            .zip(&fluid.polymer_fraction)
            .with_min_len(GRAIN)
            .map(|(v, &alpha)| mixture_velocity(v, alpha))
            .collect_into_vec(&mut self.velocity);
    }

    /// Hands a change of the mixture's velocity, caused by a force, to the phases (Eqs 6, 7, 16).
    pub fn distribute(
        &mut self,
        cement: &Cement,
        fluid: &mut FluidParticles,
        new_velocity: &[Vec3],
        rest_volume: Real,
    ) {
        let phases = fluid.phase_velocity.par_iter_mut().enumerate();
        phases.with_min_len(GRAIN).for_each(|(i, v)| {
            let rho = self.density[i];
            // Change of v_mix → impulse per volume → change of each phase.
            let change =
                (new_velocity[i] - self.velocity[i]) * (self.mass[i] / (rest_volume * rho));
            v.liquid += change * share(self.drag[i], rho, cement.liquid.density);
            v.polymer += change * share(self.drag[i], rho, cement.polymer.density);
        });
        self.refresh_velocity(fluid);
    }
}

/// Gives all phases the same acceleration [m/s²] for `dt` [s]: gravity.
pub fn accelerate(fluid: &mut FluidParticles, acceleration: &Vec3, dt: Real) {
    for v in &mut fluid.phase_velocity {
        v.liquid += acceleration * dt;
        v.polymer += acceleration * dt;
    }
}

/// Interphase friction: the slip v_polymer − v_liquid decays with time constant `relaxation` [s]; momentum stays.
///
/// The paper's model has none (C_d only redistributes accelerations), so that slip under gravity grows without
/// bound; real powder in monomer stops slipping within microseconds.
pub fn relax_slip(cement: &Cement, fluid: &mut FluidParticles, relaxation: Real, dt: Real) {
    let keep = libm::exp(-dt / relaxation);
    for (v, &alpha) in fluid.phase_velocity.iter_mut().zip(&fluid.polymer_fraction) {
        let slip = v.polymer - v.liquid;
        let lost = slip * (1.0 - keep);
        let polymer_share = alpha * cement.polymer.density / cement.density(alpha);
        // The heavier the phase, the less it changes: Σ α_k ρ_k v_k is kept.
        v.liquid += lost * polymer_share;
        v.polymer -= lost * (1.0 - polymer_share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    fn cement() -> Cement {
        let phase = |density, viscosity| crate::fluid::PhaseMaterial { density, viscosity };
        Cement {
            liquid: phase(940.0, 0.01),
            polymer: phase(1180.0, 8.0),
            relaxation_time: 0.05,
            thinning: 0.5,
            rest_drag: 0.5,
            diffusion: 0.0,
            normalised_bonding: false,
            literal_modulus: false,
            slip_relaxation: None,
        }
    }

    /// Momentum of the phases gains exactly the impulse, and v_mix exactly what the solver wanted.
    #[test]
    fn forces_keep_momentum_and_reach_the_solved_velocity() {
        let cement = cement();
        let mut random = Stream::new(1, "mixture");
        let mut fluid = FluidParticles::default();
        for i in 0..100 {
            fluid.push(Vec3::zeros(), random.cube(), random.unit(), i, 0);
            fluid.phase_velocity[i as usize].polymer += random.cube();
        }
        let drag = (0..100).map(|_| random.unit()).collect();
        let mut mix = MixtureFields::default();
        let volume = 1e-9;
        mix.refresh(&cement, &fluid, volume, drag);
        let before = fluid.clone();
        let old = mix.velocity.clone();
        let wanted: Vec<Vec3> = old.iter().map(|v| v + random.cube()).collect();
        let mass = mix.mass.clone();
        mix.distribute(&cement, &mut fluid, &wanted, volume);
        for i in 0..100 {
            let alpha = fluid.polymer_fraction[i];
            assert!((mix.velocity[i] - wanted[i]).norm() < 1e-12);
            let gained = momentum_density(&fluid.phase_velocity[i], alpha, &cement)
                - momentum_density(&before.phase_velocity[i], alpha, &cement);
            let impulse = (wanted[i] - old[i]) * mass[i] / volume;
            assert!((gained - impulse).norm() < 1e-9 * impulse.norm().max(1.0));
            assert!(mass[i] <= volume * mix.density[i] * (1.0 + 1e-12));
        }
    }

    #[test]
    fn friction_stops_slip_and_keeps_momentum() {
        let cement = cement();
        let mut fluid = FluidParticles::default();
        fluid.push(Vec3::zeros(), Vec3::x(), 0.3, 0, 0);
        fluid.phase_velocity[0].polymer = Vec3::y();
        let before = momentum_density(&fluid.phase_velocity[0], 0.3, &cement);
        relax_slip(&cement, &mut fluid, 0.1, 0.2);
        let v = fluid.phase_velocity[0];
        assert!((momentum_density(&v, 0.3, &cement) - before).norm() < 1e-9);
        assert!(((v.polymer - v.liquid).norm() - 2.0_f64.sqrt() * libm::exp(-2.0)).abs() < 1e-12);
    }
}
