//! Kernel sums over the points around one brick, in wide registers.
//!
//! ```text
//! w(q) = (1 − q)₊³ − 4 (½ − q)₊³,   q = |x − x_j| / reach
//! ```
//!
//! is the cubic spline up to a constant factor, without a branch. Lanes are added in one order everywhere.

use crate::math::{Wide, widest};

/// Points that are handled at once.
pub(super) const LANES: usize = 8;
/// Where points lie that only fill up the lanes [voxels].
pub(super) const FAR: f32 = 1e9;

/// The points around one brick; coordinates count voxels from its first node.
#[derive(Clone, Debug, Default)]
pub struct NearPoints {
    pub(super) reach: f32,
    /// Filled up to a multiple of [`LANES`].
    pub(super) position: [Vec<f32>; 3],
    /// Place of each point among the sorted points.
    pub(super) index: Vec<u32>,
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

    /// The place among the sorted points of the one nearest to each of the 8³ nodes, the first of equals; none if none is
    /// in reach.
    pub fn nearest_nodes(&self) -> Box<[Option<u32>; 512]> {
        let rows = widest(NearestNodes { near: self });
        let place = rows.as_flattened();
        Box::new(std::array::from_fn(|node| {
            self.index.get(place[node] as usize).copied()
        }))
    }

    /// Offsets and squared distances [voxels] from `at` of the points in a run of lanes. Plain loops: what iterators and
    /// closures become is not always inlined, and then not compiled for wide registers.
    #[inline(always)]
    pub(super) fn offsets(&self, at: [f32; 3], run: usize) -> ([[f32; LANES]; 3], [f32; LANES]) {
        let mut d = [[0.0; LANES]; 3];
        for axis in 0..3 {
            let lanes = &self.position[axis].as_chunks::<LANES>().0[run];
            for k in 0..LANES {
                d[axis][k] = at[axis] - lanes[k];
            }
        }
        let mut r2 = [0.0; LANES];
        for k in 0..LANES {
            r2[k] = d[0][k] * d[0][k] + d[1][k] * d[1][k] + d[2][k] * d[2][k];
        }
        (d, r2)
    }

    /// How many runs of lanes there are.
    #[inline(always)]
    pub(super) fn runs(&self) -> usize {
        self.position[0].len() / LANES
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
        for run in 0..self.near.runs() {
            let (d, r2) = self.near.offsets(self.at, run);
            let (mut w, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                let q = r2[k].sqrt() * per_reach;
                // At a point itself the gradient is 0, not 0 / 0.
                slope[k] = weights[run][k] * kernel_slope(q) * per_reach * per_reach / (q + 1e-9);
                w[k] = weights[run][k] * kernel(q);
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
        for run in 0..self.near.runs() {
            let (_, r2) = self.near.offsets(self.at, run);
            for k in 0..LANES {
                let q = r2[k].sqrt() * per_reach;
                sums[0][k] += kernel(q);
                sums[1][k] += positive(1.0 - q * q);
            }
        }
        sums.map(|lanes| across(&lanes))
    }
}

struct NearestNodes<'a> {
    near: &'a NearPoints,
}

impl Wide for NearestNodes<'_> {
    /// Place in `near`, beyond it where none is in reach.
    type Out = [[u32; 8]; 64];

    #[inline(always)]
    fn run(self) -> Self::Out {
        let near = self.near;
        let mut least = [[near.reach * near.reach; 8]; 64];
        let mut place = [[u32::MAX; 8]; 64];
        for j in 0..near.index.len() {
            let (x, y, z) = (
                near.position[0][j],
                near.position[1][j],
                near.position[2][j],
            );
            let mut dz2 = [0.0_f32; 8];
            for k in 0..8 {
                dz2[k] = (k as f32 - z) * (k as f32 - z);
            }
            for nx in 0..8 {
                let dx2 = (nx as f32 - x) * (nx as f32 - x);
                if dx2 >= near.reach * near.reach {
                    continue;
                }
                for ny in 0..8 {
                    let dxy2 = dx2 + (ny as f32 - y) * (ny as f32 - y);
                    if dxy2 >= near.reach * near.reach {
                        continue;
                    }
                    let (least, place) = (&mut least[nx * 8 + ny], &mut place[nx * 8 + ny]);
                    for k in 0..8 {
                        let nearer = dxy2 + dz2[k] < least[k];
                        place[k] = if nearer { j as u32 } else { place[k] };
                        least[k] = if nearer { dxy2 + dz2[k] } else { least[k] };
                    }
                }
            }
        }
        place
    }
}

/// Sum over lanes, in one order everywhere.
#[inline(always)]
pub(super) fn across(lanes: &[f32; LANES]) -> f32 {
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
}
