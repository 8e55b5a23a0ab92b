//! Everything that a simulation needs to be told, in SI.

use crate::fluid::Cement;
use crate::math::{Aabb, Real, Vec3};
use crate::solid::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A whole simulation: what, where, how finely, how long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimSettings {
    /// Which list of terms a step is.
    pub scheme: Scheme,
    /// How the viscoelastic stress is stepped.
    pub stress: StressStep,
    /// What a coupled step does with elastic waves.
    pub elastic_waves: ElasticWaves,
    /// θ of a coupled step: which velocity between start (0) and end (1) of a step its forces act on. 1 damps what the
    /// step does not resolve, 1/2 is of second order and rings.
    pub theta: Real,
    /// Distance between particles at rest [m].
    pub spacing: Real,
    /// Support radius of the kernel, in spacings.
    pub support_ratio: Real,
    /// Simulated time [s].
    pub duration: Real,
    /// Frames per simulated second [1/s].
    pub frames_per_second: Real,
    /// Body acceleration [m/s²].
    pub gravity: Vec3,
    /// Which axes wrap around at `domain`.
    pub periodic: [bool; 3],
    /// The region of the simulation [m]: particles that leave it have escaped.
    pub domain: Aabb,
    /// Fixed or adaptive time step.
    pub time_step: TimeStep,
    /// How far solvers go: their goals for volume strain and velocity, as a multiple of the usual ones [1].
    pub tolerance: Real,
    /// What flows.
    pub cement: Cement,
    /// Fluid that is there at the start.
    pub bodies: Vec<Body>,
    /// Fluid that comes in.
    pub inlets: Vec<Inlet>,
    /// Seed of everything random (start jitter).
    pub seed: u64,
    /// Start jitter of the lattice, in spacings.
    pub jitter: Real,
    /// Whether the energy's ways are kept account of: some passes over the pairs more a step; changes no other bit.
    pub energy_balance: bool,
    /// Skip what a scene does not need (mixture work of a single phase); changes speed, never bits.
    pub skip_unneeded: bool,
}

/// The three schemes that the paper compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Divergence-free SPH: one velocity, viscosity of the mixture, fractions fixed on particles.
    Dfsph,
    /// Implicit mixture model: two phase velocities, Newtonian viscosity (Eq. 7).
    Imm,
    /// Implicit mixture model with conformation tensor (Eqs 10–16).
    ImmCt,
}

impl Scheme {
    /// The word for it in recipes and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dfsph => "dfsph",
            Self::Imm => "imm",
            Self::ImmCt => "imm_ct",
        }
    }
}

/// How viscous and viscoelastic stress are stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StressStep {
    /// Explicit stress, pressure solved apart: small steps.
    Explicit,
    /// Velocity, pressure and stress in one implicit solve: steps at the CFL limit.
    Coupled,
    /// Step by step: explicit where its limits allow the step of the coupled solve, coupled where they bind.
    Auto,
}

impl StressStep {
    /// The word for it in recipes and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit => "explicit",
            Self::Coupled => "coupled",
            Self::Auto => "auto",
        }
    }
}

/// Elastic waves in a coupled step: whether noise is damped at their cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ElasticWaves {
    /// Flow that follows its driving, as in bone: waves are damped, noise dies soonest.
    #[default]
    Damped,
    /// Flow that swings: waves longer than a few spacings are kept, and so is more noise.
    Resolved,
}

impl ElasticWaves {
    /// θ that suits them.
    pub fn theta(self) -> Real {
        match self {
            Self::Damped => 1.0,
            Self::Resolved => 0.55,
        }
    }
}

/// Time-step control.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// Always this step [s].
    Fixed(Real),
    /// As large as the limits allow.
    Adaptive {
        /// Never below [s].
        min: Real,
        /// Never above [s].
        max: Real,
        /// Fraction of a spacing that a particle may move in a step.
        cfl: Real,
    },
}

/// Fluid that is there at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Region that it fills (where no wall is).
    pub shape: BodyShape,
    /// α of the polymer phase [1].
    pub polymer_fraction: Real,
    /// Start velocity [m/s].
    pub velocity: Vec3,
    /// Whether it fills pores to their walls: as many particles as there is room for, those too near to a wall moved off
    /// it. Otherwise these are left out.
    #[serde(default)]
    pub saturated: bool,
}

/// A region of fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum BodyShape {
    /// A box [m].
    Box(Aabb),
    /// A sphere.
    Sphere {
        /// Centre [m].
        centre: Vec3,
        /// Radius [m].
        radius: Real,
    },
    /// A capped cylinder.
    Cylinder {
        /// Centre of the first cap [m].
        base: Vec3,
        /// Unit vector to the second cap.
        axis: Vec3,
        /// Distance between the caps [m].
        length: Real,
        /// Radius [m].
        radius: Real,
    },
    /// The inside of a mesh.
    Mesh(#[serde(skip)] Inside),
}

/// The inside of a mesh: its bounds and its signed distance, once it has been read.
#[derive(Clone, Debug, Default)]
pub struct Inside(pub Option<Arc<(Aabb, Solid)>>);

/// Settings are what was told; what a file holds is compared where it is read.
impl PartialEq for Inside {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A round opening from which fluid is pressed at a given rate; the cannula's wall is part of the solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inlet {
    /// What the tables call it.
    pub name: String,
    /// Centre of the plane where fluid enters the simulation [m].
    pub position: Vec3,
    /// Unit vector of the flow.
    pub direction: Vec3,
    /// Inner diameter [m].
    pub diameter: Real,
    /// Volume per time [m³/s].
    pub flow_rate: Real,
    /// α of the polymer phase [1].
    pub polymer_fraction: Real,
    /// Volume after which it stops [m³].
    pub dose: Real,
}
