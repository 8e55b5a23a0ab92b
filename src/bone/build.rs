//! Fills the grid of signed distances: shell from the mesh, struts, bores and other openings.
//!
//! ```text
//! φ = max( min( |d + t/2| − t/2,  max(struts, d) ),  bores )        d: distance to the mesh, t: thickness of the shell
//! ```
//!
//! Each brick asks the search trees once, for what can matter to any of its nodes, and then goes through that list.

use super::network::Network;
use super::pockets;
use super::report::{self, BoneReport};
use super::settings::{BoneError, BoneSettings};
use super::share::{solid_share, unbiased_share};
use super::sources::Sources;
use super::space::{Channel, OpeningShape};
use super::{Bone, network::Strut};
use crate::grid::{BRICK, BrickGrid};
use crate::math::{Real, Vec3, Wide, widest};
use crate::mesh::{MeshDistance, TriMesh};
use crate::solid::Shape;
use rayon::prelude::*;

/// Half width of the band around the solid's surface in which φ is exact, in particle spacings.
pub const BAND: Real = 3.2;

/// What a node is made for, beyond its φ.
pub(super) mod place {
    /// Outside the bone, or in its shell.
    pub const ELSEWHERE: u8 = 0;
    /// In a bore or another opening.
    pub const BORE: u8 = 1;
    /// Inside the shell, in region 0; the next regions follow.
    pub const FIRST_REGION: u8 = 2;
}

/// One brick of the grid while it is being built.
pub(super) struct BoneBrick {
    pub(super) first: [i32; 3],
    pub(super) phi: Box<[f32; 512]>,
    /// `place` of every node.
    pub(super) place: Box<[u8; 512]>,
    /// Nodes' worth of shell, by sub-voxel fraction.
    pub(super) shell: Real,
    /// What is inside the shell, by region and class of asked porosity.
    pub(super) tallies: Vec<[Tally; CLASSES]>,
}

/// Classes of asked porosity in which made porosity is measured.
pub(super) const CLASSES: usize = 20;

/// The class of an asked `porosity` [1].
pub(super) fn class_of(porosity: Real) -> usize {
    ((porosity * CLASSES as Real) as usize).min(CLASSES - 1)
}

/// Sums over nodes.
#[derive(Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) nodes: Real,
    /// Nodes' worth of struts.
    pub(super) solid: Real,
    /// Sum of asked porosities.
    pub(super) asked: Real,
    /// What the struts gain when their surface is moved by a voxel in all, in nodes.
    pub(super) layer: Real,
}

impl Tally {
    pub(super) fn add(&mut self, other: &Self) {
        self.nodes += other.nodes;
        self.solid += other.solid;
        self.asked += other.asked;
        self.layer += other.layer;
    }
}

/// Builds the inside of `mesh`, as [`crate::mesh::repaired`] leaves it and with its `distance`, for particles `spacing`
/// [m] apart; `carve` is cut out.
pub fn build(
    mesh: &TriMesh,
    distance: &MeshDistance,
    settings: &BoneSettings,
    sources: &Sources,
    spacing: Real,
    carve: &[Channel],
) -> Result<Bone, BoneError> {
    settings.check(spacing)?;
    let bounds = mesh.bounds();
    let network = Network::grow(settings, sources, mesh, distance)?;

    let voxel = spacing / settings.nodes_per_spacing;
    let band = BAND * spacing;
    let mut grid = BrickGrid::new(bounds.min, voxel, band as f32);
    let filler = Filler {
        settings,
        sources,
        distance,
        network: &network,
        bores: &carve.iter().map(Channel::bore).collect::<Vec<_>>(),
        grid: &grid,
        band,
    };
    let mut bricks = filler.bricks(mesh)?;
    let pockets = pockets::close(&mut bricks, voxel);
    let report = BoneReport {
        pockets_closed: pockets,
        ..report::measure(settings, &network, &bricks, voxel, spacing)
    };
    for brick in bricks {
        if brick.phi.iter().any(|&phi| phi < grid.background) {
            grid.insert_brick(brick.first, brick.phi);
        }
    }
    Ok(Bone {
        solid: grid,
        struts: network.struts,
        report,
    })
}

