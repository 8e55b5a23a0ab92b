//! State, the step of each scheme, time-step control, inlets, health, ledger. Opens no file, prints nothing.

mod settings;

pub use settings::{
    Body, BodyShape, Cement, Inlet, PhaseMaterial, Scheme, SimSettings, StressStep, TimeStep,
};
