//! A benchmark, not a test: the surface of a cloud of particles, to be run beside `splashsurf reconstruct`.
//!
//! `OSTEOFLOW_XYZ=splash.xyz OSTEOFLOW_RADIUS=0.01 OSTEOFLOW_CUBE=0.5 OSTEOFLOW_PLY=out.ply RAYON_NUM_THREADS=2
//! cargo test --release --locked --test surface_peer -- --nocapture`
//! does what `splashsurf reconstruct splash.xyz -r=0.01 -l=2.0 -c=0.5 -t=0.6 -n 2 -o out.ply` does.
//! `OSTEOFLOW_ROUNDS=10` smooths as well and computes what the vertices carry; `OSTEOFLOW_EXPORT=folder` then writes OBJ and
//! all grids at a voxel of a spacing into a folder.

use osteoflow::cache::Frame;
use osteoflow::export::{ExportSettings, Leaves, grids, level_set, ply, vdb};
use osteoflow::grid::BrickGrid;
use osteoflow::math::Vec3;
use osteoflow::mesh::write_obj;
use osteoflow::surface::{Surface, SurfaceSettings, bare, reconstruct};
use std::fs;
use std::path::Path;
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
        let surface = reconstruct(&frame, None, &settings);
        if let Some(folder) = text("OSTEOFLOW_EXPORT") {
            let made = start.elapsed();
            export(&frame, &surface, folder.as_ref());
            eprintln!("surface {:.2?}", made.saturating_sub(read));
        }
        surface.mesh
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

fn export(frame: &Frame, surface: &Surface, folder: &Path) {
    let start = Instant::now();
    let settings = ExportSettings {
        voxel: 1.0,
        ..ExportSettings::default()
    };
    let mut volumes = grids::from_frame(frame, &settings);
    let voxel = volumes[0].voxel;
    let mut filled = Vec::new();
    let mut known = BrickGrid::new(Vec3::zeros(), voxel, 0.0);
    if let Leaves::Float(leaves) = &volumes[0].leaves {
        for leaf in leaves {
            known.insert_brick(leaf.first, leaf.values.clone());
            filled.push(leaf.first);
        }
    }
    let inside = |at: [i32; 3]| known.get(at) > 0.6;
    volumes.push(level_set::from_surface(
        &surface.mesh,
        &surface.normal,
        voxel,
        &filled,
        inside,
    ));
    let gridded = start.elapsed();
    let mut bytes = Vec::new();
    vdb::write(&mut bytes, &volumes, (&settings).into()).expect("written");
    fs::write(folder.join("cement.vdb"), &bytes).expect("written");
    let packed = start.elapsed();
    let mut text = Vec::new();
    write_obj(&mut text, &surface.mesh, Some(&surface.normal), None).expect("written");
    fs::write(folder.join("cement.obj"), &text).expect("written");
    let written = start.elapsed().saturating_sub(packed);
    let megabytes = text.len() as f64 * 1e-6;
    eprintln!(
        "grids {gridded:.2?}, VDB {} MB {:.2?}, OBJ {megabytes:.0} MB {written:.2?}: {:.0} MB/s",
        bytes.len() / 1_000_000,
        packed.saturating_sub(gridded),
        megabytes / written.as_secs_f64(),
    );
}
