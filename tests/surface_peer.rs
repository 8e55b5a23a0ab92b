//! A benchmark, not a test: the surface of a cloud of particles, to be run beside `splashsurf reconstruct`.
//!
//! `OSTEOFLOW_XYZ=splash.xyz OSTEOFLOW_RADIUS=0.01 OSTEOFLOW_CUBE=0.5 OSTEOFLOW_PLY=out.ply RAYON_NUM_THREADS=2
//! cargo test --release --locked --test surface_peer -- --nocapture`
//! does what `splashsurf reconstruct splash.xyz -r=0.01 -l=2.0 -c=0.5 -t=0.6 -n 2 -o out.ply` does.
//! `OSTEOFLOW_ROUNDS=10` smooths as well and computes what the vertices carry.

use osteoflow::cache::Frame;
use osteoflow::export::ply;
use osteoflow::surface::{SurfaceSettings, bare, reconstruct};
use std::time::Instant;

#[test]
fn beside_splashsurf() {
    let text = |key: &str| std::env::var(key).ok();
    let number = |key, or: f64| text(key).map_or(or, |t| t.parse().expect("a number"));
    let Some(cloud) = text("OSTEOFLOW_XYZ") else {
        return;
    };
    let start = Instant::now();
    let bytes = std::fs::read(cloud).expect("a file");
    let coordinates: Vec<f32> = (bytes.as_chunks::<4>().0.iter())
        .map(|b| f32::from_le_bytes(*b))
        .collect();
    let position = coordinates.as_chunks::<3>().0.to_vec();
    let spacing = 2.0 * number("OSTEOFLOW_RADIUS", 0.01);
    let frame = Frame {
        spacing,
        support_radius: 2.0 * spacing,
        rest_volume: spacing.powi(3),
        velocity: vec![[0.0; 3]; position.len()],
        polymer_fraction: vec![0.5; position.len()],
        position,
        ..Frame::default()
    };
    let settings = SurfaceSettings {
        cube: number("OSTEOFLOW_CUBE", 0.5) / 2.0,
        rounds: number("OSTEOFLOW_ROUNDS", 0.0) as u32,
        ..SurfaceSettings::default()
    };
    let read = start.elapsed();
    let mesh = if settings.rounds > 0 {
        reconstruct(&frame, None, &settings).mesh
    } else {
        bare(&frame, None, &settings)
    };
    let made = start.elapsed();
    if let Some(path) = text("OSTEOFLOW_PLY") {
        let mut file = std::fs::File::create(path).expect("a file");
        ply::write(&mut file, &mesh, &[]).expect("written");
    }
    eprintln!(
        "{} particles, {} triangles, {} vertices: read {read:.2?}, made {:.2?}, written {:.2?}, in all {:.2?}",
        frame.position.len(),
        mesh.triangles.len(),
        mesh.positions.len(),
        made.saturating_sub(read),
        start.elapsed().saturating_sub(made),
        start.elapsed(),
    );
}
