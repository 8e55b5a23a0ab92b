//! What an OBJ file does not say of itself: its unit and its vertical axis.

use crate::math::{Real, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Unit of the coordinates in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LengthUnit {
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
}

impl LengthUnit {
    /// Metres per unit.
    pub fn metres(self) -> Real {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
        }
    }

    /// Decimals that show a tenth of a micrometre.
    pub(super) fn decimals(self) -> u32 {
        match self {
            Self::Metre => 7,
            Self::Centimetre => 5,
            Self::Millimetre => 4,
        }
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
        })
    }
}

/// Vertical axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// As artists' tools have it.
    Y,
    /// As inside this program.
    Z,
}

impl UpAxis {
    /// From the file's axes to ours.
    pub(super) fn inward(self, p: &Vec3) -> Vec3 {
        match self {
            Self::Y => Vec3::new(p.x, -p.z, p.y),
            Self::Z => *p,
        }
    }

    /// From our axes to the file's.
    pub(super) fn outward(self, p: &Vec3) -> Vec3 {
        match self {
            Self::Y => Vec3::new(p.x, p.z, -p.y),
            Self::Z => *p,
        }
    }
}

impl std::fmt::Display for UpAxis {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}
