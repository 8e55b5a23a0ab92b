//! Bodies of fluid that fill a mesh.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A cube of 10 units.
const CUBE: &str = "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 10 10 10\nv 0 10 10\n\
    f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

const RECIPE: &str = r#"
name = "Cube"
scheme = "dfsph"
stress = "explicit"
spacing = "1 mm"
duration = "0.01 s"
frames_per_second = "100 1/s"

[domain]
min = ["0 mm", "0 mm", "0 mm"]
max = ["30 mm", "30 mm", "30 mm"]

[[body]]
mesh = { path = "cube.obj", unit = "mm", up = "z", at = ["5 mm", "6 mm", "7 mm"] }
polymer_fraction = 0

# Half a spacing of the cube's lowest layer is wall.
[[wall]]
plane = { point = ["0 mm", "0 mm", "8 mm"], normal = [0, 0, 1] }
"#;

fn run(folder: &Path, verb: &str, sets: &[&str]) -> Output {
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    Command::new(env!("CARGO_BIN_EXE_osteoflow"))
        .current_dir(folder)
        .args([verb, "cube.toml", "-o", "out", "--force"])
        .args(sets)
        .output()
        .expect("the program starts")
}

#[test]
fn a_mesh_is_filled_where_it_is_put_and_walls_are_carved_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("cube.obj"), CUBE).expect("written");
    fs::write(folder.join("cube.toml"), RECIPE).expect("written");
    for verb in ["voxelise", "simulate"] {
        let output = run(folder, verb, &[]);
        assert!(output.status.success(), "{output:?}");
    }
    let text = fs::read(folder.join("out/simulation.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    // Ten layers of a hundred, of which the lowest is in the wall.
    assert_eq!(report["particles"], 900);
    assert_eq!(report["carved_at_start"], 100);

    // Turned into centimetres it reaches out of the domain.
    let text = RECIPE.replace("unit = \"mm\"", "unit = \"cm\"");
    fs::write(folder.join("cube.toml"), text).expect("written");
    let refused = run(folder, "voxelise", &[]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(3), "{said}");
    assert!(
        said.contains("cube.obj") && said.contains("out of the domain"),
        "{said}"
    );

    // One place only.
    let text = RECIPE.replace("polymer_fraction = 0", "polymer_fraction = 0\nsphere = { centre = [\"9 mm\", \"9 mm\", \"9 mm\"], radius = \"2 mm\" }");
    fs::write(folder.join("cube.toml"), text).expect("written");
    let refused = run(folder, "voxelise", &[]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(3), "{said}");
    assert!(
        said.contains("cube.toml:") && said.contains("body[0]"),
        "{said}"
    );
}

const PORES: &str = r#"
name = "Pores"
spacing = "0.5 mm"
duration = "0.06 s"
frames_per_second = "50 1/s"

[domain]
min = ["0 mm", "0 mm", "0 mm"]
max = ["10 mm", "10 mm", "10 mm"]

[cement]
slip_relaxation = "1e-4 s"

[bone]
mesh = "cube.obj"
unit = "mm"
up = "z"
frame = "as is"
cortex = "1 mm"

[[bone.region]]
name = "spongiosa"
strut_period = "2.2 mm"
porosity = 0.82

[[body]]
box = { min = ["1 mm", "1 mm", "1 mm"], max = ["9 mm", "9 mm", "9 mm"] }
polymer_fraction = 0.5
saturated = true
"#;

/// V₀ times the particles is the volume of the pores that they fill, and it stays where it is: no particle in a wall, all
/// steps converged. Kept off the walls, the same body would hold an eighth less.
#[test]
fn a_filled_region_holds_as_much_fluid_as_its_porosity_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("cube.obj"), CUBE).expect("written");
    fs::write(folder.join("cube.toml"), PORES).expect("written");
    let json = |name: &str| -> serde_json::Value {
        let text = fs::read(folder.join("out").join(name)).expect("a report");
        serde_json::from_slice(&text).expect("JSON")
    };
    let held = |sets: &[&str]| {
        for verb in ["voxelise", "simulate"] {
            let output = run(folder, verb, sets);
            assert!(output.status.success(), "{output:?}");
        }
        let report = json("simulation.json");
        assert_eq!(report["converged_share"], 1.0, "{report}");
        assert_eq!(report["most_particles_in_walls"], 0, "{report}");
        assert_eq!(report["volume_escaped_m3"], 0.0, "{report}");
        report["volume_inside_m3"].as_f64().expect("a number") / 8e-3_f64.powi(3)
    };
    let full = held(&[]);
    let made = json("boundary/bone.json")["made"]["regions"][0]["porosity"]
        .as_f64()
        .expect("a number");
    assert!((made - 0.82).abs() < 0.01, "{made}");
    assert!((full - made).abs() < 0.01, "{full} {made}");
    let kept_off = held(&["body[0].saturated=false"]);
    assert!(kept_off < made - 0.05, "{kept_off} {made}");
}
