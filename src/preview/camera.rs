//! The eye: where it is, where it looks, how wide.
//!
//! View space is x right, y up, z forward: a sample's ray is (X, Y, 1), and its depth is its z.

use crate::math::{Aabb, Mat3, Real, Vec3};
use serde::{Deserialize, Serialize};

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Where the eye is [m].
    pub position: Vec3,
    /// What is in the middle of the picture [m].
    pub target: Vec3,
    /// What is upwards in the picture.
    pub up: Vec3,
    /// Angle across the shorter side of the picture [rad]: vertical, unless the picture is upright.
    pub field_of_view: Real,
}

impl Default for Camera {
    fn default() -> Self {
        Self::framing(&Aabb::empty(), 0.6, 0.35, 0.5)
    }
}

impl Camera {
    /// Looks at the middle of `bounds` and holds all of it, with a small margin.
    ///
    /// `azimuth` [rad] 0 looks along +y and turns towards +x; `elevation` [rad] is above the horizon.
    pub fn framing(bounds: &Aabb, azimuth: Real, elevation: Real, field_of_view: Real) -> Self {
        let corners: Vec<Vec3> = (0..8_u32)
            .map(|corner| {
                let pick =
                    |axis: usize| [bounds.min, bounds.max][(corner >> axis & 1) as usize][axis];
                Vec3::new(pick(0), pick(1), pick(2))
            })
            .collect();
        Self::fitting(&corners, 1.0, azimuth, elevation, field_of_view)
    }

    /// Like [`Camera::framing`], but fits the points themselves into a picture `aspect` times as wide as high: the shape
    /// fills the picture and stands in its middle.
    pub fn fitting(
        points: &[Vec3],
        aspect: Real,
        azimuth: Real,
        elevation: Real,
        field_of_view: Real,
    ) -> Self {
        const MARGIN: Real = 1.1;
        let bounds = Aabb::around(points.iter().filter(|p| p.iter().all(|v| v.is_finite())));
        let mut target = if bounds.is_empty() {
            Vec3::zeros()
        } else {
            bounds.centre()
        };
        let level = libm::cos(elevation);
        let to_eye = Vec3::new(
            libm::sin(azimuth) * level,
            -libm::cos(azimuth) * level,
            libm::sin(elevation),
        );
        let axes = axes(&-to_eye, &Vec3::z());

        // Along each axis of the picture the wedge of view touches the points on two sides, which fixes where its tip is:
        // x ± slope·z of the tip are bounds of x ± slope·z of the points. The axis that needs more distance wins.
        let slope = libm::tan(0.5 * field_of_view) / MARGIN;
        let slopes = [slope * aspect.max(1.0), slope / aspect.min(1.0)];
        let mut distance: Real = 0.0;
        if !bounds.is_empty() {
            let mut reach = [[Real::NEG_INFINITY; 2]; 2];
            for point in points.iter().filter(|p| p.iter().all(|v| v.is_finite())) {
                let p = axes * (point - target);
                for axis in 0..2 {
                    reach[axis][0] = reach[axis][0].max(p[axis] - slopes[axis] * p.z);
                    reach[axis][1] = reach[axis][1].max(-p[axis] - slopes[axis] * p.z);
                }
            }
            for (axis, [plus, minus]) in reach.into_iter().enumerate() {
                distance = distance.max((plus + minus) / (2.0 * slopes[axis]));
                target += axes.row(axis).transpose() * (0.5 * (plus - minus));
            }
        }
        if distance.is_nan() || distance <= 0.0 {
            distance = 1.0;
        }
        Self {
            position: target + to_eye * distance,
            target,
            up: Vec3::z(),
            field_of_view,
        }
    }

    pub(super) fn view(&self, width: u32, height: u32) -> View {
        let distance = (self.target - self.position).norm();
        let shorter = Real::from(width.min(height).max(1));
        View {
            eye: self.position,
            axes: axes(&(self.target - self.position), &self.up),
            focal: 0.5 * shorter / libm::tan(0.5 * self.field_of_view),
            centre: [0.5 * Real::from(width), 0.5 * Real::from(height)],
            near: 1e-3 * distance,
            distance,
            width: width as usize,
            height: height as usize,
        }
    }
}

