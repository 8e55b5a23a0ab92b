//! Real bones, as they are and damaged: what is inside stays inside.

mod shared;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use osteoflow::math::{Aabb, Stream, Vec3};
use osteoflow::mesh::{
    Lattice, LengthUnit, MeshDistance, TriMesh, UpAxis, inside_columns, inspect, read_obj, repaired,
};

const BONES: [(&str, LengthUnit); 4] = [
    ("bones/vhm_L3_m.obj", LengthUnit::Metre),
    ("bones/ssm_mean_L3_mm.obj", LengthUnit::Millimetre),
    ("bones/vhm_L3_body_unwelded_m.obj", LengthUnit::Metre),
    ("bones/trabecular_2p3mm_mm.obj", LengthUnit::Millimetre),
];

fn bone(which: usize) -> Option<TriMesh> {
    let (name, unit) = BONES[which];
    Some(read_obj(&shared::file(name)?, unit, UpAxis::Z).expect("an OBJ"))
}

/// Share of the nodes around `whole` where `mesh` says the same, by distance and by columns.
fn agreement(mesh: &TriMesh, whole: &TriMesh) -> [f64; 2] {
    let bounds = whole.bounds();
    let lattice = Lattice::cells(
        &bounds.grown(0.03 * bounds.extent().max()),
        bounds.extent().max() / 60.0,
    );
    let truth = inside_columns(whole, &lattice);
    let distance = MeshDistance::new(mesh);
    let columns = inside_columns(mesh, &lattice);
    let total = truth.len() as f64;
    let by_distance = (0..truth.len())
        .filter(|&n| (distance.signed(&lattice.position(n)) < 0.0) == truth[n])
        .count();
    let by_columns = columns.iter().zip(&truth).filter(|(a, b)| a == b).count();
    [by_distance as f64 / total, by_columns as f64 / total]
}

