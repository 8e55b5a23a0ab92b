//! What `check` foretells of a run, and what it builds on the way.

mod program;

use program::osteoflow;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Cement comes out of a needle into a box.
const PRESSED: &str = r#"
name = "Pressed"
spacing = "1 mm"
duration = "0.4 s"
frames_per_second = "25 1/s"

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["18 mm", "18 mm", "18 mm"]

[cement]
slip_relaxation = "1e-4 s"

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["16 mm", "16 mm", "17 mm"] }
hollow = true

[[inlet]]
name = "needle"
position = ["8 mm", "8 mm", "6 mm"]
direction = [0, 0, -1]
diameter = "4 mm"
cannula = { length = "4 mm", outer_diameter = "7 mm", clearance = "0 mm" }
flow_rate = "1.5 ml/s"
ratio = "0.45:0.55"
dose = "0.6 ml"

[preview]
width = 240
height = 180

[[preview.view]]
name = "front"
"#;

/// What `check --json` says, and its messages.
fn check(arguments: &[&str]) -> (Value, String) {
    let output = osteoflow(&[&["check", "--json"], arguments].concat());
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success(), "{said}");
    let report = serde_json::from_slice(&output.stdout).expect("JSON");
    (report, said)
}

fn size(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).expect("a folder");
    let sizes = entries.map(|entry| {
        let entry = entry.expect("an entry");
        let what = entry.metadata().expect("readable");
        if what.is_dir() {
            size(&entry.path())
        } else {
            what.len()
        }
    });
    sizes.sum()
}

/// Counts to the last particle; steps within a factor 1.5 and disk within 20 %.
fn foretold(recipe: &str, sets: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    let (report, _) = check(&[&[recipe], sets.as_slice()].concat());
    let run = ["run", "-q", recipe, "-o", out.to_str().expect("UTF-8")];
    let ran = osteoflow(&[&run, sets.as_slice()].concat());
    assert!(ran.status.success(), "{ran:?}");
    let text = fs::read(out.join("simulation.json")).expect("a report");
    let made: Value = serde_json::from_slice(&text).expect("JSON");
    let expected = &report["forecast"];
    assert_eq!(expected["wall_particles"], made["wall_particles"]);
    let near = |what: &str, expected: &Value, made: f64, factor: f64| {
        let expected = expected.as_f64().expect("a number");
        let ratio = expected / made;
        assert!(
            (1.0 / factor..=factor).contains(&ratio),
            "{recipe}: {what} {expected}, came to {made}"
        );
    };
    let number = |key: &str| made[key].as_f64().expect("a number");
    near(
        "particles",
        &expected["particles"][1],
        number("particles"),
        1.01,
    );
    near("steps", &expected["steps"], number("steps"), 1.5);
    near("disk", &expected["disk_bytes"], size(&out) as f64, 1.2);
}

#[test]
fn what_falls_is_foretold_by_a_coarse_run() {
    foretold(
        "pipeline/dam_break.toml",
        &["duration=0.1 s", "preview.width=320", "preview.height=180"],
    );
}

#[test]
fn what_is_pressed_in_is_foretold_by_laying_it_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let recipe = folder.path().join("pressed.toml");
    fs::write(&recipe, PRESSED).expect("written");
    foretold(recipe.to_str().expect("UTF-8"), &[]);
}

/// The domain of the main job is smaller than its bone, but where cement gets to it is not; made smaller still, it is.
#[test]
fn a_domain_that_cuts_the_bone_open_is_doubted_where_cement_gets_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out").display().to_string();
    let recipe = ["--quick", "pipeline/vertebra.toml"];
    let (report, said) = check(&[&recipe[..], &["-o", &out]].concat());
    assert!(!said.contains("cuts the bone open"), "{said}");
    let region = &report["forecast"]["bone"]["regions"][0];
    for key in ["asked_porosity", "porosity"] {
        assert!((region[key].as_f64().expect("a number") - 0.86).abs() < 0.01);
    }
    assert!(region["throat_in_spacings"].as_f64().expect("measured") > 0.5);
    assert!(Path::new(&out).join("boundary/slices.png").is_file());

    // What was built is there for the run.
    let again = osteoflow(&["voxelise", "--quick", "pipeline/vertebra.toml", "-o", &out]);
    assert!(String::from_utf8_lossy(&again.stderr).contains("voxelise is up to date"));

    let narrow = "domain.max=[\"12 mm\", \"24 mm\", \"18 mm\"]";
    let (_, said) = check(&[&recipe[..], &["--set", narrow]].concat());
    assert!(
        said.contains("the domain cuts the bone open at (1"),
        "{said}"
    );
}
