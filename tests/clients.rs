//! Files as the programs find them that they are for: OpenVDB's own reader, USD's own library, and Blender.

use half::f16;
use osteoflow::export::{Class, Codec, Grid, Leaf, Leaves, vdb};
use osteoflow::math::{Stream, Vec3};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Whether a command works; if not, the test is skipped and counted.
fn there_is(program: &str, arguments: &[&str]) -> bool {
    let there = Command::new(program)
        .args(arguments)
        .output()
        .is_ok_and(|output| output.status.success());
    if !there {
        use std::io::Write;
        let line = format!("{program} {}\n", arguments.join(" "));
        if let Some(path) = std::env::var_os("OSTEOFLOW_SKIPPED") {
            let file = fs::OpenOptions::new().append(true).create(true).open(path);
            file.and_then(|mut file| file.write_all(line.as_bytes()))
                .expect("the list of what was skipped");
        }
    }
    there
}

fn script(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name);
    path.display().to_string()
}

/// Random voxels, 3 in 10 active, in leaves on both sides of the borders of all nodes.
fn leaves<T: Copy>(zero: T, mut value: impl FnMut(&mut Stream, bool) -> T) -> Vec<Leaf<T>> {
    let mut random = Stream::new(3, "clients");
    let firsts = [
        [0, 0, 0],
        [8000, -16, 24],
        [-8, -8, -8],
        [-4104, 8, 0],
        [0, 128, 0],
        [8, 0, 0],
    ];
    let leaf = |first| {
        let mut leaf = Leaf {
            first,
            active: [0; 8],
            values: Box::new([zero; 512]),
        };
        for i in 0..512 {
            let active = random.unit() < 0.3;
            leaf.active[i >> 6] |= u64::from(active) << (i & 63);
            leaf.values[i] = value(&mut random, active);
        }
        leaf
    };
    firsts.map(leaf).into()
}

/// What a reader should find.
fn expected<T: Copy>(
    leaves: &[Leaf<T>],
    said: impl Fn(T) -> Value,
    shown: bool,
) -> [Vec<Value>; 2] {
    let mut voxels = [Vec::new(), Vec::new()];
    for leaf in leaves {
        for i in 0..512_i32 {
            let at = [
                leaf.first[0] + (i >> 6),
                leaf.first[1] + (i >> 3 & 7),
                leaf.first[2] + (i & 7),
            ];
            let active = leaf.active[i as usize >> 6] >> (i & 63) & 1 == 1;
            if active || shown {
                voxels[usize::from(!active)].push(json!([at, said(leaf.values[i as usize])]));
            }
        }
    }
    voxels
}

