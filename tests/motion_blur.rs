//! A benchmark, not a test: where the vertices of a run's surfaces arrive after a frame along their velocity.
//!
//! `OSTEOFLOW_RUN=out/vertebra cargo test --release --locked --test motion_blur -- --nocapture` prints, for all frames,
//! which share of the vertices, advected by velocity times the time of a frame, lies within a quarter of the support radius
//! of the next surface, and which share of the others lies inside it. `OSTEOFLOW_STEP=2` takes every other frame.

use osteoflow::cache::{Frame, read_frame, read_solid};
use osteoflow::export::mean_velocity;
use osteoflow::math::Vec3;
use osteoflow::mesh::MeshDistance;
use osteoflow::surface::{SurfaceSettings, reconstruct, reconstruct_moving};
use std::path::Path;

#[test]
fn vertices_arrive_at_the_next_surface() {
    let Ok(run) = std::env::var("OSTEOFLOW_RUN") else {
        return;
    };
    let step: usize = std::env::var("OSTEOFLOW_STEP").map_or(1, |s| s.parse().expect("a number"));
    let run = Path::new(&run);
    let solid = read_solid(&run.join("boundary/solid.osf")).expect("walls");
    let mut paths: Vec<_> = (std::fs::read_dir(run.join("frames")).expect("frames"))
        .map(|entry| entry.expect("a file").path())
        .collect();
    paths.sort();
    let frames: Vec<Frame> = (paths.iter().step_by(step))
        .map(|path| read_frame(path).expect("a frame"))
        .collect();
    let settings = SurfaceSettings::default();
    for (name, mean) in [
        ("at the moment", false),
        ("mean until the next frame", true),
    ] {
        let [mut all, mut near, mut inside] = [0; 3];
        for pair in frames.windows(2) {
            let (frame, next) = (&pair[0], &pair[1]);
            let velocity = mean_velocity(frame, mean.then_some(next), [None; 3]);
            let surface = reconstruct_moving(frame, &velocity, Some(&solid), &settings);
            let next_surface = reconstruct(next, Some(&solid), &settings);
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