struct Filler<'a> {
    settings: &'a BoneSettings,
    sources: &'a Sources,
    distance: &'a MeshDistance,
    network: &'a Network,
    bores: &'a [Shape],
    grid: &'a BrickGrid,
    band: Real,
}

/// Nodes along the edge of an octant of a brick.
const EDGE: i32 = BRICK / 2;
/// Bricks along the edge of a block that is passed over as a whole when it is far outside.
const BLOCK: i32 = 4;
/// Of more triangles around a brick, the search tree finds the nearest sooner than a list.
const MANY: usize = 256;
/// More blocks than this are refused.
const MAX_BLOCKS: Real = 1e6;

impl Filler<'_> {
    /// All bricks with a node inside the bone or near its surface, ascending by block.
    fn bricks(&self, mesh: &TriMesh) -> Result<Vec<BoneBrick>, BoneError> {
        let block = self.grid.voxel * Real::from(BRICK * BLOCK);
        let margin = (self.band / block).ceil();
        let size = mesh.bounds().extent();
        let count = size.map(|e| (e / block).ceil() + 2.0 * margin);
        if count.product() > MAX_BLOCKS {
            return Err(BoneError::TooFine {
                size: size.max(),
                key: "spacing".into(),
                length: self.grid.voxel * self.settings.nodes_per_spacing,
            });
        }
        let [nx, ny, nz] = [count.x, count.y, count.z].map(|c| c as i32);
        let low = -(margin as i32);
        let of_block: Vec<Vec<BoneBrick>> = (0..nx * ny * nz)
            .into_par_iter()
            .map(|b| {
                let block = [b / (ny * nz), b / nz % ny, b % nz].map(|c| (c + low) * BLOCK * BRICK);
                self.block(block)
            })
            .collect();
        Ok(of_block.into_iter().flatten().collect())
    }

    fn block(&self, first: [i32; 3]) -> Vec<BoneBrick> {
        let (centre, radius) = self.around(first, BLOCK * BRICK);
        if !self.wanted(first, BLOCK * BRICK) || self.distance.signed(&centre) > self.band + radius
        {
            return Vec::new();
        }
        (0..BLOCK.pow(3))
            .filter_map(|b| {
                let [x, y, z] = [b / (BLOCK * BLOCK), b / BLOCK % BLOCK, b % BLOCK];
                self.brick([
                    first[0] + x * BRICK,
                    first[1] + y * BRICK,
                    first[2] + z * BRICK,
                ])
            })
            .collect()
    }

    /// Centre of a cube of `edge` nodes, and the distance to its farthest node.
    fn around(&self, first: [i32; 3], edge: i32) -> (Vec3, Real) {
        let half = 0.5 * Real::from(edge - 1) * self.grid.voxel;
        (
            self.grid.position(first).add_scalar(half),
            half * libm::sqrt(3.0) * (1.0 + 1e-9),
        )
    }

    /// Whether a cube of `edge` nodes and the voxels around it reach into what is to be built.
    fn wanted(&self, first: [i32; 3], edge: i32) -> bool {
        let (low, high) = (
            self.grid.position(first.map(|f| f - 1)),
            self.grid.position(first.map(|f| f + edge)),
        );
        let within = self.settings.within.as_ref();
        within.is_none_or(|within| low <= within.max && within.min <= high)
    }

    fn brick(&self, first: [i32; 3]) -> Option<BoneBrick> {
        if !self.wanted(first, BRICK) {
            return None;
        }
        let (centre, radius) = self.around(first, BRICK);
        let depth = self.distance.signed(&centre);
        if depth > self.band + radius {
            return None;
        }
        let shell = self.settings.thickest_shell();
        // Deeper than the band below the shell, the mesh no longer matters.
        let near_mesh = depth > -(shell + self.band + radius);
        let triangles = if near_mesh {
            self.distance.within(&centre, depth.abs() + 2.0 * radius)
        } else {
            Vec::new()
        };
        let struts = self.network.near(&centre, self.band + radius);
        let openings = self.near_openings(&centre, radius);

        let mut brick = BoneBrick {
            first,
            phi: Box::new([self.grid.background; 512]),
            place: Box::new([place::ELSEWHERE; 512]),
            shell: 0.0,
            tallies: vec![[Tally::default(); CLASSES]; self.settings.regions.len()],
        };
        for octant in 0..8 {
            let step = [octant >> 2 & 1, octant >> 1 & 1, octant & 1];
            self.octant(&mut brick, step, &triangles, &struts, &openings, depth);
        }
        Some(brick)
    }

    /// Fills an eighth of a brick from the part of the lists that matters there.
    fn octant(
        &self,
        brick: &mut BoneBrick,
        step: [i32; 3],
        triangles: &[u32],
        struts: &[Strut],
        openings: &Openings<'_>,
        brick_depth: Real,
    ) {
        let first: [i32; 3] = std::array::from_fn(|axis| brick.first[axis] + step[axis] * EDGE);
        let (centre, radius) = self.around(first, EDGE);
        let listed = (triangles.len() <= MANY).then(|| {
            self.distance
                .nearest_within(&centre, 2.0 * radius, triangles)
        });
        let closest = |x: &Vec3| match &listed {
            Some(listed) => self.distance.closest_among(x, listed),
            None => self.distance.closest(x),
        };
        let shallowest = if triangles.is_empty() {
            brick_depth
        } else {
            let depth = closest(&centre).0;
            if depth > self.band + radius {
                return;
            }
            depth + radius
        };
        let struts: Vec<Axis> = nearest_struts(&centre, radius, struts)
            .iter()
            .map(Axis::of)
            .collect();
        let thickest = self.settings.thickest_shell();
        let strut_of_node = widest(StrutDistances {
            struts: &struts,
            places: std::array::from_fn(|n| self.grid.position(first.map(|f| f + n as i32))),
            most: self.band,
        });
        for n in 0..EDGE.pow(3) {
            let offset = [n / (EDGE * EDGE), n / EDGE % EDGE, n % EDGE];
            let node: [i32; 3] = std::array::from_fn(|axis| step[axis] * EDGE + offset[axis]);
            let x = self
                .grid
                .position(std::array::from_fn(|axis| brick.first[axis] + node[axis]));
            let strut = strut_of_node[n as usize / 4][n as usize % 4];
            // Where the shell cannot be nearer than a strut, a bound of the depth is as good as the depth.
            let (d, shell) =
                if triangles.is_empty() || shallowest < -thickest - strut.max(self.grid.voxel) {
                    (shallowest, thickest)
                } else {
                    let (d, surface) = closest(&x);
                    (d, self.settings.shell_at(&(x - surface)))
                };
            let cortex = (d + 0.5 * shell).abs() - 0.5 * shell;
            let open = if openings.is_empty() {
                -self.band
            } else {
                openings.depth(&x).max(-self.band)
            };
            let phi = cortex.min(strut.max(d)).max(open);
            let node = (node[0] << 6 | node[1] << 3 | node[2]) as usize;
            brick.phi[node] = phi.clamp(-self.band, self.band) as f32;
            brick.shell += solid_share(cortex.max(open), self.grid.voxel);
            brick.place[node] = if open > 0.0 && d < 0.0 {
                place::BORE
            } else if d < -shell {
                let region = self.sources.region_at(self.settings, &x);
                let struts = &self.settings.regions[region].struts;
                let asked = self.sources.asked(struts, &x).unwrap_or(0.0);
                let (voxel, half) = (self.grid.voxel, 0.5 * self.grid.voxel);
                brick.tallies[region][class_of(asked)].add(&Tally {
                    nodes: 1.0,
                    solid: unbiased_share(strut, voxel),
                    asked,
                    layer: solid_share(strut - half, voxel) - solid_share(strut + half, voxel),
                });
                place::FIRST_REGION + region as u8
            } else {
                place::ELSEWHERE
            };
        }
    }

    /// Bores and other openings that reach into the band around a point within `radius` of `centre`.
    fn near_openings(&self, centre: &Vec3, radius: Real) -> Openings<'_> {
        let reach = -(self.band + radius);
        let bores = self.bores.iter();
        let others = self.settings.openings.iter().map(|opening| &opening.shape);
        Openings {
            bores: bores.filter(|b| b.distance(centre).0 >= reach).collect(),
            others: others.filter(|o| o.depth(centre) >= reach).collect(),
        }
    }
}

