//! Sphere, torus and slab: against the colour field's own surface, and against the body that the particles fill.

use osteoflow::cache::Frame;
use osteoflow::grid::kernel;
use osteoflow::math::{Stream, Vec3};
use osteoflow::mesh::{MeshDistance, TriMesh};
use osteoflow::surface::{SurfaceSettings, bare, reconstruct};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Particles at rest, spacing 1 m.
fn frame_of(points: &[Vec3]) -> Frame {
    Frame {
        spacing: 1.0,
        rest_volume: 1.0,
        support_radius: 2.0,
        position: points.iter().map(|p| p.map(|c| c as f32).into()).collect(),
        velocity: vec![[0.0; 3]; points.len()],
        polymer_fraction: vec![0.5; points.len()],
        ..Frame::default()
    }
}

/// A body by its signed distance [spacings], and which part of its surface is compared.
struct Body {
    name: &'static str,
    distance: fn(&Vec3, f64) -> f64,
    within: fn(&Vec3, f64) -> bool,
    /// How far it reaches, in sizes.
    reach: f64,
    /// Volume and area, for size 1, of a body that is compared as a whole.
    whole: Option<[f64; 2]>,
}

const BODIES: [Body; 3] = [
    Body {
        name: "sphere",
        distance: |p, size| p.norm() - size,
        within: |_, _| true,
        reach: 1.0,
        whole: Some([4.0 / 3.0 * PI, 4.0 * PI]),
    },
    Body {
        name: "torus",
        distance: |p, size| (p.xy().norm() - size).hypot(p.z) - 0.5 * size,
        within: |_, _| true,
        reach: 1.5,
        whole: Some([0.5 * PI * PI, 2.0 * PI * PI]),
    },
    Body {
        name: "slab",
        distance: |p, size| {
            let out = p.abs() - Vec3::new(size, size, 0.5 * size);
            out.map(|c| c.max(0.0)).norm() + out.max().min(0.0)
        },
        // A lattice of particles has no sharp edges.
        within: |p, size| p.x.abs().max(p.y.abs()) < size - 2.5,
        reach: 1.0,
        whole: None,
    },
];

impl Body {
    /// Cut from a lattice.
    fn of_lattice(&self, size: f64, shift: Vec3) -> Frame {
        let half = (self.reach * size).ceil() as i32 + 1;
        let mut points = Vec::new();
        for x in -half..=half {
            for y in -half..=half {
                for z in -half..=half {
                    let p = Vec3::from([x, y, z].map(f64::from)) + shift;
                    if (self.distance)(&p, size) < 0.0 {
                        points.push(p);
                    }
                }
            }
        }
        frame_of(&points)
    }

    /// In layers along its surface, as a flow arranges particles: nothing of a lattice's steps.
    fn of_layers(&self, size: f64) -> Frame {
        let points = match self.name {
            "sphere" => layered_ball(size as i32),
            "torus" => layered_torus(size, (0.5 * size) as i32),
            _ => return self.of_lattice(size, Vec3::repeat(0.5)),
        };
        frame_of(&points)
    }
}

fn layered_ball(layers: i32) -> Vec<Vec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let mut points = Vec::new();
    for layer in 0..layers {
        let r = f64::from(layer) + 0.5;
        let count = (4.0 * PI * (r * r + 1.0 / 12.0)).round();
        for i in 0..count as i32 {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / count;
            let (around, turn) = ((1.0 - z * z).sqrt(), golden * f64::from(i));
            points.push(Vec3::new(around * turn.cos(), around * turn.sin(), z) * r);
        }
    }
    points
}

fn layered_torus(radius: f64, layers: i32) -> Vec<Vec3> {
    let mut points = Vec::new();
    for layer in 0..layers {
        let r = f64::from(layer) + 0.5;
        let rings = (2.0 * PI * r).round() as i32;
        for ring in 0..rings {
            let angle = 2.0 * PI * (f64::from(ring) + 0.5) / f64::from(rings);
            let (around, z) = (radius + r * angle.cos(), r * angle.sin());
            let count = (2.0 * PI * around).round() as i32;
            for i in 0..count {
                // Each ring by half a place on from the last.
                let turn = 2.0 * PI * (f64::from(i) + 0.5 * f64::from(ring)) / f64::from(count);
                points.push(Vec3::new(around * turn.cos(), around * turn.sin(), z));
            }
        }
    }
    points
}

fn corners(mesh: &TriMesh) -> impl Iterator<Item = [Vec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t))
}

/// Vertices and centres of triangles.
fn samples(mesh: &TriMesh) -> Vec<Vec3> {
    let centres = corners(mesh).map(|[a, b, c]| (a + b + c) / 3.0);
    mesh.positions.iter().copied().chain(centres).collect()
}

