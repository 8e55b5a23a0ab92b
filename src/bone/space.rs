//! Parts of space in and around a bone: where regions are, and what is open.

use crate::math::{Aabb, Real, Vec3};
use crate::solid::Shape;
use serde::{Deserialize, Serialize};

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
    /// Nearest to the part of the bone's mesh (OBJ group or material) of this number in [`super::Sources`].
    Part(u32),
}

impl Place {
    /// Whether it holds `x`, which is nearest to `part` of the mesh.
    pub fn holds(&self, x: &Vec3, part: impl FnOnce() -> Option<u32>) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Part(wanted) => part() == Some(*wanted),
            Self::Box(bounds) => bounds.contains(x),
            Self::Ellipsoid { centre, semi_axes } => {
                (x - centre).component_div(semi_axes).norm_squared() <= 1.0
            }
            Self::HalfSpace { point, normal } => (x - point).dot(normal) >= 0.0,
        }
    }
}

/// A named way through the bone, so that what leaks there can be told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opening {
    /// What reports call it.
    pub name: String,
    /// What is open.
    pub shape: OpeningShape,
}

/// What an opening takes away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OpeningShape {
    /// A box.
    Box(Aabb),
    /// A slit along a plane.
    Slit {
        /// A point on the plane [m].
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
        /// Width across the plane [m].
        aperture: Real,
        /// Only inside this box.
        within: Option<Aabb>,
    },
    /// A canal along a line through points, such as a vein.
    Canal {
        /// Points along its middle [m].
        points: Vec<Vec3>,
        /// Radius [m].
        radius: Real,
    },
}

impl OpeningShape {
    /// How deep `x` lies in the opening [m], negative outside.
    pub fn depth(&self, x: &Vec3) -> Real {
        let in_box = |bounds: &Aabb| (x - bounds.min).min().min((bounds.max - x).min());
        match self {
            Self::Box(bounds) => in_box(bounds),
            Self::Slit {
                point,
                normal,
                aperture,
                within,
            } => {
                let depth = 0.5 * aperture - (x - point).dot(normal).abs();
                within.as_ref().map_or(depth, |b| depth.min(in_box(b)))
            }
            Self::Canal { points, radius } => {
                let along = points.windows(2).map(|ends| {
                    let axis = ends[1] - ends[0];
                    let t = (x - ends[0]).dot(&axis) / axis.norm_squared().max(1e-30);
                    (x - ends[0] - axis * t.clamp(0.0, 1.0)).norm()
                });
                radius - along.fold(Real::INFINITY, Real::min)
            }
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
