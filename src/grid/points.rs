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
use crate::math::{Wide, widest};
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

    /// What `each` makes of every sorted point, given the points near it and its own place among them.
    pub fn map_points<T: Send>(
        &self,
        each: impl Fn(&NearPoints, [f32; 3], usize) -> T + Sync,
    ) -> Vec<T> {
        (0..self.bricks.len())
            .into_par_iter()
            .flat_map_iter(|b| {
                let near = self.near(self.bricks[b]);
                let first = self.bricks[b].map(|k| f64::from(k * BRICK));
                (self.start[b]..self.start[b + 1])
                    .map(|point| {
                        let at =
                            std::array::from_fn(|i| (self.position[point][i] - first[i]) as f32);
                        each(&near, at, point)
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

    /// Σ_k w of each sorted point, itself included: how many neighbours it counts for.
    pub fn crowding(&self) -> Vec<f32> {
        self.map_points(|near, at, _| near.crowding(at)[0])
    }
}

/// Points that are handled at once.
const LANES: usize = 8;
/// Where points lie that only fill up the lanes [voxels].
const FAR: f32 = 1e9;

/// The points around one brick; coordinates count voxels from its first node.
#[derive(Clone, Debug, Default)]
pub struct NearPoints {
    reach: f32,
    /// Filled up to a multiple of [`LANES`].
    position: [Vec<f32>; 3],
    /// Place of each point among the sorted points.
    index: Vec<u32>,
}

/// Sums over the points around a place.
#[derive(Clone, Copy, Debug)]
pub struct PlaceSums<const N: usize> {
    /// Σ weight w.
    pub weight: f32,
    /// Σ weight ∇w [1/voxel].
    pub gradient: [f32; 3],
    /// Σ weight w c of each channel.
    pub channels: [f32; N],
}

impl NearPoints {
    /// The values of these points among those of all sorted points; 0 for what fills up the lanes.
    pub fn pick(&self, values: impl Fn(usize) -> f32) -> Vec<f32> {
        let mut picked: Vec<f32> = self.index.iter().map(|&i| values(i as usize)).collect();
        picked.resize(self.position[0].len(), 0.0);
        picked
    }

    /// Σ_j weight_j w at the 8³ nodes of the brick, z running fastest, for several weights at once.
    pub fn node_sums<const N: usize>(
        &self,
        weight: impl Fn(usize) -> [f32; N],
    ) -> [Box<[f32; 512]>; N] {
        let weights = self.index.iter().map(|&i| weight(i as usize)).collect();
        let rows = widest(NodeSums {
            near: self,
            weights,
        });
        rows.map(|rows| {
            let all = rows.as_flattened().first_chunk();
            Box::new(*all.expect("64 rows of 8"))
        })
    }

    /// Σ_j weight_j w, its gradient, and the same sum for each channel, at a place; all picked from these points.
    pub fn place_sums<const N: usize>(
        &self,
        at: [f32; 3],
        weight: &[f32],
        channels: &[Vec<f32>; N],
    ) -> PlaceSums<N> {
        widest(AtPlace {
            near: self,
            at,
            weight,
            channels,
        })
    }

    /// Σ_j w and Σ_j (1 − q²)₊ at a place.
    pub fn crowding(&self, at: [f32; 3]) -> [f32; 2] {
        widest(Crowding { near: self, at })
    }

    /// The place among the sorted points of the nearest that is in reach of `at`, the first of equals.
    pub fn nearest(&self, at: [f32; 3]) -> Option<usize> {
        let (square, place) = widest(Nearest { near: self, at });
        (square < self.reach * self.reach).then(|| self.index[place] as usize)
    }

    /// Calls `each` with the place among the sorted points, the offset x − x_j [voxels] and q of every point in reach
    /// of `at`.
    pub fn visit(&self, at: [f32; 3], mut each: impl FnMut(usize, [f32; 3], f32)) {
        let [x, y, z] = [0, 1, 2].map(|axis| self.position[axis].as_slice());
        let square = self.reach * self.reach;
        for j in 0..self.index.len() {
            let offset = [at[0] - x[j], at[1] - y[j], at[2] - z[j]];
            let r2 = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
            if r2 < square {
                each(self.index[j] as usize, offset, r2.sqrt() / self.reach);
            }
        }
    }

    /// Offsets and squared distances [voxels] from `at` of the points in each run of lanes.
    #[inline(always)]
    fn offsets(&self, at: [f32; 3]) -> impl Iterator<Item = ([[f32; LANES]; 3], [f32; LANES])> {
        let lanes = [0, 1, 2].map(|axis| self.position[axis].as_chunks::<LANES>().0);
        (0..lanes[0].len()).map(move |run| {
            let d = [0, 1, 2].map(|axis| -> [f32; LANES] {
                std::array::from_fn(|k| at[axis] - lanes[axis][run][k])
            });
            let r2 =
                std::array::from_fn(|k| d[0][k] * d[0][k] + d[1][k] * d[1][k] + d[2][k] * d[2][k]);
            (d, r2)
        })
    }
}

struct NodeSums<'a, const N: usize> {
    near: &'a NearPoints,
    weights: Vec<[f32; N]>,
}

impl<const N: usize> Wide for NodeSums<'_, N> {
    type Out = [[[f32; 8]; 64]; N];

    #[inline(always)]
    fn run(self) -> Self::Out {
        let near = self.near;
        let mut sums = [[[0.0_f32; 8]; 64]; N];
        let per_reach = 1.0 / near.reach;
        let square = near.reach * near.reach;
        for (j, weight) in self.weights.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| near.position[axis][j]);
            let dz2: [f32; 8] = std::array::from_fn(|k| (k as f32 - z) * (k as f32 - z));
            let to_row = z - z.clamp(0.0, 7.0);
            let square = square - to_row * to_row;
            for nx in 0..8 {
                let dx2 = (nx as f32 - x) * (nx as f32 - x);
                if dx2 >= square {
                    continue;
                }
                for ny in 0..8 {
                    let dxy2 = dx2 + (ny as f32 - y) * (ny as f32 - y);
                    if dxy2 >= square {
                        continue;
                    }
                    let w: [f32; 8] =
                        std::array::from_fn(|k| kernel((dxy2 + dz2[k]).sqrt() * per_reach));
                    for channel in 0..N {
                        let row = &mut sums[channel][nx * 8 + ny];
                        for k in 0..8 {
                            row[k] += weight[channel] * w[k];
                        }
                    }
                }
            }
        }
        sums
    }
}