fn torn(mesh: &TriMesh, shake: f64, random: &mut Stream) -> TriMesh {
    TriMesh {
        positions: (0..mesh.triangles.len())
            .flat_map(|t| mesh.corners(t))
            .map(|p| p + random.cube() * shake)
            .collect(),
        triangles: (0..mesh.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    }
}

#[test]
fn damaged_bones_keep_their_inside() {
    for which in [0, 1] {
        let Some(stored) = bone(which) else { return };
        let (whole, notes) = repaired(stored).expect("a closed bone");
        assert!(notes.is_empty(), "{notes:?}");
        let size = whole.bounds().extent().max();
        let mut random = Stream::new(3, "damage");
        let mut dropped = whole.clone();
        dropped.triangles.retain(|_| random.unit() > 0.05);
        let mut flipped = dropped.clone();
        for triangle in &mut flipped.triangles {
            if random.unit() < 0.3 {
                triangle.swap(0, 1);
            }
        }
        let mut doubled = whole.clone();
        for t in 0..whole.triangles.len() / 10 {
            doubled
                .triangles
                .push(whole.triangles[7 * t % whole.triangles.len()]);
        }
        // One hole of a twentieth of the area, on top.
        let mut order: Vec<usize> = (0..whole.triangles.len()).collect();
        order.sort_by(|a, b| whole.corners(*b)[0].z.total_cmp(&whole.corners(*a)[0].z));
        let mut holed = whole.clone();
        let mut removed = vec![false; order.len()];
        let part = |t: usize| {
            let one = TriMesh {
                positions: whole.positions.clone(),
                triangles: vec![whole.triangles[t]],
            };
            one.area()
        };
        let mut left = 0.05 * whole.area();
        for t in order {
            left -= part(t);
            removed[t] = left > 0.0;
        }
        let mut flags = removed.iter();
        holed
            .triangles
            .retain(|_| !flags.next().expect("one flag a triangle"));
        // A bar pushed through the body, as a separate shell.
        let centre = whole.centroid();
        let bar = osteoflow::mesh::tube(
            &(centre - Vec3::x() * 0.3 * size),
            &Vec3::x(),
            0.6 * size,
            0.01 * size,
            0.03 * size,
        );
        let mut pierced = whole.clone();
        pierced.append(&bar);
        let inside_out = torn(&flipped, 0.0, &mut random).flipped();
        let cases = [
            ("dropped", dropped, whole.clone(), 0.99),
            ("flipped", flipped, whole.clone(), 0.99),
            ("doubled", doubled, whole.clone(), 0.999),
            ("holed", holed, whole.clone(), 0.99),
            ("torn", torn(&whole, 0.0, &mut random), whole.clone(), 0.999),
            (
                "jittered",
                torn(&whole, 3e-6 * size, &mut random),
                whole.clone(),
                0.999,
            ),
            ("inside out", inside_out, whole.clone(), 0.99),
            ("pierced", pierced.clone(), pierced, 0.998),
        ];
        for (what, damaged, whole, least) in cases {
            let (mesh, notes) = repaired(damaged).expect(what);
            let [distance, columns] = agreement(&mesh, &whole);
            eprintln!(
                "{} {what}: {distance:.5} {columns:.5} {notes:?}",
                BONES[which].0
            );
            assert!(
                distance >= least && columns >= least,
                "{what}: {distance} {columns} {notes:?}"
            );
        }
    }
}

#[test]
fn volume_does_not_depend_on_place_and_turn() {
    for (which, step) in [(0, 0.5e-3), (1, 0.5e-3), (2, 0.5e-3), (3, 0.02e-3)] {
        let Some(stored) = bone(which) else { return };
        let (mesh, _) = repaired(stored).expect("a bone");
        let exact = mesh.signed_volume();
        let volume = |mesh: &TriMesh| {
            let lattice = Lattice::cells(&mesh.bounds(), step);
            let inside = inside_columns(mesh, &lattice);
            inside.iter().filter(|inside| **inside).count() as f64 * step.powi(3) / exact - 1.0
        };
        let as_it_is = volume(&mesh);
        assert!(as_it_is.abs() < 5e-3, "{which}: {as_it_is}");
        let mut random = Stream::new(5, "turns");
        let mut worst: f64 = 0.0;
        for _ in 0..24 {
            let turn = UnitQuaternion::new(Vector3::from(random.cube() * 3.0));
            // A metre away, where single precision would already be too coarse.
            let motion = Isometry3::from_parts(Translation3::from(random.cube()), turn);
            worst = worst.max(volume(&mesh.transformed(&motion)).abs());
        }
        eprintln!("{}: {as_it_is:.5}, turned {worst:.5}", BONES[which].0);
        assert!(worst < 1e-2, "{which}: {worst}");
    }
}

#[test]
fn scale_and_unit_and_distance_from_the_origin_do_not_matter() {
    let Some(stored) = bone(2) else { return };
    let (whole, _) = repaired(stored.clone()).expect("a bone");
    for (scale, shift) in [(1000.0, 0.0), (1.0, 1.0), (1000.0, 1e5)] {
        let mut moved = stored.clone();
        for p in &mut moved.positions {
            *p = *p * scale + Vec3::repeat(shift);
        }
        let (mesh, _) = repaired(moved).expect("a bone");
        assert!(inspect(&mesh).is_closed());
        let volume = mesh.signed_volume() / (whole.signed_volume() * scale.powi(3)) - 1.0;
        assert!(volume.abs() < 1e-6, "{volume}");
    }
}

/// A shell inside a shell, either way round: a bubble if they face against each other.
#[test]
fn bubbles_stay_bubbles() {
    let ball = |radius: f64| {
        let bounds = Aabb {
            min: Vec3::repeat(-1.3),
            max: Vec3::repeat(1.3),
        };
        osteoflow::mesh::surface_nets(&bounds, 0.1, |x| x.norm() - radius)
    };
    let (outer, inner) = (ball(1.0), ball(0.5));
    let hollow = outer.signed_volume() - inner.signed_volume();
    let mut bubble = outer.clone();
    bubble.append(&inner.clone().flipped());
    let mut double = outer.clone();
    double.append(&inner);
    for (mesh, volume) in [
        (bubble.clone(), hollow),
        (bubble.flipped(), hollow),
        (double.clone(), outer.signed_volume()),
        (double.flipped(), outer.signed_volume()),
    ] {
        let (mesh, _) = repaired(mesh).expect("closed");
        let distance = MeshDistance::new(&mesh);
        let centre = distance.signed(&Vec3::zeros());
        let between = distance.signed(&Vec3::new(0.8, 0.0, 0.0));
        if volume == hollow {
            assert!((centre - 0.5).abs() < 0.02, "{centre}");
        } else {
            assert!((centre + 1.0).abs() < 0.02, "{centre}");
        }
        assert!((between + 0.2).abs() < 0.02, "{between}");
    }
}