fn order(coarse: f64, fine: f64) -> f64 {
    libm::log2(coarse / fine)
}

#[test]
fn triangles_converge_to_the_field_s_own_surface_in_the_cube() {
    for body in &BODIES {
        let frame = body.of_lattice(3.2, Vec3::new(0.1, 0.2, 0.3));
        let points: Vec<Vec3> = (frame.position.iter())
            .map(|p| Vec3::from(p.map(f64::from)))
            .collect();
        let w = |r: f64| f64::from(kernel((r / 2.0) as f32));
        let volumes: Vec<f64> = points
            .iter()
            .map(|p| 1.0 / points.iter().map(|k| w((p - k).norm())).sum::<f64>())
            .collect();
        let phi = |x: &Vec3| -> f64 {
            let near = points.iter().zip(&volumes);
            near.map(|(p, v)| v * w((x - p).norm())).sum()
        };
        // Newton's step towards the surface is the distance from it, but for terms of second order in itself.
        let away = |x: &Vec3| {
            let slope = Vec3::from_fn(|a, _| {
                let step = Vec3::ith(a, 0.01);
                (phi(&(x + step)) - phi(&(x - step))) / 0.02
            });
            (phi(x) - 0.6).abs() / slope.norm()
        };
        let measure = |cube: f64| {
            let settings = SurfaceSettings {
                cube,
                ..SurfaceSettings::default()
            };
            let mesh = bare(&frame, None, &settings);
            let square: Vec<f64> = samples(&mesh).par_iter().map(|x| away(x).powi(2)).collect();
            let farthest = square.iter().copied().fold(0.0, f64::max);
            let mean = square.iter().sum::<f64>() / square.len() as f64;
            [farthest.sqrt(), mean.sqrt()]
        };
        let [coarse, middle, fine] = [0.5, 0.25, 0.125].map(measure);
        let orders = |k: usize| [order(coarse[k], middle[k]), order(middle[k], fine[k])];
        let (farthest, mean) = (orders(0), orders(1));
        // Measured: farthest 1.68 (sphere, still coarse), 1.97; 1.90, 1.94; 1.94, 2.02; mean square 1.92 to 2.02.
        assert!(
            farthest[0] > 1.6 && farthest[1] > 1.9,
            "{}: {farthest:?}",
            body.name
        );
        assert!(
            mean.iter().all(|order| *order > 1.9),
            "{}: {mean:?}",
            body.name
        );
    }
}

#[test]
fn surfaces_converge_to_the_exact_body_in_the_spacing() {
    for body in &BODIES {
        let measure = |size: f64, frame: &Frame| {
            let mesh = reconstruct(frame, None, &SurfaceSettings::default()).mesh;
            let distance = |p: &Vec3| (body.distance)(p, size);
            let outward = (samples(&mesh).iter())
                .filter(|p| (body.within)(p, size))
                .map(|p| distance(p).abs())
                .fold(0.0, f64::max);
            // Points of the body's surface: its distance is exact, so one step leads there.
            let mut random = Stream::new(5, body.name);
            let to_mesh = MeshDistance::new(&mesh);
            let mut tried = 0;
            let mut inward = 0.0_f64;
            while tried < 2000 {
                let x = random.cube() * (size * body.reach);
                let slope = Vec3::from_fn(|a, _| {
                    let step = Vec3::ith(a, 1e-6);
                    (distance(&(x + step)) - distance(&(x - step))) / 2e-6
                });
                let p = x - slope * distance(&x);
                if distance(&p).abs() < 1e-4 && (body.within)(&p, size) {
                    tried += 1;
                    inward = inward.max(to_mesh.signed(&p).abs());
                }
            }
            let errors = body.whole.map_or([0.0; 2], |[volume, area]| {
                [
                    mesh.signed_volume() / (volume * size.powi(3)) - 1.0,
                    mesh.area() / (area * size.powi(2)) - 1.0,
                ]
            });
            (outward.max(inward), errors)
        };
        let sizes = [6.0, 12.0, 24.0];
        let layers = sizes.map(|size| measure(size, &body.of_layers(size)));
        let observed = order(layers[0].0 / sizes[0], layers[2].0 / sizes[2]) / 2.0;
        // Measured: sphere 1.39, torus 1.93, slab 1.83.
        assert!(observed > 1.3, "{}: {observed}", body.name);
        let shift = if body.whole.is_some() {
            Vec3::new(0.13, 0.27, 0.41)
        } else {
            Vec3::repeat(0.5)
        };
        let lattice = measure(24.0, &body.of_lattice(24.0, shift));
        for (distance, [volume, area]) in [layers[2], lattice] {
            // Half a spacing is what steps of a lattice are.
            assert!(distance < 0.5, "{}: {distance}", body.name);
            assert!(volume.abs() < 0.003, "{}: volume {volume}", body.name);
            assert!(area.abs() < 0.005, "{}: area {area}", body.name);
        }
        assert!(layers[2].0 < 0.07, "{}: {layers:?}", body.name);
    }
}

