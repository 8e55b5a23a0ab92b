//! Scattered points found again brick by brick, and kernel sums over them.
//!
//! ```text
//! w(q) = (1 − q)₊³ − 4 (½ − q)₊³,   q = |x − x_j| / reach
//! ```
//!
//! is the cubic spline up to a constant factor, without a branch. Lengths are in voxels and local to a brick, so
//! that single precision is enough wherever the brick lies. A brick takes its points in a fixed order: sums have the
//! same bits on any number of threads.

use super::brick::BRICK;
use super::near::{FAR, LANES, NearPoints};
use rayon::prelude::*;

/// Lattice coordinates beyond this are left out, so that brick arithmetic cannot overflow.
const FARTHEST: f64 = (1 << 28) as f64;

/// Points sorted by the brick that they lie in.
#[derive(Clone, Debug, Default)]
pub struct PointBricks {
    /// Radius of the kernel [voxels].
    pub reach: f64,
    /// Index that each sorted point had in the input. Points that are not finite, or further than 2²⁸ voxels
    /// from the origin, are left out.
    pub order: Vec<u32>,
    /// Sorted positions [voxels].
    position: Vec<[f64; 3]>,
    /// Keys (first node / 8) of the bricks that hold points, ascending.
    bricks: Vec<[i32; 3]>,
    /// Points of brick b: `start[b]..start[b + 1]`.
    start: Vec<usize>,
}

impl PointBricks {
    /// Sorts `points` [m] into the bricks of a lattice with a node at the origin and `voxel` [m] between nodes;
    /// the kernel vanishes at `radius` [m].
    pub fn new(points: &[[f32; 3]], voxel: f64, radius: f64) -> Self {
        let scaled = |i: usize| points[i].map(|c| f64::from(c) / voxel);
        let mut keyed: Vec<([i32; 3], u32)> = (0..points.len())
            .into_par_iter()
            .filter(|&i| scaled(i).iter().all(|c| c.abs() < FARTHEST))
            .map(|i| (scaled(i).map(|c| c.floor() as i32 >> 3), i as u32))
            .collect();
        keyed.par_sort_unstable();
        let mut bricks = Vec::new();
        let mut start = vec![0];
        for run in keyed.chunk_by(|a, b| a.0 == b.0) {
            bricks.push(run[0].0);
            start.push(start[start.len() - 1] + run.len());
        }
        Self {
            reach: radius / voxel,
            position: keyed.iter().map(|&(_, i)| scaled(i as usize)).collect(),
            order: keyed.into_iter().map(|(_, i)| i).collect(),
            bricks,
            start,
        }
    }

