//! The trabecular network: struts between the nodes of a jittered lattice.
//!
//! Every region has its own lattice. A strut that would leave its region is led to the nearest node of the region that
//! it enters, so that the networks of all regions hang together; a strut that leaves the bone ends in its shell.

use super::settings::{BoneError, BoneSettings, Struts};
use crate::math::{Aabb, Real, Vec3, hash_unit};
use crate::mesh::{Lattice, MeshDistance, TriMesh, inside_columns, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A rod with round ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strut {
    /// Centre of one end [m].
    pub from: Vec3,
    /// Centre of the other end [m].
    pub to: Vec3,
    /// Radius [m].
    pub radius: Real,
}

impl Strut {
    /// Distance to the surface [m], negative inside.
    #[inline]
    pub fn distance(&self, x: &Vec3) -> Real {
        self.axis_distance(x) - self.radius
    }

    #[inline]
    fn axis_distance(&self, x: &Vec3) -> Real {
        let axis = self.to - self.from;
        let along = ((x - self.from).dot(&axis) / axis.norm_squared().max(1e-30)).clamp(0.0, 1.0);
        (x - self.from - axis * along).norm()
    }
}

/// All struts of a bone, ready to be searched.
pub(super) struct Network {
    pub(super) struts: Vec<Strut>,
    /// Diameter of the horizontal struts of each region [m].
    pub(super) diameters: Vec<Real>,
    tree: Bvh,
}

impl Network {
    /// Grows the struts of every region inside `mesh`, whose distance is `distance`.
    pub(super) fn grow(
        settings: &BoneSettings,
        mesh: &TriMesh,
        distance: &MeshDistance,
    ) -> Result<Self, BoneError> {
        let bounds = mesh.bounds();
        let lattices = (0..settings.regions.len())
            .map(|region| StrutLattice::new(settings, region, distance, &bounds))
            .collect::<Result<Vec<_>, _>>()?;
        let mut struts = Vec::new();
        let mut diameters = Vec::new();
        for region in 0..lattices.len() {
            // With radius 1 (or the vertical ratio): the true radius multiplies it once it is known.
            let mut own = lattices[region].struts(settings, &lattices);
            let diameter = match settings.regions[region].struts {
                Struts::Diameter(diameter) => diameter,
                Struts::Porosity(porosity) => {
                    2.0 * radius_for(porosity, settings, region, &own, &struts, mesh, distance)
                }
            };
            for strut in &mut own {
                strut.radius *= 0.5 * diameter;
            }
            diameters.push(diameter);
            struts.extend(own);
        }
        let tree = tree_of(&struts);
        Ok(Self {
            struts,
            diameters,
            tree,
        })
    }

    /// Struts whose surface may come within `reach` [m] of `centre`.
    pub(super) fn near(&self, centre: &Vec3, reach: Real) -> Vec<Strut> {
        let largest = self.diameters.iter().fold(0.0, |a: Real, d| a.max(*d));
        let square = (reach + largest) * (reach + largest);
        self.tree
            .leaves(|node: &BvhNode| square_to_box(centre, node) <= square)
            .map(|s| self.struts[s as usize])
            .filter(|strut| strut.distance(centre) <= reach)
            .collect()
    }
}

/// Boxes around the axes, not the surfaces.
fn tree_of(struts: &[Strut]) -> Bvh {
    let boxes: Vec<_> = struts
        .iter()
        .map(|s| {
            let (low, high) = (s.from.inf(&s.to), s.from.sup(&s.to));
            parry3d_f64::bounding_volume::Aabb::new(low.into(), high.into())
        })
        .collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}

/// The radius with which struts leave `porosity` of their region open: the quantile of the distance to their axes.
/// What `others`, led here from regions before, fill is not open already.
fn radius_for(
    porosity: Real,
    settings: &BoneSettings,
    region: usize,
    struts: &[Strut],
    others: &[Strut],
    mesh: &TriMesh,
    distance: &MeshDistance,
) -> Real {
    let bounds = mesh.bounds();
    let extent = bounds.extent();
    let by_count = (extent.x * extent.y * extent.z / SAMPLES).cbrt();
    // Not a simple fraction of the period: samples would always hit the same places.
    let step = (settings.regions[region].period / 7.31).max(by_count);
    let lattice = Lattice::cells(&bounds, step);
    let inside = inside_columns(mesh, &lattice);
    let largest = settings.vertical.max(1.0);
    let tree = tree_of(struts);
    let tree_of_others = tree_of(others);
    let thickest = others
        .iter()
        .fold(0.0, |a: Real, strut| a.max(strut.radius));
    let filled = |x: &Vec3| {
        let square = thickest * thickest;
        tree_of_others
            .leaves(|node: &BvhNode| square_to_box(x, node) <= square)
            .any(|s| others[s as usize].distance(x) < 0.0)
    };
    let mut distances: Vec<Real> = (0..lattice.len())
        .into_par_iter()
        .filter(|&index| inside[index])
        .filter_map(|index| {
            let x = lattice.position(index);
            if settings.region_at(&x) != region || distance.signed(&x) > -settings.shell_thickness {
                return None;
            }
            if filled(&x) {
                return Some(0.0);
            }
            let nearest = tree.find_best(
                Real::MAX,
                |node: &BvhNode, _| square_to_box(&x, node).sqrt() / largest,
                |s, _| {
                    let strut = &struts[s as usize];
                    Some(strut.axis_distance(&x) / strut.radius)
                },
            );
            Some(nearest.map_or(Real::INFINITY, |(_, scaled)| scaled))
        })
        .collect();
    if distances.is_empty() {
        // Nothing of the region lies inside the bone: any radius is right.
        return 0.25 * settings.regions[region].period;
    }
    let solid = ((1.0 - porosity) * distances.len() as Real) as usize;
    let at = solid.min(distances.len() - 1);
    *distances.select_nth_unstable_by(at, Real::total_cmp).1
}

/// Points in the bone's bounding box from which a porosity is solved.
const SAMPLES: Real = 1.5e6;
/// More lattice cells than this are refused.
const MAX_CELLS: Real = 2e7;

/// The nodes of one region's lattice.
struct StrutLattice {
    region: usize,
    period: Real,
    origin: Vec3,
    seed: u64,
    jitter: Real,
    /// Nodes that lie in the region, and whether they are inside the bone.
    nodes: BTreeMap<[i64; 3], (Vec3, bool)>,
}

impl StrutLattice {
    fn new(
        settings: &BoneSettings,
        region: usize,
        distance: &MeshDistance,
        bounds: &Aabb,
    ) -> Result<Self, BoneError> {
        let period = settings.regions[region].period;
        let extent = bounds.extent();
        if extent.map(|e| e / period + 3.0).product() > MAX_CELLS {
            return Err(BoneError::TooFine {
                size: extent.max(),
                key: format!("regions[{region}].period"),
                length: period,
            });
        }
        let mut lattice = Self {
            region,
            period,
            origin: bounds.min,
            seed: settings.seed.wrapping_add(region as u64),
            jitter: settings.jitter,
            nodes: BTreeMap::new(),
        };
        let count = extent.map(|e| (e / period).ceil() as i64 + 1);
        let mut cells = Vec::new();
        for x in -1..=count.x {
            for y in -1..=count.y {
                cells.extend((-1..=count.z).map(|z| [x, y, z]));
            }
        }
        lattice.nodes = cells
            .into_par_iter()
            .filter_map(|cell| {
                let x = lattice.position(cell);
                (settings.region_at(&x) == region).then(|| (cell, (x, distance.signed(&x) < 0.0)))
            })
            .collect::<Vec<_>>()
            .into_iter()
            .collect();
        Ok(lattice)
    }

    fn position(&self, cell: [i64; 3]) -> Vec3 {
        Vec3::from_fn(|axis, _| {
            let stray = 2.0 * hash_unit(self.seed, cell, axis as u64) - 1.0;
            (cell[axis] as Real + 0.5 + self.jitter * stray) * self.period
        }) + self.origin
    }

    /// Struts from this region's nodes, with the ratio to the region's radius in place of the radius.
    fn struts(&self, settings: &BoneSettings, all: &[Self]) -> Vec<Strut> {
        let mut struts = Vec::new();
        for (&cell, &(from, inside)) in &self.nodes {
            for direction in 0..6 {
                let (axis, forward) = (direction / 2, direction % 2 == 0);
                let mut next = cell;
                next[axis] += if forward { 1 } else { -1 };
                let to = match self.nodes.get(&next) {
                    // A pair of nodes inside one region: once.
                    Some(&(to, other_inside)) if forward && (inside || other_inside) => to,
                    Some(_) => continue,
                    None => {
                        let to = self.position(next);
                        let neighbour = settings.region_at(&to);
                        if !inside || neighbour < self.region {
                            continue;
                        }
                        all[neighbour].nearest(&to).unwrap_or(to)
                    }
                };
                struts.push(Strut {
                    from,
                    to,
                    radius: if axis == 2 { settings.vertical } else { 1.0 },
                });
            }
        }
        struts
    }

    /// The node nearest to `x`, if there is one in the cells around it.
    fn nearest(&self, x: &Vec3) -> Option<Vec3> {
        let centre = (x - self.origin) / self.period;
        let cell: [i64; 3] = std::array::from_fn(|axis| centre[axis].floor() as i64);
        let mut nearest: Option<(Real, Vec3)> = None;
        for dx in -1..=1 {
            for dy in -1..=1 {
                for dz in -1..=1 {
                    let key = [cell[0] + dx, cell[1] + dy, cell[2] + dz];
                    if let Some((node, _)) = self.nodes.get(&key) {
                        let far = (node - x).norm();
                        if nearest.is_none_or(|(best, _)| far < best) {
                            nearest = Some((far, *node));
                        }
                    }
                }
            }
        }
        nearest.map(|(_, node)| node)
    }
}
