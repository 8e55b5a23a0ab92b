//! What a recipe says, then what it means: checked, in SI, ready for the rooms below.

mod document;
mod error;
mod place;
mod recipe;
mod show;

pub use document::Document;
pub use error::{Finding, SceneError};
pub use place::{
    BodyRecipe, BoneFrame, BoneRecipe, BoxRecipe, CannulaRecipe, CylinderRecipe, EllipsoidRecipe,
    InletRecipe, MeshRecipe, MeshUnit, PlaneRecipe, Ratio, RegionRecipe, SphereRecipe, WallRecipe,
};
pub use recipe::{
    Axis, Bonding, CementRecipe, Modulus, PhaseRecipe, Recipe, TimeOrNone, TimeStepRecipe,
};
pub use show::{BoneLook, ExportRecipe, PreviewRecipe, SurfaceRecipe, ViewRecipe};
