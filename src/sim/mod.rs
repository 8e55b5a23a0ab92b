//! State, the step of each scheme, time-step control, inlets, health, ledger. Opens no file, prints nothing.

mod compression;
mod contact;
mod energy;
mod forces;
mod health;
mod inlet;
mod ledger;
mod motion;
mod motion_law;
mod mover;
mod outlook;
mod probe;
mod room;
mod schemes;
mod settings;
mod shifting;
mod simulation;
mod solves;
mod start;
mod state;
mod stepper;
mod time_step;

pub use crate::fluid::{Cement, PhaseMaterial};
pub use energy::Energy;
pub use health::{SimError, Symptom};
pub use inlet::InletState;
pub use ledger::{Ledger, Tally};
pub use motion_law::{Motion, Path, Pose, Twist};
pub use mover::MovingSolid;
pub use probe::{Gauge, Probe, Sample};
pub use settings::{
    Body, BodyShape, ElasticWaves, Inlet, Inside, Scheme, SimSettings, StressStep, TimeStep,
};
pub use simulation::{Simulation, StepReport};
pub use state::{InletProgress, Progress, State};
pub use time_step::{Limit, StepBound, bounds_at_start};
