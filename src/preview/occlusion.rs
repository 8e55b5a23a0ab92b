//! Screen-space ambient occlusion: how much of the sky a surface sees past its neighbours in the picture.
//!
//! What rises above the tangent plane hides sky, less the farther it is.

use super::camera::View;
use crate::math::{Real, Vec3};

/// Reach, in shorter sides of the picture.
const REACH: Real = 0.09;
/// Sine of the rise above the tangent plane that hides nothing yet: facets of a smooth surface stay clean.
const BIAS: Real = 0.08;
/// Darkening by a neighbourhood that rises everywhere.
const STRENGTH: Real = 3.2;

/// How far it looks [pixels].
pub(super) fn reach(view: &View) -> Real {
    REACH * view.width.min(view.height) as Real
}

/// Depths of a picture to look around in.
pub(super) struct Neighbourhood<'a> {
    view: &'a View,
    /// Where in their pixels the depths were taken.
    offset: [Real; 2],
    depth: &'a [f32],
}

impl<'a> Neighbourhood<'a> {
    pub fn new(view: &'a View, offset: [Real; 2], depth: &'a [f32]) -> Self {
        Self {
            view,
            offset,
            depth,
        }
    }

    /// Share of the sky [1] that is open at a pixel, asked at `taps` in the unit disc.
    pub fn open(&self, pixel: usize, normal: &Vec3, taps: &[[Real; 2]]) -> Real {
        let (width, height) = (self.view.width as Real, self.view.height as Real);
        let (column, row) = (pixel % self.view.width, pixel / self.view.width);
        let point = self.point(column, row);
        let far = reach(self.view) * point.z / self.view.focal;
        let mut hidden = 0.0;
        for tap in taps {
            // The half pixel and more keeps the inmost taps off the pixel itself.
            let away = |along: Real| (along * reach(self.view) + along.signum()).round();
            let (c, r) = (column as Real + away(tap[0]), row as Real + away(tap[1]));
            if c >= 0.0 && r >= 0.0 && c < width && r < height {
                hidden += hides(&(self.point(c as usize, r as usize) - point), normal, far);
            }
        }
        (1.0 - STRENGTH * hidden / taps.len() as Real).max(0.0)
    }

    /// What is seen there, in view space; not finite if nothing is.
    fn point(&self, column: usize, row: usize) -> Vec3 {
        let (x, y) = (
            column as Real + self.offset[0],
            row as Real + self.offset[1],
        );
        self.view.ray(x, y) * Real::from(self.depth[row * self.view.width + column])
    }
}

fn hides(offset: &Vec3, normal: &Vec3, reach: Real) -> Real {
    let squared = offset.norm_squared();
    let nearness = 1.0 - squared / (reach * reach);
    if nearness > 0.0 && squared > 0.0 {
        (offset.dot(normal) / squared.sqrt() - BIAS).max(0.0) * nearness
    } else {
        0.0
    }
}
