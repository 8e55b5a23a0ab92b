//! The whole walk as typed, on recipes of a few hundred particles: every file is there and reads back, a second run
//! has nothing to do, and the bytes do not depend on the number of threads.

use osteoflow::cache;
use osteoflow::math::{Aabb, Vec3};
use osteoflow::mesh::{self, LengthUnit, ObjStyle, UpAxis};
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A block of cement falls into a box.
const FALL: &str = r#"
name = "Fall"
spacing = "1 mm"
duration = "0.03 s"
frames_per_second = "100 1/s"
jitter = 0.1

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["12 mm", "10 mm", "12 mm"]

[cement]
slip_relaxation = "1e-4 s"

[[body]]
box = { min = ["1 mm", "1 mm", "1 mm"], max = ["7 mm", "7 mm", "6 mm"] }
polymer_fraction = 0.4

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["10 mm", "8 mm", "10 mm"] }
hollow = true

[[wall]]
mesh = { path = "stone.obj", unit = "mm", up = "z" }

[preview]
width = 160
height = 120
samples = 1
"#;

/// Cement is injected into a hollow ball with a few struts, cortex all around.
const BALL: &str = r#"
name = "Ball"
spacing = "0.8 mm"
duration = "0.3 s"
frames_per_second = "10 1/s"

[domain]
min = ["-12 mm", "-12 mm", "-12 mm"]
max = ["12 mm", "12 mm", "12 mm"]

[time_step]
max = "4 ms"

[cement]
slip_relaxation = "1e-4 s"

[bone]
mesh = "ball.obj"
unit = "mm"
up = "z"
frame = "as is"
cortex = "2 mm"

[[bone.region]]
name = "core"
strut_period = "5 mm"
strut_diameter = "1 mm"

[[inlet]]
name = "needle"
position = ["0 mm", "0 mm", "3 mm"]
direction = [0, 0, -1]
diameter = "2.5 mm"
cannula = { length = "4 mm", outer_diameter = "5 mm", clearance = "1 mm", shaft = "12 mm" }
flow_rate = "0.5 ml/s"
ratio = "0.45:0.55"
dose = "0.15 ml"

[preview]
width = 160
height = 120
samples = 1

[[preview.view]]
name = "cut"
cut = { point = ["0 mm", "0 mm", "0 mm"], normal = [0, -1, 0] }
cut_cement = true
bone = "cut"

[[preview.view]]
name = "glass"
"#;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &[u8]| {
            fs::write(folder.path().join(name), text).expect("written");
        };
        write("fall.toml", FALL.as_bytes());
        write("ball.toml", BALL.as_bytes());
        write("ball.obj", &ball(Vec3::zeros(), 10e-3));
        write("stone.obj", &ball(Vec3::new(8e-3, 4e-3, 1e-3), 2.5e-3));
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, verb: &str, recipe: &str, out: &str, more: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_osteoflow"))
            .args([verb, recipe, "-o", out])
            .args(more)
            .current_dir(self.folder.path())
            .output()
            .expect("the program starts")
    }

    fn done(&self, verb: &str, recipe: &str, out: &str, more: &[&str]) -> String {
        let output = self.run(verb, recipe, out, more);
        let err = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(0), "{verb}: {err}");
        err
    }
}

/// A ball as an OBJ file in millimetres.
fn ball(centre: Vec3, radius: f64) -> Vec<u8> {
    let bounds = Aabb {
        min: centre,
        max: centre,
    };
    let mesh = mesh::surface_nets(&bounds.grown(1.2 * radius), 0.15 * radius, |x| {
        (x - centre).norm() - radius
    });
    let style = ObjStyle {
        groups: &[],
        unit: LengthUnit::Millimetre,
        up: UpAxis::Z,
        comments: &[],
    };
    let mut text = Vec::new();
    mesh::write_obj_with(&mut text, &style, &mesh, None, None).expect("written");
    text
}

/// Paths and contents of what stages left, but for times and machines.
fn results(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for folder in ["boundary", "frames", "surface", "vdb", "preview"] {
        for entry in fs::read_dir(out.join(folder)).expect(folder) {
            let path = entry.expect("readable").path();
            let name = path.file_name().expect("a file").to_string_lossy();
            files.push((
                format!("{folder}/{name}"),
                fs::read(&path).expect("readable"),
            ));
        }
    }
    for file in ["stats.csv", "simulation.json"] {
        files.push((file.to_owned(), fs::read(out.join(file)).expect(file)));
    }
    files.sort();
    files
}