/// A flat face may lie anywhere between two layers of a lattice: the particles are the same, and so is every surface made
/// of them. Half a spacing is what no reconstruction does without; where it is lost here as well, it is not ours.
#[test]
fn half_a_spacing_of_doubt_is_the_lattice_s_own() {
    let slab = |half: f64| {
        let mut points = Vec::new();
        for i in 0..20 * 20 * 20 {
            let p = Vec3::from([i % 20, i / 20 % 20, i / 400].map(|c| f64::from(c) - 9.5));
            if p.z.abs() < half {
                points.push(p);
            }
        }
        frame_of(&points)
    };
    let (thin, thick) = (4.51, 5.49);
    assert_eq!(slab(thin).position, slab(thick).position);
    let mesh = reconstruct(&slab(thin), None, &SurfaceSettings::default()).mesh;
    let farthest = |half: f64| {
        let middle = samples(&mesh);
        let middle = middle.iter().filter(|p| p.x.abs().max(p.y.abs()) < 6.0);
        middle.map(|p| (p.z.abs() - half).abs()).fold(0.0, f64::max)
    };
    let (low, high) = (farthest(thin), farthest(thick));
    // Measured: 0.54 and 0.44, as volume lost at edges is given back on faces. Whatever the surface, the larger is not
    // below 0.49.
    assert!((0.49..0.56).contains(&low.max(high)), "{low} {high}");
}

/// What the sizes share in is the mean over surface and places. The farthest point errs by half a spacing at every size,
/// which is first order, and as good as the lattice allows. Worst of 24 places, in spacings, at sizes of 6, 8.5, 12, 17, 24
/// and 34: sphere 0.41, 0.43, 0.49, 0.50, 0.52, 0.53; torus 0.44, 0.44, 0.48, 0.52, 0.51, 0.53; slab 0.62, 0.58, 0.56,
/// 0.55, 0.52, 0.53. Orders fitted to these are 0.85, 0.88 and 1.10: steps of small round bodies are narrow enough to be
/// smoothed, so the bound is met from below. Splashsurf 0.14, with 25 rounds of its own smoothing, at six of these places
/// and sizes up to 24: sphere 0.45, 0.50, 0.46, 0.46, 0.46 where these are 0.33, 0.43, 0.42, 0.45, 0.47; torus 0.49, 0.42,
/// 0.49, 0.52, 0.50 where these are 0.44, 0.39, 0.46, 0.51, 0.50.
#[test]
fn bodies_cut_from_a_lattice_converge_in_the_mean_and_err_by_half_a_spacing_at_most() {
    for body in &BODIES {
        let mut random = Stream::new(3, body.name);
        let shifts: Vec<Vec3> = (0..8).map(|_| random.cube() * 0.5).collect();
        let errors = [6.0, 12.0, 24.0].map(|size| {
            let (mut square, mut count, mut farthest) = (0.0, 0.0, 0.0_f64);
            for shift in &shifts {
                let frame = body.of_lattice(size, *shift);
                let mesh = reconstruct(&frame, None, &SurfaceSettings::default()).mesh;
                for p in samples(&mesh).iter().filter(|p| (body.within)(p, size)) {
                    let distance = (body.distance)(p, size);
                    square += distance * distance;
                    count += 1.0;
                    farthest = farthest.max(distance.abs());
                }
                let volume = mesh.signed_volume() / frame.position.len() as f64 - 1.0;
                assert!(
                    volume.abs() < 0.001,
                    "{} {size}: volume {volume}",
                    body.name
                );
            }
            [(square / count).sqrt() / size, farthest]
        });
        let orders = [0, 1].map(|k| order(errors[k][0], errors[k + 1][0]));
        // Measured: sphere 1.12, 1.03; torus 1.21, 1.10; slab 1.27, 1.08; farthest 0.50 spacings.
        assert!(
            orders.iter().all(|order| *order > 1.0),
            "{}: {orders:?}",
            body.name
        );
        let farthest = errors.map(|[_, farthest]| farthest);
        assert!(
            farthest.iter().all(|distance| *distance < 0.53),
            "{}: {farthest:?}",
            body.name
        );
    }
}
