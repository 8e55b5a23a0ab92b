//! What a recipe says about what is made of a simulation: surface, volumes, pictures.

use super::place::PlaneRecipe;
use crate::math::Real;
use crate::preview::Background;
use crate::units::{Angle, Length};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PreviewRecipe {
    /// Width [pixels].
    pub width: u32,
    /// Height [pixels].
    pub height: u32,
    /// Samples a pixel: 1, 4, 9 or 16.
    pub samples: u32,
    /// What is behind everything.
    pub background: Background,
    /// One sequence of pictures each.
    pub view: Vec<ViewRecipe>,
}

impl Default for PreviewRecipe {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 4,
            background: Background::Light,
            view: vec![ViewRecipe {
                name: "front".to_owned(),
                ..ViewRecipe::default()
            }],
        }
    }
}

/// One camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Bone in front of this plane, on the side of its normal, is taken away.
    pub cut: Option<PlaneRecipe>,
    /// Whether the plane cuts the cement as well.
    #[serde(default)]
    pub cut_cement: bool,
    /// How the bone is shown.
    #[serde(default)]
    pub bone: BoneLook,
    /// What the colours of the cement show.
    #[serde(default)]
    pub colour: Shows,
    /// Pictures of the last frame from all around, in `preview/<name>.turntable.png`: 36 a good number, 0 none.
    #[serde(default)]
    pub turntable: u32,
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
            cut_cement: false,
            bone: BoneLook::default(),
            colour: Shows::default(),
            turntable: 0,
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

/// What the colours of the cement show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shows {
    /// How much of it is polymer.
    #[default]
    Polymer,
    /// Its pressure.
    Pressure,
    /// Its speed.
    Speed,
    /// Which millilitre it came with.
    Age,
}

/// How the bone is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BoneLook {
    /// Translucent.
    #[default]
    Glass,
    /// Opaque, with its trabeculae, cut open at `cut`; what is taken away is translucent.
    Cut,
    /// Not at all.
    Hidden,
}
