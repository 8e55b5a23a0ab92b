//! A bone's mesh → cortical shell, trabeculae, porosity that varies in space.

mod build;
mod hold;
pub mod landmarks;
mod network;
mod nodes;
mod permeability;
mod pockets;
mod preset;
mod report;
mod settings;
mod share;
mod sources;
mod space;
mod thickness;
mod thin;
pub mod vertebra;

pub use build::{BAND, build};
pub use network::Strut;
pub use permeability::Sample;
pub use preset::{HEALTHY_POROSITY, Preset};
pub use report::{ACROSS, BoneReport, Reach, RegionReport};
pub use settings::{BoneError, BoneSettings, Region, Struts, Varying};
pub use sources::{Sources, Volume};
pub use space::{Channel, Opening, OpeningShape, Place};

use crate::grid::BrickGrid;

/// A bone with its inside.
#[derive(Clone, Debug)]
pub struct Bone {
    /// φ [m]: positive outside and in the pores, negative in bone, exact within ±[`BAND`] spacings of the surface.
    pub solid: BrickGrid,
    /// The trabeculae, in pieces where porosity varies; where they leave the bone, φ cuts them off.
    pub struts: Vec<Strut>,
    /// What it turned out to be.
    pub report: BoneReport,
}

#[cfg(test)]
mod tests;
