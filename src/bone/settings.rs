//! What a bone is to be like inside.

use super::space::{Opening, Place};
use crate::math::{Aabb, Real, Vec3};
use serde::{Deserialize, Serialize};

/// Shell and trabeculae of a bone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoneSettings {
    /// Thickness of the cortical shell [m].
    pub shell_thickness: Real,
    /// Thickness of the shell where it faces up or down, the endplates [m].
    pub endplate_thickness: Real,
    /// Ways through the shell and what is behind it: cracks, veins.
    pub openings: Vec<Opening>,
    /// Trabeculae by place: the first region that holds a point decides; the last one must be everywhere.
    pub regions: Vec<Region>,
    /// How far a node of the network strays from its lattice, in strut periods: 0 regular, 0.45 natural.
    pub jitter: Real,
    /// Diameter of the vertical struts, in those of the others: trabeculae are thicker along the load.
    pub vertical: Real,
    /// Seed of the network.
    pub seed: u64,
    /// Nodes of the distance grid along a particle spacing.
    pub nodes_per_spacing: Real,
    /// Builds only what lies in this box [m], for a quick look: around it everything is open. What is built is the
    /// same as in the whole bone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Aabb>,
}

impl Default for BoneSettings {
    /// At teaching scale: pores a few millimetres wide, in which particles of half a millimetre can flow.
    fn default() -> Self {
        Self {
            shell_thickness: 0.8e-3,
            endplate_thickness: 0.8e-3,
            openings: Vec::new(),
            regions: vec![Region {
                name: "spongiosa".into(),
                place: Place::Everywhere,
                period: 2e-3,
                struts: Struts::Diameter(0.7e-3),
                lost: 0.0,
            }],
            jitter: 0.45,
            vertical: 1.15,
            seed: 1,
            nodes_per_spacing: 3.0,
            within: None,
        }
    }
}

/// A part of the spongy bone and its trabeculae.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// What the report calls it.
    pub name: String,
    /// Where it is, in the frame of the bone's mesh.
    pub place: Place,
    /// Edge of the cube that holds one node of the strut network [m].
    pub period: Real,
    /// How thick the struts are.
    pub struts: Struts,
    /// Share of the struts that ageing has taken [1]: of horizontal ones four times as many as of vertical ones, and
    /// never one on which the hold of others depends.
    #[serde(default)]
    pub lost: Real,
}

/// Thickness of struts, told or asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Struts {
    /// Mean diameter of the horizontal struts [m]; each is up to a fifth thicker or thinner.
    Diameter(Real),
    /// Share of the region that is pores [1]: the diameter follows.
    Porosity(Real),
    /// The same, varying in space: struts taper.
    Varying(Varying),
}

/// Where a porosity that varies in space comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Varying {
    /// Linear from one point to another, constant beyond them.
    Gradient {
        /// Where the first value holds [m].
        from: Vec3,
        /// Where the second value holds [m].
        to: Vec3,
        /// Porosities there [1].
        values: [Real; 2],
    },
    /// The brightness of the mesh's vertex colours at the nearest point of its surface.
    Painted {
        /// Porosity of black [1].
        black: Real,
        /// Porosity of white [1].
        white: Real,
    },
    /// A volume, such as a CT.
    Volume {
        /// Least porosity [1]: denser voxels count as this.
        least: Real,
        /// Greatest porosity [1].
        most: Real,
    },
}

/// Why a bone cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoneError {
    /// A number out of range.
    #[error("bone.{key}: {value} is not usable: expected {expected}")]
    Setting {
        /// Which setting.
        key: String,
        /// What it is.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// Far too many grid nodes or struts.
    #[error(
        "a bone of {size:.3} m with {key} of {length:.2e} m needs more memory than any machine has: \
         check the mesh's unit, or make it coarser"
    )]
    TooFine {
        /// Longest edge of the bone [m].
        size: Real,
        /// What is too small.
        key: String,
        /// How small [m].
        length: Real,
    },
}