/// Rows right, up, forward; any right angle will do where `up` says nothing.
fn axes(forward: &Vec3, up: &Vec3) -> Mat3 {
    let forward = forward.try_normalize(1e-300).unwrap_or_else(Vec3::y);
    let across = |up: &Vec3| forward.cross(up).try_normalize(1e-9);
    let right = across(&up.try_normalize(1e-300).unwrap_or_else(Vec3::z))
        .or_else(|| across(&Vec3::y()))
        .or_else(|| across(&Vec3::x()))
        .unwrap_or_else(Vec3::x);
    let up = right.cross(&forward);
    Mat3::from_rows(&[right.transpose(), up.transpose(), forward.transpose()])
}

/// A camera made ready for one size of picture.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// Position of the eye [m].
    pub eye: Vec3,
    /// Rows: right, up, forward.
    pub axes: Mat3,
    /// Pixels a unit of X or Y.
    pub focal: Real,
    /// The middle of the picture [pixels].
    pub centre: [Real; 2],
    /// Nothing nearer is drawn [m].
    pub near: Real,
    /// Depth of the target [m].
    pub distance: Real,
    /// Width [pixels].
    pub width: usize,
    /// Height [pixels].
    pub height: usize,
}

impl View {
    /// World to view space.
    pub fn place(&self, point: &Vec3) -> Vec3 {
        self.axes * (point - self.eye)
    }

    /// View to world space.
    pub fn world(&self, point: &Vec3) -> Vec3 {
        self.axes.tr_mul(point) + self.eye
    }

    /// The ray (X, Y, 1) through a point of the picture, y down.
    pub fn ray(&self, x: Real, y: Real) -> Vec3 {
        Vec3::new(
            (x - self.centre[0]) / self.focal,
            (self.centre[1] - y) / self.focal,
            1.0,
        )
    }

    /// Where a point in view space falls in the picture; it must be in front of the eye.
    pub fn project(&self, point: &Vec3) -> [Real; 2] {
        [
            self.centre[0] + self.focal * point.x / point.z,
            self.centre[1] - self.focal * point.y / point.z,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_holds_the_box_from_every_side_and_is_not_wasteful() {
        let bounds = Aabb {
            min: Vec3::new(-0.05, -0.03, 0.8),
            max: Vec3::new(0.05, 0.06, 0.84),
        };
        for (azimuth, elevation) in [
            (0.0, 0.0),
            (0.7, 0.4),
            (2.0, -1.2),
            (1.0, core::f64::consts::FRAC_PI_2),
        ] {
            let view = Camera::framing(&bounds, azimuth, elevation, 0.5).view(640, 480);
            let mut reach: Real = 0.0;
            for corner in 0..8_u32 {
                let pick = |bit: usize| {
                    if corner >> bit & 1 == 0 {
                        bounds.min[bit]
                    } else {
                        bounds.max[bit]
                    }
                };
                let [x, y] = view.project(&view.place(&Vec3::new(pick(0), pick(1), pick(2))));
                reach = reach
                    .max((x - 320.0).abs() / 240.0)
                    .max((y - 240.0).abs() / 240.0);
            }
            assert!(
                (0.85..0.95).contains(&reach),
                "{azimuth} {elevation}: {reach}"
            );
        }
    }

    #[test]
    fn azimuth_turns_the_eye_and_ray_undoes_project() {
        let bounds = Aabb::around(&[Vec3::zeros(), Vec3::repeat(1.0)]);
        let quarter = core::f64::consts::FRAC_PI_2;
        assert!(Camera::framing(&bounds, 0.0, 0.0, 0.5).position.y < -1.0);
        assert!(Camera::framing(&bounds, quarter, 0.0, 0.5).position.x > 2.0);
        let view = Camera::framing(&bounds, 0.3, 0.2, 0.5).view(320, 200);
        let point = view.place(&Vec3::new(0.1, 0.9, 0.4));
        assert!((view.world(&point) - Vec3::new(0.1, 0.9, 0.4)).norm() < 1e-12);
        let [x, y] = view.project(&point);
        assert!((view.ray(x, y) * point.z - point).norm() < 1e-12);
    }
}
