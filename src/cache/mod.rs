//! What stages leave for one another on disk: boundary files, frames, tables, the state of a stopped run.

mod atomic;
mod boundary;
mod container;
mod error;
mod frame;
mod restart;
mod table;

pub use atomic::{write, write_json};
pub use boundary::{read_solid, read_walls, write_solid, write_walls};
pub use error::CacheError;
pub use frame::{read_frame, write_frame};
pub use restart::{Restart, read_restart, write_restart};
pub use table::Table;

/// One picture of the cement in time: what `surface`, `export` and `preview` read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// n; frame 0 is the start.
    pub index: u32,
    /// n / frames per second [s].
    pub time: f64,
    /// Distance between particles at rest [m].
    pub spacing: f64,
    /// Support radius of the kernel [m].
    pub support_radius: f64,
    /// Rest volume of a particle [m³].
    pub rest_volume: f64,
    /// Positions, metres, z up.
    pub position: Vec<[f32; 3]>,
    /// Mixture velocity [m/s].
    pub velocity: Vec<[f32; 3]>,
    /// α of the polymer phase [1].
    pub polymer_fraction: Vec<f32>,
    /// Pressure [Pa].
    pub pressure: Vec<f32>,
    /// Identity of each particle, the same in all frames.
    pub id: Vec<u32>,
}
