//! Every recipe in `pipeline/` reads, makes sense, and survives being locked.

mod shared;

use osteoflow::scene;
use osteoflow::sim::TimeStep;
use std::path::{Path, PathBuf};

fn recipes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
    let entries = std::fs::read_dir(folder).expect("pipeline/ is there");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    paths
}

#[test]
fn every_recipe_resolves_and_its_lock_means_the_same() {
    let recipes = recipes();
    assert!(recipes.len() >= 4);
    for path in recipes {
        let (recipe, mut scene) = scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.particles > 1000, "{}", path.display());
        assert!(matches!(scene.sim.time_step, TimeStep::Adaptive { min, max, .. } if min < max));

        let lock = recipe.to_toml();
        let folder = path.parent().expect("in pipeline/");
        let (again, mut same) =
            scene::read("lock", &lock, folder, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again, recipe);
        // Warnings name lines, and a lock has others.
        assert_eq!(same.warnings.len(), scene.warnings.len());
        same.warnings.clear();
        scene.warnings.clear();
        assert_eq!(same, scene);
    }
}

#[test]
fn the_main_job_is_what_it_says() {
    let path = recipes()
        .into_iter()
        .find(|path| path.ends_with("vertebra.toml"));
    let (_, scene) = scene::load(&path.expect("the main job"), &[]).expect("resolves");
    let inlet = &scene.sim.inlets[0];
    assert!((inlet.polymer_fraction - 0.55).abs() < 1e-12);
    assert_eq!(inlet.flow_rate, 0.2e-6);
    assert_eq!(scene.sim.cement.polymer.viscosity, 8.0);
    let entering = inlet.dose / scene.sim.spacing.powi(3);
    assert!(entering >= 10_000.0, "{entering}");
    assert!(scene.sim.duration * scene.sim.frames_per_second >= 48.0);
    assert_eq!(scene.bone.expect("a bone").regions.len(), 2);
    // The cement enters 8 mm behind the tip and flows along the cannula.
    let tip = osteoflow::math::Vec3::new(7e-3, 6e-3, 3e-3);
    assert!((inlet.position + inlet.direction * 8e-3 - tip).norm() < 1e-12);
}

#[test]
fn the_bone_may_be_any_file_in_any_unit() {
    let Some(bone) = shared::file("bones/vhm_L3_m.obj") else {
        return;
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline/vertebra.toml");
    let sets = [
        format!("bone.mesh={}", bone.display()),
        "bone.unit=m".to_owned(),
    ];
    let (_, scene) = scene::load(&path, &sets).expect("resolves");
    let file = scene.bone.expect("a bone").file;
    assert_eq!(file.unit, 1.0);
    // An absolute path stays itself.
    assert_eq!(file.path, bone);
}
