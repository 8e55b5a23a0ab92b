//! A scalar field that stores only the bricks where something happens.

use crate::math::{Real, Vec3};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

/// Nodes along the edge of a brick.
pub const BRICK: i32 = 8;
const NODES: usize = 512;

/// Values at the nodes `origin + voxel · (i, j, k)`; where no brick is stored, `background`.
#[derive(Clone, Debug)]
pub struct BrickGrid {
    /// Position of node (0, 0, 0) [m].
    pub origin: Vec3,
    /// Distance between nodes [m].
    pub voxel: Real,
    /// Value where no brick is stored.
    pub background: f32,
    place: HashMap<Key, u32, BuildHasherDefault<KeyHasher>>,
    stored: Vec<([i32; 3], Box<[f32; NODES]>)>,
}

/// Place of a brick, in bricks. Hashed as three words: the standard array goes byte by byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Key([i32; 3]);

impl Key {
    #[inline]
    fn holding(node: [i32; 3]) -> Self {
        Self(node.map(|n| n.div_euclid(BRICK)))
    }
}

impl Hash for Key {
    #[inline]
    fn hash<H: Hasher>(&self, state: &mut H) {
        for coordinate in self.0 {
            state.write_i32(coordinate);
        }
    }
}

/// Hashes the three coordinates of a brick: sampling looks bricks up all the time, and the order of a hash never
/// leaves this file.
#[derive(Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_i32(byte.into());
        }
    }

    #[inline]
    fn write_i32(&mut self, coordinate: i32) {
        let mixed = (self.0.rotate_left(21) ^ u64::from(coordinate.cast_unsigned()))
            .wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 29);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

impl BrickGrid {
    /// An empty field.
    pub fn new(origin: Vec3, voxel: Real, background: f32) -> Self {
        Self {
            origin,
            voxel,
            background,
            place: HashMap::default(),
            stored: Vec::new(),
        }
    }

    /// The bricks in ascending order of (x, y, z): first node and the 512 values, z running fastest.
    pub fn bricks(&self) -> impl Iterator<Item = ([i32; 3], &[f32; NODES])> {
        let mut order: Vec<u32> = (0..self.stored.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.stored[i as usize].0);
        order.into_iter().map(|i| {
            let (key, values) = &self.stored[i as usize];
            (key.map(|k| k * BRICK), &**values)
        })
    }

    /// Stores a brick whose first node is `first` (multiples of [`BRICK`]).
    pub fn insert_brick(&mut self, first: [i32; 3], values: Box<[f32; 512]>) {
        *self.brick_mut(Key::holding(first)) = values;
    }

    /// Number of stored bricks.
    pub fn brick_count(&self) -> usize {
        self.stored.len()
    }

    /// The value at a node.
    #[inline]
    pub fn get(&self, node: [i32; 3]) -> f32 {
        self.brick(node)
            .map_or(self.background, |values| values[offset(node)])
    }

    /// Sets a node, storing its brick if need be.
    pub fn set(&mut self, node: [i32; 3], value: f32) {
        self.brick_mut(Key::holding(node))[offset(node)] = value;
    }

    /// The brick that holds a node.
    #[inline]
    pub(super) fn brick(&self, node: [i32; 3]) -> Option<&[f32; NODES]> {
        let &place = self.place.get(&Key::holding(node))?;
        Some(&self.stored[place as usize].1)
    }

    fn brick_mut(&mut self, key: Key) -> &mut Box<[f32; NODES]> {
        let place = *self.place.entry(key).or_insert_with(|| {
            self.stored
                .push((key.0, Box::new([self.background; NODES])));
            self.stored.len() as u32 - 1
        });
        &mut self.stored[place as usize].1
    }

    /// Position of a node [m].
    pub fn position(&self, node: [i32; 3]) -> Vec3 {
        self.origin + Vec3::new(node[0].into(), node[1].into(), node[2].into()) * self.voxel
    }

    /// The value at `x`, trilinear between nodes.
    pub fn value(&self, x: &Vec3) -> Real {
        let (corner, f) = self.around(x);
        let lerp = |a: Real, b: Real, t: Real| a + (b - a) * t;
        let along_z: [Real; 4] =
            std::array::from_fn(|i| lerp(corner[2 * i], corner[2 * i + 1], f.z));
        lerp(
            lerp(along_z[0], along_z[1], f.y),
            lerp(along_z[2], along_z[3], f.y),
            f.x,
        )
    }

