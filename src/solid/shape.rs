//! Solids with a closed formula for their distance.

use crate::math::{Aabb, Real, Vec3};
use serde::{Deserialize, Serialize};

/// A primitive; `hollow` ones are solid outside (containers), the others inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// Everything behind a plane; `normal` (unit) points into the open.
    HalfSpace {
        /// A point on the plane [m].
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
    },
    /// A box.
    Box {
        /// Lower corner [m].
        min: Vec3,
        /// Upper corner [m].
        max: Vec3,
        /// Solid outside instead of inside.
        hollow: bool,
    },
    /// A sphere.
    Sphere {
        /// Centre [m].
        centre: Vec3,
        /// Radius [m].
        radius: Real,
        /// Solid outside instead of inside.
        hollow: bool,
    },
    /// A capped cylinder.
    Cylinder {
        /// Centre of the first cap [m].
        base: Vec3,
        /// Unit vector from the first cap to the second.
        axis: Vec3,
        /// Distance between the caps [m].
        length: Real,
        /// Radius [m].
        radius: Real,
        /// Solid outside instead of inside.
        hollow: bool,
    },
    /// A tube wall: solid between the two radii, open at both ends.
    Tube {
        /// Centre of the first end [m].
        base: Vec3,
        /// Unit vector along the tube.
        axis: Vec3,
        /// Length [m].
        length: Real,
        /// Inner radius [m].
        inner: Real,
        /// Outer radius [m].
        outer: Real,
    },
}

impl Shape {
    /// The smallest box around its surface [m]; none where that has no end.
    pub fn bounds(&self) -> Option<Aabb> {
        let capped = |base: &Vec3, axis: &Vec3, length: Real, radius: Real| {
            // A disc of radius r across the axis reaches r √(1 − a²) along a coordinate.
            let reach = axis.map(|a| radius * (1.0 - a * a).max(0.0).sqrt());
            let top = base + axis * length;
            Aabb {
                min: base.inf(&top) - reach,
                max: base.sup(&top) + reach,
            }
        };
        Some(match self {
            Self::HalfSpace { .. } => return None,
            Self::Box { min, max, .. } => Aabb {
                min: *min,
                max: *max,
            },
            Self::Sphere { centre, radius, .. } => Aabb {
                min: *centre,
                max: *centre,
            }
            .grown(*radius),
            Self::Cylinder {
                base,
                axis,
                length,
                radius,
                ..
            } => capped(base, axis, *length, *radius),
            Self::Tube {
                base,
                axis,
                length,
                outer,
                ..
            } => capped(base, axis, *length, *outer),
        })
    }

    /// Whether everything outside it is solid.
    pub fn is_hollow(&self) -> bool {
        matches!(
            self,
            Self::Box { hollow: true, .. }
                | Self::Sphere { hollow: true, .. }
                | Self::Cylinder { hollow: true, .. }
        )
    }

    /// φ [m] at `x` and its unit gradient.
    pub fn distance(&self, x: &Vec3) -> (Real, Vec3) {
        match self {
            Self::HalfSpace { point, normal } => ((x - point).dot(normal), *normal),
            Self::Box { min, max, hollow } => turned(box_distance(x, min, max), *hollow),
            Self::Sphere {
                centre,
                radius,
                hollow,
            } => {
                let from_centre = x - centre;
                let r = from_centre.norm();
                turned(
                    (
                        r - radius,
                        from_centre.try_normalize(1e-300).unwrap_or(Vec3::z()),
                    ),
                    *hollow,
                )
            }
            Self::Cylinder {
                base,
                axis,
                length,
                radius,
                hollow,
            } => {
                let (along, radial, outward) = axial(x, base, axis);
                let section =
                    rectangle_distance(radial, along - 0.5 * length, *radius, 0.5 * length);
                turned((section.0, outward * section.1 + axis * section.2), *hollow)
            }
            Self::Tube {
                base,
                axis,
                length,
                inner,
                outer,
            } => {
                let (along, radial, outward) = axial(x, base, axis);
                let section = rectangle_distance(
                    radial - 0.5 * (inner + outer),
                    along - 0.5 * length,
                    0.5 * (outer - inner),
                    0.5 * length,
                );
                (section.0, outward * section.1 + axis * section.2)
            }
        }
    }
}