struct Openings<'a> {
    bores: Vec<&'a Shape>,
    others: Vec<&'a OpeningShape>,
}

impl Openings<'_> {
    fn is_empty(&self) -> bool {
        self.bores.is_empty() && self.others.is_empty()
    }

    /// How deep `x` lies in one of them [m], negative outside all.
    fn depth(&self, x: &Vec3) -> Real {
        let bores = self.bores.iter().map(|bore| bore.distance(x).0);
        let others = self.others.iter().map(|shape| shape.depth(x));
        bores.chain(others).fold(Real::NEG_INFINITY, Real::max)
    }
}

/// A strut made ready for many points.
struct Axis {
    from: Vec3,
    along: Vec3,
    per_square: Real,
    radius: Real,
    taper: Real,
}

impl Axis {
    fn of(strut: &Strut) -> Self {
        let along = strut.to - strut.from;
        Self {
            from: strut.from,
            along,
            per_square: 1.0 / along.norm_squared().max(1e-30),
            radius: strut.radius[0],
            taper: strut.radius[1] - strut.radius[0],
        }
    }
}

/// Distances [m] from the nodes of an octant to the nearest strut, as [`Strut::distance`], at most `most`.
struct StrutDistances<'a> {
    struts: &'a [Axis],
    /// Positions of the nodes along its diagonal [m].
    places: [Vec3; EDGE as usize],
    most: Real,
}

