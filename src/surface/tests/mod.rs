//! Surfaces of lattices and clouds against closed answers.

mod finished;

use super::cubes::Brick;
use super::*;
use crate::grid::kernel;
use crate::math::Stream;
use std::collections::BTreeMap;

/// Particles at rest, spacing 1 m.
fn frame_of(points: &[Vec3]) -> Frame {
    Frame {
        spacing: 1.0,
        rest_volume: 1.0,
        support_radius: 2.0,
        position: points
            .iter()
            .map(|p| [p.x as f32, p.y as f32, p.z as f32])
            .collect(),
        velocity: vec![[1.0, -2.0, 3.0]; points.len()],
        polymer_fraction: points.iter().map(|p| 0.5 + 0.01 * p.x as f32).collect(),
        ..Frame::default()
    }
}

/// Lattice points in a body within `half` of the origin.
fn fill(half: i32, shift: Vec3, inside: impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let side = -half - 1..=half + 1;
    let mut points = Vec::new();
    for x in side.clone() {
        for y in side.clone() {
            for z in side.clone() {
                let p = Vec3::new(x.into(), y.into(), z.into()) + shift;
                if inside(&p) {
                    points.push(p);
                }
            }
        }
    }
    points
}

fn with_cube(cube: f64) -> SurfaceSettings {
    SurfaceSettings {
        cube,
        rounds: 0,
        keep_volume: false,
        ..SurfaceSettings::default()
    }
}

fn corners(mesh: &TriMesh) -> impl Iterator<Item = [Vec3; 3]> {
    let at = |v: u32| mesh.positions[v as usize];
    mesh.triangles.iter().map(move |t| t.map(at))
}

fn volume(mesh: &TriMesh) -> f64 {
    corners(mesh)
        .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
        .sum()
}

fn area(mesh: &TriMesh) -> f64 {
    corners(mesh)
        .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
        .sum()
}

/// Every directed edge once, with its opposite; one ring of triangles around each vertex; no flat triangle.
fn assert_closed_manifold_oriented(mesh: &TriMesh) {
    let mut next_around = BTreeMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (v, from, to) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            assert!(
                next_around.insert((v, from), to).is_none(),
                "edge {v}-{from} twice in one direction"
            );
        }
    }
    let mut degree = vec![0; mesh.positions.len()];
    let mut start = vec![None; mesh.positions.len()];
    for (v, from) in next_around.keys() {
        assert!(
            next_around.contains_key(&(*from, *v)),
            "edge {v}-{from} is open"
        );
        degree[*v as usize] += 1;
        start[*v as usize] = Some(*from);
    }
    for v in 0..mesh.positions.len() {
        let start = start[v].expect("every vertex is used");
        let (mut ring, mut at) = (1, next_around[&(v as u32, start)]);
        while at != start {
            at = next_around[&(v as u32, at)];
            ring += 1;
        }
        assert_eq!(ring, degree[v], "vertex {v} joins two fans");
    }
    assert!(corners(mesh).all(|[a, b, c]| (b - a).cross(&(c - a)).norm() > 0.0));
}

#[test]
fn random_clouds_give_closed_manifold_oriented_surfaces() {
    let mut random = Stream::new(1, "clouds");
    let mut ambiguous = 0;
    for cloud in 0..200 {
        let count = 1 + (random.unit() * 60.0) as usize;
        let size = random.between(0.3, 4.0);
        let points: Vec<Vec3> = (0..count).map(|_| random.cube() * size).collect();
        let settings = SurfaceSettings {
            smoothing: random.between(1.0, 3.0),
            cube: [0.25, 0.5, 0.8, 1.0][cloud % 4],
            threshold: random.between(0.05, 0.95),
            rounds: cloud as u32 % 3,
            ..SurfaceSettings::default()
        };
        let surface = reconstruct(&frame_of(&points), None, &settings);
        assert_closed_manifold_oriented(&surface.mesh);
        let speed = surface.speed();
        for i in 0..surface.mesh.positions.len() {
            assert!((surface.normal[i].norm() - 1.0).abs() < 1e-12);
            assert!((0.4..0.6).contains(&surface.polymer_fraction[i]));
            let error = Vec3::from(surface.velocity[i].map(f64::from)) - Vec3::new(1.0, -2.0, 3.0);
            assert!(error.norm() < 1e-5);
            assert!((speed[i] - 14.0_f32.sqrt()).abs() < 1e-5);
        }
        let euler = surface.mesh.positions.len() as i64 - surface.mesh.triangles.len() as i64 / 2;
        ambiguous += i64::from(euler != 2);
    }
    assert!(ambiguous > 50, "the clouds are too tame to prove anything");
}

