//! What a bone is to be like inside.

use crate::math::{Aabb, Real, Vec3};
use crate::solid::Shape;
use serde::{Deserialize, Serialize};

/// Shell and trabeculae of a bone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoneSettings {
    /// Thickness of the cortical shell [m].
    pub shell_thickness: Real,
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
            regions: vec![Region {
                name: "spongiosa".into(),
                place: Place::Everywhere,
                period: 2e-3,
                struts: Struts::Diameter(0.7e-3),
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
}

/// Thickness of struts, told or asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Struts {
    /// Mean diameter of the horizontal struts [m]; each is up to a fifth thicker or thinner.
    Diameter(Real),
    /// Share of the region that is pores [1]: the diameter follows.
    Porosity(Real),
}

/// A part of space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// All of it.
    Everywhere,
    /// A box [m].
    Box(Aabb),
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// Centre [m].
        centre: Vec3,
        /// Half lengths along x, y, z [m].
        semi_axes: Vec3,
    },
    /// The side of a plane that `normal` points to.
    HalfSpace {
        /// A point on the plane [m].
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
    },
}

impl Place {
    /// Whether it holds `x`.
    pub fn holds(&self, x: &Vec3) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Box(bounds) => bounds.contains(x),
            Self::Ellipsoid { centre, semi_axes } => {
                (x - centre).component_div(semi_axes).norm_squared() <= 1.0
            }
            Self::HalfSpace { point, normal } => (x - point).dot(normal) >= 0.0,
        }
    }
}

/// A bore through the bone, such as a cannula leaves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Centre of one end [m].
    pub base: Vec3,
    /// Unit vector to the other end.
    pub axis: Vec3,
    /// Length [m].
    pub length: Real,
    /// Radius [m].
    pub radius: Real,
}

impl Channel {
    /// Everything but the bore, as a solid.
    pub fn bore(&self) -> Shape {
        Shape::Cylinder {
            base: self.base,
            axis: self.axis,
            length: self.length,
            radius: self.radius,
            hollow: true,
        }
    }

    /// A tube of wall `thickness` [m] around the bore.
    pub fn tube(&self, thickness: Real) -> Shape {
        Shape::Tube {
            base: self.base,
            axis: self.axis,
            length: self.length,
            inner: self.radius,
            outer: self.radius + thickness,
        }
    }
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
    /// Index of the region that decides at `x`.
    pub fn region_at(&self, x: &Vec3) -> usize {
        let found = self.regions.iter().position(|region| region.place.holds(x));
        found.unwrap_or(self.regions.len() - 1)
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
                Struts::Porosity(p) => number(
                    &key("struts"),
                    p,
                    p > 0.0 && p < 1.0,
                    "a porosity between 0 and 1",
                )?,
            }
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

const MAX_REGIONS: usize = 200;
