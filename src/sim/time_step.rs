//! The time step, and what limits it.
//!
//! Explicit stress: dt [η_p tanh(dt/2λ) k² + η_s k_L²] < 2ρ, the exact bound of the linear modes, with half of it
//! taken; k² and k_L² are the largest eigenvalues of the operators on a lattice. Coupled: only what the
//! particles may move and strain in a step.

use super::settings::{Scheme, SimSettings, StressStep, TimeStep};
use crate::math::Real;
use serde::{Deserialize, Serialize};

/// What the step is limited by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The recipe says so.
    Fixed,
    /// The largest that the recipe allows.
    Largest,
    /// Motion by a fraction of a spacing.
    Cfl,
    /// Acceleration.
    Acceleration,
    /// Explicit viscosity.
    Viscous,
    /// Explicit elastic waves.
    Elastic,
    /// Pressure shaking particles when it is solved apart from viscosity.
    Packing,
    /// Strain in a step.
    Strain,
    /// Phase diffusion.
    Diffusion,
    /// The end of a frame.
    Frame,
    /// The dose is complete.
    Dose,
    /// A step failed and was taken back: smaller ones follow for a while.
    Retry,
}

impl Limit {
    /// The word for tables and the progress line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Largest => "largest",
            Self::Cfl => "cfl",
            Self::Acceleration => "acceleration",
            Self::Viscous => "viscous",
            Self::Elastic => "elastic",
            Self::Packing => "packing",
            Self::Strain => "strain",
            Self::Diffusion => "diffusion",
            Self::Frame => "frame",
            Self::Dose => "dose",
            Self::Retry => "retry",
        }
    }
}

/// What is known of the flow when a step is chosen.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlowMeasures {
    /// Fastest phase or piston [m/s].
    pub speed: Real,
    /// Largest component of the velocity gradient, in norm [1/s].
    pub strain_rate: Real,
    /// Largest G λ_max(U) [Pa].
    pub stiffness: Real,
    /// Largest Newtonian viscosity in explicit use [Pa·s].
    pub viscosity: Real,
    /// Least density [kg/m³].
    pub density: Real,
    /// Largest pressure [Pa].
    pub pressure: Real,
}

/// Strain in a coupled step: the conformation update takes the gradient as frozen.
const MOST_STRAIN: Real = 0.5;

/// The step [s], its limit, and how its stress is stepped (never `Auto`).
pub fn choose(settings: &SimSettings, flow: &FlowMeasures) -> (Real, Limit, StressStep) {
    let with = |stress| limited(settings, flow, stress);
    let stress = match (settings.stress, settings.time_step) {
        (StressStep::Auto, TimeStep::Adaptive { .. }) => {
            explicit_if(with(StressStep::Explicit).0 >= with(StressStep::Coupled).0)
        }
        (StressStep::Auto, TimeStep::Fixed(dt)) => {
            let adaptive = SimSettings {
                time_step: TimeStep::Adaptive {
                    min: 0.0,
                    max: dt,
                    cfl: Real::INFINITY,
                },
                ..settings.clone()
            };
            explicit_if(limited(&adaptive, flow, StressStep::Explicit).0 >= dt)
        }
        (stress, _) => stress,
    };
    let (dt, limit) = with(stress);
    (dt, limit, stress)
}

fn explicit_if(allowed: bool) -> StressStep {
    if allowed {
        StressStep::Explicit
    } else {
        StressStep::Coupled
    }
}

fn limited(settings: &SimSettings, flow: &FlowMeasures, stress: StressStep) -> (Real, Limit) {
    let (min, max, cfl) = match settings.time_step {
        TimeStep::Fixed(dt) => return (dt, Limit::Fixed),
        TimeStep::Adaptive { min, max, cfl } => (min, max, cfl),
    };
    let dx = settings.spacing;
    let mut best = (max, Limit::Largest);
    let mut limit = |dt: Real, by: Limit| {
        if dt < best.0 {
            best = (dt, by);
        }
    };
    limit(cfl * dx / flow.speed.max(1e-12), Limit::Cfl);
    if settings.scheme != Scheme::Dfsph {
        limit(
            crate::fluid::transfer::most_diffusion_step(&settings.cement, dx),
            Limit::Diffusion,
        );
    }
    match stress {
        StressStep::Coupled | StressStep::Auto => {
            if settings.scheme == Scheme::ImmCt {
                limit(MOST_STRAIN / flow.strain_rate.max(1e-12), Limit::Strain);
            }
        }
        StressStep::Explicit => {
            let acceleration = settings.gravity.norm();
            limit(
                0.25 * (dx / acceleration.max(1e-12)).sqrt(),
                Limit::Acceleration,
            );
            // p dt²/(ρ dx²) < 0.6: beyond it pressure shakes a disordered packing apart.
            limit(
                0.7 * dx * (flow.density / flow.pressure.max(1e-12)).sqrt(),
                Limit::Packing,
            );
            let rho = flow.density;
            if settings.scheme == Scheme::ImmCt && settings.cement.relaxation_time > 0.0 {
                let elastic = |dt: Real| {
                    let lambda = settings.cement.relaxation_time;
                    let polymer = flow.stiffness * lambda * libm::tanh(dt / (2.0 * lambda)) * 2.4;
                    // The stabiliser takes up to a tenth of the viscous limit on top.
                    let solvent =
                        settings.cement.liquid.viscosity * 6.05 + 0.1 * rho * dx * dx / dt * 6.05;
                    dt * (polymer + solvent) / (dx * dx) < 2.0 * rho
                };
                limit(0.5 * bisect(elastic, max), Limit::Elastic);
            } else {
                limit(
                    0.12 * rho * dx * dx / flow.viscosity.max(1e-12),
                    Limit::Viscous,
                );
            }
        }
    }
    (best.0.max(min), best.1)
}

/// Largest dt in (0, max] with `holds(dt)`, for a bound that is monotone.
fn bisect(holds: impl Fn(Real) -> bool, max: Real) -> Real {
    if holds(max) {
        return max;
    }
    let (mut low, mut high) = (0.0, max);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
