//! What a recipe says about the bone.

use super::place::{BoxRecipe, EllipsoidRecipe, PlaneRecipe, SphereRecipe};
use crate::bone::Preset;
use crate::math::Real;
use crate::mesh::{LengthUnit, UpAxis};
use crate::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A bone: its outer surface as a mesh, and what is inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneRecipe {
    /// OBJ file, relative to the recipe.
    pub mesh: String,
    /// What a 1 in the file is.
    pub unit: LengthUnit,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Whether the recipe's points are the bone's own.
    #[serde(default)]
    pub frame: BoneFrame,
    /// Cortex, endplates and trabeculae of a state of health, for what is not given.
    pub preset: Option<Preset>,
    /// Enlarges the preset's lengths: 1 is anatomical.
    pub scale: Option<Real>,
    /// Thickness of the cortical shell.
    pub cortex: Option<Length>,
    /// Its thickness where it faces up or down; as the cortex if not given.
    pub endplate: Option<Length>,
    /// A volume that regions take their porosity from.
    pub volume: Option<VolumeRecipe>,
    /// Trabecular regions; the first that holds a point counts there.
    #[serde(default)]
    pub region: Vec<RegionRecipe>,
    /// Cracks through shell and trabeculae.
    #[serde(default)]
    pub crack: Vec<CrackRecipe>,
    /// Veins and other canals out of the bone.
    #[serde(default)]
    pub vein: Vec<VeinRecipe>,
}

/// Where the origin and the axes of the recipe lie in the bone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum BoneFrame {
    /// Origin in the centre of the vertebral body, x to the left, y to the back, z up.
    #[default]
    #[serde(rename = "anatomical")]
    Anatomical,
    /// As in the file, turned z up.
    #[serde(rename = "as is")]
    AsIs,
}

/// A density volume from a CT or from an artist's program, in the same space as the bone's mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeRecipe {
    /// OpenVDB file, relative to the recipe.
    pub path: String,
    /// Which of its grids; the first if not given.
    pub grid: Option<String>,
    /// What a 1 in it is.
    pub holds: VolumeMeaning,
    /// What a 1 in the file's coordinates is.
    pub unit: LengthUnit,
    /// Which axis of the file points up.
    pub up: UpAxis,
}

/// What a volume tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum VolumeMeaning {
    /// 1 is all bone.
    #[serde(rename = "bone fraction")]
    BoneFraction,
    /// 1 is all open.
    #[serde(rename = "porosity")]
    Porosity,
}

/// Trabecular bone somewhere inside: struts of a period, thick by diameter or by the porosity they leave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionRecipe {
    /// What the report calls it.
    pub name: String,
    /// Inside this box,
    pub r#box: Option<BoxRecipe>,
    /// or this ellipsoid,
    pub ellipsoid: Option<EllipsoidRecipe>,
    /// or this ball,
    pub sphere: Option<SphereRecipe>,
    /// or on the side of a plane that its normal points to,
    pub plane: Option<PlaneRecipe>,
    /// or nearest to the faces of this OBJ group or material; none of these: everywhere else.
    pub part: Option<String>,
    /// Distance from strut to strut.
    pub strut_period: Length,
    /// Thickness of a strut,
    pub strut_diameter: Option<Length>,
    /// or the open fraction to be met [1],
    pub porosity: Option<Real>,
    /// or one that changes from point to point,
    pub gradient: Option<GradientRecipe>,
    /// or one that the mesh's vertex colours tell,
    pub painted: Option<PaintedRecipe>,
    /// or the bone's volume, kept within these porosities [1].
    pub volume: Option<[Real; 2]>,
    /// Share of struts that ageing has taken, horizontal ones first [1].
    #[serde(default)]
    pub lost: Real,
}

/// Porosity changes linearly between two points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradientRecipe {
    /// Where the first value holds.
    pub from: [Length; 3],
    /// Where the second value holds.
    pub to: [Length; 3],
    /// Porosities there [1].
    pub values: [Real; 2],
}

/// Porosity by the brightness of vertex colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaintedRecipe {
    /// Porosity of black [1].
    pub black: Real,
    /// Porosity of white [1].
    pub white: Real,
}

/// A crack: a box, or a slit along a plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackRecipe {
    /// What reports call it.
    pub name: String,
    /// A box that is open: alone, or the part of the plane that is.
    pub r#box: Option<BoxRecipe>,
    /// Its plane,
    pub plane: Option<PlaneRecipe>,
    /// and its width across the plane.
    pub aperture: Option<Length>,
}

/// A canal along a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VeinRecipe {
    /// What reports call it.
    pub name: String,
    /// Points along its middle.
    pub points: Vec<[Length; 3]>,
    /// Its width.
    pub diameter: Length,
}