#[test]
fn noise_at_every_node_gives_a_closed_manifold_surface() {
    // All 256 cases, and every pair of them at a face.
    let mut random = Stream::new(2, "noise");
    let inner = 0..3;
    let mut keys = Vec::new();
    let mut bricks = Vec::new();
    for x in -1..4 {
        for y in -1..4 {
            for z in -1..4 {
                let full = [x, y, z].iter().all(|k| inner.contains(k));
                keys.push([x, y, z]);
                bricks.push(Brick::Nodes(Box::new(std::array::from_fn(|_| {
                    if full {
                        random.unit() as f32 - 0.5
                    } else {
                        -0.5
                    }
                }))));
            }
        }
    }
    let cubes = Cubes {
        keys: &keys,
        bricks: &bricks,
        outside: -0.5,
    };
    let cuts = cubes.cuts();
    let mut mesh = TriMesh::default();
    for (key, cuts) in keys.iter().zip(&cuts) {
        for cut in cuts {
            let first = Vec3::from(key.map(|k| f64::from(k * 8)));
            mesh.positions
                .push(first + Vec3::from(cut.place().map(f64::from)));
        }
    }
    mesh.triangles = cubes.triangles(&cuts);
    assert!(mesh.triangles.len() > 20_000);
    assert_closed_manifold_oriented(&mesh);
    assert!(volume(&mesh) > 0.0, "inside out");
}

/// Particles in concentric shells, one spacing apart, each particle for one unit of volume.
fn shells(radius: i32) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut points = Vec::new();
    for shell in 0..radius {
        let r = f64::from(shell) + 0.5;
        let count = (4.0 * std::f64::consts::PI * (r * r + 1.0 / 12.0)).round();
        for i in 0..count as i32 {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / count;
            let (around, turn) = ((1.0 - z * z).sqrt(), golden * f64::from(i));
            points.push(Vec3::new(around * libm::cos(turn), around * libm::sin(turn), z) * r);
        }
    }
    points
}

#[test]
fn a_ball_of_shells_is_round() {
    for (radius, volume_error, area_error) in [(5, 0.045, 0.005), (10, 0.02, 0.005)] {
        let surface = reconstruct(
            &frame_of(&shells(radius)),
            None,
            &SurfaceSettings::default(),
        );
        let radius = f64::from(radius);
        let made = volume(&surface.mesh);
        let error = made / (4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)) - 1.0;
        assert!(
            error.abs() < volume_error,
            "radius {radius}: volume {error}"
        );
        let roundest = libm::cbrt(36.0 * std::f64::consts::PI * made * made);
        let error = area(&surface.mesh) / roundest - 1.0;
        assert!(
            (0.0..area_error).contains(&error),
            "radius {radius}: area {error}"
        );
        for (p, n) in surface.mesh.positions.iter().zip(&surface.normal) {
            assert!(p.normalize().dot(n) > 0.98, "normal {n} at {p}");
        }
    }
}

#[test]
fn bodies_cut_from_a_lattice_keep_their_volume() {
    let keeps = |points: &[Vec3], tolerance: f64| {
        let mesh = reconstruct(&frame_of(points), None, &SurfaceSettings::default()).mesh;
        assert_closed_manifold_oriented(&mesh);
        let error = volume(&mesh) / points.len() as f64 - 1.0;
        assert!(error.abs() < tolerance, "volume {error}");
        mesh
    };
    for shift in [Vec3::repeat(0.5), Vec3::new(0.13, 0.27, 0.41)] {
        keeps(&fill(5, shift, |p| p.norm() < 5.0), 0.02);
        keeps(&fill(10, shift, |p| p.norm() < 10.0), 0.01);
    }
    let torus = |p: &Vec3| (p.xy().norm() - 10.0).powi(2) + p.z * p.z < 25.0;
    let mesh = keeps(&fill(15, Vec3::repeat(0.5), torus), 0.02);
    assert_eq!(mesh.positions.len(), mesh.triangles.len() / 2, "one hole");
    // Steps of the lattice on a curved wall add area.
    let error = area(&mesh) / (4.0 * std::f64::consts::PI.powi(2) * 50.0) - 1.0;
    assert!((0.0..0.06).contains(&error), "torus: area {error}");
}

