//! States of health of lumbar bone, as morphometry knows them.
//!
//! | | trabecular porosity | strut period | struts lost | cortex | endplate |
//! |---|--:|--:|--:|--:|--:|
//! | healthy | 0.84 | 0.65 mm | – | 0.45 mm | 0.60 mm |
//! | osteopenic | 0.90 | 0.65 mm | 0.20 | 0.35 mm | 0.50 mm |
//! | osteoporotic | 0.94 | 0.65 mm | 0.45 | 0.30 mm | 0.40 mm |
//!
//! Porosities and shells are those of the literature [Baroud04], [Hildebrand99]. The period is chosen so that creeping
//! flow through osteoporotic bone finds the permeability that lumbar cores have, 3.4 to 4.5e-8 m² [Baroud04]; struts
//! are then 0.17 mm thick, where they were measured to be 0.12 to 0.2 mm. The loss is chosen so that struts that stay
//! keep most of their thickness: what ageing takes are whole struts, horizontal ones first, and the gaps grow.

use super::settings::{Region, Struts};
use super::space::Place;
use crate::math::Real;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A state of health.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// A young adult's.
    Healthy,
    /// Some bone lost.
    Osteopenic,
    /// Much bone lost.
    Osteoporotic,
}

impl Preset {
    /// What the report calls its region.
    pub fn name(self) -> &'static str {
        match self {
            Self::Healthy => "healthy",
            Self::Osteopenic => "osteopenic",
            Self::Osteoporotic => "osteoporotic",
        }
    }

    /// Thickness of the cortical shell [m].
    pub fn cortex(self) -> Real {
        match self {
            Self::Healthy => 0.45e-3,
            Self::Osteopenic => 0.35e-3,
            Self::Osteoporotic => 0.3e-3,
        }
    }

    /// Thickness of the endplates [m].
    pub fn endplate(self) -> Real {
        match self {
            Self::Healthy => 0.6e-3,
            Self::Osteopenic => 0.5e-3,
            Self::Osteoporotic => 0.4e-3,
        }
    }

    /// Its trabeculae, everywhere, all lengths `scale` times as long.
    pub fn region(self, scale: Real) -> Region {
        let (porosity, lost) = match self {
            Self::Healthy => (HEALTHY_POROSITY, 0.0),
            Self::Osteopenic => (0.90, 0.2),
            Self::Osteoporotic => (0.94, 0.45),
        };
        Region {
            name: self.name().to_owned(),
            place: Place::Everywhere,
            period: PERIOD * scale,
            struts: Struts::Porosity(porosity),
            lost,
        }
    }
}

/// Share of healthy trabecular bone that is pores [1].
pub const HEALTHY_POROSITY: Real = 0.84;
/// Edge of the cube that holds one node of the network of healthy struts [m].
const PERIOD: Real = 0.65e-3;
