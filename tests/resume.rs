//! Stopping a simulation in any way and going on: in the end every byte is as if it had never stopped.
#![cfg(unix)]

use osteoflow::math::Stream;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// A body, an inlet and a paddle: everything that has a state.
const RECIPE: &str = r#"
name = "Stirred"
spacing = "1 mm"
duration = "0.06 s"
frames_per_second = "100 1/s"
jitter = 0.1

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["14 mm", "14 mm", "14 mm"]

[time_step]
max = "1 ms"

[cement]
polymer = { density = "1180 kg/m3", viscosity = "1 Pa.s" }
slip_relaxation = "1e-4 s"

[[body]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["12 mm", "12 mm", "3 mm"] }
polymer_fraction = 0.3

[[inlet]]
name = "needle"
position = ["3 mm", "6 mm", "9 mm"]
direction = [0, 0, -1]
diameter = "3 mm"
flow_rate = "0.7 ml/s"
polymer_fraction = 0.8
dose = "0.04 ml"

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["12 mm", "12 mm", "12 mm"] }
hollow = true

[[wall]]
box = { min = ["2 mm", "5 mm", "1 mm"], max = ["10 mm", "7 mm", "4 mm"] }
turning = { point = ["6 mm", "6 mm", "0 mm"], axis = [0, 0, 1], rate = "4 1/s", ramp = "0.02 s" }
"#;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("stirred.toml"), RECIPE).expect("written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, verb: &str, out: &str, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_osteoflow"));
        command
            .args([verb, "stirred.toml", "-o", out, "-n", "1"])
            .args(more)
            .current_dir(self.folder.path());
        command
    }

    fn run(&self, verb: &str, out: &str, more: &[&str]) -> Output {
        self.command(verb, out, more).output().expect("it starts")
    }

    fn expect(&self, verb: &str, out: &str, more: &[&str], code: i32) -> String {
        let output = self.run(verb, out, more);
        let err = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(code), "{verb} {more:?}: {err}");
        err
    }

    fn start(&self, out: &str, more: &[&str]) -> Child {
        self.command("simulate", out, more)
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts")
    }

    /// A simulation that a signal stopped after its first frames.
    fn stopped(&self, out: &str, signal: &str) {
        self.expect("voxelise", out, &[], 0);
        let mut child = self.start(out, &[]);
        let frame = self.path(out).join("frames/000002.osf");
        while !frame.exists() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let sent = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(sent.expect("kill").success());
        let code = child.wait().expect("it ends").code();
        assert_eq!(code, Some(75), "{signal}");
    }
}

fn results(out: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let frames = fs::read_dir(out.join("frames")).expect("frames");
    let mut paths: Vec<PathBuf> = frames
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.extend(["stats.csv", "simulation.json"].map(|name| out.join(name)));
    paths.sort();
    let read = |path: PathBuf| {
        let bytes = fs::read(&path).expect("readable");
        let name = path.strip_prefix(out).expect("inside").to_owned();
        (name, bytes)
    };
    paths.into_iter().map(read).collect()
}

fn assert_same(a: &[(PathBuf, Vec<u8>)], b: &[(PathBuf, Vec<u8>)], what: &str) {
    let names = |r: &[(PathBuf, Vec<u8>)]| r.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(a), names(b), "{what}");
    for ((name, a), (_, b)) in a.iter().zip(b) {
        assert!(a == b, "{what}: {} differs", name.display());
    }
}

#[test]
fn killed_twenty_times_it_ends_with_the_same_bytes() {
    let bench = Bench::new();
    bench.expect("voxelise", "whole", &[], 0);
    bench.expect("simulate", "whole", &[], 0);
    let whole = results(&bench.path("whole"));
    assert_eq!(whole.len(), 7 + 2);

    let mut random = Stream::new(20, "moments");
    let (mut kills, mut folder) = (0, 0);
    while kills < 20 {
        let out = format!("killed{folder}");
        folder += 1;
        bench.expect("voxelise", &out, &[], 0);
        while kills < 20 {
            let mut child = bench.start(&out, &["--resume"]);
            std::thread::sleep(Duration::from_secs_f64(0.02 + 0.3 * random.unit()));
            if child.try_wait().expect("asked").is_some() {
                break;
            }
            child.kill().expect("killed");
            child.wait().expect("ended");
            kills += 1;
        }
        bench.expect("simulate", &out, &["--resume"], 0);
        assert_same(&results(&bench.path(&out)), &whole, &out);
    }
}

