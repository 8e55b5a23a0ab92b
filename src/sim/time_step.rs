//! The time step, and what limits it.
//!
//! Explicit stress: dt [η_p tanh(dt/2λ) k² + η_s k_L²] < 2ρ, the exact bound of the linear modes, with half of it
//! taken; k² and k_L² are the largest eigenvalues of the operators on a lattice. Coupled: only what the
//! particles may move and strain in a step.

use super::settings::{Scheme, SimSettings, StressStep, TimeStep};
use crate::fluid::stress::most_explicit_stabiliser;
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
    let with = |coupled, stress| {
        let (dt, limit) = shortest(settings, &bounds(settings, flow, coupled));
        (dt, limit, stress)
    };
    match settings.stress {
        StressStep::Explicit => with(false, StressStep::Explicit),
        StressStep::Coupled => with(true, StressStep::Coupled),
        StressStep::Auto => {
            let bounds = bounds(settings, flow, true);
            let (dt, limit) = shortest(settings, &bounds);
            let binds = bounds.iter().any(|bound| bound.lifted && bound.dt < dt);
            (
                dt,
                limit,
                if binds {
                    StressStep::Coupled
                } else {
                    StressStep::Explicit
                },
            )
        }
    }
}

fn shortest(settings: &SimSettings, bounds: &[StepBound]) -> (Real, Limit) {
    let (min, max) = match settings.time_step {
        TimeStep::Fixed(dt) => return (dt, Limit::Fixed),
        TimeStep::Adaptive { min, max, .. } => (min, max),
    };
    let mut best = (max, Limit::Largest);
    for bound in bounds {
        if !bound.lifted && bound.dt < best.0 {
            best = (bound.dt, bound.limit);
        }
    }
    (best.0.max(min), best.1)
}

/// What bounds the step, and how far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StepBound {
    /// By what.
    pub limit: Limit,
    /// The step [s].
    pub dt: Real,
    /// Whether a coupled step does not know it, and this one is coupled.
    pub lifted: bool,
}

/// What bounds the first step of a run.
pub fn bounds_at_start(settings: &SimSettings) -> Vec<StepBound> {
    let cement = &settings.cement;
    let bodies = settings.bodies.iter();
    let inlets = settings.inlets.iter();
    let fractions = bodies.clone().map(|body| body.polymer_fraction);
    let fractions = fractions.chain(inlets.clone().map(|inlet| inlet.polymer_fraction));
    let most = |of: &dyn Fn(Real) -> Real| fractions.clone().map(of).fold(0.0, Real::max);
    let injected = inlets.map(|inlet| {
        let radius = 0.5 * inlet.diameter;
        inlet.flow_rate / (core::f64::consts::PI * radius * radius)
    });
    let flow = FlowMeasures {
        speed: bodies
            .map(|b| b.velocity.norm())
            .chain(injected)
            .fold(0.0, Real::max),
        strain_rate: 0.0,
        stiffness: most(&|alpha| cement.modulus(alpha)),
        viscosity: most(&|alpha| cement.mixture_viscosity(alpha)),
        density: fractions
            .clone()
            .map(|alpha| cement.density(alpha))
            .fold(Real::INFINITY, Real::min),
        pressure: 0.0,
    };
    let known = |bound: &StepBound| bound.dt < 1e3 && bound.dt.is_finite();
    let coupled = settings.stress != StressStep::Explicit;
    bounds(settings, &flow, coupled)
        .into_iter()
        .filter(known)
        .collect()
}

/// Every bound, also those that a coupled step lifts.
fn bounds(settings: &SimSettings, flow: &FlowMeasures, coupled: bool) -> Vec<StepBound> {
    let (max, cfl) = match settings.time_step {
        TimeStep::Fixed(dt) => (dt, 0.4),
        TimeStep::Adaptive { max, cfl, .. } => (max, cfl),
    };
    let (dx, rho) = (settings.spacing, flow.density);
    let cement = &settings.cement;
    let elastic = settings.scheme == Scheme::ImmCt && cement.relaxation_time > 0.0;
    let mut bounds = Vec::with_capacity(8);
    let mut bound = |limit: Limit, dt: Real, lifted: bool| {
        bounds.push(StepBound { limit, dt, lifted });
    };
    bound(Limit::Cfl, cfl * dx / flow.speed.max(1e-12), false);
    if settings.scheme != Scheme::Dfsph {
        bound(
            Limit::Diffusion,
            crate::fluid::transfer::most_diffusion_step(cement, dx),
            false,
        );
    }
    if coupled && settings.scheme == Scheme::ImmCt {
        bound(
            Limit::Strain,
            MOST_STRAIN / flow.strain_rate.max(1e-12),
            false,
        );
    }
    let acceleration = settings.gravity.norm().max(1e-12);
    bound(
        Limit::Acceleration,
        0.25 * (dx / acceleration).sqrt(),
        coupled,
    );
    // p dt²/(ρ dx²) < 0.6: beyond it pressure shakes a disordered packing apart.
    let packing = 0.7 * dx * (rho / flow.pressure.max(1e-12)).sqrt();
    bound(Limit::Packing, packing, coupled);
    if elastic {
        let holds = |dt: Real| {
            let lambda = cement.relaxation_time;
            let polymer = flow.stiffness * lambda * libm::tanh(dt / (2.0 * lambda)) * 2.4;
            let stabiliser = most_explicit_stabiliser(rho, dx, dt);
            let solvent = (cement.liquid.viscosity + stabiliser) * 6.05;
            dt * (polymer + solvent) / (dx * dx) < 2.0 * rho
        };
        bound(Limit::Elastic, 0.5 * bisect(holds, 2.0 * max), coupled);
    } else {
        let viscous = 0.12 * rho * dx * dx / flow.viscosity.max(1e-12);
        bound(Limit::Viscous, viscous, coupled);
    }
    bounds
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
