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
    /// X of the rays of a row, Y of those of a column: where in their pixels the depths were taken.
    across: Vec<Real>,
    down: Vec<Real>,
    depth: &'a [f32],
    /// Where to ask, pattern by pattern [pixels].
    steps: Vec<Vec<[i32; 2]>>,
}

impl<'a> Neighbourhood<'a> {
    /// To be asked at patterns of `taps` in the unit disc.
    pub fn new<const N: usize>(
        view: &'a View,
        offset: [Real; 2],
        depth: &'a [f32],
        taps: &[[[Real; 2]; N]],
    ) -> Self {
        // The half pixel and more keeps the inmost taps off the pixel itself.
        let away = |along: Real| (along * reach(view) + along.signum()).round() as i32;
        let ray = |column: usize, row: usize| {
            view.ray(column as Real + offset[0], row as Real + offset[1])
        };
        Self {
            view,
            across: (0..view.width).map(|column| ray(column, 0).x).collect(),
            down: (0..view.height).map(|row| ray(0, row).y).collect(),
            depth,
            steps: (taps.iter())
                .map(|pattern| pattern.iter().map(|tap| tap.map(away)).collect())
                .collect(),
        }
    }

    /// Share of the sky [1] that is open at a pixel, asked at the taps of a pattern.
    pub fn open(&self, pixel: usize, normal: &Vec3, pattern: usize) -> Real {
        let (width, height) = (self.view.width as i32, self.view.height as i32);
        let (column, row) = (pixel % self.view.width, pixel / self.view.width);
        let point = self.point(column, row);
        let far = reach(self.view) * point.z / self.view.focal;
        let mut hidden = 0.0;
        let steps = &self.steps[pattern];
        for step in steps {
            let (c, r) = (column as i32 + step[0], row as i32 + step[1]);
            if (0..width).contains(&c) && (0..height).contains(&r) {
                hidden += hides(&(self.point(c as usize, r as usize) - point), normal, far);
            }
        }
        (1.0 - STRENGTH * hidden / steps.len() as Real).max(0.0)
    }

    /// What is seen there, in view space; not finite if nothing is.
    fn point(&self, column: usize, row: usize) -> Vec3 {
        let ray = Vec3::new(self.across[column], self.down[row], 1.0);
        ray * Real::from(self.depth[row * self.view.width + column])
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