#[test]
fn halves_of_files_of_every_kind_do_no_harm() {
    let bench = Bench::new();
    bench.expect("voxelise", "whole", &[], 0);
    bench.expect("simulate", "whole", &[], 0);
    let whole = results(&bench.path("whole"));
    bench.stopped("out", "-INT");
    let out = bench.path("out");
    let half = |name: &str| {
        let bytes = fs::read(out.join(name)).expect("readable");
        bytes[..bytes.len() / 2].to_vec()
    };
    let put = |name: &str, bytes: &[u8]| fs::write(out.join(name), bytes).expect("written");

    // As a kill in the middle of a write leaves them; the newest state is not whole, the one before is.
    put("frames/000003.osf.partial", &half("frames/000002.osf"));
    put("restart/state.osf.partial", &half("restart/state.osf"));
    put("restart/state.osf", &half("restart/state.osf"));
    let table = fs::read_to_string(out.join("stats.csv")).expect("a table");
    put("stats.csv", format!("{table}3,0.03,1").as_bytes());
    put("simulation.json.partial", b"{");
    put("stamps/simulate.json.partial", b"{");
    bench.expect("simulate", "out", &["--resume"], 0);
    let left: Vec<_> = results(&out);
    assert_same(&left, &whole, "half files");
    // It has ended; a second go has nothing to do.
    assert!(
        bench
            .expect("simulate", "out", &["--resume"], 0)
            .contains("up to date")
    );

    // The file was just renamed away and not yet written anew.
    bench.stopped("moved", "-TERM");
    let moved = bench.path("moved/restart");
    fs::rename(moved.join("state.osf"), moved.join("before.osf")).expect("renamed");
    bench.expect("simulate", "moved", &["--resume"], 0);
    assert_same(&results(&bench.path("moved")), &whole, "moved");
}

#[test]
fn what_cannot_go_on_is_said_and_nothing_is_lost() {
    let bench = Bench::new();
    bench.stopped("out", "-INT");
    let err = bench.expect("simulate", "out", &[], 1);
    assert!(err.contains("give --resume to go on"), "{err}");
    let coarser = ["--resume", "--set", "spacing=0.9 mm"];
    bench.expect("voxelise", "out", &coarser[1..], 0);
    let err = bench.expect("simulate", "out", &coarser, 1);
    assert!(err.contains("spacing") && err.contains("changed"), "{err}");
    bench.expect("voxelise", "out", &[], 0);

    // Other settings that make no other scene are allowed, and said.
    let slower = ["--resume", "--set", "time_step.max=0.5 ms"];
    let err = bench.expect("simulate", "out", &slower, 0);
    assert!(err.contains("other settings: time_step"), "{err}");

    // A foreign file, and one that is cut, with nothing else to fall back to.
    bench.stopped("other", "-INT");
    let restart = bench.path("other/restart");
    fs::remove_file(restart.join("before.osf")).expect("there are two");
    let state = fs::read(restart.join("state.osf")).expect("a state");
    fs::copy(
        bench.path("other/frames/000001.osf"),
        restart.join("state.osf"),
    )
    .expect("copied");
    let err = bench.expect("simulate", "other", &["--resume"], 1);
    assert!(err.contains("it holds a frame"), "{err}");
    fs::write(restart.join("state.osf"), &state[..state.len() - 9]).expect("written");
    let err = bench.expect("simulate", "other", &["--resume"], 1);
    assert!(err.contains("bytes long"), "{err}");
    fs::write(restart.join("state.osf"), &state).expect("written");
    fs::remove_file(bench.path("other/frames/000000.osf")).expect("removed");
    let err = bench.expect("simulate", "other", &["--resume"], 1);
    assert!(err.contains("000000.osf: is missing"), "{err}");
    bench.expect("simulate", "other", &["--force"], 0);
}

/// A limit on the size of files stands for a full disk; a folder in the place of a file for one that cannot be written.
#[test]
fn a_full_disk_stops_it_and_later_it_goes_on() {
    let bench = Bench::new();
    bench.expect("voxelise", "whole", &[], 0);
    bench.expect("simulate", "whole", &[], 0);
    bench.expect("voxelise", "full", &[], 0);
    let script = format!(
        "trap '' XFSZ; ulimit -f 40; exec '{}' simulate stirred.toml -o full -n 1",
        env!("CARGO_BIN_EXE_osteoflow")
    );
    let output = Command::new("bash")
        .args(["-c", &script])
        .current_dir(bench.folder.path())
        .output()
        .expect("bash");
    let err = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.contains("error: full/"), "{err}");
    let partial = |folder: &str| {
        let entries = fs::read_dir(bench.path("full").join(folder)).expect("a folder");
        let names = entries.map(|e| e.expect("readable").file_name());
        names
            .filter(|n| n.to_string_lossy().ends_with(".partial"))
            .count()
    };
    assert_eq!((partial("frames"), partial("restart")), (0, 0));
    bench.expect("simulate", "full", &["--resume"], 0);
    let (full, whole) = (bench.path("full"), bench.path("whole"));
    assert_same(&results(&full), &results(&whole), "after a full disk");

    bench.expect("voxelise", "barred", &[], 0);
    fs::create_dir(bench.path("barred/stats.csv")).expect("made");
    let err = bench.expect("simulate", "barred", &[], 1);
    assert!(err.contains("barred/stats.csv"), "{err}");
}
