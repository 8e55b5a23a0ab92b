//! Wall particles: one for every voxel that holds solid near its surface.
//!
//! φ is a distance, so it cannot change faster than the way to a point is long: a block of voxels whose centre is far
//! enough from the surface is passed over without a look inside. What is visited grows with the surface.

use super::{Shape, Solid};
use crate::grid::Patch;
use crate::math::{Aabb, Real, Vec3};
use crate::sph::WallParticles;
use rayon::prelude::*;

/// Voxels along the edge of a block; a power of 2.
const BLOCK: i64 = 8;
/// Sub-voxels along the edge of a voxel.
const FINE: usize = 4;
/// Smaller solid parts of a voxel are left out.
const LEAST: Real = 0.02;
/// Spacings by which the centroid of a voxel may lie deeper than the walls are to be: a voxel that reaches into their
/// depth counts, but what is deeper than a support radius is felt by nobody.
const DEEPER: Real = 0.4;

/// Fills the solid within `depth` [m] of its surface with one particle per voxel of edge `spacing` [m], at the
/// centroid of the voxel's solid part and of its volume. None lies deeper than `depth` and 0.4 spacings: with that
/// much less than the support radius as `depth`, none is out of reach.
///
/// Voxels lie on multiples of `spacing`; those with their middle in `region` count. Order: blocks of 8³ voxels in
/// (x, y, z), and the same within a block.
pub fn wall_particles(solid: &Solid, region: &Aabb, spacing: Real, depth: Real) -> WallParticles {
    let walls = Walls {
        solid,
        region,
        spacing,
        depth,
    };
    let block = spacing * BLOCK as Real;
    let low = region.min.map(|c| (c / block).floor() as i64);
    let count = region.max.map(|c| (c / block).floor() as i64 + 1) - low;
    if region.is_empty() || count.min() <= 0 {
        return WallParticles::default();
    }
    let of_block: Vec<Vec<Particle>> = (0..count.x * count.y * count.z)
        .into_par_iter()
        .map(|b| {
            let place = [b / (count.y * count.z), b / count.z % count.y, b % count.z];
            let first = std::array::from_fn(|axis| (low[axis] + place[axis]) * BLOCK);
            let mut found = Vec::new();
            if let Some(block) = walls.block(first) {
                block.descend(first, BLOCK, &mut found);
            }
            found.sort_unstable_by_key(|particle: &Particle| particle.voxel);
            found
        })
        .collect();
    let (position, volume) = of_block
        .iter()
        .flatten()
        .map(|particle| (particle.position, particle.volume))
        .unzip();
    WallParticles { position, volume }
}

struct Particle {
    voxel: [i64; 3],
    position: Vec3,
    volume: Real,
}

struct Walls<'a> {
    solid: &'a Solid,
    region: &'a Aabb,
    spacing: Real,
    depth: Real,
}

impl Walls<'_> {
    /// What can matter in the block that begins at `first`, unless the whole block is to be passed over: shapes whose
    /// surface may come near (elsewhere the least φ is another's, or tells that nothing is there), and grids.
    fn block(&self, first: [i64; 3]) -> Option<Block<'_>> {
        let centre = self.centre(first, BLOCK);
        let reach = (0.87 * BLOCK as Real + 1.5) * self.spacing;
        let near = |shape: &&Shape| shape.distance(&centre).0 <= reach;
        let shapes: Vec<&Shape> = self.solid.shapes.iter().filter(near).collect();
        let of_shapes = shapes.iter().map(|shape| shape.distance(&centre).0);
        let of_grids = self.solid.grids.iter().map(|grid| grid.value(&centre));
        if self.passes_over(
            of_shapes.chain(of_grids).fold(Real::INFINITY, Real::min),
            BLOCK,
        ) {
            return None;
        }
        let half = Vec3::repeat(0.5 * BLOCK as Real * self.spacing);
        let (low, high) = (centre - half, centre + half);
        let grids = self.solid.grids.iter();
        Some(Block {
            walls: self,
            shapes,
            grids: grids.map(|grid| grid.patch(&low, &high)).collect(),
        })
    }

    fn centre(&self, first: [i64; 3], edge: i64) -> Vec3 {
        Vec3::from(first.map(|f| f as Real)).add_scalar(0.5 * edge as Real) * self.spacing
    }

    /// Whether no surface is near a cube of `edge` voxels with φ in its centre, or only solid too deep.
    fn passes_over(&self, phi: Real, edge: i64) -> bool {
        // A little more than the half diagonal: φ between grid nodes is not exact.
        let radius = (0.87 * edge as Real + 0.1) * self.spacing;
        phi > radius || phi < -self.depth - radius
    }
}

struct Block<'a> {
    walls: &'a Walls<'a>,
    shapes: Vec<&'a Shape>,
    grids: Vec<Patch>,
}

