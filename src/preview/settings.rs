//! What a picture should be like, whatever it shows.

use super::colour::{Colour, from_srgb};
use crate::math::Real;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Size and finish of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PictureSettings {
    /// Width [pixels].
    pub width: u32,
    /// Height [pixels].
    pub height: u32,
    /// Samples a pixel: 1, 4, 9 or 16 (others are rounded down to one of these).
    pub samples: u32,
    /// What is behind everything.
    pub background: Background,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 960,
            samples: 4,
            background: Background::Light,
        }
    }
}

/// The backdrop, and with it the colour of the lettering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Background {
    /// A light studio wall that darkens towards the floor.
    Light,
    /// A dark studio wall.
    Dark,
    /// Plain white, for print.
    White,
}

impl Background {
    /// Its light.
    pub(super) fn wall(self) -> Wall {
        let (bright, dim) = match self {
            Self::White => ([255; 3], [255; 3]),
            Self::Light => ([246, 247, 248], [204, 209, 215]),
            Self::Dark => ([58, 64, 74], [17, 19, 23]),
        };
        Wall {
            bright: from_srgb(bright),
            dim: from_srgb(dim),
        }
    }

    /// sRGB colours of lettering and of the halo around it.
    pub(super) fn ink(self) -> ([u8; 3], [u8; 3]) {
        match self {
            Self::Light | Self::White => ([38, 44, 54], [246, 247, 248]),
            Self::Dark => ([232, 235, 240], [17, 19, 23]),
        }
    }
}

/// A wall with a soft glow a little above its middle.
pub(super) struct Wall {
    bright: Colour,
    dim: Colour,
}

impl Wall {
    /// Linear colour at `x`, `y`, both from −1 to 1, y up.
    pub fn at(&self, x: Real, y: Real) -> Colour {
        let from_glow = x * x * 0.35 + (y - 0.25) * (y - 0.25) * 0.55;
        let dimming = from_glow.min(1.0);
        self.bright + (self.dim - self.bright) * (dimming * (2.0 - dimming))
    }
}
