//! Where the energy goes: work that came in, what is held, what was lost and how, step by step.
//!
//! ```text
//! ½ Σ α_k ρ_k v_k² V + Σ (G/2)(tr U − ln det U − 3) V = start + carried + gravity + walls − losses + residual
//! relaxation loss    = Σ V G/2 [tr(U + U⁻¹ − 2I)/λ + γ tr (U − I)²] dt                  (of Eqs 12, 13)
//! ```
//!
//! Forces work on the velocity that carries the particles. Losses are of the model (viscosity, relaxation, slip) or of
//! the method (implicit Euler, the stabiliser, shifting, compression that pressure undoes), each from its own term and none from
//! the balance; so the residual is what stress, velocity gradient and conformation do not agree on.

use super::settings::{Scheme, SimSettings, StressStep};
use super::stepper::Stepper;
use crate::fluid::{Cement, FluidParticles, conformation, mixture, stress};
use crate::math::{Mat3, Real, Sym3, Vec3, ordered_sum};
use crate::sph::PressureOperator;
use crate::sph::operators::{Mean, viscous_force};
use crate::sph::power;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What came, went and was lost since the start [J].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic and elastic at the start.
    pub start: Real,
    /// Of particles that came in, less that of those that left.
    pub carried: Real,
    /// Work of gravity.
    pub gravity: Real,
    /// Work of moving walls and pistons.
    pub walls: Real,
    /// Lost to viscosity: of the liquid beside a polymer with memory, else of the mixture.
    pub viscous: Real,
    /// Lost as the polymer relaxes.
    pub relaxed: Real,
    /// Lost as phases slip past each other and exchange volume.
    pub slipped: Real,
    /// Lost in the stabiliser, and what the solver left of its forces.
    pub stabilised: Real,
    /// Lost where the force of the stress and the gradient that stretches the polymer are no exact pair: the gradient
    /// is made exact beside walls and in disorder, which its adjoint is not, and the flow would be wrong if it were. Nor
    /// does what of the gradient compresses stretch any polymer.
    pub unpaired: Real,
    /// Lost to compression that pressure undoes; negative where that gives energy.
    pub compressed: Real,
    /// Lost as particles are shifted in the field that they carry, and where walls stop them.
    pub shifted: Real,
    /// Lost to steps in time: ½ m |Δv|² of implicit Euler, and where a stress that changes within the step acts as one
    /// that does not.
    pub stepped: Real,
    /// |gravity| + |walls|, added up over steps.
    pub turnover: Real,
}

impl Energy {
    /// Adds a step's.
    fn add(&mut self, step: &Self) {
        self.carried += step.carried;
        self.gravity += step.gravity;
        self.walls += step.walls;
        self.viscous += step.viscous;
        self.relaxed += step.relaxed;
        self.slipped += step.slipped;
        self.stabilised += step.stabilised;
        self.unpaired += step.unpaired;
        self.compressed += step.compressed;
        self.shifted += step.shifted;
        self.stepped += step.stepped;
        self.turnover += step.gravity.abs() + step.walls.abs();
    }

    /// The books with those of another step in them, whose start they keep.
    pub(super) fn followed_by(so_far: Option<Self>, step: &Self) -> Self {
        let mut all = so_far.unwrap_or(Self {
            start: step.start,
            ..Self::default()
        });
        all.add(step);
        all
    }

    /// Losses of the method [J].
    pub fn numerical(&self) -> Real {
        self.stabilised + self.unpaired + self.compressed + self.shifted + self.stepped
    }

    /// What is held beyond what the books account for [J]; positive: from nowhere.
    pub fn residual(&self, held: Real) -> Real {
        held + self.viscous + self.relaxed + self.slipped + self.numerical()
            - (self.start + self.carried + self.gravity + self.walls)
    }

    /// All that was there to be turned over [J].
    pub fn scale(&self) -> Real {
        self.start + self.turnover
    }
}

/// A step's start, as far as its energy needs it.
#[derive(Debug, Default)]
pub struct Books {
    velocity: Vec<Vec3>,
    conformation: Vec<Sym3>,
    kinetic: Real,
    /// −dt P k of all solves [N s], and the walls' part of its work [J].
    pressure: Vec<Vec3>,
    pushed: Real,
}

/// Σ ½ α_k ρ_k v_k² V [J].
pub fn kinetic(cement: &Cement, fluid: &FluidParticles, rest_volume: Real) -> Real {
    let alpha = &fluid.polymer_fraction;
    0.5 * rest_volume
        * ordered_sum(fluid.len(), |i| {
            let v = &fluid.phase_velocity[i];
            (1.0 - alpha[i]) * cement.liquid.density * v.liquid.norm_squared()
                + alpha[i] * cement.polymer.density * v.polymer.norm_squared()
        })
}

