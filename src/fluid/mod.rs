//! Phases, mixture, transfer, bonding network, conformation tensor, stress; knows no time loop.

pub mod bonding;
pub mod conformation;
mod material;
pub mod mixture;
mod particles;
pub mod stress;
pub mod transfer;

pub use material::{Cement, PerPhase, PhaseMaterial};
pub use mixture::MixtureFields;
pub use particles::FluidParticles;
