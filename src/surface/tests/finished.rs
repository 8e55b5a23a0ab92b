//! What smoothing, walls, small pieces and attributes make of a surface.

use super::*;

/// A drop of 200 or so particles, flattened on a floor that they stand off from by `gap` spacings.
fn pancake(gap: f64) -> Frame {
    let mut points = fill(8, Vec3::new(0.3, 0.1, gap), |p| {
        p.xy().norm() < 6.0 && p.z < 2.5
    });
    points.retain(|p| p.z > gap - 0.5);
    frame_of(&points)
}

#[test]
fn cement_meets_a_wall_without_gap_or_deep_overlap() {
    let floor = Solid {
        shapes: vec![crate::solid::Shape::HalfSpace {
            point: Vec3::zeros(),
            normal: Vec3::z(),
        }],
        grids: Vec::new(),
    };
    for gap in [-0.2, 0.0, 0.25, 0.5, 0.75] {
        let surface = reconstruct(&pancake(gap), Some(&floor), &SurfaceSettings::default());
        assert_closed_manifold_oriented(&surface.mesh);
        let mut seen = 0;
        for (p, n) in surface.mesh.positions.iter().zip(&surface.normal) {
            assert!(p.z > -0.5, "{gap}: {p}");
            if p.xy().norm() < 4.0 && n.z < -0.5 {
                seen += 1;
                assert!(p.z < 0.5, "{gap}: {p}");
            }
        }
        assert!(seen > 50, "{gap}: {seen}");
    }
}

#[test]
fn in_a_narrow_vessel_the_walls_give_way_until_volume_is_kept() {
    // Five spacings wide; loose as in a stretched column, and dense as under a piston. Most of the surface is wall.
    let vessel = Solid {
        shapes: vec![crate::solid::Shape::Box {
            min: Vec3::new(-2.5, -2.5, -10.0),
            max: Vec3::new(2.5, 2.5, 30.0),
            hollow: true,
        }],
        grids: Vec::new(),
    };
    for stretch in [0.92, 1.0, 1.1] {
        let points: Vec<Vec3> = fill(10, Vec3::repeat(0.0), |p| p.xy().abs().max() < 2.5)
            .iter()
            .map(|p| Vec3::new(p.x, p.y, p.z * stretch))
            .collect();
        let surface = reconstruct(
            &frame_of(&points),
            Some(&vessel),
            &SurfaceSettings::default(),
        );
        assert_closed_manifold_oriented(&surface.mesh);
        let error = volume(&surface.mesh) / points.len() as f64 - 1.0;
        assert!(error.abs() < 0.005, "{stretch}: {error}");
        for p in &surface.mesh.positions {
            let deep = p.xy().abs().max() - 2.5;
            assert!(deep < 0.5, "{stretch}: {p}");
            // Well away from the ends there is no gap either.
            assert!(
                p.z.abs() > 8.0 || deep > -0.01 || p.xy().abs().min() > 2.0,
                "{stretch}: {p}"
            );
        }
    }
}

#[test]
fn a_strut_between_particles_stays_free() {
    // One spacing thin, cement on both sides.
    let strut = Solid {
        shapes: vec![crate::solid::Shape::Box {
            min: Vec3::new(-20.0, -20.0, -0.5),
            max: Vec3::new(20.0, 20.0, 0.5),
            hollow: false,
        }],
        grids: Vec::new(),
    };
    let points = fill(6, Vec3::repeat(0.5), |p| p.norm() < 6.5);
    let frame = frame_of(&points);
    let open = reconstruct(&frame, None, &SurfaceSettings::default());
    let cut = reconstruct(&frame, Some(&strut), &SurfaceSettings::default());
    assert_closed_manifold_oriented(&cut.mesh);
    let deepest = cut
        .mesh
        .positions
        .iter()
        .map(|p| 0.5 - p.z.abs())
        .fold(0.0, f64::max);
    assert!(deepest < 0.4, "{deepest}");
    let inside = |mesh: &TriMesh| mesh.positions.iter().filter(|p| p.z.abs() < 0.1).count();
    assert!(inside(&open.mesh) > 0 && inside(&cut.mesh) == 0);
    let error = volume(&cut.mesh) / points.len() as f64 - 1.0;
    assert!(error.abs() < 0.02, "{error}");
}

