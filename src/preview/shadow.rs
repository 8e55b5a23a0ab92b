//! The shadow of the key lamp: the scene as the lamp sees it, asked whether a surface is what it sees first.
//!
//! The lamp is looked from once, with the same rasteriser. Around each surface a disc of its view is compared with the
//! surface's tangent plane: the share that is not nearer to the lamp is lit, which softens the edge.

use super::{
    Camera, MeshLayer, Sphere,
    camera::View,
    changes::Changes,
    geometry::{Geometry, Surface},
    layers::{self, Seen},
    raster::Samples,
    shade::Rig,
};
use crate::math::{Aabb, Mat3, Real, Vec3};
use rayon::prelude::*;

/// Distance of the lamp, in radii of the scene: nearly parallel light.
const DISTANCE: Real = 12.0;
/// Radius of the disc that is asked, in widths of the lamp's view.
const SOFTNESS: Real = 0.012;
/// How much nearer to the lamp something must be to shade, in pixels of its view.
const BIAS: Real = 2.5;
/// Largest side of the lamp's view [pixels].
const LARGEST: u32 = 2048;

/// The lamp's view.
pub(super) struct Shadow {
    lamp: View,
    seen: Vec<Seen>,
    /// From the eye's view space to the lamp's.
    turn: Mat3,
    shift: Vec3,
}

impl Shadow {
    /// Looks from the lamp at all of `bounds`; none if they hold nothing that could be lit.
    pub fn new(meshes: &[MeshLayer], bounds: &Aabb, view: &View) -> Option<Self> {
        let radius = 0.5 * bounds.extent().norm();
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let to_lamp = view.axes.transpose() * Rig::new(view).key;
        let camera = Camera {
            position: bounds.centre() + to_lamp * (DISTANCE * radius),
            target: bounds.centre(),
            up: Vec3::z(),
            field_of_view: 2.05 * libm::asin(1.0 / DISTANCE),
        };
        let side = (view.width.min(view.height) as u32 * 3 / 2).clamp(64, LARGEST);
        let lamp = camera.view(side, side);
        let geometry = Geometry::new(meshes, &[], lamp.clone());
        Some(Self {
            turn: lamp.axes * view.axes.transpose(),
            shift: lamp.place(&view.eye),
            seen: layers::opaque(&geometry, 0, &Samples::new(1), None),
            lamp,
        })
    }

    /// With more before the lamp, and where in its view that changes something.
    pub fn with(&self, meshes: &[MeshLayer], spheres: &[Sphere]) -> (Self, Changes) {
        let lamp = self.lamp.clone();
        let geometry = Geometry::new(meshes, spheres, lamp.clone());
        let seen = layers::opaque(&geometry, 0, &Samples::new(1), Some(&self.seen));
        let changed: Vec<bool> = seen
            .par_iter()
            .zip(&self.seen)
            .map(|(now, before)| now.depth.to_bits() != before.depth.to_bits())
            .collect();
        let changes = Changes::new(lamp.width, &changed);
        let with = Self {
            lamp,
            seen,
            ..*self
        };
        (with, changes)
    }

    /// How far around the place of a surface it looks [pixels of the lamp's view].
    pub fn reach(&self) -> Real {
        SOFTNESS * self.lamp.width as Real
    }

    /// Where in the lamp's view a surface is; not finite if it is behind.
    pub fn place(&self, surface: &Surface) -> [f32; 2] {
        let point = self.turn * surface.position + self.shift;
        if point.z > self.lamp.near {
            self.lamp.project(&point).map(|v| v as f32)
        } else {
            [f32::NAN; 2]
        }
    }

