//! Studio light: a soft key, a cool fill, a rim from behind, and a sky that a closed place sees less of.
//!
//! The lamps hang on the camera, so a turntable keeps its light; the sky stays above the scene.

use super::{Colour, Material, camera::View, geometry::Surface};
use crate::math::{Real, Vec3};

/// How much of the light around reaches a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Exposure {
    /// Share of the sky that nothing near hides [1].
    pub sky: Real,
    /// Share of the key lamp that reaches it [1].
    pub key: Real,
}

impl Exposure {
    /// Nothing in the way.
    pub const FULL: Self = Self { sky: 1.0, key: 1.0 };
}

/// The lamps, in view space.
pub(super) struct Rig {
    /// Direction to the key lamp.
    pub key: Vec3,
    fill: Vec3,
    rim: Vec3,
    up: Vec3,
}

impl Rig {
    pub fn new(view: &View) -> Self {
        Self {
            key: Vec3::new(-0.50, 0.70, -0.62).normalize(),
            fill: Vec3::new(0.85, 0.05, -0.52).normalize(),
            rim: Vec3::new(0.45, 0.50, 0.74).normalize(),
            up: view.axes * Vec3::z(),
        }
    }

    /// Light that an opaque surface sends to the eye.
    pub fn light(&self, surface: &Surface, exposure: &Exposure) -> Colour {
        let gloss = match surface.material {
            Material::Opaque { gloss } => gloss,
            Material::Glass { .. } => 1.0,
        };
        let to_eye = -surface.position.normalize();
        let (normal, colour) = (&surface.normal, &surface.colour);
        // Lamps are as large as soft boxes: a closed place sees less of them, too.
        let crevice = 0.35 + 0.65 * exposure.sky;
        let key = (0.2 + 0.8 * exposure.key) * crevice;
        let diffuse = self.key_light(normal) * key
            + self.other_lamps(normal) * crevice
            + self.sky(normal) * exposure.sky;
        let shine =
            self.highlight(normal, &to_eye) * key + self.edge(normal, &to_eye) * exposure.sky;
        tone(&(colour.component_mul(&diffuse) + Colour::repeat(gloss * shine)))
    }

    /// Light of a pane of glass, already times its opacity, and that opacity.
    pub fn glass(&self, surface: &Surface) -> (Colour, Real) {
        let Material::Glass { facing, edge } = surface.material else {
            return (self.light(surface, &Exposure::FULL), 1.0);
        };
        let to_eye = -surface.position.normalize();
        let grazing = 1.0 - surface.normal.dot(&to_eye).clamp(0.0, 1.0);
        let opacity = facing + (edge - facing) * grazing * grazing * grazing;
        // A pane is thicker where it is seen edge-on, and takes more of the light there: the outline stays dark on white.
        let normal = &surface.normal;
        let light = self.key_light(normal) + self.other_lamps(normal) + self.sky(normal);
        let lit = surface.colour.component_mul(&light) * (1.0 - 0.65 * grazing);
        let shine = 0.5 * self.highlight(&surface.normal, &to_eye);
        (tone(&(lit * opacity + Colour::repeat(shine))), opacity)
    }

    fn key_light(&self, normal: &Vec3) -> Colour {
        // A toe instead of a wrap: the lamp fades out before the horizon, where its shadow map says little.
        let facing = normal.dot(&self.key).max(0.0);
        Colour::new(0.90, 0.88, 0.84) * (facing * facing * 1.1 / (facing + 0.1))
    }

    fn other_lamps(&self, normal: &Vec3) -> Colour {
        Colour::new(0.22, 0.24, 0.27) * wrapped(normal, &self.fill, 0.4)
            + Colour::new(0.22, 0.23, 0.25) * wrapped(normal, &self.rim, 0.0)
    }

    fn sky(&self, normal: &Vec3) -> Colour {
        let (above, below) = (
            Colour::new(0.23, 0.245, 0.27),
            Colour::new(0.12, 0.108, 0.096),
        );
        below + (above - below) * (0.5 + 0.5 * normal.dot(&self.up))
    }

    /// A broad highlight of the key lamp: (n·h)³².
    fn highlight(&self, normal: &Vec3, to_eye: &Vec3) -> Real {
        let half = (self.key + to_eye).normalize();
        let mut power = normal.dot(&half).max(0.0);
        for _ in 0..5 {
            power *= power;
        }
        0.35 * power
    }

    /// Fresnel glow where a glossy surface turns away and mirrors the sky.
    fn edge(&self, normal: &Vec3, to_eye: &Vec3) -> Real {
        let grazing = 1.0 - normal.dot(to_eye).clamp(0.0, 1.0);
        let square = grazing * grazing;
        0.12 * square * square * (0.5 + 0.5 * normal.dot(&self.up))
    }
}

/// Diffuse light of a lamp so large that it reaches `wrap` beyond the horizon.
fn wrapped(normal: &Vec3, lamp: &Vec3, wrap: Real) -> Real {
    ((normal.dot(lamp) + wrap) / (1.0 + wrap)).max(0.0)
}

/// Leaves light below the knee as it is and bends what is brighter towards white, never beyond.
fn tone(light: &Colour) -> Colour {
    const KNEE: Real = 0.75;
    light.map(|v| {
        let over = (v - KNEE) / (1.0 - KNEE);
        if over <= 0.0 {
            v.max(0.0)
        } else {
            KNEE + (1.0 - KNEE) * over / (1.0 + over)
        }
    })
}
