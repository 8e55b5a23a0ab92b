//! Stages that write small files stand in for the real ones: what is tested is which of them run.

use super::*;
use std::fs;
use std::path::PathBuf;

const RECIPE: &str = r#"
name = "ball"
spacing = "1 mm"
duration = "1 s"
frames_per_second = "4 1/s"
[domain]
min = ["-10 mm", "-10 mm", "-10 mm"]
max = ["10 mm", "10 mm", "10 mm"]
[[body]]
sphere = { centre = ["0 mm", "0 mm", "0 mm"], radius = "5 mm" }
polymer_fraction = 0.3
[[wall]]
mesh = { path = "wall.obj", unit = "mm", up = "z" }
"#;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("ball.toml"), RECIPE).unwrap();
        fs::write(folder.path().join("wall.obj"), "v 0 0 0\n").unwrap();
        Self { folder }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn job(&self, overrides: &[&str]) -> Job {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        let recipe = self.folder.path().join("ball.toml");
        Job::open(&recipe, &overrides, false, &self.out(), false, &mut |_| {}).unwrap()
    }

    /// Runs all stages and says which of them worked.
    fn run(job: &Job) -> Vec<Stage> {
        let mut worked = Vec::new();
        for stage in Stage::ALL {
            job.perform(stage, &mut |_| {}, |job, _| {
                worked.push(stage);
                write(job, stage)
            })
            .unwrap();
        }
        worked
    }
}

fn write(job: &Job, stage: Stage) -> Result<(), FlowError> {
    let folder = &job.folder;
    let put = |path: PathBuf| cache::write(&path, b"content");
    let each = |path: &dyn Fn(u32) -> PathBuf| {
        let mut frames = folder.frames(job.frames)?.into_iter();
        frames.try_for_each(|n| put(path(n)).map_err(FlowError::from))
    };
    match stage {
        Stage::Voxelise => put(folder.walls())?,
        Stage::Simulate => (0..=4).try_for_each(|n| put(folder.frame(n)))?,
        Stage::Surface => each(&|n| folder.surface(n))?,
        Stage::Export => each(&|n| folder.vdb(n))?,
        Stage::Preview => put(folder.picture("front", 0))?,
    }
    Ok(())
}

#[test]
fn only_what_is_stale_runs() {
    use Stage::{Export, Preview, Simulate, Surface, Voxelise};
    let bench = Bench::new();
    let job = bench.job(&[]);
    assert_eq!(Bench::run(&job), Stage::ALL);
    assert_eq!(Bench::run(&job), []);
    assert_eq!(Bench::run(&bench.job(&["preview.width=640"])), [Preview]);
    assert_eq!(Bench::run(&bench.job(&["preview.width=640"])), []);
    assert_eq!(Bench::run(&job), [Preview]);
    assert_eq!(
        Bench::run(&bench.job(&["surface.cube=0.25"])),
        [Surface, Export, Preview]
    );
    assert_eq!(Bench::run(&job), [Surface, Export, Preview]);
    let longer = bench.job(&["duration=2 s"]);
    assert_eq!(Bench::run(&longer), [Simulate, Surface, Export, Preview]);
    Bench::run(&job);

    // A file that vanished, one that was cut, one from outside that changed.
    fs::remove_file(job.folder.vdb(2)).unwrap();
    assert_eq!(Bench::run(&job), [Export]);
    // The surface comes out as it was, so the pictures of it stand.
    fs::write(job.folder.surface(1), "cut").unwrap();
    assert_eq!(Bench::run(&job), [Surface]);
    fs::write(bench.folder.path().join("wall.obj"), "v 0 0 1\n").unwrap();
    assert_eq!(
        Bench::run(&job),
        [Voxelise, Simulate, Surface, Export, Preview]
    );
    fs::write(job.folder.stamp(Simulate), "{").unwrap();
    assert_eq!(Bench::run(&job), [Simulate]);
    let forced = Job { force: true, ..job };
    assert_eq!(Bench::run(&forced), Stage::ALL);
}

#[test]
fn a_stage_that_fails_is_not_finished_and_leaves_no_old_results() {
    let bench = Bench::new();
    let job = bench.job(&[]);
    Bench::run(&job);
    let changed = bench.job(&["spacing=0.8 mm"]);
    changed
        .perform(Stage::Voxelise, &mut |_| {}, |job, _| {
            write(job, Stage::Voxelise)
        })
        .unwrap();
    let failed = changed.perform(Stage::Simulate, &mut |_| {}, |job, _| {
        assert!(job.folder.frames(None).unwrap().is_empty());
        cache::write(&job.folder.frame(0), b"half").unwrap();
        Err(FlowError::io("disk")(std::io::Error::other("full")))
    });
    assert!(failed.is_err());
    let missing = changed
        .perform(Stage::Surface, &mut |_| {}, |_, _| Ok(()))
        .unwrap_err();
    assert!(
        matches!(
            missing,
            FlowError::Missing {
                needed: Stage::Simulate,
                ..
            }
        ),
        "{missing}"
    );
    assert_eq!(Bench::run(&changed)[0], Stage::Simulate);
}

#[test]
fn chosen_frames_are_written_again_and_the_others_stay() {
    let bench = Bench::new();
    let job = bench.job(&[]);
    Bench::run(&job);
    let some = Job {
        frames: Some("1..2".parse().unwrap()),
        ..job.clone()
    };
    let mut frames = Vec::new();
    some.perform(Stage::Export, &mut |_| {}, |job, _| {
        frames = job.folder.frames(job.frames)?;
        Ok(())
    })
    .unwrap();
    assert_eq!(frames, [1, 2]);
    assert!(job.folder.vdb(4).exists());
    assert_eq!(Bench::run(&job), []);
    let none = job.folder.frames(Some("9".parse().unwrap())).unwrap_err();
    assert_eq!(none.to_string(), "--frames 9..9: there are frames 0 to 4");
}

#[test]
fn folders_of_others_are_refused() {
    let bench = Bench::new();
    let recipe = bench.folder.path().join("ball.toml");
    let open =
        |out: &Path, set: &[String], force| Job::open(&recipe, set, false, out, force, &mut |_| {});
    let message = |out: &Path, set: &[String]| open(out, set, false).unwrap_err().to_string();
    assert!(message(bench.folder.path(), &[]).contains("not an output folder"));
    bench.job(&[]);
    assert!(
        message(&bench.out(), &["name=cube".to_owned()]).contains("holds the results of \"ball\"")
    );
    assert!(open(&bench.out(), &["name=cube".to_owned()], true).is_ok());
}

#[test]
fn the_lock_is_a_recipe_with_the_same_meaning_and_run_info_tells_the_story() {
    let bench = Bench::new();
    let job = bench.job(&["cement.thinning=0.7 1/s"]);
    Bench::run(&job);
    let (_, locked) = scene::load(&job.folder.lock(), &[]).unwrap();
    assert_eq!(locked.sim, job.scene.sim);
    assert_eq!(locked.meshes, job.scene.meshes);
    assert_eq!(locked.meshes[0].path, bench.folder.path().join("wall.obj"));
    let info = fs::read_to_string(job.folder.run_info()).unwrap();
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    assert_eq!(info["recipe"], "ball");
    for stage in Stage::ALL {
        assert!(info["stages"][stage.name()]["seconds"].is_f64(), "{stage}");
    }
}
