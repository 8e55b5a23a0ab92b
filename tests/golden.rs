//! Golden images: `preview --golden` passes what looks the same and stops what does not.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let recipe = fs::read_to_string(set().join("start.toml")).expect("the recipe");
        fs::write(folder.path().join("start.toml"), recipe).expect("written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Exit code and messages of a verb.
    fn run(&self, verb: &str, recipe: &str, more: &[&str]) -> (Option<i32>, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_osteoflow"))
            .current_dir(self.folder.path())
            .args([verb, recipe, "-o", "out", "--force"])
            .args(more)
            .output()
            .expect("the program starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        (output.status.code(), said)
    }

    fn simulate(&self, recipe: &str) {
        for verb in ["voxelise", "simulate"] {
            let (code, said) = self.run(verb, recipe, &[]);
            assert_eq!(code, Some(0), "{said}");
        }
    }
}

fn set() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// After a change that is meant to be seen, look at the pictures and take them as good:
/// `osteoflow run tests/golden/start.toml -o out/start`, then the same with
/// `preview --frames 0 --golden tests/golden --bless`.
#[test]
fn the_start_looks_as_it_did() {
    let bench = Bench::new();
    bench.simulate("start.toml");
    let golden = set().display().to_string();
    let more = ["--frames", "0", "--golden", &golden];
    let (code, said) = bench.run("preview", "start.toml", &more);
    assert_eq!(code, Some(0), "{said}");
}

/// Bones are shown as glass: what struts there are is not drawing.
const INJECTION: &[&str] = &["inlet[0].dose=0.004 ml", "preview.view[0].bone=glass"];

/// Every recipe, by name, and what makes it short.
const RECIPES: [(&str, &[&str]); 14] = [
    ("bench_dam", &[]),
    ("channel", &[]),
    ("dam_break", &[]),
    ("falling_drop", &[]),
    ("injection_15_85", INJECTION),
    ("injection_45_55", INJECTION),
    ("injection_80_20", INJECTION),
    ("mixing_10", &[]),
    ("mixing_100", &[]),
    ("mixing_1000", &[]),
    ("periodic_box", &[]),
    ("resting_column", &[]),
    ("syringe", &[]),
    (
        "vertebra",
        &[
            "inlet[0].dose=0.004 ml",
            "preview.view[0].turntable=0",
            "preview.view[1].bone=glass",
            "preview.view[2].bone=glass",
        ],
    ),
];

/// In quick form and small, at the start and after the first steps. What can be seen counts, not bits: a solver that is as
/// right may move them, and so much (pressure that found its step length otherwise tinted the resting column by 2.4 of 255)
/// that it has to be looked at. After a change that is meant to be seen:
/// `OSTEOFLOW_BLESS=1 cargo test --release --test golden recipes`, and look at `tests/golden/recipes`.
#[test]
fn recipes_look_as_they_did() {
    let bless = std::env::var_os("OSTEOFLOW_BLESS").is_some();
    let bench = Bench::new();
    let pipeline = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
    for (name, further) in RECIPES {
        let recipe = pipeline.join(format!("{name}.toml")).display().to_string();
        let golden = set().join("recipes").join(name).display().to_string();
        let small = [
            "duration=24 ms",
            "frames_per_second=125 1/s",
            "preview.width=240",
            "preview.height=180",
            "preview.background=white",
        ];
        let set = small.iter().chain(further).flat_map(|key| ["--set", key]);
        let mut more: Vec<&str> = ["--quick"].into_iter().chain(set).collect();
        for verb in ["voxelise", "simulate", "surface"] {
            let (code, said) = bench.run(verb, &recipe, &more);
            assert_eq!(code, Some(0), "{name}: {said}");
        }
        let report = fs::read(bench.path("out/surface/surface.json")).expect("the report");
        let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
        for n in ["0", "1"] {
            let closed = report[n]["closed"].as_bool();
            let error = report[n]["volume_error"].as_f64().expect("a number");
            assert!(
                closed == Some(true) && error.abs() < 0.02,
                "{name} {n}: {error}"
            );
        }
        more.extend(["--frames", "0..1", "--golden", &golden]);
        if bless {
            more.push("--bless");
        }
        let (code, said) = bench.run("preview", &recipe, &more);
        assert_eq!(code, Some(0), "{name}: {said}");
    }
}

#[test]
fn no_recipe_is_without_a_golden_image() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
    let entries = fs::read_dir(folder).expect("pipeline/ is there");
    let names = entries.map(|entry| entry.expect("readable").file_name());
    let names = names.map(|name| name.to_string_lossy().into_owned());
    let mut names: Vec<String> = names
        .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
        .collect();
    names.sort();
    assert_eq!(names, RECIPES.map(|(name, _)| name));
    for name in names {
        let kept = fs::read_dir(set().join("recipes").join(&name));
        let kept = kept.unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(kept.count() > 0, "{name}: nothing is kept");
    }
}

#[test]
fn a_shift_a_turn_a_tint_and_a_lost_drop_are_noticed() {
    let bench = Bench::new();
    bench.simulate("start.toml");
    let good = bench.path("good").display().to_string();
    let golden = ["--golden", &good];
    let with = |more: &[&'static str]| [&golden[..], more].concat();
    let (code, said) = bench.run("preview", "start.toml", &golden);
    assert!(code == Some(2) && said.contains("--bless"), "{said}");
    let (code, said) = bench.run("preview", "start.toml", &with(&["--bless"]));
    assert_eq!(code, Some(0), "{said}");
    for threads in ["1", "2", "3"] {
        let (code, said) = bench.run("preview", "start.toml", &with(&["--exact", "-n", threads]));
        assert_eq!(code, Some(0), "{said}");
    }

    let differs = |recipe: &str, more: &[&'static str]| {
        let (code, said) = bench.run("preview", recipe, &with(more));
        assert!(code == Some(5) && said.contains("golden.html"), "{said}");
        assert!(bench.path("out/golden/golden.html").exists());
    };
    // A fiftieth of the distance to the scene.
    differs("start.toml", &["--set", "preview.view[0].zoom=1.02"]);
    // One frame late.
    let kept = fs::read(bench.path("good/front.0001.png")).expect("a picture");
    fs::copy(
        bench.path("good/front.0002.png"),
        bench.path("good/front.0001.png"),
    )
    .expect("copied");
    differs("start.toml", &["--frames", "1"]);
    fs::write(bench.path("good/front.0001.png"), kept).expect("written");

    let text = fs::read_to_string(bench.path("start.toml")).expect("the recipe");
    let changed = |name: &str, from: &str, to: &str| {
        assert!(text.contains(from));
        fs::write(bench.path(name), text.replace(from, to)).expect("written");
        bench.simulate(name);
        differs(name, &["--frames", "0"]);
    };
    changed(
        "tint.toml",
        "polymer_fraction = 0.2",
        "polymer_fraction = 0.25",
    );
    let drop = text.find("# A drop").expect("a drop")..text.find("[[wall]]").expect("a wall");
    changed("drop.toml", &text[drop], "");
}