impl Wide for StrutDistances<'_> {
    /// Rows along z.
    type Out = [[Real; EDGE as usize]; (EDGE * EDGE) as usize];

    #[inline(always)]
    fn run(self) -> Self::Out {
        let mut least = [[self.most; EDGE as usize]; (EDGE * EDGE) as usize];
        for strut in self.struts {
            let along = strut.along;
            let z = self.places.map(|place| place.z - strut.from.z);
            for (row, least) in least.iter_mut().enumerate() {
                let x = self.places[row / EDGE as usize].x - strut.from.x;
                let y = self.places[row % EDGE as usize].y - strut.from.y;
                for (least, z) in least.iter_mut().zip(z) {
                    let t = (x * along.x + y * along.y + z * along.z) * strut.per_square;
                    let t = t.clamp(0.0, 1.0);
                    let (x, y, z) = (x - along.x * t, y - along.y * t, z - along.z * t);
                    let away = (x * x + y * y + z * z).sqrt();
                    *least = least.min(away - (strut.radius + strut.taper * t));
                }
            }
        }
        least
    }
}

/// The struts that can be nearest to a point within `radius` of `centre`.
fn nearest_struts(centre: &Vec3, radius: Real, struts: &[Strut]) -> Vec<Strut> {
    let distances: Vec<Real> = struts.iter().map(|strut| strut.distance(centre)).collect();
    let nearest = distances.iter().copied().fold(Real::INFINITY, Real::min);
    let reach = nearest + 2.0 * radius;
    let kept = struts.iter().zip(&distances).filter(|(_, d)| **d <= reach);
    kept.map(|(strut, _)| *strut).collect()
}

/// [`build`] of a mesh whose distance nothing else needs.
#[cfg(test)]
pub(super) fn build_alone(
    mesh: &TriMesh,
    settings: &BoneSettings,
    sources: &Sources,
    spacing: Real,
    carve: &[Channel],
) -> Result<Bone, BoneError> {
    let distance = MeshDistance::new(mesh);
    build(mesh, &distance, settings, sources, spacing, carve)
}
