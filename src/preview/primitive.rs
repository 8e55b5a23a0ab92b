//! Triangles and balls as a ray through the eye meets them.
//!
//! With the eye at the origin, a ray d hits the triangle a, b, c where e₀·d, e₁·d, e₂·d ≥ 0 with e₀ = b × c, e₁ = c × a,
//! e₂ = a × b (homogeneous edge functions), at depth det / Σ eᵢ·d with det = a · (b × c), and eᵢ·d / Σ are its
//! perspective-correct weights. No clipping is needed: what is behind the eye never satisfies all three. Neighbours see
//! their common edge with exactly opposite signs, so no sample falls between them and none is hit twice.

use super::camera::View;
use crate::math::{Real, Vec3};

/// Rows and columns of pixels that something may touch, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub x: [u32; 2],
    pub y: [u32; 2],
}

impl Window {
    fn around(low: [Real; 2], high: [Real; 2], view: &View) -> Option<Self> {
        let clamp = |v: Real, end: usize| v.clamp(0.0, end as Real) as u32;
        let window = Self {
            x: [
                clamp(low[0].floor(), view.width),
                clamp(high[0].ceil(), view.width),
            ],
            y: [
                clamp(low[1].floor(), view.height),
                clamp(high[1].ceil(), view.height),
            ],
        };
        (window.x[0] < window.x[1] && window.y[0] < window.y[1]).then_some(window)
    }

    fn whole(view: &View) -> Option<Self> {
        let (width, height) = (view.width as Real, view.height as Real);
        Self::around([0.0; 2], [width, height], view)
    }
}

/// Something a sample can see.
pub(super) trait Primitive {
    /// Depth [m] at which the ray through (x, y) meets it.
    fn depth(&self, x: Real, y: Real) -> Option<Real>;
}

/// A triangle as linear functions of pixel coordinates.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// w_i(x, y) = edge[i]·(x, y, 1), positive inside.
    edge: [[Real; 3]; 3],
    /// A sample is inside where w_i > least[i]: one of two neighbours owns their common edge.
    least: [Real; 3],
    det: Real,
    /// Whether the outside faces the eye.
    pub front: bool,
}

impl Triangle {
    /// The triangle with these corners in view space, unless it is seen exactly edge-on or is not finite.
    pub fn new(corners: &[Vec3; 3], view: &View) -> Option<Self> {
        let [a, b, c] = corners;
        let det = a.dot(&b.cross(c));
        if !(det.is_finite() && det != 0.0) {
            return None;
        }
        // View space is left-handed, hence the sign.
        let front = det > 0.0;
        let sign = if front { 1.0 } else { -1.0 };
        let edge = [b.cross(c), c.cross(a), a.cross(b)].map(|e| {
            let (x, y) = (sign * e.x / view.focal, -sign * e.y / view.focal);
            [x, y, sign * e.z - x * view.centre[0] - y * view.centre[1]]
        });
        let least = edge.map(|[x, y, _]| {
            if x > 0.0 || (x == 0.0 && y > 0.0) {
                -Real::MIN_POSITIVE
            } else {
                0.0
            }
        });
        Some(Self {
            edge,
            least,
            det: det.abs(),
            front,
        })
    }

    /// The pixels that the part beyond the near plane may touch.
    pub fn window(corners: &[Vec3; 3], view: &View) -> Option<Window> {
        let (mut low, mut high) = ([Real::INFINITY; 2], [Real::NEG_INFINITY; 2]);
        let mut include = |point: &Vec3| {
            let at = view.project(point);
            for axis in 0..2 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        };
        for k in 0..3 {
            let (p, q) = (&corners[k], &corners[(k + 1) % 3]);
            if !p.iter().all(|v| v.is_finite()) {
                return None;
            }
            if p.z >= view.near {
                include(p);
            }
            if (p.z >= view.near) != (q.z >= view.near) {
                let mut crossing = p + (q - p) * ((view.near - p.z) / (q.z - p.z));
                crossing.z = view.near;
                include(&crossing);
            }
        }
        Window::around(low, high, view)
    }

    /// Weights of the corners at (x, y): they add to 1.
    pub fn weights(&self, x: Real, y: Real) -> [Real; 3] {
        let w = self.edge.map(|[a, b, c]| a * x + (b * y + c));
        let sum = w[0] + w[1] + w[2];
        w.map(|w| w / sum)
    }
}

impl Primitive for Triangle {
    #[inline(always)]
    fn depth(&self, x: Real, y: Real) -> Option<Real> {
        let [u, v, w] = self.edge.map(|[a, b, c]| a * x + (b * y + c));
        let inside = u > self.least[0] && v > self.least[1] && w > self.least[2];
        inside.then(|| self.det / (u + v + w))
    }
}

/// A ball in view space.
#[derive(Clone, Debug)]
pub(super) struct Ball<'a> {
    pub centre: Vec3,
    pub radius: Real,
    view: &'a View,
}

impl<'a> Ball<'a> {
    /// The ball, unless it is not finite, has no size or holds the eye.
    pub fn new(centre: Vec3, radius: Real, view: &'a View) -> Option<Self> {
        let outside = centre.norm() > radius;
        (radius > 0.0 && radius.is_finite() && outside && centre.iter().all(|v| v.is_finite()))
            .then_some(Self {
                centre,
                radius,
                view,
            })
    }

    /// The pixels that it may touch: exact bounds of its elliptic outline.
    pub fn window(&self) -> Option<Window> {
        let (c, r, view) = (&self.centre, self.radius, self.view);
        if c.z + r <= view.near {
            return None;
        }
        if c.z <= r {
            return Window::whole(view);
        }
        // Planes x = X z (and y = Y z) at distance r from the centre touch it.
        let tangents = |side: Real| {
            let slack = r * (side * side + c.z * c.z - r * r).sqrt();
            let scale = view.focal / (c.z * c.z - r * r);
            [(side * c.z - slack) * scale, (side * c.z + slack) * scale]
        };
        let ([left, right], [down, up]) = (tangents(c.x), tangents(c.y));
        let [x, y] = view.centre;
        Window::around([x + left, y - up], [x + right, y - down], view)
    }
}

impl Primitive for Ball<'_> {
    #[inline(always)]
    fn depth(&self, x: Real, y: Real) -> Option<Real> {
        let ray = self.view.ray(x, y);
        let (a, b) = (ray.norm_squared(), ray.dot(&self.centre));
        let off_axis = self.centre - ray * (b / a);
        let half_chord_squared = self.radius * self.radius - off_axis.norm_squared();
        (half_chord_squared > 0.0).then(|| b / a - (half_chord_squared / a).sqrt())
    }
}
