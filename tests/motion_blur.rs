//! A benchmark, not a test: where the vertices of a run's surfaces arrive after a frame along their velocity.
//!
//! `OSTEOFLOW_RUN=out/vertebra cargo test --release --locked --test motion_blur -- --nocapture` prints, for all frames,
//! which share of the vertices, advected by velocity times the time of a frame, lies within a quarter of the support radius
//! of the next surface, and which share of the others lies inside it. `OSTEOFLOW_STEP=2` takes every other frame.

#[path = "shared/run.rs"]
mod run;

use osteoflow::cache::Frame;
use osteoflow::export::mean_velocity;
use osteoflow::math::Vec3;
use osteoflow::mesh::MeshDistance;
use osteoflow::surface::{SurfaceSettings, reconstruct, reconstruct_moving};
use run::Run;

#[test]
fn vertices_arrive_at_the_next_surface() {
    let Some(run) = Run::named() else {
        return;
    };
    let solid = &run.solid;
    let frames: Vec<Frame> = run.frames().collect();
    let settings = SurfaceSettings::default();
    for (name, mean) in [
        ("at the moment", false),
        ("mean until the next frame", true),
    ] {
        let [mut all, mut near, mut inside] = [0; 3];
        for pair in frames.windows(2) {
            let (frame, next) = (&pair[0], &pair[1]);
            let velocity = mean_velocity(frame, mean.then_some(next), [None; 3]);
            let surface = reconstruct_moving(frame, &velocity, Some(solid), &settings);
            let next_surface = reconstruct(next, Some(solid), &settings);
            let distance = MeshDistance::new(&next_surface.mesh);
            let dt = next.time - frame.time;
            for (x, v) in surface.mesh.positions.iter().zip(&surface.velocity) {
                let away = distance.signed(&(x + Vec3::from(v.map(f64::from)) * dt));
                all += 1;
                if away.abs() <= frame.support_radius / 4.0 {
                    near += 1;
                } else if away < 0.0 {
                    inside += 1;
                }
            }
        }
        eprintln!(
            "{name}: {:.2} % of {all} vertices within a quarter, {:.1} % of the others inside",
            100.0 * f64::from(near) / f64::from(all),
            100.0 * f64::from(inside) / f64::from(all - near)
        );
    }
}
