//! What a recipe says about probes.

use crate::math::Real;
use crate::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A gauge whose readings go to `probes.csv`, a row a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeRecipe {
    /// What its columns begin with.
    pub name: String,
    /// Mean pressure in a ball,
    pub pressure: Option<PressureRecipe>,
    /// or volume per time through a disc,
    pub flux: Option<FluxRecipe>,
    /// or how far the fluid reaches and where its centre is (`true`),
    #[serde(default)]
    pub extents: bool,
    /// or velocities along a line.
    pub profile: Option<ProfileRecipe>,
}

/// Where pressure is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureRecipe {
    /// Centre of the ball.
    pub centre: [Length; 3],
    /// Its radius.
    pub radius: Length,
}

/// Where flow is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluxRecipe {
    /// Centre of the disc.
    pub point: [Length; 3],
    /// Its normal, along which flow counts; any length but zero.
    pub normal: [Real; 3],
    /// Its radius.
    pub radius: Length,
}

/// Where velocities are measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileRecipe {
    /// Where the line begins.
    pub from: [Length; 3],
    /// Where it ends.
    pub to: [Length; 3],
    /// How far off the line fluid counts.
    pub radius: Length,
    /// Which component; any length but zero.
    pub direction: [Real; 3],
    /// How many equal parts.
    pub parts: u32,
}