impl Block<'_> {
    fn phi(&self, x: &Vec3) -> Real {
        let shapes = self.shapes.iter().map(|shape| shape.distance(x).0);
        let grids = self
            .grids
            .iter()
            .map(|grid| grid.value([0, 1, 2].map(|axis| grid.between(axis, x[axis]))));
        shapes.chain(grids).fold(Real::INFINITY, Real::min)
    }

    /// φ in the middles of the sub-voxels of the voxel around `centre`, z running fastest.
    fn fine(&self, centre: &Vec3, offset: [Real; FINE]) -> [Real; FINE.pow(3)] {
        let place = |n: usize| [n / (FINE * FINE), n / FINE % FINE, n % FINE];
        let mut least = [Real::INFINITY; FINE.pow(3)];
        for grid in &self.grids {
            let at = [0, 1, 2].map(|axis| offset.map(|o| grid.between(axis, centre[axis] + o)));
            let values = grid.values(&at);
            for (least, value) in least.iter_mut().zip(values.as_flattened().as_flattened()) {
                *least = least.min(*value);
            }
        }
        for shape in &self.shapes {
            for (n, least) in least.iter_mut().enumerate() {
                let x = centre + Vec3::from(place(n).map(|p| offset[p]));
                *least = least.min(shape.distance(&x).0);
            }
        }
        least
    }

    fn descend(&self, first: [i64; 3], edge: i64, found: &mut Vec<Particle>) {
        let centre = self.walls.centre(first, edge);
        if self.walls.passes_over(self.phi(&centre), edge) {
            return;
        }
        if edge == 1 {
            found.extend(self.voxel(first, &centre));
            return;
        }
        let half = edge / 2;
        for octant in 0..8 {
            let step = [octant >> 2 & 1, octant >> 1 & 1, octant & 1];
            let corner = std::array::from_fn(|axis| first[axis] + step[axis] * half);
            self.descend(corner, half, found);
        }
    }

    fn voxel(&self, voxel: [i64; 3], centre: &Vec3) -> Option<Particle> {
        let walls = self.walls;
        if !walls.region.contains(centre) {
            return None;
        }
        let edge = walls.spacing / FINE as Real;
        let offset: [Real; FINE] =
            std::array::from_fn(|p| (p as Real + 0.5 - 0.5 * FINE as Real) * edge);
        let mut share = 0.0;
        let mut moment = Vec3::zeros();
        let mut shallowest = Real::NEG_INFINITY;
        for (n, phi) in self.fine(centre, offset).into_iter().enumerate() {
            let part = (0.5 - phi / edge).clamp(0.0, 1.0);
            if part > 0.0 {
                share += part;
                moment +=
                    Vec3::from([n / (FINE * FINE), n / FINE % FINE, n % FINE].map(|p| offset[p]))
                        * part;
                shallowest = shallowest.max(phi);
            }
        }
        let whole = FINE.pow(3) as Real;
        if share < LEAST * whole || shallowest < -walls.depth {
            return None;
        }
        // In a corner that reaches around the open, the centroid may lie in the open: the surface is near enough.
        let centroid = centre + moment / share;
        let (phi, normal) = walls.solid.distance(&centroid);
        if phi < -walls.depth - DEEPER * walls.spacing {
            return None;
        }
        Some(Particle {
            voxel,
            position: centroid - normal * phi.max(0.0),
            volume: share / whole * walls.spacing.powi(3),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(walls: &WallParticles) -> Real {
        walls.volume.iter().sum()
    }

    /// The walls of a container fill exactly what the container leaves of the region.
    #[test]
    fn hollow_box_has_the_volume_of_its_walls() {
        let spacing = 0.1;
        let (min, max) = (Vec3::new(0.33, 0.45, 0.26), Vec3::new(2.71, 1.94, 3.18));
        let solid = Solid {
            shapes: vec![Shape::Box {
                min,
                max,
                hollow: true,
            }],
            grids: Vec::new(),
        };
        let region = Aabb {
            min: Vec3::new(0.1, 0.2, 0.0),
            max: Vec3::new(3.0, 2.2, 3.4),
        };
        let walls = wall_particles(&solid, &region, spacing, 0.6);
        let volume = |a: &Vec3, b: &Vec3| (b - a).product();
        let exact = volume(&region.min, &region.max) - volume(&min, &max);
        assert!(
            (total(&walls) / exact - 1.0).abs() < 0.01,
            "{} {exact}",
            total(&walls)
        );
        assert!(walls.position.iter().all(|x| solid.distance(x).0 < 1e-9));

        // A layer of two voxels on aligned walls.
        let (min, max) = (Vec3::repeat(0.5), Vec3::new(1.5, 2.0, 1.2));
        let solid = Solid {
            shapes: vec![Shape::Box {
                min,
                max,
                hollow: true,
            }],
            grids: Vec::new(),
        };
        let region = Aabb {
            min: Vec3::zeros(),
            max: Vec3::repeat(3.0),
        };
        let walls = wall_particles(&solid, &region, spacing, 1.999 * spacing);
        let (low, high) = (min.add_scalar(-0.2), max.add_scalar(0.2));
        let layer = volume(&low, &high) - volume(&min, &max);
        // The corners of the layer are round: voxels deeper than that along the diagonal are left out.
        assert!(
            (total(&walls) / layer - 1.0).abs() < 0.01,
            "{} {layer}",
            total(&walls)
        );
    }

    #[test]
    fn sphere_volume_and_centroid_do_not_depend_on_the_lattice_or_the_threads() {
        for shift in [0.0, 0.037, 0.081] {
            let centre = Vec3::new(shift, -2.0 * shift, 1.0 + shift);
            let solid = Solid {
                shapes: vec![Shape::Sphere {
                    centre,
                    radius: 0.5,
                    hollow: false,
                }],
                grids: Vec::new(),
            };
            let region = Aabb {
                min: centre.add_scalar(-1.0),
                max: centre.add_scalar(1.0),
            };
            let on = |threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| wall_particles(&solid, &region, 0.1, 1.0))
            };
            let (walls, other) = (on(1), on(2));
            assert!(walls.position == other.position && walls.volume == other.volume);
            let exact = 4.0 / 3.0 * core::f64::consts::PI * 0.125;
            assert!((total(&walls) / exact - 1.0).abs() < 0.01);
            let moment: Vec3 = walls
                .position
                .iter()
                .zip(&walls.volume)
                .map(|(x, v)| x * *v)
                .sum();
            assert!((moment / total(&walls) - centre).norm() < 1e-3);
        }
    }
}