impl BoneSettings {
    /// Thickness of the shell [m] where the surface is passed in direction `across`, of any length: between cortex and
    /// endplate as it is between horizontal and vertical.
    pub fn shell_at(&self, across: &Vec3) -> Real {
        if self.shell_thickness == self.endplate_thickness {
            return self.shell_thickness;
        }
        let upright = across.z.abs() / across.norm().max(1e-30);
        let t = ((upright - 0.6) / 0.3).clamp(0.0, 1.0);
        let smooth = t * t * (3.0 - 2.0 * t);
        self.shell_thickness + (self.endplate_thickness - self.shell_thickness) * smooth
    }

    /// The greater thickness of the shell [m].
    pub(super) fn thickest_shell(&self) -> Real {
        self.shell_thickness.max(self.endplate_thickness)
    }

    pub(super) fn check(&self, spacing: Real) -> Result<(), BoneError> {
        let setting = |key: &str, value: String, ok: bool, expected: &'static str| {
            let key = key.to_owned();
            if ok {
                Ok(())
            } else {
                Err(BoneError::Setting {
                    key,
                    value,
                    expected,
                })
            }
        };
        let number = |key: &str, value: Real, ok: bool, expected| {
            setting(key, value.to_string(), ok && value.is_finite(), expected)
        };
        number("spacing", spacing, spacing > 0.0, "a length above 0")?;
        number(
            "shell_thickness",
            self.shell_thickness,
            self.shell_thickness >= 0.0,
            "a length, or 0 for none",
        )?;
        number(
            "endplate_thickness",
            self.endplate_thickness,
            self.endplate_thickness >= 0.0,
            "a length, or 0 for none",
        )?;
        number(
            "jitter",
            self.jitter,
            (0.0..=0.45).contains(&self.jitter),
            "0 (regular) to 0.45",
        )?;
        number(
            "vertical",
            self.vertical,
            self.vertical > 0.0,
            "a ratio above 0",
        )?;
        number(
            "nodes_per_spacing",
            self.nodes_per_spacing,
            (1.0..=32.0).contains(&self.nodes_per_spacing),
            "1 to 32",
        )?;
        if let Some(within) = &self.within {
            setting(
                "within",
                format!(
                    "from {:?} to {:?}",
                    within.min.as_slice(),
                    within.max.as_slice()
                ),
                within.min <= within.max,
                "a box whose corners are in order",
            )?;
        }
        setting(
            "regions",
            format!("a list of {}", self.regions.len()),
            (1..=MAX_REGIONS).contains(&self.regions.len()),
            "1 to 200 regions",
        )?;
        for (r, region) in self.regions.iter().enumerate() {
            let key = |what: &str| format!("regions[{r}].{what}");
            number(
                &key("period"),
                region.period,
                region.period > 0.0,
                "a length above 0",
            )?;
            match region.struts {
                Struts::Diameter(d) => number(&key("struts"), d, d > 0.0, "a diameter above 0")?,
                Struts::Porosity(p) => {
                    number(&key("struts"), p, p > 0.0 && p < 1.0, POROSITY)?;
                }
                Struts::Varying(varying) => {
                    for p in varying.range() {
                        number(&key("struts"), p, p > 0.0 && p < 1.0, POROSITY)?;
                    }
                }
            }
            number(
                &key("lost"),
                region.lost,
                (0.0..=0.8).contains(&region.lost),
                "a share from 0 to 0.8",
            )?;
        }
        let last = &self.regions[self.regions.len() - 1];
        setting(
            "regions",
            format!("the last region, `{}`,", last.name),
            last.place == Place::Everywhere,
            "the last region to be everywhere",
        )
    }
}

impl Varying {
    /// The least and the greatest porosity that it can ask for.
    pub fn range(&self) -> [Real; 2] {
        let [a, b] = match self {
            Self::Gradient { values, .. } => *values,
            Self::Painted { black, white } => [*black, *white],
            Self::Volume { least, most } => [*least, *most],
        };
        [a.min(b), a.max(b)]
    }
}

const POROSITY: &str = "a porosity between 0 and 1";
const MAX_REGIONS: usize = 200;