    /// Share of the key lamp [1] that reaches `surface`, asked at `taps` in the unit disc.
    pub fn lit(&self, surface: &Surface, taps: &[[Real; 2]]) -> Real {
        let lamp = &self.lamp;
        let point = self.turn * surface.position + self.shift;
        let normal = self.turn * surface.normal;
        // Surfaces that turn away are dark anyway; the tangent plane of grazing ones says little.
        let facing = -normal.dot(&point.normalize());
        let trust = (facing * 15.0).min(1.0);
        if !(trust > 0.0 && point.z > lamp.near) {
            return 1.0;
        }
        let [x, y] = lamp.project(&point);
        let disc = self.reach();
        let bias = BIAS * point.z / lamp.focal;
        let mut shaded = 0.0;
        for tap in taps {
            let (c, r) = (x + disc * tap[0], y + disc * tap[1]);
            if c >= 0.0 && r >= 0.0 && c < lamp.width as Real && r < lamp.height as Real {
                let (c, r) = (c as u32, r as u32);
                let there = self.seen[r as usize * lamp.width + c as usize].depth;
                let ray = lamp.ray(Real::from(c) + 0.5, Real::from(r) + 0.5);
                let plane = normal.dot(&point) / normal.dot(&ray);
                shaded += Real::from(u8::from(Real::from(there) < plane - bias));
            }
        }
        1.0 - trust * shaded / taps.len() as Real
    }
}

/// Bounds of all that is finite.
pub(super) fn bounds(meshes: &[MeshLayer], spheres: &[Sphere]) -> Aabb {
    let include = |mut bounds: Aabb, point: &Vec3| {
        if point.iter().all(|v| v.is_finite()) {
            bounds.include(point);
        }
        bounds
    };
    let mut bounds = Aabb::empty();
    for mesh in meshes {
        let of_mesh = mesh
            .positions
            .par_iter()
            .fold(Aabb::empty, include)
            .reduce(Aabb::empty, |a, b| a.union(&b));
        bounds = bounds.union(&of_mesh);
    }
    for sphere in spheres {
        bounds = include(bounds, &sphere.centre);
        if sphere.radius.is_finite() && sphere.radius > 0.0 {
            bounds = include(bounds, &sphere.centre.add_scalar(sphere.radius));
            bounds = include(bounds, &sphere.centre.add_scalar(-sphere.radius));
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::{Colour, Colours, Material};

    #[test]
    fn a_square_shades_exactly_what_is_behind_it_from_the_lamp() {
        let square = |half: Real, z: Real| {
            [(-half, -half), (half, -half), (half, half), (-half, half)]
                .map(|(x, y)| Vec3::new(x, y, z))
        };
        let (height, half) = (0.02, 0.015);
        let positions = [square(0.1, 0.0), square(half, height)].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let meshes = [MeshLayer {
            positions: &positions,
            triangles: &triangles,
            normals: None,
            colours: Colours::Uniform(Colour::repeat(0.5)),
            material: Material::BONE,
            cut: None,
        }];
        let view = Camera::fitting(&positions, 1.0, 0.4, 0.7, 0.5).view(300, 300);
        let shadow = Shadow::new(&meshes, &bounds(&meshes, &[]), &view).unwrap();
        let shaded = |x: Real, y: Real| {
            let ground = Vec3::new(x, y, 0.0);
            let over = ground + (shadow.lamp.eye - ground) * (height / shadow.lamp.eye.z);
            over.x.abs() < half && over.y.abs() < half
        };

        let (mut dark, mut bright, edge) = (0, 0, 0.0025);
        for i in 0..10_000 {
            let [x, y] = [i % 100, i / 100].map(|k| 0.0019 * (f64::from(k) - 49.5));
            let around = [(-edge, -edge), (edge, -edge), (-edge, edge), (edge, edge)];
            let here = shaded(x, y);
            if around.iter().all(|(dx, dy)| shaded(x + dx, y + dy) == here) {
                let surface = Surface {
                    position: view.place(&Vec3::new(x, y, 0.0)),
                    normal: view.axes * Vec3::z(),
                    colour: Colour::zeros(),
                    material: Material::BONE,
                };
                let lit = shadow.lit(&surface, &[[0.0; 2]]);
                assert!((lit - Real::from(u8::from(!here))).abs() < 1e-12, "{x} {y}");
                *if here { &mut dark } else { &mut bright } += 1;
            }
        }
        assert!(dark > 100 && bright > 5000, "{dark} {bright}");
    }
}
