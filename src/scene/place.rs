//! What a recipe says about where things are: bodies, walls, the bone, inlets.
//!
//! A region is one of several keys (`box`, `sphere`, …), all optional here: errors then keep their line, which
//! serde's tagged enums would lose.

use crate::math::Real;
use crate::mesh::{LengthUnit, UpAxis};
use crate::units::{FlowRate, Frequency, Length, Quoted, Time, Velocity, Volume};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxRecipe {
    /// Lower corner.
    pub min: [Length; 3],
    /// Upper corner.
    pub max: [Length; 3],
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereRecipe {
    /// Centre.
    pub centre: [Length; 3],
    /// Radius.
    pub radius: Length,
}

/// A capped cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderRecipe {
    /// Centre of the first cap.
    pub base: [Length; 3],
    /// Towards the second cap; any length but zero.
    pub axis: [Real; 3],
    /// Distance between the caps.
    pub length: Length,
    /// Radius.
    pub radius: Length,
}

/// Everything behind a plane is solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneRecipe {
    /// A point on it.
    pub point: [Length; 3],
    /// Into the open; any length but zero.
    pub normal: [Real; 3],
}

/// An ellipsoid along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidRecipe {
    /// Centre.
    pub centre: [Length; 3],
    /// Half axes along x, y, z.
    pub radii: [Length; 3],
}

/// Fluid at the start: one region, filled where no wall is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyRecipe {
    /// A box of fluid,
    pub r#box: Option<BoxRecipe>,
    /// or a ball,
    pub sphere: Option<SphereRecipe>,
    /// or a cylinder,
    pub cylinder: Option<CylinderRecipe>,
    /// or the inside of a mesh.
    pub mesh: Option<MeshRecipe>,
    /// α of the polymer phase [1].
    pub polymer_fraction: Real,
    /// Start velocity; at rest if not given.
    pub velocity: Option<[Velocity; 3]>,
    /// Fills pores to their walls: as many particles as there is room for.
    #[serde(default)]
    pub saturated: bool,
}

/// A solid: one region; with `hollow` everything outside it is solid instead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallRecipe {
    /// A box,
    pub r#box: Option<BoxRecipe>,
    /// or a ball,
    pub sphere: Option<SphereRecipe>,
    /// or a cylinder,
    pub cylinder: Option<CylinderRecipe>,
    /// or everything behind a plane,
    pub plane: Option<PlaneRecipe>,
    /// or a closed mesh.
    pub mesh: Option<MeshRecipe>,
    /// A container: solid outside instead of inside.
    #[serde(default)]
    pub hollow: bool,
    /// It stands still,
    pub turning: Option<TurningRecipe>,
    /// or turns, or moves on,
    pub moving: Option<MovingRecipe>,
    /// or swings to and fro.
    pub oscillating: Option<OscillatingRecipe>,
}

/// A wall that turns about an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurningRecipe {
    /// A point on the axis.
    pub point: [Length; 3],
    /// Anticlockwise around it; any length but zero.
    pub axis: [Real; 3],
    /// Turns per time; below zero: clockwise.
    pub rate: Frequency,
    /// Time in which it comes up to that; at once if not given.
    pub ramp: Option<Time>,
}

/// A wall that moves straight on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovingRecipe {
    /// Where to, how fast.
    pub velocity: [Velocity; 3],
    /// How far; never stops if not given.
    pub travel: Option<Length>,
    /// Time in which it comes up to its speed; at once if not given.
    pub ramp: Option<Time>,
}

/// A wall that swings to and fro about its place: shift = amplitude · sin(2π frequency t).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OscillatingRecipe {
    /// Half of the whole way.
    pub amplitude: [Length; 3],
    /// How often.
    pub frequency: Frequency,
    /// Time in which it comes up to that; at once if not given.
    pub ramp: Option<Time>,
}

/// A mesh file, and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshRecipe {
    /// OBJ file, relative to the recipe.
    pub path: String,
    /// What a 1 in the file is.
    pub unit: LengthUnit,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Where the file's origin is put; where it is if not given.
    pub at: Option<[Length; 3]>,
}

/// A round opening from which cement is pressed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InletRecipe {
    /// What the tables call it.
    pub name: String,
    /// Centre of the opening; with a cannula: of its tip.
    pub position: [Length; 3],
    /// Of the flow; any length but zero.
    pub direction: [Real; 3],
    /// Inner diameter.
    pub diameter: Length,
    /// The tube that leads there.
    pub cannula: Option<CannulaRecipe>,
    /// Volume per time.
    pub flow_rate: FlowRate,
    /// Liquid to polymer by volume, `"0.45:0.55"`,
    pub ratio: Option<Ratio>,
    /// or α of the polymer phase [1].
    pub polymer_fraction: Option<Real>,
    /// Volume after which it stops.
    pub dose: Volume,
}

/// A cannula, of which the end is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CannulaRecipe {
    /// Simulated length, back from the tip.
    pub length: Length,
    /// Outer diameter; its wall is simulated at least two spacings thick, outwards, or it would leak.
    pub outer_diameter: Length,
    /// Bone is cleared this far before its tip.
    pub clearance: Length,
    /// Length of the whole tube; the simulated part if not given.
    pub shaft: Option<Length>,
}

/// Liquid to polymer by volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// Parts of liquid.
    pub liquid: Real,
    /// Parts of polymer.
    pub polymer: Real,
}

impl Ratio {
    /// α of the polymer phase [1].
    pub fn polymer_fraction(self) -> Real {
        self.polymer / (self.liquid + self.polymer)
    }
}

impl FromStr for Ratio {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("expected a ratio liquid : polymer such as \"0.45:0.55\", found {text:?}");
        let part = |part: &str| part.trim().parse::<Real>().ok();
        let (liquid, polymer) = text.split_once(':').ok_or_else(expected)?;
        let (Some(liquid), Some(polymer)) = (part(liquid), part(polymer)) else {
            return Err(expected());
        };
        let sum = liquid + polymer;
        if liquid >= 0.0 && polymer >= 0.0 && sum > 0.0 && sum.is_finite() {
            Ok(Self { liquid, polymer })
        } else {
            Err(expected())
        }
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.liquid, self.polymer)
    }
}

impl JsonSchema for Ratio {
    fn schema_name() -> Cow<'static, str> {
        "Ratio".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "liquid to polymer by volume",
            "examples": ["0.45:0.55"],
        })
    }
}

impl Serialize for Ratio {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Ratio {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer
            .deserialize_any(Quoted("expected a ratio such as \"0.45:0.55\""))?
            .parse()
            .map_err(D::Error::custom)
    }
}