/// Every kind of file of every frame reads back and says the same as the others.
fn check(out: &Path, frames: u32, views: &[&str]) {
    for n in 0..=frames {
        let frame = cache::read_frame(&out.join(format!("frames/{n:06}.osf"))).expect("a frame");
        assert!(!frame.position.is_empty());

        let path = out.join(format!("surface/cement.{n:04}.obj"));
        let surface = mesh::read_obj(&path, LengthUnit::Metre, UpAxis::Y).expect("an OBJ");
        assert!(mesh::inspect(&surface).is_closed(), "{}", path.display());
        let (found, held) = (surface.bounds(), Aabb::around(&points(&frame)));
        let reach = 2.0 * frame.spacing;
        assert!((found.min - held.min).amax() < reach && (found.max - held.max).amax() < reach);
        let (models, _) = tobj::load_obj(&path, &tobj::LoadOptions::default()).expect("an OBJ");
        let read = &models[0].mesh;
        let vertices = 3 * surface.positions.len();
        assert_eq!(
            [&read.positions, &read.normals, &read.vertex_color].map(Vec::len),
            [vertices; 3]
        );

        let bytes = fs::read(out.join(format!("vdb/cement.{n:04}.vdb"))).expect("a VDB");
        let mut reader = vdb_rs::VdbReader::new(Cursor::new(&bytes)).expect("vdb-rs reads it");
        let density = reader.read_grid::<f32>("density").expect("a density grid");
        let voxels = density.descriptor.voxel_count().expect("counted");
        assert!(voxels as usize > frame.position.len(), "{voxels}");
        let (_, grids) = OpenVDB_rs::io::read_stream(Cursor::new(&bytes)).expect("read");
        let names: Vec<_> = grids.iter().map(|grid| grid.name().to_string()).collect();
        assert_eq!(names, ["density", "polymer", "velocity", "surface"]);

        for view in views {
            let path = out.join(format!("preview/{view}.{n:04}.png"));
            let picture = image::open(&path).expect("a PNG").into_rgb8();
            assert_eq!(picture.dimensions(), (160, 120));
            // Cement is teal; neither bone, backdrop nor lettering is.
            let teal = |p: &&image::Rgb<u8>| i32::from(p.0[2]) > i32::from(p.0[0]) + 30;
            assert!(
                picture.pixels().filter(teal).count() > 20,
                "{}",
                path.display()
            );
        }
    }
    let table = fs::read_to_string(out.join("stats.csv")).expect("a table");
    assert_eq!(table.lines().count() as u32, frames + 2);
}

fn points(frame: &cache::Frame) -> Vec<Vec3> {
    frame
        .position
        .iter()
        .map(|p| Vec3::from(p.map(f64::from)))
        .collect()
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).expect("a report")).expect("JSON")
}

#[test]
fn cement_falls_into_a_box_on_any_number_of_threads() {
    let bench = Bench::new();
    let first = bench.done("run", "fall.toml", "one", &["-n", "1"]);
    assert!(first.contains("frame 3/3"), "{first}");
    check(&bench.path("one"), 3, &["front"]);
    let one = results(&bench.path("one"));
    for threads in ["2", "3"] {
        // Stage by stage comes to the same as all at once.
        for verb in ["voxelise", "simulate", "surface", "export", "preview"] {
            bench.done(verb, "fall.toml", threads, &["-n", threads]);
        }
        for (a, b) in one.iter().zip(results(&bench.path(threads))) {
            assert_eq!(a.0, b.0);
            assert!(a.1 == b.1, "{} differs on {threads} threads", a.0);
        }
    }
    let report = json(&bench.path("one/simulation.json"));
    assert_eq!(report["diverged"], serde_json::Value::Null);
    // The block takes 6 × 6 × 5 particles; the stone takes some of their places.
    let count = |key: &str| report[key].as_u64().expect("a number");
    assert_eq!(count("particles") + count("carved_at_start"), 180);
    assert!(count("carved_at_start") > 0);
    // The cement has fallen, and nothing fell through the floor.
    let end = cache::read_frame(&bench.path("one/frames/000003.osf")).expect("a frame");
    let lowest = Aabb::around(&points(&end)).min.z;
    assert!((0.0..0.9e-3).contains(&lowest), "{lowest}");
}

