//! Exporting again touches only the files of frames that changed.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::SystemTime;

const RECIPE: &str = r#"
name = "Fall"
spacing = "1 mm"
duration = "0.02 s"
frames_per_second = "100 1/s"

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["12 mm", "10 mm", "12 mm"]

[[body]]
box = { min = ["1 mm", "1 mm", "1 mm"], max = ["5 mm", "5 mm", "5 mm"] }
polymer_fraction = 0.4

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["10 mm", "8 mm", "10 mm"] }
hollow = true
"#;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn run(&self, verb: &str, more: &[&str]) {
        let output = Command::new(env!("CARGO_BIN_EXE_osteoflow"))
            .current_dir(self.folder.path())
            .args([verb, "fall.toml", "-o", "out"])
            .args(more)
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{verb} {more:?}: {said}");
    }

    fn volume(&self, n: u32) -> PathBuf {
        self.folder
            .path()
            .join(format!("out/vdb/cement.{n:04}.vdb"))
    }

    /// When the volume and the mesh of each frame were written.
    fn written(&self, frames: u32) -> Vec<[SystemTime; 2]> {
        let when = |path: PathBuf| {
            let data = fs::metadata(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            data.modified().expect("a time")
        };
        (0..frames)
            .map(|n| {
                let mesh = format!("out/usd/cement.{n:04}.usda");
                [when(self.volume(n)), when(self.folder.path().join(mesh))]
            })
            .collect()
    }
}

#[test]
fn only_what_changed_is_written_again() {
    let bench = Bench {
        folder: tempfile::tempdir().expect("a folder"),
    };
    fs::write(bench.folder.path().join("fall.toml"), RECIPE).expect("written");
    for verb in ["voxelise", "simulate", "export"] {
        bench.run(verb, &[]);
    }
    let first = bench.written(3);

    // Longer: what was the last frame moves on towards the next one now.
    let longer = ["--set", "duration=0.03 s"];
    bench.run("simulate", &[&longer[..], &["--resume"]].concat());
    bench.run("export", &longer);
    let second = bench.written(4);
    assert_eq!(first[..2], second[..2]);
    assert_ne!(first[2], second[2]);

    // A file that vanished.
    let bytes = fs::read(bench.volume(1)).expect("a volume");
    fs::remove_file(bench.volume(1)).expect("removed");
    bench.run("export", &longer);
    let third = bench.written(4);
    assert_eq!(fs::read(bench.volume(1)).expect("a volume"), bytes);
    let same = |n: usize| second[n] == third[n];
    assert!(same(0) && !same(1) && same(2) && same(3));

    // One frame in another form: it goes back with the next export of all.
    bench.run(
        "export",
        &[&longer[..], &["--frames", "2", "--set", "export.half=true"]].concat(),
    );
    fs::remove_file(bench.volume(0)).expect("removed");
    bench.run("export", &longer);
    let fourth = bench.written(4);
    let same = |n: usize| third[n] == fourth[n];
    assert!(!same(0) && same(1) && !same(2) && same(3));

    // Other settings: all of them, and no file of a form that is not asked for stays.
    bench.run(
        "export",
        &[&longer[..], &["--set", "export.formats=[\"usd\"]"]].concat(),
    );
    let fifth = bench.written(4);
    assert!((0..4).all(|n| fourth[n] != fifth[n]));
    assert!(!bench.folder.path().join("out/ply/cement.0000.ply").exists());
}