    /// The value at `x`, trilinear between nodes, and its gradient [1/m].
    pub fn sample(&self, x: &Vec3) -> (Real, Vec3) {
        let (corner, f) = self.around(x);
        let lerp = |a: Real, b: Real, t: Real| a + (b - a) * t;
        // Value: along z, then y, then x; gradient: the same differences, interpolated on the other two axes.
        let along_z: [Real; 4] =
            std::array::from_fn(|i| lerp(corner[2 * i], corner[2 * i + 1], f.z));
        let along_y = [
            lerp(along_z[0], along_z[1], f.y),
            lerp(along_z[2], along_z[3], f.y),
        ];
        let slope_z: [Real; 4] = std::array::from_fn(|i| corner[2 * i + 1] - corner[2 * i]);
        let gradient = Vec3::new(
            along_y[1] - along_y[0],
            lerp(along_z[1] - along_z[0], along_z[3] - along_z[2], f.x),
            lerp(
                lerp(slope_z[0], slope_z[1], f.y),
                lerp(slope_z[2], slope_z[3], f.y),
                f.x,
            ),
        );
        (lerp(along_y[0], along_y[1], f.x), gradient / self.voxel)
    }

    /// The eight values around `x`, z running fastest, and where `x` lies between them.
    #[inline]
    fn around(&self, x: &Vec3) -> ([Real; 8], Vec3) {
        let local = (x - self.origin) / self.voxel;
        let first = [floor(local.x), floor(local.y), floor(local.z)];
        let base = Vec3::from(first.map(Real::from));
        (self.corners(first), local - base)
    }

    fn corners(&self, first: [i32; 3]) -> [Real; 8] {
        let inner = first.map(|n| n.rem_euclid(BRICK));
        if inner.iter().all(|&n| n < BRICK - 1) {
            return match self.brick(first) {
                None => [self.background.into(); 8],
                Some(values) => {
                    let o = offset(first);
                    let at = |o: usize| Real::from(values[o]);
                    [
                        at(o),
                        at(o + 1),
                        at(o + 8),
                        at(o + 9),
                        at(o + 64),
                        at(o + 65),
                        at(o + 72),
                        at(o + 73),
                    ]
                }
            };
        }
        // Only along axes where the first node is the last of its brick do the others lie in another.
        let mut across = 0;
        for axis in 0..3 {
            across |= usize::from(inner[axis] == BRICK - 1) << (2 - axis);
        }
        let mut bricks: [Option<&[f32; NODES]>; 8] = [None; 8];
        let mut values = [Real::from(self.background); 8];
        for c in 0..8 {
            let [x, y, z] = first;
            let node = [
                x + (c >> 2) as i32,
                y + (c >> 1 & 1) as i32,
                z + (c & 1) as i32,
            ];
            let holder = c & across;
            if holder == c {
                bricks[c] = self.brick(node);
            }
            if let Some(brick) = bricks[holder] {
                values[c] = brick[offset(node)].into();
            }
        }
        values
    }
}

/// ⌊c⌋ without a call; a particle lost far away finds the background, not an overflow.
#[inline]
pub(super) fn floor(c: Real) -> i32 {
    let c = c.clamp(-1e9, 1e9);
    let towards_zero = c as i32;
    towards_zero - i32::from(Real::from(towards_zero) > c)
}

/// Place of a node inside its brick, z running fastest (as in an OpenVDB leaf).
#[inline]
pub(super) fn offset(node: [i32; 3]) -> usize {
    let [x, y, z] = node.map(|n| n.rem_euclid(BRICK) as usize);
    x << 6 | y << 3 | z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_is_sampled_exactly_across_bricks() {
        let slope = Vec3::new(2.0, -1.0, 0.5);
        let mut grid = BrickGrid::new(Vec3::new(-0.3, 0.1, 0.2), 0.25, 0.0);
        for x in -10..10 {
            for y in -10..10 {
                for z in -10..10 {
                    let value = slope.dot(&grid.position([x, y, z])) as f32;
                    grid.set([x, y, z], value);
                }
            }
        }
        let mut random = crate::math::Stream::new(3, "grid");
        for _ in 0..200 {
            let x = grid.origin + random.cube() * 2.0;
            let (value, gradient) = grid.sample(&x);
            assert_eq!(value, grid.value(&x));
            assert!((value - slope.dot(&x)).abs() < 1e-5);
            assert!((gradient - slope).norm() < 1e-4);
        }
        assert_eq!(grid.get([100, 0, 0]), 0.0);
        let first: Vec<[i32; 3]> = grid.bricks().map(|(first, _)| first).collect();
        assert!(first.is_sorted() && first.len() == grid.brick_count() && first[0] == [-16; 3]);
    }
}
