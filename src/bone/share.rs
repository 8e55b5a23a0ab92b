//! How much of the voxel around a node is solid, from φ at the node.

use crate::math::Real;

/// The share of a voxel around a node that is solid [1], from φ [m] at the node.
///
/// Summed over nodes this is the mean of the volumes V(c) of φ < c for c within half a voxel h of 0: that of a slab is
/// right, that of a rod of radius r is too much by V″ h²/24, a share of h²/(12 r²).
pub(super) fn solid_share(phi: Real, voxel: Real) -> Real {
    (0.5 - phi / voxel).clamp(0.0, 1.0)
}

/// The same less V″ h²/24, for sums over rods: exact for those that do not taper, with their ends and crossings, as long
/// as r ≥ 3 h/2; too much by 0.2 % for r = h, by 1.3 % for 0.7 h, by 5 % for h/2. Not for slabs thinner than 3 h, of
/// which it takes away what is there. At a single node it may be a little below 0 or above 1.
pub(super) fn unbiased_share(phi: Real, voxel: Real) -> Real {
    let share = |offset: Real| solid_share(phi + offset, voxel);
    share(0.0) - (share(-voxel) - 2.0 * share(0.0) + share(voxel)) / 24.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::build::build_alone as build;
    use crate::bone::{BoneSettings, Sources, Strut, Struts};
    use crate::math::{Stream, Vec3};
    use crate::mesh::tests::cuboid;
    use core::f64::consts::PI;

    const VOXEL: Real = 0.125;
    /// Length of the rods and edge of the piece of slab [voxels].
    const LENGTH: i32 = 16;
    const PLACINGS: usize = 100;

    /// Sums over the nodes of a box around the origin, plain and unbiased [voxels].
    fn sums(half: [i32; 3], phi: impl Fn(&Vec3) -> Real) -> [Real; 2] {
        let [x, y, z] = half.map(|half| -half..half);
        let mut sums = [0.0; 2];
        for x in x {
            for y in y.clone() {
                for z in z.clone() {
                    let phi = phi(&(Vec3::new(x.into(), y.into(), z.into()) * VOXEL));
                    sums[0] += solid_share(phi, VOXEL);
                    sums[1] += unbiased_share(phi, VOXEL);
                }
            }
        }
        sums
    }

    /// A direction, and one across it.
    fn directions(stream: &mut Stream) -> [Vec3; 2] {
        let along = loop {
            let along = stream.cube();
            if (0.1..1.0).contains(&along.norm()) {
                break along.normalize();
            }
        };
        let across = along.cross(&Vec3::from_fn(|axis, _| f64::from(axis == along.iamin())));
        [along, across.normalize()]
    }

    /// Relative errors of volume, plain and unbiased, over many placings of `count` rods that cross in their middles, and
    /// the plain one that is expected.
    fn of_rods(count: usize, radius: Real) -> ([Real; 2], Real) {
        let length = Real::from(LENGTH);
        let of = |rod: Real, both: Real| count as Real * rod - (count - 1) as Real * both;
        let capsule = PI * radius.powi(2) * (length + 4.0 / 3.0 * radius);
        let exact = of(capsule, 16.0 / 3.0 * radius.powi(3));
        let second = of(2.0 * PI * (length + 4.0 * radius), 32.0 * radius);
        let half = [(0.5 * length + radius).ceil() as i32 + 3; 3];
        let mut stream = Stream::new(5, "rods");
        let mut sum = [0.0; 2];
        for _ in 0..PLACINGS {
            let centre = stream.cube() * (0.5 * VOXEL);
            let rods = directions(&mut stream).map(|along| Strut {
                from: centre - along * (0.5 * length * VOXEL),
                to: centre + along * (0.5 * length * VOXEL),
                radius: [radius * VOXEL; 2],
            });
            let rods = &rods[..count];
            let distances = |x: &Vec3| rods.iter().map(|rod| rod.distance(x)).reduce(Real::min);
            let found = sums(half, |x| distances(x).unwrap()).map(|found| found / exact - 1.0);
            assert!(
                found[1].abs() < found[0].abs(),
                "{count} {radius}: {found:?}"
            );
            sum = std::array::from_fn(|n| sum[n] + found[n] / PLACINGS as Real);
        }
        (sum, second / 24.0 / exact)
    }

    #[test]
    fn rods_and_crossings_have_their_volume() {
        for count in [1, 2] {
            for radius in [1.0, 1.5, 2.0, 3.0, 4.0] {
                let ([plain, unbiased], expected) = of_rods(count, radius);
                let told = format!("{count} {radius}: {plain} {expected} {unbiased}");
                let bound = 0.002 / (radius * radius);
                assert!((plain - expected).abs() < bound, "{told}");
                assert!(unbiased.abs() < bound, "{told}");
                assert!(expected > 25.0 * bound, "{told}");
            }
        }
    }

    /// Over whole columns of voxels.
    #[test]
    fn slabs_have_their_volume() {
        for thickness in [3.0, 4.0, 6.0, 8.0] {
            let mut stream = Stream::new(5, "slabs");
            let mut sum = [0.0; 2];
            for _ in 0..PLACINGS {
                let centre = stream.cube() * (0.5 * VOXEL);
                let normal = (stream.cube() + Vec3::z() * 2.0).normalize();
                let exact = Real::from(LENGTH).powi(2) * thickness / normal.z;
                let half = LENGTH / 2;
                let found = sums([half, half, 4 * half], |x| {
                    (x - centre).dot(&normal).abs() - 0.5 * thickness * VOXEL
                });
                sum = std::array::from_fn(|n| sum[n] + (found[n] / exact - 1.0) / PLACINGS as Real);
            }
            assert!(
                sum.iter().all(|error| error.abs() < 1e-4),
                "{thickness}: {sum:?}"
            );
        }
    }

    /// The report of a bone against points between its very struts, of 1 to 3 voxels radius in the mean.
    #[test]
    fn porosity_is_that_of_the_struts() {
        let size = Vec3::new(0.014, 0.012, 0.016);
        let block = cuboid(Vec3::zeros(), size);
        for asked in [0.75, 0.92] {
            let [coarse, fine] = [2.0, 3.0].map(|nodes_per_spacing| {
                let mut settings = BoneSettings {
                    nodes_per_spacing,
                    ..Default::default()
                };
                settings.regions[0].struts = Struts::Porosity(asked);
                build(&block, &settings, &Sources::default(), 0.5e-3, &[]).unwrap()
            });
            assert_eq!(coarse.struts, fine.struts);
            // One point in each cell of 0.2 mm below the shell.
            let (shell, step) = (BoneSettings::default().shell_thickness, 0.2e-3);
            let cells = size.map(|edge| ((edge - 2.0 * shell) / step).round() as u32);
            let mut stream = Stream::new(5, "points");
            let [mut open, mut all] = [0.0; 2];
            for x in 0..cells.x {
                for y in 0..cells.y {
                    for z in 0..cells.z {
                        let within =
                            [x, y, z].map(|n| shell + step * (Real::from(n) + stream.unit()));
                        let mut struts = coarse.struts.iter();
                        let free = struts.all(|strut| strut.distance(&within.into()) > 0.0);
                        open += Real::from(u8::from(free));
                        all += 1.0;
                    }
                }
            }
            for bone in [&coarse, &fine] {
                let told = bone.report.regions[0].porosity;
                assert!((told - open / all).abs() < 0.001, "{told} {}", open / all);
            }
        }
    }
}
