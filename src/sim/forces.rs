//! Gravity, friction between the phases, viscosity and polymer stress.

use super::settings::{ElasticWaves, Scheme, StressStep};
use super::stepper::Stepper;
use crate::fluid::{conformation, mixture, stress};
use crate::math::{Mat3, Real, Sym3, Vec3, ordered_sums};
use crate::sph::PressureOperator;
use crate::sph::operators::{Mean, gradient_of_change, stress_force, viscous_force, wall_friction};
use rayon::prelude::*;

impl Stepper<'_> {
    /// Gravity: the same acceleration for every phase.
    pub fn apply_gravity(&mut self) {
        mixture::accelerate(self.fluid, &self.settings.gravity, self.dt);
        self.mix.refresh_velocity(self.fluid);
    }

    /// Interphase friction, if the cement has any.
    pub fn relax_slip(&mut self) {
        if let Some(relaxation) = self.settings.cement.slip_relaxation {
            mixture::relax_slip(&self.settings.cement, self.fluid, relaxation, self.dt);
            self.mix.refresh_velocity(self.fluid);
        }
    }

    pub(super) fn mixture_viscosity(&self) -> Vec<Real> {
        let cement = &self.settings.cement;
        self.fluid
            .polymer_fraction
            .iter()
            .map(|&a| cement.mixture_viscosity(a))
            .collect()
    }

    /// Newtonian viscosity of the mixture, explicit (Eq. 7 with M_k = α_k M); walls implicit, else they would set
    /// the step.
    pub fn apply_viscosity(&mut self) {
        let viscosity = self.mixture_viscosity();
        let force = viscous_force(
            self.near,
            &viscosity,
            Mean::Harmonic,
            &self.mix.velocity,
            false,
        );
        self.push(&force, &viscosity);
    }

    /// v ← (v + dt F/m + walls) for an explicit force [N], friction at walls with `viscosity` implicit.
    ///
    /// What will be pushed on by pressure meets that friction as well: the last step's pressure acts while it does and is
    /// taken back for the solve that follows. Without it a steady flow past walls depends on the step. (Before a wall that
    /// swings, 5 Pa·s, the largest pressures of a frame come out as with a fourth of the step: 8.0 kPa in nine of ten frames,
    /// 8.3 there, 7.2 without.)
    pub(super) fn push(&mut self, force: &[Vec3], viscosity: &[Real]) {
        let (dt, volume) = (self.dt, self.near.rest_volume);
        let pressure = self.fluid.multiplier(0);
        let pressing = PressureOperator { near: self.near }.force_at_walls(&pressure);
        let velocity: Vec<Vec3> = (0..self.fluid.len())
            .into_par_iter()
            .with_min_len(128)
            .map(|i| {
                let (friction, carried) = wall_friction(self.near, i);
                let inverse_mass = dt / self.mix.mass[i];
                let scale = inverse_mass * volume * viscosity[i];
                let pressed = pressing[i] * inverse_mass;
                let driven = self.mix.velocity[i] + force[i] * inverse_mass + carried * scale;
                (driven - pressed) / (1.0 + scale * friction) + pressed
            })
            .collect();
        self.mix
            .distribute(&self.settings.cement, self.fluid, &velocity, volume);
    }

    /// Eq. 12, then Eqs 13–16 with the new U: explicit, stabilised as far as the step allows.
    pub fn apply_polymer_stress(&mut self) {
        self.refresh_gradient();
        self.advance_conformation();
        let cement = &self.settings.cement;
        let spacing = self.settings.spacing;
        let n = self.fluid.len();
        let mut stabiliser = vec![0.0; n];
        let tau: Vec<Mat3> = (0..n)
            .map(|i| {
                let modulus = cement.modulus(self.fluid.polymer_fraction[i]);
                let rho = self.mix.density[i];
                let stretch = largest(&self.fluid.conformation[i]);
                let full =
                    stress::stabiliser_viscosity(cement, modulus, rho, stretch, spacing, true);
                stabiliser[i] = full.min(stress::most_explicit_stabiliser(rho, spacing, self.dt));
                stress::of_conformation(modulus, &self.fluid.conformation[i])
                    - self.gradient[i] * stabiliser[i]
            })
            .collect();
        let elastic = self.force_of_stress(tau);
        let viscosity: Vec<Real> = stabiliser
            .iter()
            .map(|s| s + cement.liquid.viscosity)
            .collect();
        let viscous = viscous_force(
            self.near,
            &viscosity,
            Mean::Arithmetic,
            &self.mix.velocity,
            false,
        );
        let force: Vec<Vec3> = elastic.iter().zip(&viscous).map(|(a, b)| a + b).collect();
        self.push(&force, &viscosity);
    }

    /// Force of a stress [Pa] on each particle [N], without what a uniform stress does to an uneven packing.
    ///
    /// A uniform stress has no force, but in pairs that are equal and opposite it has one that no refinement lessens, and
    /// that spoils the packing further: where little thinning lets N₁ grow to 17 times the shear stress (γ λ = 0.125,
    /// 100/s), the shear stress of a cell is 28 % too high with it (27 % at 16 across), and 0.1 % off without. In a closed
    /// body the mean is taken off, and pairs stay as they are. At a free surface a uniform stress pulls, so in an open body
    /// that touches walls (one that does not has its momentum to keep) particles with neighbours all round feel differences
    /// of the stress alone: the pressure of a viscoelastic needle then changes by 0.6 % over steps x 10, with it by 1.7 %.
    pub(super) fn force_of_stress(&self, mut stress: Vec<Mat3>) -> Vec<Vec3> {
        if !self.closed {
            let walled = self.near.wall.entries() > 0;
            return stress_force(self.near, &stress, |i| !walled || self.near.one_sided(i));
        }
        let n = stress.len();
        let sum = ordered_sums(n, |i| std::array::from_fn::<Real, 9, _>(|k| stress[i][k]));
        let mean = Mat3::from_column_slice(&sum) / n as Real;
        for tau in &mut stress {
            *tau -= mean;
        }
        stress_force(self.near, &stress, |_| true)
    }

    /// U^{n+1} (Eq. 12) with the current gradient.
    pub(super) fn advance_conformation(&mut self) {
        let cement = &self.settings.cement;
        let dt = self.dt;
        self.fluid
            .conformation
            .par_iter_mut()
            .zip(&self.gradient)
            .with_min_len(128)
            .for_each(|(u, l)| {
                *u = conformation::advance(u, l, cement.relaxation_time, cement.thinning, dt);
            });
    }

    /// Gravity, Newtonian viscosity and pressure in one solve.
    pub fn solve_newtonian(&mut self) {
        self.refresh_gradient();
        let viscosity = self.mixture_viscosity();
        let n = self.fluid.len();
        self.solve_coupled(
            &viscosity,
            Mean::Harmonic,
            vec![0.0; n],
            &self.likely_change(),
            vec![Vec3::zeros(); n],
        );
    }

    /// Whether polymer stress may pull at a free surface: it has one, and no piston keeps it under pressure.
    pub(super) fn may_be_pulled(&self) -> bool {
        !self.closed
            && self.inlets.is_empty()
            && self.stress != StressStep::Explicit
            && self.settings.scheme == Scheme::ImmCt
            && self.settings.cement.relaxation_time > 0.0
    }

    /// Gravity, solvent viscosity, polymer stress (Eqs 12–16) and pressure in one solve.
    ///
    /// The stress enters in increment form around a prediction with L(v*), v* the likely velocity (see `outlook`),
    /// div[(1 − b) τ^n + b τ_p] + Lap[η_K](v' − v*) plus the stabiliser Lap[η_a] v' − div(η_a L(v*)); steady states
    /// depend on neither dt nor η_K, and λ → 0 leaves the plain viscous step. η_K is weighted with the largest
    /// stretch, without which steps beyond Wi = 1 blow up.
    pub fn solve_viscoelastic(&mut self) {
        let cement = &self.settings.cement;
        let (dt, spacing) = (self.dt, self.settings.spacing);
        let resolved = self.settings.elastic_waves == ElasticWaves::Resolved;
        let n = self.fluid.len();
        let (b, memory) = stress::implicit_weight(cement, dt);
        let change = self.likely_change();
        let turn = gradient_of_change(self.near, &change);
        let stress_of = if self.may_be_pulled() {
            stress::above_least
        } else {
            stress::of_conformation
        };
        let terms: Vec<(Mat3, Real, Real)> = (0..n)
            .into_par_iter()
            .with_min_len(128)
            .map(|i| {
                let u = &self.fluid.conformation[i];
                let gradient = self.gradient[i] + turn[i];
                let modulus = cement.modulus(self.fluid.polymer_fraction[i]);
                let predicted = conformation::advance(
                    u,
                    &gradient,
                    cement.relaxation_time,
                    cement.thinning,
                    dt,
                );
                let stretch = largest(u).max(largest(&predicted));
                let rho = self.mix.density[i];
                let stabiliser =
                    stress::stabiliser_viscosity(cement, modulus, rho, stretch, spacing, resolved);
                let implicit = (modulus * memory * stretch).max(stabiliser);
                let tau = stress_of(modulus, u) * (1.0 - b) + stress_of(modulus, &predicted) * b
                    - gradient * stabiliser;
                (tau, stabiliser, implicit - stabiliser)
            })
            .collect();
        let force = self.force_of_stress(terms.iter().map(|t| t.0).collect());
        let solvent = cement.liquid.viscosity;
        let viscosity: Vec<Real> = terms.iter().map(|t| t.1 + solvent).collect();
        let lag: Vec<Real> = terms.iter().map(|t| t.2).collect();
        self.solve_coupled(&viscosity, Mean::Arithmetic, lag, &change, force);
        self.refresh_gradient();
        self.advance_conformation();
    }
}

fn largest(u: &Sym3) -> Real {
    u.eigenvalues()[2]
}