#[test]
fn smoothing_takes_the_steps_out_of_a_ball_and_leaves_a_thread() {
    let area_error = |rounds: u32| {
        let points = fill(10, Vec3::new(0.13, 0.27, 0.41), |p| p.norm() < 10.0);
        let settings = SurfaceSettings {
            rounds,
            ..SurfaceSettings::default()
        };
        let mesh = reconstruct(&frame_of(&points), None, &settings).mesh;
        let made = volume(&mesh);
        assert!((made / points.len() as f64 - 1.0).abs() < 0.005, "{made}");
        area(&mesh) / libm::cbrt(36.0 * std::f64::consts::PI * made * made) - 1.0
    };
    let [bumpy, smooth] = [0, 10].map(area_error);
    assert!(bumpy > 0.02 && smooth < 0.4 * bumpy, "{bumpy} {smooth}");

    let thread: Vec<Vec3> = (0..20).map(|i| Vec3::new(0.13, 0.27, i.into())).collect();
    let thin = |rounds: u32| {
        let settings = SurfaceSettings {
            rounds,
            keep_volume: false,
            ..SurfaceSettings::default()
        };
        let mesh = reconstruct(&frame_of(&thread), None, &settings).mesh;
        let middle = mesh.positions.iter().filter(|p| (5.0..15.0).contains(&p.z));
        middle
            .map(|p| (p.xy() - thread[0].xy()).norm())
            .fold(1.0, f64::min)
    };
    assert!(thin(10) > 0.9 * thin(0), "{} {}", thin(10), thin(0));
}

#[test]
fn a_slowly_moving_blob_does_not_flicker() {
    let mut random = Stream::new(8, "blob");
    let points: Vec<Vec3> = fill(6, Vec3::repeat(0.5), |p| p.norm() < 6.0)
        .iter()
        .map(|p| p + random.cube() * 0.3)
        .collect();
    let at = |step: i32| {
        let moved: Vec<Vec3> = (points.iter())
            .map(|p| p + Vec3::new(0.07, 0.05, 0.03) * f64::from(step))
            .collect();
        let mesh = reconstruct(&frame_of(&moved), None, &SurfaceSettings::default()).mesh;
        [volume(&mesh), area(&mesh)]
    };
    let mut before = at(0);
    for step in 1..12 {
        let now = at(step);
        for k in 0..2 {
            assert!(
                (now[k] / before[k] - 1.0).abs() < 0.01,
                "{before:?} {now:?}"
            );
        }
        before = now;
    }
}

#[test]
fn small_pieces_are_left_out_and_counted() {
    let mut points = fill(4, Vec3::repeat(0.5), |p| p.norm() < 4.0);
    points.extend([Vec3::new(9.0, 0.0, 0.0), Vec3::new(0.0, 9.0, 0.0)]);
    let settings = SurfaceSettings {
        smallest_piece: 3.0,
        ..SurfaceSettings::default()
    };
    let surface = reconstruct(&frame_of(&points), None, &settings);
    assert_closed_manifold_oriented(&surface.mesh);
    assert_eq!(surface.left_out.pieces, 2);
    assert!(
        (1.0..2.5).contains(&surface.left_out.volume),
        "{:?}",
        surface.left_out
    );
    assert!(surface.mesh.positions.iter().all(|p| p.norm() < 5.0));
    assert_eq!(surface.normal.len(), surface.mesh.positions.len());
}

#[test]
fn a_shear_is_measured_and_millilitres_are_counted() {
    let points = fill(6, Vec3::repeat(0.5), |p| p.norm() < 6.0);
    let mut frame = frame_of(&points);
    frame.velocity = points
        .iter()
        .map(|p| [3.0 * p.y as f32, 0.0, 0.0])
        .collect();
    frame.pressure = points.iter().map(|p| 100.0 * p.z as f32).collect();
    frame.id = (0..points.len() as u32).collect();
    frame.rest_volume = 1e-6;
    let settings = SurfaceSettings {
        keep_volume: false,
        ..SurfaceSettings::default()
    };
    let surface = reconstruct(&frame, None, &settings);
    for v in 0..surface.mesh.positions.len() {
        assert!(
            (surface.shear_rate[v] - 3.0).abs() < 0.05,
            "{}",
            surface.shear_rate[v]
        );
        let expected = 100.0 * surface.mesh.positions[v].z as f32;
        assert!((surface.pressure[v] - expected).abs() < 100.0);
    }
    let newest = surface.millilitre.iter().copied().fold(0.0, f32::max);
    assert!(newest > 0.9 * points.len() as f32 && newest < points.len() as f32);
}