#[test]
fn faces_of_a_slab_lie_half_a_spacing_outside_its_particles() {
    let points = fill(15, Vec3::repeat(0.5), |p| p.z.abs() < 5.0);
    let surface = reconstruct(&frame_of(&points), None, &with_cube(0.5));
    let mut seen = 0;
    for (p, n) in surface.mesh.positions.iter().zip(&surface.normal) {
        if p.x.abs() < 8.0 && p.y.abs() < 8.0 {
            seen += 1;
            assert!((p.z.abs() - 5.0).abs() < 0.03, "{p}");
            assert!(n.z * p.z.signum() > 0.999);
        }
    }
    assert!(seen > 1000);
    for (p, alpha) in surface.mesh.positions.iter().zip(&surface.polymer_fraction) {
        if p.x.abs() < 8.0 && p.y.abs() < 8.0 {
            assert!((f64::from(*alpha) - 0.5 - 0.01 * p.x).abs() < 2e-3);
        }
    }
}

#[test]
fn drops_and_filaments_of_single_particles_stay_visible() {
    let of = |points: Vec<Vec3>| {
        let mesh = reconstruct(&frame_of(&points), None, &SurfaceSettings::default()).mesh;
        volume(&mesh) / points.len() as f64
    };
    let drop = of(vec![Vec3::new(0.13, 0.27, 0.41)]);
    let filament = of((0..20).map(|i| Vec3::new(0.13, 0.27, i.into())).collect());
    assert!((0.5..1.1).contains(&drop), "{drop}");
    assert!((0.8..1.1).contains(&filament), "{filament}");
}

#[test]
fn vertices_converge_to_the_field_s_own_surface() {
    let points = fill(3, Vec3::new(0.1, 0.2, 0.3), |p| p.norm() < 3.0);
    let w = |r: f64| f64::from(kernel((r / 2.0) as f32));
    let volumes: Vec<f64> = points
        .iter()
        .map(|p| 1.0 / points.iter().map(|k| w((p - k).norm())).sum::<f64>())
        .collect();
    let phi = |x: &Vec3| -> f64 {
        points
            .iter()
            .zip(&volumes)
            .map(|(p, v)| v * w((x - p).norm()))
            .sum()
    };
    let measure = |cube: f64| {
        let surface = reconstruct(&frame_of(&points), None, &with_cube(cube));
        let positions = &surface.mesh.positions;
        let square: f64 = positions
            .iter()
            .zip(&surface.normal)
            .map(|(p, n)| {
                let slope = (phi(&(p - n * 0.01)) - phi(&(p + n * 0.01))) / 0.02;
                ((phi(p) - 0.6) / slope).powi(2)
            })
            .sum();
        (
            (square / positions.len() as f64).sqrt(),
            volume(&surface.mesh),
        )
    };
    let [coarse, middle, fine] = [0.5, 0.25, 0.125].map(measure);
    let order = |a: f64, b: f64| libm::log2(a / b);
    let distance = [order(coarse.0, middle.0), order(middle.0, fine.0)];
    assert!(distance.iter().all(|o| *o > 1.9), "{distance:?}");
    let volume = order(middle.1 - coarse.1, fine.1 - middle.1);
    assert!(volume > 1.9, "{volume}");
}

#[test]
fn the_surface_has_the_same_bits_on_any_number_of_threads() {
    let mut random = Stream::new(4, "threads");
    let points: Vec<Vec3> = (0..4000).map(|_| random.cube() * 8.0).collect();
    let frame = frame_of(&points);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| reconstruct(&frame, None, &SurfaceSettings::default()))
    };
    let one = on(1);
    assert!(one.mesh.triangles.len() > 1000);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn frames_without_usable_particles_give_an_empty_surface() {
    let empty = Surface::default();
    assert_eq!(
        reconstruct(&Frame::default(), None, &SurfaceSettings::default()),
        empty
    );
    let lost = frame_of(&[Vec3::repeat(f64::NAN), Vec3::repeat(1e30)]);
    assert_eq!(reconstruct(&lost, None, &SurfaceSettings::default()), empty);
}

#[test]
fn settings_out_of_range_are_named() {
    assert_eq!(SurfaceSettings::default().check(), Ok(()));
    let message = with_cube(0.0).check().unwrap_err();
    assert!(
        message.contains("cube") && message.contains("0.1"),
        "{message}"
    );
    let unknown = toml::from_str::<SurfaceSettings>("cubes = 1.0").unwrap_err();
    assert!(unknown.to_string().contains("cube"));
}
