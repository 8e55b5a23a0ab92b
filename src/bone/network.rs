//! The trabecular network: struts between scattered nodes, three or four at a typical one.
//!
//! Every region scatters nodes of its own, one a cell of its lattice. Two nodes are joined if no third is nearer to
//! both: the relative neighbourhood graph [Toussaint80]. It contains the shortest tree through all nodes, so the
//! struts of all regions hang together; a strut that leaves the bone ends in its shell.

use super::nodes::Nodes;
use super::settings::{BoneError, BoneSettings, Struts};
use crate::math::{Real, Vec3};
use crate::mesh::{Lattice, MeshDistance, TriMesh, inside_columns, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use rayon::prelude::*;

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
    /// Mean diameter of the horizontal struts of each region [m].
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
        let nodes = Nodes::scatter(settings, distance, &bounds)?;
        let joined = nodes.join(settings.vertical);
        let mut struts = Vec::new();
        let mut diameters = Vec::new();
        for region in 0..settings.regions.len() {
            // With the ratio to the region's radius in place of the radius, until that is known.
            let of_region = joined.iter().filter(|(owner, _)| *owner == region);
            let mut own: Vec<Strut> = of_region.map(|(_, strut)| *strut).collect();
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
