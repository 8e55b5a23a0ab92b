//! A box of nodes copied out of the bricks: many samples close together then look no brick up.

use super::brick::{BRICK, BrickGrid, floor, offset};
use crate::math::{Real, Vec3};

/// Planes of nodes that [`Patch::values`] does at once.
const PLANES: usize = 4;

/// The values of a grid in a box.
#[derive(Clone, Debug)]
pub struct Patch {
    origin: Vec3,
    voxel: Real,
    first: [i32; 3],
    count: [usize; 3],
    /// z runs fastest; none where the grid stores nothing.
    values: Vec<f32>,
    background: Real,
}

/// Where a coordinate lies between two nodes of a patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Between {
    node: usize,
    share: Real,
}

impl BrickGrid {
    /// The values that samples between `low` and `high` [m] need.
    pub fn patch(&self, low: &Vec3, high: &Vec3) -> Patch {
        let node = |x: &Vec3| {
            let local = (x - self.origin) / self.voxel;
            [floor(local.x), floor(local.y), floor(local.z)]
        };
        let (first, last) = (node(low), node(high).map(|n| n + 1));
        let count = [0, 1, 2].map(|axis| (last[axis] - first[axis] + 1) as usize);
        let mut patch = Patch {
            origin: self.origin,
            voxel: self.voxel,
            first,
            count,
            values: Vec::new(),
            background: self.background.into(),
        };
        let [from, to] = [first, last].map(|node| node.map(|n| n.div_euclid(BRICK)));
        for x in from[0]..=to[0] {
            for y in from[1]..=to[1] {
                for z in from[2]..=to[2] {
                    let brick = [x, y, z].map(|b| b * BRICK);
                    if let Some(values) = self.brick(brick) {
                        patch.copy(brick, values, self.background);
                    }
                }
            }
        }
        patch
    }
}

impl Patch {
    fn copy(&mut self, brick: [i32; 3], values: &[f32; 512], background: f32) {
        if self.values.is_empty() {
            self.values = vec![background; self.count.iter().product()];
        }
        let low: [i32; 3] = std::array::from_fn(|axis| brick[axis].max(self.first[axis]));
        let high: [i32; 3] = std::array::from_fn(|axis| {
            (brick[axis] + BRICK).min(self.first[axis] + self.count[axis] as i32)
        });
        let run = (high[2] - low[2]) as usize;
        for x in low[0]..high[0] {
            for y in low[1]..high[1] {
                let [i, j, k] = [x - self.first[0], y - self.first[1], low[2] - self.first[2]]
                    .map(|n| n as usize);
                let to = (i * self.count[1] + j) * self.count[2] + k;
                let from = offset([x, y, low[2]]);
                self.values[to..to + run].copy_from_slice(&values[from..from + run]);
            }
        }
    }

    /// Where a coordinate [m] of a point inside the patch lies along an axis.
    #[inline]
    pub fn between(&self, axis: usize, x: Real) -> Between {
        let local = (x - self.origin[axis]) / self.voxel;
        let below = floor(local);
        Between {
            node: (below - self.first[axis]).clamp(0, self.count[axis] as i32 - 2) as usize,
            share: local - Real::from(below),
        }
    }

    /// The value there, as [`BrickGrid::value`].
    #[inline]
    pub fn value(&self, at: [Between; 3]) -> Real {
        if self.values.is_empty() {
            return self.background;
        }
        let [x, y, z] = at;
        let lerp = |a: Real, b: Real, t: Real| a + (b - a) * t;
        let along_z = |i: usize, j: usize| {
            let place = ((x.node + i) * self.count[1] + y.node + j) * self.count[2] + z.node;
            let pair = &self.values[place..place + 2];
            lerp(pair[0].into(), pair[1].into(), z.share)
        };
        let along_y = |i: usize| lerp(along_z(i, 0), along_z(i, 1), y.share);
        lerp(along_y(0), along_y(1), x.share)
    }

    /// The values at all points of a small lattice whose coordinates ascend, x first, each as [`Self::value`]: what
    /// neighbours share of the interpolation is done once.
    pub fn values<const N: usize>(&self, at: &[[Between; N]; 3]) -> [[[Real; N]; N]; N] {
        let [x, y, z] = at;
        let first = [x[0].node, y[0].node];
        let count = [x, y].map(|axis| axis[N - 1].node - axis[0].node + 2);
        if self.values.is_empty() || count.iter().any(|&count| count > PLANES) {
            let of = |i: usize, j: usize, k: usize| self.value([x[i], y[j], z[k]]);
            return std::array::from_fn(|i| {
                std::array::from_fn(|j| std::array::from_fn(|k| of(i, j, k)))
            });
        }
        let lerp = |a: Real, b: Real, t: Real| a + (b - a) * t;
        let mut along_y = [[[0.0; N]; N]; PLANES];
        for (i, along_y) in along_y.iter_mut().enumerate().take(count[0]) {
            let mut along_z = [[0.0; N]; PLANES];
            for (j, along_z) in along_z.iter_mut().enumerate().take(count[1]) {
                let row = ((first[0] + i) * self.count[1] + first[1] + j) * self.count[2];
                let row = &self.values[row..row + self.count[2]];
                for (value, z) in along_z.iter_mut().zip(z) {
                    *value = lerp(row[z.node].into(), row[z.node + 1].into(), z.share);
                }
            }
            for (along_y, y) in along_y.iter_mut().zip(y) {
                let j = y.node - first[1];
                *along_y = std::array::from_fn(|k| lerp(along_z[j][k], along_z[j + 1][k], y.share));
            }
        }
        x.map(|x| {
            let i = x.node - first[0];
            let of = |j: usize, k: usize| lerp(along_y[i][j][k], along_y[i + 1][j][k], x.share);
            std::array::from_fn(|j| std::array::from_fn(|k| of(j, k)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_patch_have_the_bits_of_samples_of_the_grid() {
        let mut random = crate::math::Stream::new(8, "patch");
        let mut grid = BrickGrid::new(Vec3::new(0.1, -0.2, 0.3), 0.25, 0.7);
        for _ in 0..2000 {
            let node = (random.cube() * 12.0).map(|c| c as i32);
            grid.set(node.into(), random.unit() as f32);
        }
        for _ in 0..20 {
            let low = random.cube() * 5.0;
            let high = low + Vec3::repeat(2.0) + random.cube().map(Real::abs);
            let patch = grid.patch(&low, &high);
            for _ in 0..200 {
                let x = low + (high - low).component_mul(&random.cube().map(Real::abs));
                let at = [0, 1, 2].map(|axis| patch.between(axis, x[axis]));
                assert_eq!(patch.value(at), grid.value(&x));
            }
            // A small lattice, and one that is wider than what is done at once.
            for step in [0.1, 0.6] {
                let place = |n: usize| low.add_scalar(0.03 + step * n as Real);
                let along = |axis: usize| {
                    std::array::from_fn::<_, 4, _>(|n| patch.between(axis, place(n)[axis]))
                };
                let values = patch.values(&[0, 1, 2].map(along));
                for n in 0..64 {
                    let [i, j, k] = [n / 16, n / 4 % 4, n % 4];
                    let x = Vec3::new(place(i).x, place(j).y, place(k).z);
                    assert_eq!(values[i][j][k], grid.value(&x));
                }
            }
        }
    }
}
