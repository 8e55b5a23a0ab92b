//! Exact solutions and measurements by others, that cases are held against.

mod bessel;
mod channel;
mod giesekus;
mod startup;

pub use channel::{Thinning, giesekus_channel};
pub use giesekus::{SteadyShear, extension, steady_shear};
pub use startup::{Fluid, Start, couette, mode, pipe_poiseuille, plane_poiseuille};