    /// Keys of the bricks that matter, ascending: every node in reach of a point lies in one of them, and so does
    /// the node before it on each axis.
    pub fn touched(&self) -> Vec<[i32; 3]> {
        let mut keys: Vec<[i32; 3]> = (0..self.bricks.len())
            .into_par_iter()
            .flat_map_iter(|b| {
                let points = &self.position[self.start[b]..self.start[b + 1]];
                let end = |axis: usize, fold: fn(f64, f64) -> f64| {
                    points.iter().map(|p| p[axis]).reduce(fold).unwrap_or(0.0)
                };
                let low: [i32; 3] = std::array::from_fn(|a| {
                    ((end(a, f64::min) - self.reach).floor() as i32 - 1) >> 3
                });
                let high: [i32; 3] =
                    std::array::from_fn(|a| (end(a, f64::max) + self.reach).ceil() as i32 >> 3);
                (low[0]..=high[0]).flat_map(move |x| {
                    (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
                })
            })
            .collect();
        keys.par_sort_unstable();
        keys.dedup();
        keys
    }

    /// The points within reach of the cells of a brick, in ascending order.
    pub fn near(&self, key: [i32; 3]) -> NearPoints {
        let mut near = NearPoints {
            reach: self.reach as f32,
            ..NearPoints::default()
        };
        let width = f64::from(BRICK);
        let around = (self.reach / width).ceil() as i32;
        let first = key.map(|k| f64::from(k) * width);
        for x in key[0] - around..=key[0] + around {
            for y in key[1] - around..=key[1] + around {
                let place = |z: i32| self.bricks.partition_point(|b| *b < [x, y, z]);
                let a = place(key[2] - around);
                let run = self.bricks[a..].iter();
                let run = run.take_while(|b| **b < [x, y, key[2] + around + 1]);
                let b = a + run.count();
                for point in self.start[a]..self.start[b] {
                    let p: [f64; 3] = std::array::from_fn(|i| self.position[point][i] - first[i]);
                    let outside = p.map(|c| c - c.clamp(0.0, width));
                    if outside.iter().map(|c| c * c).sum::<f64>() < self.reach * self.reach {
                        for axis in 0..3 {
                            near.position[axis].push(p[axis] as f32);
                        }
                        near.index.push(point as u32);
                    }
                }
            }
        }
        for axis in &mut near.position {
            axis.resize(axis.len().next_multiple_of(LANES), FAR);
        }
        near
    }

    /// What `each` makes of every sorted point, given the points near it, what `prepare` made of those, its place in the
    /// brick and its own place among the sorted points.
    pub fn map_points<P, T: Send>(
        &self,
        prepare: impl Fn(&NearPoints) -> P + Sync,
        each: impl Fn(&NearPoints, &P, [f32; 3], usize) -> T + Sync,
    ) -> Vec<T> {
        (0..self.bricks.len())
            .into_par_iter()
            .flat_map_iter(|b| {
                let near = self.near(self.bricks[b]);
                let prepared = prepare(&near);
                let first = self.bricks[b].map(|k| f64::from(k * BRICK));
                (self.start[b]..self.start[b + 1])
                    .map(|point| {
                        let at =
                            std::array::from_fn(|i| (self.position[point][i] - first[i]) as f32);
                        each(&near, &prepared, at, point)
                    })
                    .collect::<Vec<T>>()
            })
            .collect()
    }

    /// The least of the `values` of the sorted points in each brick that holds any.
    pub fn brick_least(&self, values: &[f32]) -> Vec<f32> {
        let runs = self.start.windows(2).map(|run| &values[run[0]..run[1]]);
        runs.map(|run| run.iter().copied().fold(f32::INFINITY, f32::min))
            .collect()
    }

    /// Whether a brick and the 26 around it all hold points, and `least` is at least `limit` in all of them; never if the
    /// kernel reaches beyond them.
    pub fn all_around(&self, key: [i32; 3], least: &[f32], limit: f32) -> bool {
        if self.reach > f64::from(BRICK) {
            return false;
        }
        (0..9).all(|row| {
            let first = [key[0] + row / 3 - 1, key[1] + row % 3 - 1, key[2] - 1];
            let place = self.bricks.partition_point(|b| *b < first);
            (0..3).all(|z| {
                let there =
                    self.bricks.get(place + z) == Some(&[first[0], first[1], first[2] + z as i32]);
                there && least[place + z] >= limit
            })
        })
    }
}

/// Σ_k w of each of the `points` [m], itself included, for a kernel that vanishes at `radius` [m]: how many neighbours it
/// counts for. 0 for those that are left out.
pub fn crowding(points: &[[f32; 3]], radius: f64) -> Vec<f32> {
    // Bricks of two radii: larger ones hold points that are not asked for, smaller ones are too many.
    let bricks = PointBricks::new(points, radius / 4.0, radius);
    let sorted = bricks.map_points(|_| (), |near, (), at, _| near.crowding(at)[0]);
    let mut crowding = vec![0.0; points.len()];
    for (&i, sum) in bricks.order.iter().zip(sorted) {
        crowding[i as usize] = sum;
    }
    crowding
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::kernel;
    use crate::math::Stream;

    #[test]
    fn node_sums_and_crowding_agree_with_brute_force() {
        for (voxel, radius) in [(0.25, 1.0), (0.1, 1.7), (1.0, 0.9)] {
            let mut random = Stream::new(6, "points");
            let points: Vec<[f32; 3]> = (0..150)
                .map(|_| (random.cube() * 3.0).map(|x| x as f32).into())
                .collect();
            let sum_at = |x: [f64; 3], weight: &dyn Fn(usize) -> f64| -> f64 {
                let distance = |p: &[f32; 3]| {
                    let square = |a: usize| (x[a] - f64::from(p[a])).powi(2);
                    (square(0) + square(1) + square(2)).sqrt()
                };
                let w = |i: usize| f64::from(kernel((distance(&points[i]) / radius) as f32));
                (0..points.len()).map(|i| weight(i) * w(i)).sum()
            };
            let bricks = PointBricks::new(&points, voxel, radius);
            for (point, crowding) in points.iter().zip(crowding(&points, radius)) {
                let expected = sum_at(point.map(f64::from), &|_| 1.0);
                assert!((f64::from(crowding) - expected).abs() < 1e-4);
            }
            let keys = bricks.touched();
            let mut total = 0.0;
            for key in &keys {
                let near = bricks.near(*key);
                let nearest = near.nearest_nodes();
                let sums = near.node_sums(|j| [1.0, bricks.order[j] as f32]);
                total += sums[0].iter().map(|s| f64::from(*s)).sum::<f64>();
                for node in [0, 77, 511_i32] {
                    let inner = [node >> 6, node >> 3 & 7, node & 7];
                    let x: [f64; 3] =
                        std::array::from_fn(|a| f64::from(key[a] * 8 + inner[a]) * voxel);
                    let away = |i: u32| {
                        let p = points[bricks.order[i as usize] as usize].map(f64::from);
                        (0..3).map(|a| (x[a] - p[a]).powi(2)).sum::<f64>().sqrt()
                    };
                    let least = (0..150).map(away).fold(radius, f64::min);
                    let found = nearest[node as usize].map_or(radius, away);
                    assert!((found - least).abs() < 1e-6, "{found} {least}");
                    for (channel, weight) in [(0, 1.0), (1, 0.0)] {
                        let expected = sum_at(x, &|i| weight + (1.0 - weight) * i as f64);
                        let found = f64::from(sums[channel][node as usize]);
                        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
                    }
                }
            }
            if radius > 3.0 * voxel {
                // No node in reach is missed: the sum over all nodes is the kernel's integral.
                let expected = std::f64::consts::PI / 16.0 * (radius / voxel).powi(3) * 150.0;
                assert!((total / expected - 1.0).abs() < 2e-3, "{total} {expected}");
            }
        }
    }
}
