//! Bones against what was asked, and against exact distances.

use super::*;
use crate::math::{Aabb, Real, Stream, Vec3};
use crate::mesh::tests::cuboid;

const SPACING: Real = 0.5e-3;

fn block() -> crate::mesh::TriMesh {
    cuboid(Vec3::zeros(), Vec3::new(0.014, 0.012, 0.016))
}

fn region(name: &str, place: Place, period: Real, struts: Struts) -> Region {
    Region {
        name: name.into(),
        place,
        period,
        struts,
    }
}

#[test]
fn porosity_is_made_as_asked_and_everything_hangs_together() {
    let mut settings = BoneSettings {
        nodes_per_spacing: 4.0,
        ..Default::default()
    };
    for asked in [0.75, 0.84, 0.92] {
        settings.regions[0].struts = Struts::Porosity(asked);
        let report = build(&block(), &settings, SPACING, &[]).unwrap().report;
        let made = report.regions[0].porosity;
        assert!((made - asked).abs() < 0.01, "{asked}: {made}");
        assert!(report.bone_connected > 0.99, "{report:?}");
        assert!(report.pores_connected > 0.99, "{report:?}");
        let inner = (0.014 - 0.0016) * (0.012 - 0.0016) * (0.016 - 0.0016);
        let shell = 0.014 * 0.012 * 0.016 - inner;
        assert!((report.shell_volume / shell - 1.0).abs() < 0.01);
        let bone = shell + (1.0 - made) * inner;
        assert!((report.bone_volume / bone - 1.0).abs() < 0.01, "{report:?}");
    }
}

/// Straight struts of a regular lattice have a window that is known exactly.
#[test]
fn throat_of_a_regular_lattice_is_its_window() {
    let mut settings = BoneSettings {
        jitter: 0.0,
        vertical: 1.0,
        ..Default::default()
    };
    settings.regions[0].struts = Struts::Diameter(0.5e-3);
    let report = build(&block(), &settings, SPACING, &[]).unwrap().report;
    let region = &report.regions[0];
    let window = 2e-3 - 0.5e-3;
    let voxel = SPACING / 4.0;
    assert!(
        (region.throat_diameter - window).abs() <= 2.0 * voxel,
        "{region:?}"
    );
    let cell = 2e-3 * libm::sqrt(2.0) - 0.5e-3;
    assert!(region.pore_diameter > window - voxel && region.pore_diameter < cell + voxel);
}

#[test]
fn two_regions_differ_as_asked_and_share_one_network() {
    let settings = BoneSettings {
        regions: vec![
            region(
                "sparse",
                Place::HalfSpace {
                    point: Vec3::new(0.0, 0.0, 0.008),
                    normal: Vec3::z(),
                },
                2.6e-3,
                Struts::Porosity(0.92),
            ),
            region("dense", Place::Everywhere, 2e-3, Struts::Porosity(0.84)),
        ],
        ..Default::default()
    };
    let report = build(&block(), &settings, SPACING, &[]).unwrap().report;
    for (region, asked) in report.regions.iter().zip([0.92, 0.84]) {
        assert!((region.porosity - asked).abs() < 0.02, "{region:?}");
    }
    assert!(report.bone_connected > 0.99, "{report:?}");
    assert!(report.regions[0].throat_diameter >= report.regions[1].throat_diameter);
}

#[test]
fn grid_is_the_exact_distance_near_the_surface() {
    let settings = BoneSettings::default();
    let bone = build(&block(), &settings, SPACING, &[]).unwrap();
    let bounds = Aabb {
        min: Vec3::repeat(0.8e-3),
        max: Vec3::new(0.0132, 0.0112, 0.0152),
    };
    let mut random = Stream::new(6, "bone");
    let (mut bias, mut count) = (0.0, 0.0);
    for _ in 0..20_000 {
        let x = bounds.centre() + random.cube().component_mul(&bounds.extent()) * 0.5;
        let wall = (x - bounds.min).min().min((bounds.max - x).min());
        let struts = bone.struts.iter().map(|strut| strut.distance(&x));
        let exact = struts.fold(wall, Real::min);
        if exact.abs() < 0.3 * SPACING {
            let error = bone.solid.sample(&x).0 - exact;
            assert!(error.abs() < 0.15 * SPACING, "{error}");
            bias += error;
            count += 1.0;
        }
    }
    let bias = bias / count / SPACING;
    assert!(count > 1000.0 && bias.abs() < 0.02, "{bias}");
}

