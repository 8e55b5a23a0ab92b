//! Nodes of the trabecular network, and which of them are joined.

use super::network::Strut;
use super::settings::{BoneError, BoneSettings};
use super::sources::Sources;
use super::thin::{Joint, thinned};
use crate::math::{Aabb, Real, Vec3, hash_unit};
use crate::mesh::{MeshDistance, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use rayon::prelude::*;

/// More lattice cells than this are refused.
const MAX_CELLS: Real = 2e7;

/// The longest strut, in periods: within half of it around its middle there is no other node, yet the cell there
/// holds one (√3 periods reach across it).
const REACH: Real = 3.5;

/// Within so many periods, the neighbours of a node nearly always block all that lies farther.
const NEAR: Real = 2.0;

/// No direction is farther than this from one to a face, an edge or a corner of a cube [rad]: it is 27.57°.
const BETWEEN: Real = 0.482;

/// Edge of a block of lattice cells that is told as a whole from the distance of its middle.
const BLOCK: i64 = 4;

/// Nearly all nodes that are not joined to one are refused for one of so many that are nearest to it.
const NEAREST: usize = 16;

/// Struts differ in thickness by this share, up and down.
const UNEVEN: Real = 0.2;

struct Node {
    position: Vec3,
    region: usize,
    period: Real,
    inside: bool,
}

/// The nodes of all regions, in the bone and just outside.
pub(super) struct Nodes {
    all: Vec<Node>,
    tree: Bvh,
    seed: u64,
}

impl Nodes {
    /// One node a cell of each region's lattice, where it falls into the region.
    pub(super) fn scatter(
        settings: &BoneSettings,
        sources: &Sources,
        distance: &MeshDistance,
        bounds: &Aabb,
    ) -> Result<Self, BoneError> {
        let mut nodes = Vec::new();
        for (region, what) in settings.regions.iter().enumerate() {
            let period = what.period;
            let extent = bounds.extent();
            if extent.map(|e| e / period + 3.0).product() > MAX_CELLS {
                return Err(BoneError::TooFine {
                    size: extent.max(),
                    key: format!("regions[{region}].period"),
                    length: period,
                });
            }
            let seed = settings.seed.wrapping_add(region as u64);
            let count = extent.map(|e| (e / period).ceil() as i64 + 3);
            let blocks = Blocks::of([count.x, count.y, count.z], |cell: Vec3| {
                let depth = distance.signed(&(bounds.min + cell.add_scalar(-0.5) * period));
                // From the middle of the block to where a node of it can be.
                let radius = 0.5 * (BLOCK - 1) as Real + settings.jitter;
                let radius = radius * period * libm::sqrt(3.0) * (1.0 + 1e-9);
                if depth > REACH * period + radius {
                    Side::Far
                } else if depth < -radius {
                    Side::Inside
                } else {
                    Side::Near
                }
            });
            let of_region: Vec<Node> = (0..count.x * count.y * count.z)
                .into_par_iter()
                .filter_map(|c| {
                    let cell = [c / (count.y * count.z), c / count.z % count.y, c % count.z];
                    let position = bounds.min
                        + Vec3::from_fn(|axis, _| {
                            let stray = 2.0 * hash_unit(seed, cell, axis as u64) - 1.0;
                            (cell[axis] as Real - 0.5 + settings.jitter * stray) * period
                        });
                    let side = blocks.side(cell);
                    if side == Side::Far || sources.region_at(settings, &position) != region {
                        return None;
                    }
                    let depth = match side {
                        Side::Near => distance.signed(&position),
                        _ => Real::NEG_INFINITY,
                    };
                    (depth < REACH * period).then_some(Node {
                        position,
                        region,
                        period,
                        inside: depth < 0.0,
                    })
                })
                .collect();
            nodes.extend(of_region);
        }
        let boxes: Vec<_> = nodes
            .iter()
            .map(|node| {
                let corner = node.position.into();
                parry3d_f64::bounding_volume::Aabb::new(corner, corner)
            })
            .collect();
        Ok(Self {
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            all: nodes,
            seed: settings.seed,
        })
    }

    /// The struts that have an end inside the bone, each with the first of its regions; `radius` holds their
    /// thickness relative to others.
    pub(super) fn join(&self, settings: &BoneSettings) -> Vec<(usize, Strut)> {
        let of_node: Vec<Vec<Joint>> = (0..self.all.len())
            .into_par_iter()
            .map(|i| {
                let joined = self.joined_to(i).into_iter();
                joined.map(|j| self.joint(settings, i, j)).collect()
            })
            .collect();
        let joints: Vec<Joint> = of_node.into_iter().flatten().collect();
        // All that lies outside hangs together: there, struts end in the shell.
        let anchored: Vec<bool> = self.all.iter().map(|node| !node.inside).collect();
        let kept = thinned(joints, &anchored).into_iter();
        kept.map(|joint| self.strut(&joint, settings.vertical))
            .collect()
    }

    fn joint(&self, settings: &BoneSettings, i: usize, j: usize) -> Joint {
        let (from, to) = (&self.all[i], &self.all[j]);
        let along = (to.position - from.position).try_normalize(0.0);
        let upright = along.map_or(0.0, |along| along.z * along.z);
        let lost = settings.regions[from.region.min(to.region)].lost;
        Joint {
            nodes: [i, j],
            upright,
            doomed: hash_unit(self.seed, [i as i64, j as i64, 0], 4) < losing(lost, upright),
        }
    }

    /// The nodes that are joined to node `i` and leave the strut to it: each strut belongs to its coarser end.
    fn joined_to(&self, i: usize) -> Vec<usize> {
        let node = &self.all[i];
        let near = NEAR * node.period;
        let mut around = self.around(i, near);
        let offset = |&(_, j): &(Real, usize)| self.all[j].position - node.position;
        let offsets: Vec<Vec3> = around.iter().map(offset).collect();
        if !blocked(&offsets, near) {
            around = self.around(i, REACH * node.period);
        }
        let order = |a: &(Real, usize), b: &(Real, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if around.len() > NEAREST {
            around.select_nth_unstable_by(NEAREST, order);
        }
        let owned = |j: usize| {
            let other = &self.all[j];
            let coarser = other.period < node.period || other.period == node.period && i < j;
            coarser && (node.inside || other.inside)
        };
        let free = |&&(square, j): &&(Real, usize)| {
            let to = &self.all[j].position;
            let nearer = around.iter().filter(|(near, _)| *near < square);
            nearer
                .map(|&(_, k)| (self.all[k].position - to).norm_squared())
                .all(|across| across >= square)
        };
        let candidates = around.iter().filter(|&&(_, j)| owned(j));
        let mut joined: Vec<(Real, usize)> = candidates.filter(free).copied().collect();
        joined.sort_unstable_by(order);
        joined.into_iter().map(|(_, j)| j).collect()
    }

    /// The other nodes within `reach` [m] of node `i`, and the squares of their distances.
    fn around(&self, i: usize, reach: Real) -> Vec<(Real, usize)> {
        let centre = self.all[i].position;
        let square = reach * reach;
        self.tree
            .leaves(|leaf: &BvhNode| square_to_box(&centre, leaf) <= square)
            .map(|j| j as usize)
            .filter(|&j| j != i)
            .map(|j| ((self.all[j].position - centre).norm_squared(), j))
            .collect()
    }

    fn strut(&self, joint: &Joint, vertical: Real) -> (usize, Strut) {
        let [i, j] = joint.nodes;
        let (from, to) = (&self.all[i], &self.all[j]);
        let uneven = 1.0 + UNEVEN * (2.0 * hash_unit(self.seed, [i as i64, j as i64, 0], 3) - 1.0);
        (
            from.region.min(to.region),
            Strut {
                from: from.position,
                to: to.position,
                radius: [(1.0 + (vertical - 1.0) * joint.upright) * uneven; 2],
            },
        )
    }
}

/// Whether all that lies farther than `reach` from a node is nearer to one of its neighbours, `offsets` away and none
/// farther than that: a neighbour k blocks what lies at an angle of less than arccos(|k|/2 reach) from it.
///
/// Told by the directions to the faces, edges and corners of a cube: no direction is farther than [`BETWEEN`] from all.
fn blocked(offsets: &[Vec3], reach: Real) -> bool {
    let (sine, cosine) = libm::sincos(BETWEEN);
    let blocks = |offset: &Vec3, direction: &Vec3| {
        let distance = offset.norm();
        let along = offset.dot(direction) / distance;
        // Cosine of the largest angle between the offset and what the direction stands for.
        let least = along * cosine - (1.0 - along * along).max(0.0).sqrt() * sine;
        least > 0.5 * distance / reach + 1e-9
    };
    let mut directions = (0..27).filter(|n| *n != 13).map(|n: i32| {
        let [x, y, z] = [n / 9, n / 3 % 3, n % 3].map(|c| Real::from(c - 1));
        Vec3::new(x, y, z).normalize()
    });
    let blocked = |direction: Vec3| offsets.iter().any(|offset| blocks(offset, &direction));
    directions.all(blocked)
}

/// Where a block of lattice cells lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// No node of it can hold a strut.
    Far,
    /// All its nodes are inside the bone.
    Inside,
    /// Neither is certain.
    Near,
}

/// The blocks of a lattice of cells.
struct Blocks {
    count: [i64; 3],
    sides: Vec<Side>,
}

impl Blocks {
    /// Of a lattice of `count` cells, told by the places of the blocks' middles, in cells.
    fn of(count: [i64; 3], side: impl Fn(Vec3) -> Side + Sync) -> Self {
        let count = count.map(|cells| (cells + BLOCK - 1) / BLOCK);
        let [_, y, z] = count;
        let middle = |block: i64| {
            let first = [block / (y * z), block / z % y, block % z].map(|b| (b * BLOCK) as Real);
            Vec3::from(first).add_scalar(0.5 * (BLOCK - 1) as Real)
        };
        let all = (0..count.iter().product()).into_par_iter();
        Self {
            count,
            sides: all.map(|block| side(middle(block))).collect(),
        }
    }

    fn side(&self, cell: [i64; 3]) -> Side {
        let [x, y, z] = cell.map(|c| c / BLOCK);
        self.sides[((x * self.count[1] + y) * self.count[2] + z) as usize]
    }
}

/// Chance to be lost: a vertical strut's is a quarter of a horizontal one's. Over all directions its mean is `lost`.
fn losing(lost: Real, upright: Real) -> Real {
    lost * (1.0 - 0.75 * upright) / 0.75
}