fn turned((phi, normal): (Real, Vec3), hollow: bool) -> (Real, Vec3) {
    if hollow {
        (-phi, -normal)
    } else {
        (phi, normal)
    }
}

/// Coordinate along the axis, distance from it, and the unit vector away from it.
fn axial(x: &Vec3, base: &Vec3, axis: &Vec3) -> (Real, Real, Vec3) {
    let from_base = x - base;
    let along = from_base.dot(axis);
    let across = from_base - axis * along;
    let sideways = if axis.x.abs() < 0.9 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let fallback = (sideways - axis * sideways.dot(axis)).normalize();
    (
        along,
        across.norm(),
        across.try_normalize(1e-300).unwrap_or(fallback),
    )
}

/// Signed distance to the rectangle |u| ≤ half_u, |v| ≤ half_v, and its gradient in (u, v).
fn rectangle_distance(u: Real, v: Real, half_u: Real, half_v: Real) -> (Real, Real, Real) {
    let (a, b) = (u.abs() - half_u, v.abs() - half_v);
    let (sign_u, sign_v) = (u.signum(), v.signum());
    if a > 0.0 && b > 0.0 {
        let r = a.hypot(b);
        (r, sign_u * a / r, sign_v * b / r)
    } else if a > b {
        (a, sign_u, 0.0)
    } else {
        (b, 0.0, sign_v)
    }
}

fn box_distance(x: &Vec3, min: &Vec3, max: &Vec3) -> (Real, Vec3) {
    let from_centre = x - (min + max) * 0.5;
    let excess = from_centre.abs() - (max - min) * 0.5;
    let outside = excess.map(|e| e.max(0.0));
    let r = outside.norm();
    if r > 0.0 {
        (r, outside.component_mul(&from_centre.map(Real::signum)) / r)
    } else {
        let axis = excess.imax();
        let mut normal = Vec3::zeros();
        normal[axis] = from_centre[axis].signum();
        (excess[axis], normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// φ must be a distance: gradient of length 1 that agrees with differences of φ.
    #[test]
    fn every_shape_has_a_unit_gradient_that_matches_its_distance() {
        let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
        let shapes = [
            Shape::HalfSpace {
                point: Vec3::new(0.1, 0.2, 0.3),
                normal: axis,
            },
            Shape::Box {
                min: Vec3::repeat(-0.5),
                max: Vec3::new(0.4, 0.6, 0.8),
                hollow: false,
            },
            Shape::Box {
                min: Vec3::repeat(-0.5),
                max: Vec3::new(0.4, 0.6, 0.8),
                hollow: true,
            },
            Shape::Sphere {
                centre: Vec3::repeat(0.1),
                radius: 0.7,
                hollow: true,
            },
            Shape::Cylinder {
                base: Vec3::repeat(-0.2),
                axis,
                length: 0.9,
                radius: 0.3,
                hollow: false,
            },
            Shape::Tube {
                base: Vec3::repeat(-0.2),
                axis,
                length: 0.9,
                inner: 0.2,
                outer: 0.4,
            },
        ];
        let mut random = crate::math::Stream::new(5, "shape");
        for shape in &shapes {
            for _ in 0..500 {
                let x = random.cube();
                let (_, normal) = shape.distance(&x);
                assert!((normal.norm() - 1.0).abs() < 1e-9, "{shape:?}");
                let step = 1e-6;
                let slope = (shape.distance(&(x + normal * step)).0
                    - shape.distance(&(x - normal * step)).0)
                    / (2.0 * step);
                // Off the medial axis the slope along the normal is 1.
                assert!(
                    (slope - 1.0).abs() < 1e-3 || slope.abs() < 1.0,
                    "{shape:?} {slope}"
                );
            }
        }
        let tube = &shapes[5];
        let on_axis = Vec3::repeat(-0.2) + axis * 0.4;
        assert!((tube.distance(&on_axis).0 - 0.2).abs() < 1e-9);
    }
}