struct AtPlace<'a, const N: usize> {
    near: &'a NearPoints,
    at: [f32; 3],
    weight: &'a [f32],
    channels: &'a [Vec<f32>; N],
}

impl<const N: usize> Wide for AtPlace<'_, N> {
    type Out = PlaceSums<N>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let per_reach = 1.0 / self.near.reach;
        let weights = self.weight.as_chunks::<LANES>().0;
        let channels = self.channels.each_ref().map(|c| c.as_chunks::<LANES>().0);
        let mut total = [0.0_f32; LANES];
        let mut gradient = [[0.0_f32; LANES]; 3];
        let mut sums = [[0.0_f32; LANES]; N];
        for (run, (d, r2)) in self.near.offsets(self.at).enumerate() {
            let q: [f32; LANES] = std::array::from_fn(|k| r2[k].sqrt() * per_reach);
            // At a point itself the gradient is 0, not 0 / 0.
            let slope: [f32; LANES] = std::array::from_fn(|k| {
                weights[run][k] * kernel_slope(q[k]) * per_reach * per_reach / (q[k] + 1e-9)
            });
            let w: [f32; LANES] = std::array::from_fn(|k| weights[run][k] * kernel(q[k]));
            for k in 0..LANES {
                total[k] += w[k];
            }
            for axis in 0..3 {
                for k in 0..LANES {
                    gradient[axis][k] += slope[k] * d[axis][k];
                }
            }
            for channel in 0..N {
                for k in 0..LANES {
                    sums[channel][k] += w[k] * channels[channel][run][k];
                }
            }
        }
        PlaceSums {
            weight: across(&total),
            gradient: gradient.map(|lanes| across(&lanes)),
            channels: sums.map(|lanes| across(&lanes)),
        }
    }
}

