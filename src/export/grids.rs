//! A frame as volumes: how much cement there is, how much of it is polymer, how fast it moves.

use super::{Class, ExportSettings, Grid, Leaf, Leaves, y_up};
use crate::cache::Frame;
use crate::grid::{BRICK, PointBricks, crowding};
use crate::math::Vec3;
use rayon::prelude::*;

/// `density` (about 1 inside, fading to 0 across the surface), `polymer` (α of the polymer phase) and the velocity
/// [m/s]; the same bits on any number of threads. α and velocity are Shepard means, so they do not fade.
pub fn from_frame(frame: &Frame, settings: &ExportSettings) -> Vec<Grid> {
    let voxel = settings.voxel * frame.spacing;
    let position: Vec<[f32; 3]> = frame.position.iter().map(|p| y_up(*p)).collect();
    let radius = settings.smoothing * frame.spacing;
    let points = PointBricks::new(&position, voxel, radius);
    let crowding = crowding(&position, radius);
    // V, V α, V v of each particle; V as in the surface's colour field.
    let carried: Vec<[f32; 5]> = points
        .order
        .iter()
        .map(|&i| {
            let i = i as usize;
            let [u, v, w] = y_up(frame.velocity[i]);
            [1.0, frame.polymer_fraction[i], u, v, w].map(|x| x / crowding[i])
        })
        .collect();
    let leaves: Vec<_> = points
        .touched()
        .par_iter()
        .filter_map(|&key| {
            let sums = points.near(key).node_sums(|j| carried[j]);
            let mut active = [0_u64; 8];
            for i in 0..512 {
                if f64::from(sums[0][i]) > settings.active_above {
                    active[i >> 6] |= 1 << (i & 63);
                }
            }
            if active == [0; 8] {
                return None;
            }
            let mean = |channel: usize, i: usize| {
                if active[i >> 6] >> (i & 63) & 1 == 1 {
                    sums[channel][i] / sums[0][i]
                } else {
                    0.0
                }
            };
            let first = key.map(|k| k * BRICK);
            let density = Box::new(std::array::from_fn(|i| sums[0][i].min(1.0)));
            let polymer = Box::new(std::array::from_fn(|i| mean(1, i)));
            let velocity = Box::new(std::array::from_fn(|i| [2, 3, 4].map(|c| mean(c, i))));
            Some((
                Leaf {
                    first,
                    active,
                    values: density,
                },
                Leaf {
                    first,
                    active,
                    values: polymer,
                },
                Leaf {
                    first,
                    active,
                    values: velocity,
                },
            ))
        })
        .collect();

    let (mut density, mut polymer, mut velocity) = (Vec::new(), Vec::new(), Vec::new());
    for (d, p, v) in leaves {
        density.push(d);
        polymer.push(p);
        velocity.push(v);
    }
    let grid = |name: &str, leaves| Grid {
        name: name.into(),
        class: Class::Fog,
        origin: Vec3::zeros(),
        voxel,
        leaves,
    };
    vec![
        grid("density", Leaves::Float(density)),
        grid("polymer", Leaves::Float(polymer)),
        grid(&settings.velocity_name, Leaves::Vec3(velocity)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 6 mm around (10, 20, 30) mm, z up, that turns about z.
    fn ball() -> Frame {
        let mut frame = Frame {
            spacing: 1e-3,
            ..Frame::default()
        };
        for x in -6..=6_i16 {
            for y in -6..=6_i16 {
                for z in -6..=6_i16 {
                    if x * x + y * y + z * z < 36 {
                        let [x, y, z] = [x, y, z].map(f32::from);
                        frame
                            .position
                            .push([x + 10.0, y + 20.0, z + 30.0].map(|c| c * 1e-3));
                        frame.velocity.push([-y, x, 2.0]);
                        frame.polymer_fraction.push(0.25);
                    }
                }
            }
        }
        frame
    }

    fn value<T: Copy>(leaves: &[Leaf<T>], voxel: [i32; 3]) -> Option<T> {
        let leaf = leaves.iter().find(|l| l.first == voxel.map(|v| v & !7))?;
        let i = voxel.iter().fold(0, |i, v| i << 3 | (*v & 7) as usize);
        (leaf.active[i >> 6] >> (i & 63) & 1 == 1).then_some(leaf.values[i])
    }

    #[test]
    fn a_ball_lies_where_it_is_with_its_amount_fraction_and_velocity() {
        let frame = ball();
        let grids = from_frame(&frame, &ExportSettings::default());
        let [
            Leaves::Float(density),
            Leaves::Float(polymer),
            Leaves::Vec3(velocity),
        ] = [&grids[0].leaves, &grids[1].leaves, &grids[2].leaves]
        else {
            panic!("kinds of grids")
        };
        // World (10, 20, 30) is (10, 30, −20) in the file.
        assert!((value(density, [10, 30, -20]).unwrap() - 1.0).abs() < 1e-3);
        assert_eq!(value(density, [10, 20, 30]), None);
        assert_eq!(value(density, [18, 30, -20]), None);
        let amount: f32 = density.iter().flat_map(|l| l.values.iter()).sum();
        let error = f64::from(amount) / frame.position.len() as f64 - 1.0;
        assert!(error.abs() < 0.12, "{error}");
        assert!((value(polymer, [12, 31, -19]).unwrap() - 0.25).abs() < 1e-6);
        // Offset (2, −1, 1) in the world: v = (1, 2, 2), in the file (1, 2, −2).
        let v = value(velocity, [12, 31, -19]).unwrap();
        for (found, expected) in v.iter().zip([1.0, 2.0, -2.0]) {
            assert!((found - expected).abs() < 1e-4, "{v:?}");
        }
    }

    #[test]
    fn settings_out_of_range_are_named() {
        assert_eq!(ExportSettings::default().check(), Ok(()));
        let settings = ExportSettings {
            velocity_name: "density".into(),
            ..ExportSettings::default()
        };
        assert!(settings.check().unwrap_err().contains("velocity_name"));
        let settings = ExportSettings {
            voxel: 0.0,
            ..ExportSettings::default()
        };
        assert!(settings.check().unwrap_err().contains("voxel"));
    }
}