/// Whether the polymer has a memory.
fn conforms(settings: &SimSettings) -> bool {
    settings.scheme == Scheme::ImmCt && settings.cement.relaxation_time > 0.0
}

/// Σ (G/2)(tr U − ln det U − 3) V [J]; 0 for a scheme without memory.
pub fn elastic(settings: &SimSettings, fluid: &FluidParticles, rest_volume: Real) -> Real {
    if !conforms(settings) {
        return 0.0;
    }
    let modulus = |i: usize| settings.cement.modulus(fluid.polymer_fraction[i]);
    rest_volume
        * ordered_sum(fluid.len(), |i| {
            stress::elastic_energy(modulus(i), &fluid.conformation(i))
        })
}

/// Both [J].
pub fn held(settings: &SimSettings, fluid: &FluidParticles, rest_volume: Real) -> Real {
    kinetic(&settings.cement, fluid, rest_volume) + elastic(settings, fluid, rest_volume)
}

/// τ : L [W/m³], without the trace of L, which does not stretch the polymer either (`conformation::advance`).
fn power_of(tau: &Mat3, gradient: &Mat3) -> Real {
    tau.dot(gradient) - tau.trace() * gradient.trace() / 3.0
}

/// What U loses by relaxing in a step, and what stretching it takes [J/m³]: Simpson's rule over pieces that begin at
/// half a memory and double, since what is left of the last step relaxes first.
fn loss_and_work(
    cement: &Cement,
    alpha: Real,
    start: &Sym3,
    gradient: &Mat3,
    dt: Real,
) -> [Real; 2] {
    let modulus = cement.modulus(alpha);
    let powers = |u: &Sym3| {
        [
            stress::relaxation_power(cement, modulus, u),
            power_of(&stress::of_conformation(modulus, u), gradient),
        ]
    };
    let after = |u: &Sym3, time: Real| {
        conformation::advance(u, gradient, cement.relaxation_time, cement.thinning, time)
    };
    let stretch = start.eigenvalues()[2];
    let memory = 1.0 / (1.0 / cement.relaxation_time + cement.thinning * stretch);
    let (mut piece, mut left) = ((0.5 * memory).min(0.5 * dt), dt);
    let (mut u, mut sums) = (*start, [0.0; 2]);
    while left > 0.0 {
        let time = if left < 1.5 * piece { left } else { piece };
        let middle = after(&u, 0.5 * time);
        let end = after(&middle, 0.5 * time);
        let (first, between, last) = (powers(&u), powers(&middle), powers(&end));
        for k in 0..2 {
            sums[k] += (first[k] + 4.0 * between[k] + last[k]) * time / 6.0;
        }
        (u, left, piece) = (end, left - time, 2.0 * piece);
    }
    sums
}

