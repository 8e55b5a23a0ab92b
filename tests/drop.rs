//! A viscoelastic drop that falls on a plate: it spreads, springs back, and stays one piece without holes.

use osteoflow::flow::{Job, Stage};
use osteoflow::mesh::{LengthUnit, TriMesh, UpAxis, read_obj};
use std::collections::BTreeSet;
use std::path::Path;

/// V − E + F: 2 for a closed surface that is a sphere, 2 less for each hole through it.
fn euler(mesh: &TriMesh) -> i64 {
    let mut corners = BTreeSet::new();
    let mut edges = BTreeSet::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            corners.insert(a);
            edges.insert((a.min(b), a.max(b)));
        }
    }
    corners.len() as i64 - edges.len() as i64 + mesh.triangles.len() as i64
}

#[test]
fn a_drop_that_remembers_its_shape_does_not_tear() {
    let folder = tempfile::tempdir().expect("a folder");
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline/falling_drop.toml");
    let out = folder.path().join("out");
    let job = Job::open(&recipe, &[], true, &out, false, &mut |_| {}).expect("opened");
    for stage in [Stage::Voxelise, Stage::Simulate, Stage::Surface] {
        job.run(stage, &mut |_| {}).expect("runs");
    }
    let frames = job.scene.last_frame() + 1;
    let mut widths = Vec::new();
    for n in 0..frames {
        let mesh = read_obj(&job.folder.surface(n), LengthUnit::Metre, UpAxis::Y).expect("read");
        assert_eq!(euler(&mesh), 2, "frame {n} of {frames}");
        let along = mesh.positions.iter().map(|x| x.x);
        let (low, high) = along.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        widths.push(high - low);
    }
    let widest = widths.iter().copied().fold(0.0, f64::max);
    let last = widths[widths.len() - 1];
    assert!(
        widest > 1.4 * widths[0] && last < 0.99 * widest,
        "it spreads and springs back: {widths:?} m"
    );
}
