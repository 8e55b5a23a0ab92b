//! Health after every step: what is not a number, not positive or not credible stops the run.

use crate::fluid::FluidParticles;
use crate::math::{Real, Vec3};
use rayon::prelude::*;

/// Falling over is an answer, not a crash.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimError {
    /// A particle is ill.
    #[error(
        "the simulation diverged in step {step} at t = {time:.6} s: {what} of particle {particle} at \
         ({:.3}, {:.3}, {:.3}) mm after {term}; what was computed so far is kept. Try a smaller time step or spacing",
        .position.x * 1e3, .position.y * 1e3, .position.z * 1e3
    )]
    Diverged {
        /// Step number.
        step: u64,
        /// Simulated time [s].
        time: Real,
        /// Identity of the first ill particle.
        particle: u32,
        /// Where it is [m].
        position: Vec3,
        /// Which part of the step it was.
        term: &'static str,
        /// What is wrong with it.
        what: Symptom,
    },
    /// A solver did not reach its goals, whatever the step.
    #[error(
        "the solver did not converge in step {step} at t = {time:.6} s, even with dt = {:.3} us: volume strain {strain:.1e} \
         a step, {:.1} % of the inflow unbalanced, velocity off by {velocity:.1e} m/s; what was computed so far is kept. \
         Try a larger viscosity, a slower inlet or a finer spacing",
        .dt * 1e6, .balance * 100.0
    )]
    Unconverged {
        /// Step number.
        step: u64,
        /// Simulated time [s].
        time: Real,
        /// The last step tried [s].
        dt: Real,
        /// Volume strain left over [1].
        strain: Real,
        /// Share of the inflow left unbalanced [1].
        balance: Real,
        /// Velocity residual [m/s].
        velocity: Real,
    },
    /// Fluid cannot be pressed into a closed space that is full.
    #[error(
        "inlet `{inlet}` opens into a closed space with room for {:.3} ml, but {:.3} ml are to be pressed in: give it a \
         way out, or lower `dose`",
        .room * 1e6, .pressed * 1e6
    )]
    NoRoom {
        /// Name of the inlet.
        inlet: String,
        /// What all inlets there press in [m³].
        pressed: Real,
        /// What is empty [m³].
        room: Real,
    },
    /// The neighbour rows cannot be numbered.
    #[error("the scene holds {0} fluid particles; at most {1} fit: use a coarser spacing")]
    TooMany(usize, usize),
}

/// What is wrong with a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symptom {
    /// Position, velocity or pressure is NaN or infinite.
    NonFinite,
    /// The conformation tensor is not positive definite.
    NotPositive,
    /// A polymer fraction outside [0, 1].
    Fraction,
    /// It moves more than a support radius in a step.
    Runaway,
}

impl std::fmt::Display for Symptom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NonFinite => "a value that is not a number",
            Self::NotPositive => "a conformation tensor that is not positive definite",
            Self::Fraction => "a polymer fraction outside 0…1",
            Self::Runaway => "a runaway velocity",
        })
    }
}

/// The first ill particle, if any: its index and what is wrong.
pub fn first_symptom(fluid: &FluidParticles, reach: Real, dt: Real) -> Option<(usize, Symptom)> {
    let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
    let particles = (0..fluid.len()).into_par_iter().with_min_len(2048);
    particles.find_map_first(|i| {
        let v = &fluid.phase_velocity[i];
        let alpha = fluid.polymer_fraction[i];
        let symptom = if !finite(&fluid.position[i])
            || !finite(&v.liquid)
            || !finite(&v.polymer)
            || !fluid.pressure[i].iter().all(|p| p.is_finite())
        {
            Symptom::NonFinite
        } else if !(0.0..=1.0).contains(&alpha) {
            Symptom::Fraction
        } else if !fluid.conformation(i).is_positive_definite() {
            Symptom::NotPositive
        } else if crate::fluid::mixture::mixture_velocity(v, alpha).norm() * dt > reach {
            Symptom::Runaway
        } else {
            return None;
        };
        Some((i, symptom))
    })
}
