//! Every recipe in `pipeline/` reads, makes sense, and survives being locked.

mod shared;

use osteoflow::bone::landmarks;
use osteoflow::math::Vec3;
use osteoflow::mesh::{LengthUnit, MeshDistance, read_obj};
use osteoflow::scene;
use osteoflow::sim::TimeStep;
use osteoflow::solid::Shape;
use serde_json::Value;
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

/// Every key of a filled-in recipe is in the schema, which allows no others; each has its sentence.
fn in_schema(value: &toml::Value, schema: &Value, root: &Value, path: &str) {
    let named = |schema: &Value| {
        let name = schema["$ref"]
            .as_str()
            .and_then(|r| r.strip_prefix("#/$defs/"));
        name.map(|name| root["$defs"][name].clone())
    };
    let mut schema = named(schema).unwrap_or_else(|| schema.clone());
    if let Some(options) = schema["anyOf"].as_array() {
        let some = options.iter().find(|option| option["type"] != "null");
        let some = some.expect("not only null").clone();
        schema = named(&some).unwrap_or(some);
    }
    match value {
        toml::Value::Table(table) => {
            assert_eq!(schema["additionalProperties"], false, "{path}");
            for (key, inner) in table {
                let known = &schema["properties"][key];
                assert!(known["description"].is_string(), "{path}.{key}: {known}");
                in_schema(inner, known, root, &format!("{path}.{key}"));
            }
        }
        toml::Value::Array(items) => {
            for item in items {
                in_schema(item, &schema["items"], root, &format!("{path}[]"));
            }
        }
        toml::Value::String(_) => {
            let text = schema["type"] == "string"
                || schema["type"][0] == "string"
                || schema["enum"].is_array()
                || schema["oneOf"].is_array();
            assert!(text, "{path}: {schema}");
        }
        _ => {}
    }
}

#[test]
fn the_schema_knows_every_key_of_every_recipe() {
    let schema = scene::schema();
    for path in recipes() {
        let (recipe, _) = scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let value: toml::Value = toml::from_str(&recipe.to_toml()).expect("TOML");
        in_schema(&value, &schema, &schema, "");
    }
}

/// Coarser where that is possible, a third of the time, and still a recipe.
#[test]
fn every_recipe_has_a_quick_form() {
    for path in recipes() {
        let (full, _) = scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let quick = scene::load_as(&path, &[], scene::Recipe::quick);
        let (quick, scene) = quick.unwrap_or_else(|e| panic!("{e}"));
        let ratio = quick.spacing.si() / full.spacing.si();
        assert!((1.0..=1.6).contains(&ratio), "{}: {ratio}", path.display());
        assert!(
            ratio > 1.3 || !full.periodic.is_empty(),
            "{}",
            path.display()
        );
        let share = quick.duration.si() / full.duration.si();
        assert!((share - 1.0 / 3.0).abs() < 1e-12);
        assert!(scene.name.ends_with("(quick)"));
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
    assert_eq!(scene.bone.expect("a bone").settings.regions.len(), 2);
    // The cement enters 8 mm behind the tip and flows along the cannula.
    assert!((inlet.position + inlet.direction * 8e-3 - TIP).norm() < 1e-12);
}

const TIP: Vec3 = Vec3::new(8e-3, -2e-3, 0.0);

/// The cannula enters from behind, stays inside the pedicle's cortex, and ends where the dose has room on all sides.
#[test]
fn the_needle_of_the_main_job_lies_well() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline/vertebra.toml");
    let (_, scene) = scene::load(&path, &[]).expect("resolves");
    let bone = scene.bone.expect("a bone");
    let mesh = read_obj(&bone.file.path, bone.file.unit, bone.file.up).expect("the asset");
    let distance = MeshDistance::new(&mesh);
    let frame = landmarks::find(&mesh, &distance)
        .expect("a vertebra")
        .to_frame();
    let distance = distance.transformed(&frame);
    let cortex = bone.settings.shell_thickness;
    assert!(
        distance.signed(&TIP) < -9e-3 - cortex,
        "{}",
        distance.signed(&TIP)
    );
    let [
        Shape::Tube {
            base,
            axis,
            length,
            outer,
            ..
        },
    ] = &scene.shapes[..]
    else {
        panic!("one cannula: {:?}", scene.shapes);
    };
    assert!((base + axis * *length - TIP).norm() < 1e-12);
    // From the tip to the back edge of the pedicle.
    let pedicle = (0..=28).map(|mm| TIP - axis * (f64::from(mm) * 1e-3));
    let nearest = pedicle.map(|x| -distance.signed(&x)).fold(1.0, f64::min);
    assert!(nearest > outer + cortex, "{nearest}");
    assert!(distance.signed(base) > 5e-3, "the hub is outside");
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
    assert_eq!(file.unit, LengthUnit::Metre);
    // An absolute path stays itself.
    assert_eq!(file.path, bone);
}
