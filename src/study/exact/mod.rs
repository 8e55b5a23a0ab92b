//! Exact solutions and measurements by others, that cases are held against.

mod bessel;
mod channel;
mod dam;
mod giesekus;
mod spheres;
mod startup;

pub use channel::{Thinning, giesekus_channel};
pub use dam::DAM_FRONT;
pub use giesekus::{SteadyShear, extension, steady_shear};
pub use spheres::{SIMPLE_CUBIC, permeability, radius as sphere_radius};
pub use startup::{Fluid, Start, couette, mode, pipe_poiseuille, plane_poiseuille};