#[test]
fn openvdb_reads_every_grid_as_it_was_written() {
    if !there_is("/usr/bin/python3", &["-c", "import pyopenvdb, numpy"]) {
        return;
    }
    let (origin, voxel, background) = (Vec3::new(0.5, -0.25, 2.0), 0.3e-3, 0.75_f32);
    let fog = leaves(0.0, |r, _| r.between(-1.0, 1.0) as f32);
    let level = leaves(0.0, |r, active| {
        let value = r.between(-0.75, 0.75) as f32;
        if active {
            value
        } else {
            background.copysign(value)
        }
    });
    let vector = leaves([0.0; 3], |r, _| {
        let v = r.cube();
        [v.x as f32, v.y as f32, v.z as f32]
    });
    let grid = |name: &str, class, leaves| Grid {
        name: name.into(),
        class,
        origin,
        voxel,
        leaves,
    };
    let grids = [
        grid("density", Class::Fog, Leaves::Float(fog.clone())),
        grid(
            "surface",
            Class::LevelSet { background },
            Leaves::Float(level.clone()),
        ),
        grid("velocity", Class::Fog, Leaves::Vec3(vector.clone())),
        grid("nothing", Class::Fog, Leaves::Float(Vec::new())),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for half in [false, true] {
        let number = |n: f32| if half { f16::from_f32(n).to_f32() } else { n };
        let float = |n: f32| json!(number(n));
        let [fog_on, _] = expected(&fog, float, false);
        let [level_on, level_off] = expected(
            &level,
            |n| {
                // Inactive values are stored at full size.
                if n.abs() == background {
                    json!(n)
                } else {
                    float(n)
                }
            },
            true,
        );
        let [vector_on, _] = expected(&vector, |v| json!(v.map(number)), false);
        let places = [[0, 0, 0], [1, 2, -3]]
            .map(|at: [i32; 3]| json!([at, origin + Vec3::from(at.map(f64::from)) * voxel]));
        let all = json!([
            { "name": "density", "class": "fog volume", "background": 0, "places": places, "active": fog_on, "inactive": [] },
            { "name": "surface", "class": "level set", "background": background, "places": places, "active": level_on, "inactive": level_off },
            { "name": "velocity", "class": "fog volume", "background": 0, "places": places, "active": vector_on, "inactive": [] },
            { "name": "nothing", "class": "fog volume", "background": 0, "places": places, "active": [], "inactive": [] },
        ]);
        let list = folder.path().join("expected.json");
        fs::write(&list, all.to_string()).expect("written");
        for codec in [Codec::Blosc, Codec::Zip, Codec::None] {
            let path = folder.path().join("grids.vdb");
            let mut bytes = Vec::new();
            vdb::write(&mut bytes, &grids, vdb::Storage { codec, half }).expect("written");
            fs::write(&path, bytes).expect("written");
            let output = Command::new("/usr/bin/python3")
                .arg(script("openvdb.py"))
                .args([&path, &list])
                .output()
                .expect("python starts");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{codec:?} half {half}: {said}");
        }
    }
}

const RECIPE: &str = r#"
name = "Clients"
spacing = "1 mm"
duration = "0.02 s"
frames_per_second = "100 1/s"

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["18 mm", "10 mm", "12 mm"]

[cement]
slip_relaxation = "1e-4 s"

[[body]]
box = { min = ["1 mm", "1 mm", "1 mm"], max = ["7 mm", "7 mm", "6 mm"] }
polymer_fraction = 0.2

[[body]]
box = { min = ["9 mm", "1 mm", "1 mm"], max = ["14 mm", "7 mm", "4 mm"] }
polymer_fraction = 0.8

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["16 mm", "8 mm", "10 mm"] }
hollow = true

[preview]
width = 160
height = 120
samples = 1
"#;

/// The folder of a take with everything exported.
fn take() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let recipe = folder.path().join("recipe.toml");
    fs::write(&recipe, RECIPE).expect("written");
    let out = folder.path().join("out");
    for verb in ["voxelise", "simulate", "surface", "export"] {
        let output = Command::new(env!("CARGO_BIN_EXE_osteoflow"))
            .args([
                verb.as_ref(),
                recipe.as_os_str(),
                "-o".as_ref(),
                out.as_os_str(),
            ])
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{verb}: {said}");
    }
    folder
}

/// `OSTEOFLOW_PYTHON`: a Python that has USD's own library (`pip install usd-core`).
#[test]
fn usd_opens_the_scene_and_finds_every_frame() {
    let python = std::env::var("OSTEOFLOW_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if !there_is(&python, &["-c", "from pxr import Usd, UsdGeom, UsdVol"]) {
        return;
    }
    let folder = take();
    let output = Command::new(python)
        .arg(script("usd.py"))
        .arg(folder.path().join("out"))
        .output()
        .expect("Python starts");
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && said.contains("a scene of 3 frames"),
        "{said}"
    );
}

#[test]
fn blender_opens_a_take_through_its_own_script() {
    if !there_is("blender", &["--version"]) {
        return;
    }
    let folder = take();
    let out = folder.path().join("out");
    let output = Command::new("blender")
        .args([
            "-b",
            "--factory-startup",
            "--python-exit-code",
            "1",
            "--python",
        ])
        .args([
            script("blender.py").as_ref(),
            "--".as_ref(),
            out.as_os_str(),
        ])
        .arg(folder.path().join("picture.png"))
        .output()
        .expect("Blender starts");
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && said.contains("line up"),
        "{said}"
    );
}