impl Stepper<'_> {
    /// Opens the books of a step, if they are kept.
    pub fn open_books(&mut self) {
        if !self.settings.energy_balance {
            return;
        }
        let volume = self.near.rest_volume;
        self.report.energy = Energy {
            start: held(self.settings, self.fluid, volume),
            ..Energy::default()
        };
        self.books = Some(Books {
            velocity: self.mix.velocity.clone(),
            conformation: (0..self.fluid.len())
                .map(|i| self.fluid.conformation(i))
                .collect(),
            kinetic: kinetic(&self.settings.cement, self.fluid, volume),
            pressure: vec![Vec3::zeros(); self.fluid.len()],
            pushed: 0.0,
        });
    }

    /// Books a solved pressure [Pa], which acts over the whole step.
    pub(super) fn book_pressure(&mut self, pressure: &[Real]) {
        let Some(books) = &mut self.books else { return };
        let operator = PressureOperator { near: self.near };
        let n = pressure.len();
        let closing = operator.volume_rate_with_walls(&vec![Vec3::zeros(); n]);
        books.pushed += self.dt * ordered_sum(n, |i| pressure[i] * closing[i]);
        for (sum, force) in books.pressure.iter_mut().zip(operator.force(pressure)) {
            *sum -= force * self.dt;
        }
    }

    /// Books what was taken off the pressure's force in the step [N].
    pub(super) fn book_relief(&mut self, relief: &[Vec3]) {
        let Some(books) = &mut self.books else { return };
        for (sum, relief) in books.pressure.iter_mut().zip(relief) {
            *sum += relief * self.dt;
        }
    }

    /// Books what the forces of the step did, before phases exchange anything.
    pub fn book_work(&mut self) {
        let Some(books) = self.books.take() else {
            return;
        };
        let (cement, near, dt) = (&self.settings.cement, &*self.near, self.dt);
        let (fluid, mix) = (&*self.fluid, &self.mix);
        let (n, volume) = (fluid.len(), near.rest_volume);
        let carrying = self.carrying_velocity();
        let gravity = self.settings.gravity;
        let memory = conforms(self.settings);
        let viscosity = if memory {
            vec![cement.liquid.viscosity; n]
        } else {
            self.mixture_viscosity()
        };
        let viscous = viscous_force(near, &viscosity, Mean::Harmonic, &carrying, true);
        let dragged = dt * power::of_friction(near, &viscosity, &carrying);
        let (mut elastic, mut stretched) = (vec![Vec3::zeros(); n], 0.0);
        let (mut relaxed, mut sampled, mut taken) = (0.0, 0.0, 0.0);
        if memory {
            let weight = match self.stress {
                StressStep::Explicit => 1.0,
                StressStep::Coupled | StressStep::Auto => stress::implicit_weight(cement, dt).0,
            };
            let tau: Vec<Mat3> = (0..n)
                .map(|i| {
                    let modulus = cement.modulus(fluid.polymer_fraction[i]);
                    stress::of_conformation(modulus, &books.conformation[i]) * (1.0 - weight)
                        + stress::of_conformation(modulus, &fluid.conformation(i)) * weight
                })
                .collect();
            stretched = dt * power::of_stress(near, &tau);
            sampled = dt * volume * ordered_sum(n, |i| power_of(&tau[i], &self.gradient[i]));
            elastic = self.force_of_stress(tau);
            let sums: Vec<[Real; 2]> = (0..n)
                .into_par_iter()
                .with_min_len(128)
                .map(|i| {
                    let (alpha, u) = (fluid.polymer_fraction[i], &books.conformation[i]);
                    loss_and_work(cement, alpha, u, &self.gradient[i], dt)
                })
                .collect();
            relaxed = volume * ordered_sum(n, |i| sums[i][0]);
            taken = volume * ordered_sum(n, |i| sums[i][1]);
        }
        let change = |i: usize| mix.velocity[i] - books.velocity[i];
        let work = |force: &[Vec3]| dt * ordered_sum(n, |i| force[i].dot(&carrying[i]));
        let pressed = ordered_sum(n, |i| books.pressure[i].dot(&carrying[i]));
        let (of_viscous, of_elastic) = (work(&viscous), work(&elastic));
        // Of all forces but gravity, which the phases feel each by its own density.
        let of_all = ordered_sum(n, |i| {
            mix.mass[i] * (change(i) - gravity * dt).dot(&carrying[i])
        });
        let stepped = ordered_sum(n, |i| {
            let middle = (mix.velocity[i] + books.velocity[i]) * 0.5;
            mix.mass[i] * change(i).dot(&(carrying[i] - middle))
        });
        let fallen = dt
            * volume
            * ordered_sum(n, |i| {
                let alpha = fluid.polymer_fraction[i];
                let lead = self.lead.get(i).copied().unwrap_or_default();
                let momentum = mixture::momentum_density(&fluid.phase_velocity[i], alpha, cement);
                gravity.dot(&(momentum + lead * mix.density[i]))
            });
        let gained = kinetic(cement, fluid, volume) - books.kinetic;
        let now = held(self.settings, fluid, volume);
        let e = &mut self.report.energy;
        e.gravity = fallen;
        e.walls = books.pushed + dragged + stretched;
        e.viscous = dragged - of_viscous;
        e.unpaired = stretched - of_elastic - sampled;
        e.compressed = books.pushed - pressed;
        e.stabilised = pressed + of_viscous + of_elastic - of_all;
        e.stepped = stepped + sampled - taken;
        e.relaxed = relaxed;
        e.slipped = fallen + of_all - stepped - gained;
        // Until the step is over: what is held by those who have not moved yet.
        e.carried = now;
    }

    /// Books what phases lost as they exchanged momentum and volume, after they did.
    pub fn book_exchange(&mut self) {
        self.report.energy.slipped += self.lost_since();
    }

    /// Books what shifting lost, after particles moved and before others come in.
    pub(super) fn book_shift(&mut self) {
        self.report.energy.shifted += self.lost_since();
    }

    /// What is held no longer that was when this was asked last [J].
    fn lost_since(&mut self) -> Real {
        if !self.settings.energy_balance {
            return 0.0;
        }
        let now = held(self.settings, self.fluid, self.near.rest_volume);
        std::mem::replace(&mut self.report.energy.carried, now) - now
    }
}
