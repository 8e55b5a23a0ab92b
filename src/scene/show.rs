//! What a recipe says about what is made of a simulation: surface, volumes, pictures.

use super::place::PlaneRecipe;
use super::recipe::Axis;
use crate::math::Real;
use crate::units::{Angle, Length};
use serde::{Deserialize, Serialize};

/// How the cement's surface is drawn out of the particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SurfaceRecipe {
    /// Edge of a marching cube, in spacings.
    pub cube: Real,
    /// Smoothing passes over the finished mesh.
    pub smoothing: u32,
    /// Value of the colour field at the surface: 0 outside, 1 deep inside.
    pub threshold: Real,
}

impl Default for SurfaceRecipe {
    fn default() -> Self {
        Self {
            cube: 0.5,
            smoothing: 5,
            threshold: 0.5,
        }
    }
}

/// How volumes are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExportRecipe {
    /// Edge of a voxel, in spacings.
    pub voxel: Real,
    /// Axis that points up in the files.
    pub up: Axis,
    /// Name of the velocity grid: Blender looks for `velocity`, Houdini for `vel`.
    pub velocity_grid: String,
}

impl Default for ExportRecipe {
    fn default() -> Self {
        Self {
            voxel: 0.5,
            up: Axis::Y,
            velocity_grid: "velocity".to_owned(),
        }
    }
}

/// Pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PreviewRecipe {
    /// Width [pixels].
    pub width: u32,
    /// Height [pixels].
    pub height: u32,
    /// Samples along each edge of a pixel.
    pub samples: u32,
    /// One sequence of pictures each.
    pub view: Vec<ViewRecipe>,
}

impl Default for PreviewRecipe {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 3,
            view: vec![ViewRecipe {
                name: "front".to_owned(),
                ..ViewRecipe::default()
            }],
        }
    }
}

/// One camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewRecipe {
    /// Its pictures are `preview/<name>.0001.png`.
    pub name: String,
    /// From −y towards +x, seen from above.
    #[serde(default = "default_azimuth")]
    pub azimuth: Angle,
    /// Above the horizon.
    #[serde(default = "default_elevation")]
    pub elevation: Angle,
    /// 1 fits the scene into the picture, 2 shows half of it.
    #[serde(default = "default_zoom")]
    pub zoom: Real,
    /// What is in the centre; the middle of the scene if not given.
    pub target: Option<[Length; 3]>,
    /// What lies in front of this plane, on the side of its normal, is left out.
    pub cut: Option<PlaneRecipe>,
    /// How the bone is shown.
    #[serde(default)]
    pub bone: BoneLook,
}

impl Default for ViewRecipe {
    fn default() -> Self {
        Self {
            name: String::new(),
            azimuth: default_azimuth(),
            elevation: default_elevation(),
            zoom: default_zoom(),
            target: None,
            cut: None,
            bone: BoneLook::default(),
        }
    }
}

fn default_azimuth() -> Angle {
    Angle::from_si(30.0_f64.to_radians())
}

fn default_elevation() -> Angle {
    Angle::from_si(20.0_f64.to_radians())
}

fn default_zoom() -> Real {
    1.0
}

/// How the bone is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BoneLook {
    /// Translucent.
    #[default]
    Glass,
    /// Opaque, cut open at `cut`.
    Cut,
    /// Not at all.
    Hidden,
}