/// The box is built as it is in the whole bone, and far less is built.
#[test]
fn within_a_box_the_bone_is_the_same() {
    let mut settings = BoneSettings::default();
    settings.regions[0].struts = Struts::Porosity(0.84);
    let whole = build(&block(), &settings, SPACING, &[]).unwrap();
    let bounds = Aabb {
        min: Vec3::new(0.004, -0.001, 0.009),
        max: Vec3::new(0.008, 0.003, 0.0122),
    };
    settings.within = Some(bounds);
    let part = build(&block(), &settings, SPACING, &[]).unwrap();
    assert_eq!(part.struts, whole.struts);
    assert!(6 * part.solid.brick_count() < whole.solid.brick_count());
    let mut random = Stream::new(7, "within");
    for _ in 0..5000 {
        let x = bounds.centre() + random.cube().component_mul(&bounds.extent()) * 0.5;
        assert_eq!(part.solid.sample(&x), whole.solid.sample(&x));
    }
    settings.within = Some(Aabb::empty());
    let refused = build(&block(), &settings, SPACING, &[]).unwrap_err();
    assert!(refused.to_string().contains("bone.within"));
}

/// A few struts a node, as many along each axis as along the others.
#[test]
fn the_network_is_sparse_and_has_no_direction() {
    let bone = build(&block(), &BoneSettings::default(), SPACING, &[]).unwrap();
    let mut ends: Vec<[u64; 3]> = Vec::new();
    let mut squares = Vec3::zeros();
    for strut in &bone.struts {
        ends.extend([strut.from, strut.to].map(|end| [end.x, end.y, end.z].map(Real::to_bits)));
        let along = (strut.to - strut.from).normalize();
        squares += along.component_mul(&along);
    }
    let total = ends.len() as Real;
    ends.sort_unstable();
    ends.dedup();
    let a_node = total / ends.len() as Real;
    assert!((2.0..3.5).contains(&a_node), "{a_node}");
    let share = squares / bone.struts.len() as Real;
    assert!(share.add_scalar(-1.0 / 3.0).amax() < 0.06, "{share}");
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut settings = BoneSettings::default();
        settings.regions[0].struts = Struts::Porosity(0.84);
        let bone = pool.install(|| build(&block(), &settings, 2.0 * SPACING, &[]).unwrap());
        let bricks: Vec<_> = bone.solid.bricks().map(|(f, v)| (f, *v)).collect();
        (bricks, bone.report)
    };
    let (one, two) = (on(1), on(2));
    assert!(one.0 == two.0 && one.1 == two.1 && !one.0.is_empty());
}

#[test]
fn a_bore_is_open_through_shell_and_struts() {
    let channel = Channel {
        base: Vec3::new(0.007, -0.002, 0.008),
        axis: Vec3::y(),
        length: 0.01,
        radius: 1.4e-3,
    };
    let bone = build(&block(), &BoneSettings::default(), SPACING, &[channel]).unwrap();
    for step in 0..100 {
        let on_axis = channel.base + channel.axis * (0.0099 * Real::from(step) / 99.0);
        let (phi, _) = bone.solid.sample(&on_axis);
        let along = (on_axis - channel.base).norm();
        let to_bone = (0.01 - along)
            .min(1.4e-3)
            .min((0.002 - along).abs().max(along - 0.002));
        assert!(phi > to_bone - 0.1 * SPACING, "{step} {phi}");
    }
}

#[test]
fn impossible_settings_are_refused() {
    let refused = |change: &dyn Fn(&mut BoneSettings), spacing| {
        let mut settings = BoneSettings::default();
        change(&mut settings);
        build(&block(), &settings, spacing, &[])
            .unwrap_err()
            .to_string()
    };
    assert!(refused(&|s| s.regions.clear(), SPACING).contains("regions"));
    assert!(
        refused(&|s| s.regions[0].struts = Struts::Porosity(1.2), SPACING).contains("porosity")
    );
    assert!(refused(&|s| s.regions[0].period = 1e-6, SPACING).contains("period"));
    assert!(refused(&|s| s.jitter = Real::NAN, SPACING).contains("jitter"));
    assert!(refused(&|_| {}, 1e-7).contains("spacing"));
    assert!(refused(&|_| {}, 0.0).contains("spacing"));
}