struct Crowding<'a> {
    near: &'a NearPoints,
    at: [f32; 3],
}

impl Wide for Crowding<'_> {
    type Out = [f32; 2];

    #[inline(always)]
    fn run(self) -> Self::Out {
        let per_reach = 1.0 / self.near.reach;
        let mut sums = [[0.0_f32; LANES]; 2];
        for (_, r2) in self.near.offsets(self.at) {
            for k in 0..LANES {
                let q = r2[k].sqrt() * per_reach;
                sums[0][k] += kernel(q);
                sums[1][k] += positive(1.0 - q * q);
            }
        }
        sums.map(|lanes| across(&lanes))
    }
}

struct Nearest<'a> {
    near: &'a NearPoints,
    at: [f32; 3],
}

impl Wide for Nearest<'_> {
    /// Squared distance and place in `near`.
    type Out = (f32, usize);

    #[inline(always)]
    fn run(self) -> Self::Out {
        let mut least = [f32::INFINITY; LANES];
        let mut place = [0_u32; LANES];
        for (run, (_, r2)) in self.near.offsets(self.at).enumerate() {
            for k in 0..LANES {
                let nearer = r2[k] < least[k];
                place[k] = if nearer { run as u32 } else { place[k] };
                least[k] = if nearer { r2[k] } else { least[k] };
            }
        }
        let mut best = (f32::INFINITY, 0);
        for k in 0..LANES {
            let candidate = (least[k], place[k] as usize * LANES + k);
            if candidate < best {
                best = candidate;
            }
        }
        best
    }
}

/// Sum over lanes, in one order everywhere.
#[inline(always)]
fn across(lanes: &[f32; LANES]) -> f32 {
    lanes.iter().sum()
}

/// x₊; unlike `f32::max` it need not care for NaN, and is one instruction.
#[inline(always)]
fn positive(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// w(q); ½ at q = 0.
#[inline(always)]
pub fn kernel(q: f32) -> f32 {
    let (a, b) = (positive(1.0 - q), positive(0.5 - q));
    a * a * a - 4.0 * b * b * b
}

/// dw/dq.
#[inline(always)]
pub fn kernel_slope(q: f32) -> f32 {
    let (a, b) = (positive(1.0 - q), positive(0.5 - q));
    12.0 * b * b - 3.0 * a * a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn the_kernel_is_the_cubic_spline() {
        let steps = 4000;
        let mut volume = 0.0;
        for i in 0..steps {
            let q = (i as f32 + 0.5) / steps as f32;
            volume += 4.0 * std::f64::consts::PI * f64::from(kernel(q) * q * q) / f64::from(steps);
            // 6 (q³ − q²) + 1 up to ½, 2 (1 − q)³ beyond, here halved.
            let spline = if q < 0.5 {
                3.0 * (q * q * q - q * q) + 0.5
            } else {
                (1.0 - q).powi(3)
            };
            assert!((kernel(q) - spline).abs() < 1e-6);
            let slope = (kernel(q + 1e-3) - kernel(q - 1e-3)) / 2e-3;
            assert!((kernel_slope(q) - slope).abs() < 1e-3);
        }
        // 8/π [1/support³] normalises the spline; ours is half of it.
        assert!((volume - std::f64::consts::PI / 16.0).abs() < 1e-5);
        assert_eq!(kernel(1.2), 0.0);
    }

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
            for (&i, crowding) in bricks.order.iter().zip(bricks.crowding()) {
                let expected = sum_at(points[i as usize].map(f64::from), &|_| 1.0);
                assert!((f64::from(crowding) - expected).abs() < 1e-4);
            }
            let keys = bricks.touched();
            let mut total = 0.0;
            for key in &keys {
                let near = bricks.near(*key);
                let sums = near.node_sums(|j| [1.0, bricks.order[j] as f32]);
                total += sums[0].iter().map(|s| f64::from(*s)).sum::<f64>();
                for node in [0, 77, 511_i32] {
                    let inner = [node >> 6, node >> 3 & 7, node & 7];
                    let x = std::array::from_fn(|a| f64::from(key[a] * 8 + inner[a]) * voxel);
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