#[test]
fn cement_is_injected_into_a_bone_and_a_second_run_has_nothing_to_do() {
    let bench = Bench::new();
    let first = bench.done("run", "ball.toml", "out", &[]);
    assert!(!first.contains("up to date"), "{first}");
    let out = bench.path("out");
    check(&out, 3, &["cut", "glass"]);
    let before = results(&out);
    let second = bench.done("run", "ball.toml", "out", &[]);
    assert_eq!(second.matches("up to date").count(), 5, "{second}");
    // The folder stands for the recipe that its results were made of.
    let third = bench.done("run", "out", "out", &[]);
    assert_eq!(third.matches("up to date").count(), 5, "{third}");
    assert!(results(&out) == before);

    let report = json(&out.join("simulation.json"));
    assert_eq!(report["inside_bone_share"], 1.0);
    let dose = report["volume_injected_m3"].as_f64().expect("a number");
    assert!((dose / 0.15e-6 - 1.0).abs() < 0.1, "{dose}");
    let bone = json(&out.join("boundary/bone.json"));
    let porosity = bone["made"]["regions"][0]["porosity"].as_f64();
    assert!(
        (0.85..0.99).contains(&porosity.expect("a number")),
        "{bone}"
    );
    assert_eq!(json(&out.join("run.json"))["simulation"], report);

    // Chosen frames alone; pictures of another size; what is damaged is made again.
    bench.done("preview", "ball.toml", "out", &["--frames", "1..2"]);
    let other = bench.done("run", "ball.toml", "out", &["--set", "preview.width=200"]);
    assert_eq!(other.matches("up to date").count(), 4, "{other}");
    fs::remove_file(out.join("frames/000002.osf")).expect("removed");
    bench.done("run", "ball.toml", "out", &[]);
    assert!(results(&out) == before, "the same bytes again");
}

#[test]
fn what_is_wrong_is_said_with_its_exit_code() {
    let bench = Bench::new();
    let fails = |verb, recipe, more: &[&str], code, message: &str| {
        let output = bench.run(verb, recipe, "failed", more);
        let err = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(code), "{err}");
        assert!(err.contains(message), "{err}");
    };
    fails(
        "simulate",
        "ball.toml",
        &[],
        1,
        "needs the results of voxelise",
    );
    fs::write(
        bench.path("stone.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    )
    .expect("written");
    fails("voxelise", "fall.toml", &["--force"], 3, "stone.obj:4: ");
    fs::write(
        bench.path("stone.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .expect("written");
    fails("run", "fall.toml", &["--force"], 3, "is not closed");
    fs::write(bench.path("ball.obj"), "").expect("written");
    fails("run", "ball.toml", &["--force"], 3, "ball.obj: no faces");

    // A step that no fluid survives: frames so far stay, and can be drawn.
    let bench = Bench::new();
    let sets = ["--set", "body[0].velocity=[\"9 km/s\",\"0 m/s\",\"0 m/s\"]"];
    let fixed = ["--set", "time_step={ fixed = \"5 ms\" }"];
    let sets = [&sets[..], &fixed].concat();
    let output = bench.run("run", "fall.toml", "out", &sets);
    let err = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(4), "{err}");
    assert!(err.contains("diverged in step"), "{err}");
    assert!(json(&bench.path("out/simulation.json"))["diverged"].is_string());
    let more = [&sets[..], &["--frames", "0", "--force"]].concat();
    bench.done("surface", "fall.toml", "out", &more);
    assert!(bench.path("out/surface/cement.0000.obj").exists());
}

#[test]
fn make_writes_the_asset_and_other_sizes() {
    let bench = Bench::new();
    let out = bench.path("made.obj").display().to_string();
    let make = |more: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_osteoflow"))
            .args(["make", "vertebra", "-o", &out])
            .args(more)
            .status()
            .expect("the program starts")
            .code()
    };
    assert_eq!(make(&[]), Some(0));
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/vertebra.obj");
    assert!(fs::read(&out).expect("made") == fs::read(asset).expect("the asset"));
    assert_eq!(make(&["--width", "50 mm", "--resolution", "3 mm"]), Some(0));
    let mesh = mesh::read_obj(Path::new(&out), LengthUnit::Millimetre, UpAxis::Z).expect("an OBJ");
    assert!(mesh::inspect(&mesh).is_closed());
    assert_eq!(make(&["--width", "0 mm"]), Some(2));
    assert_eq!(make(&["--resolution", "1 um"]), Some(2));
}
