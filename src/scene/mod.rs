//! What a recipe says, then what it means: checked, in SI, ready for the rooms below.

mod accuracy;
mod bone;
mod document;
mod error;
mod meaning;
mod place;
mod probe;
mod recipe;
mod resolve;
mod show;

pub use accuracy::Accuracy;
pub use bone::{
    BoneFrame, BoneRecipe, CrackRecipe, GradientRecipe, PaintedRecipe, RegionRecipe, VeinRecipe,
    VolumeMeaning, VolumeRecipe,
};
pub use document::Document;
pub use error::{Finding, SceneError};
pub use meaning::{Bone, MeshFile, MovingWall, Plane, Preview, Region, Scene, View, VolumeFile};
pub use place::{
    BodyRecipe, BoxRecipe, CannulaRecipe, CylinderRecipe, EllipsoidRecipe, InletRecipe, MeshRecipe,
    MovingRecipe, OscillatingRecipe, PlaneRecipe, Ratio, SphereRecipe, TurningRecipe, WallRecipe,
};
pub use probe::{FluxRecipe, PressureRecipe, ProbeRecipe, ProfileRecipe};
pub use recipe::{
    Axis, Bonding, CementRecipe, Modulus, PhaseRecipe, Recipe, TimeOrNone, TimeStepRecipe,
};
pub use show::{BoneLook, PreviewRecipe, Shows, ViewRecipe};

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The JSON Schema of a recipe, for editors that complete and check as one types.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Recipe).to_value()
}

/// Longer files are no recipes.
const LONGEST: u64 = 1 << 20;

/// Reads a recipe, applies `path=value` overrides, and checks what comes out.
pub fn load(path: &Path, overrides: &[String]) -> Result<(Recipe, Scene), SceneError> {
    load_as(path, overrides, Recipe::clone)
}

/// The same, with what the recipe says changed by `alter`, such as [`Recipe::quick`].
pub fn load_as(
    path: &Path,
    overrides: &[String],
    alter: impl Fn(&Recipe) -> Recipe,
) -> Result<(Recipe, Scene), SceneError> {
    let cannot_read = |source| SceneError::Read {
        path: path.to_owned(),
        source,
    };
    let mut text = String::new();
    let file = File::open(path).map_err(cannot_read)?;
    file.take(LONGEST + 1)
        .read_to_string(&mut text)
        .map_err(cannot_read)?;
    if text.len() as u64 > LONGEST {
        return Err(SceneError::TooLong {
            path: path.to_owned(),
            most: LONGEST,
        });
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    read_as(&path.display().to_string(), &text, folder, overrides, alter)
}

/// As [`load`], from text; `file` is what messages call it, meshes are relative to `folder`.
pub fn read(
    file: &str,
    text: &str,
    folder: &Path,
    overrides: &[String],
) -> Result<(Recipe, Scene), SceneError> {
    read_as(file, text, folder, overrides, Recipe::clone)
}

fn read_as(
    file: &str,
    text: &str,
    folder: &Path,
    overrides: &[String],
    alter: impl Fn(&Recipe) -> Recipe,
) -> Result<(Recipe, Scene), SceneError> {
    let mut document = Document::parse(file, text)?;
    for set in overrides {
        document.r#override(set)?;
    }
    let recipe = alter(&document.recipe()?);
    let scene = resolve::resolve(&document, &recipe, folder)?;
    Ok((recipe, scene))
}
