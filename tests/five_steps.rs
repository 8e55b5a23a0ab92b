//! Every recipe in `pipeline/` makes its first five steps, at the size of `--quick`: converged, nothing lost, nothing
//! inside walls. Those with a bone go on until cement has spread in it.

use osteoflow::flow::{Job, Stage};
use std::path::Path;

fn five_steps(recipe: &str, out: &Path) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("pipeline")
        .join(recipe);
    // Forced only into the folder: walls that another recipe left there serve, if they are the same.
    let job = Job::open(&path, &[], true, out, true, &mut |_| {});
    let mut job = job.unwrap_or_else(|e| panic!("{recipe}: {e}"));
    job.force = false;
    job.run(Stage::Voxelise, &mut |_| {})
        .unwrap_or_else(|e| panic!("{recipe}: {e}"));
    let mut run = job.simulation().unwrap_or_else(|e| panic!("{recipe}: {e}"));
    let bodies: usize = run.fluid.len();
    assert!(bodies > 0, "{recipe}: nothing flows");
    assert!(run.wall_count() > 0 || run.settings.periodic == [true; 3]);
    for step in 0..5 {
        let report = run.step_towards(job.scene.sim.duration);
        let report = report.unwrap_or_else(|e| panic!("{recipe}: {e}"));
        assert!(report.converged, "{recipe}: step {step}: {report:?}");
    }
    let ledger = run.ledger();
    assert_eq!(ledger.in_walls, 0, "{recipe}");
    assert_eq!(
        ledger.escaped.liquid + ledger.escaped.polymer,
        0.0,
        "{recipe}"
    );
    let volume = ledger.inside.liquid + ledger.inside.polymer;
    let held = run.fluid.len() as f64 * run.rest_volume;
    assert!((volume / held - 1.0).abs() < 1e-12, "{recipe}");
    assert!(
        ledger.speed.is_finite() && ledger.stretch[0] > 0.0,
        "{recipe}"
    );
}

/// The recipes that are tested here, so that none is forgotten.
const WITHOUT_BONE: [&str; 10] = [
    "bench_dam.toml",
    "channel.toml",
    "dam_break.toml",
    "falling_drop.toml",
    "mixing_10.toml",
    "mixing_100.toml",
    "mixing_1000.toml",
    "periodic_box.toml",
    "resting_column.toml",
    "syringe.toml",
];
const WITH_BONE: [&str; 4] = [
    "injection_15_85.toml",
    "injection_45_55.toml",
    "injection_80_20.toml",
    "vertebra.toml",
];

#[test]
fn recipes_without_a_bone() {
    for recipe in WITHOUT_BONE {
        let folder = tempfile::tempdir().expect("a folder");
        five_steps(recipe, &folder.path().join("out"));
    }
}

#[test]
fn recipes_with_a_bone() {
    let folder = tempfile::tempdir().expect("a folder");
    for recipe in WITH_BONE {
        five_steps(recipe, &folder.path().join("out"));
    }
}

/// At the size of `--quick` a cannula's wall is less than half a spacing thick, and throats are two spacings wide:
/// what is pressed must go through the throats and not through the wall.
#[test]
fn cement_spreads_in_the_bone_and_does_not_leave_its_cannula() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    for recipe in WITH_BONE {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("pipeline")
            .join(recipe);
        let sets = ["duration=1.5 s", "inlet[0].dose=0.3 ml"].map(str::to_owned);
        let job = Job::open(&path, &sets, true, &out, true, &mut |_| {});
        let mut job = job.unwrap_or_else(|e| panic!("{recipe}: {e}"));
        job.force = false;
        for stage in [Stage::Voxelise, Stage::Simulate] {
            job.run(stage, &mut |_| {})
                .unwrap_or_else(|e| panic!("{recipe}: {e}"));
        }
        let report = std::fs::read(job.folder.simulation_report()).expect("a report");
        let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
        assert_eq!(report["converged_share"], 1.0, "{recipe}: {report}");
        assert_eq!(report["most_particles_in_walls"], 0, "{recipe}: {report}");
        assert_eq!(report["inside_bone_share"], 1.0, "{recipe}: {report}");
    }
}

#[test]
fn no_recipe_is_forgotten() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
    let entries = std::fs::read_dir(folder).expect("pipeline/ is there");
    let names = entries.map(|e| {
        e.expect("readable")
            .file_name()
            .to_string_lossy()
            .into_owned()
    });
    let mut names: Vec<String> = names.filter(|n| n.contains(".toml")).collect();
    names.sort();
    let mut tested = [&WITHOUT_BONE[..], &WITH_BONE[..]].concat();
    tested.sort_unstable();
    assert_eq!(names, tested);
}
