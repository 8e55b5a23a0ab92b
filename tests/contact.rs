//! A benchmark, not a test: how close the surfaces of a run come to what is solid.
//!
//! `OSTEOFLOW_RUN=out/vertebra cargo test --release --locked --test contact -- --nocapture` prints, in spacings, how deep
//! vertices lie in walls at most, and for particles that touch one how far the wall beside them is from the surface.
//! `OSTEOFLOW_STEP=8` takes every eighth frame.

#[path = "shared/run.rs"]
mod run;

use osteoflow::math::Vec3;
use osteoflow::mesh::MeshDistance;
use osteoflow::surface::{SurfaceSettings, reconstruct};
use rayon::prelude::*;
use run::Run;

/// Particles touch a wall that is nearer [spacings]: at rest beside one they lie half a spacing from it.
const TOUCHING: f64 = 0.75;

#[test]
fn surfaces_leave_no_gap_at_walls() {
    let Some(run) = Run::named() else {
        return;
    };
    let solid = &run.solid;
    let (mut deepest, mut vertices, mut gaps) = (0.0_f64, 0, Vec::new());
    for frame in run.frames() {
        let (mesh, spacing) = (
            reconstruct(&frame, Some(solid), &SurfaceSettings::default()).mesh,
            frame.spacing,
        );
        if mesh.positions.is_empty() {
            continue;
        }
        vertices += mesh.positions.len();
        for x in &mesh.positions {
            deepest = deepest.max(-solid.phi(x) / spacing);
        }
        let to_mesh = MeshDistance::new(&mesh);
        let gap = |p: &[f32; 3]| {
            let x = Vec3::from(p.map(f64::from));
            let away = solid.phi(&x);
            let slope = Vec3::from_fn(|a, _| {
                let step = Vec3::ith(a, 0.05 * spacing);
                solid.phi(&(x + step)) - solid.phi(&(x - step))
            });
            let wall = x - slope.try_normalize(0.0)? * away;
            (away < TOUCHING * spacing).then(|| to_mesh.signed(&wall) / spacing)
        };
        gaps.par_extend(frame.position.par_iter().filter_map(gap));
    }
    gaps.sort_by(f64::total_cmp);
    let wide = gaps.iter().filter(|gap| **gap > 0.5).count();
    let at = |share: f64| gaps[(share * (gaps.len() - 1) as f64) as usize];
    eprintln!("overlap: {deepest:.3} at most, of {vertices} vertices");
    eprintln!(
        "gap: median {:.3}, 99 % {:.3}, {:.3} at most; above a half at {wide} of {} particles",
        at(0.5),
        at(0.99),
        at(1.0),
        gaps.len()
    );
}
