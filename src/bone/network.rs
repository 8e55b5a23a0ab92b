//! The trabecular network: struts between scattered nodes, three or four at a typical one.
//!
//! Every region scatters nodes of its own, one a cell of its lattice. Two nodes are joined if no third is nearer to
//! both: the relative neighbourhood graph [Toussaint80]. It contains the shortest tree through all nodes, so the
//! struts of all regions hang together; a strut that leaves the bone ends in its shell.

use super::nodes::Nodes;
use super::settings::{BoneError, BoneSettings, Struts};
use super::sources::Sources;
use super::thickness::{self, Samples};
use crate::math::{Real, Vec3};
use crate::mesh::{MeshDistance, TriMesh, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};

/// Pieces of struts whose thickness varies, in periods at most: the thickness of a rod cannot follow any closer.
const PIECE: Real = 0.5;

/// A rod with round ends, which may taper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strut {
    /// Centre of one end [m].
    pub from: Vec3,
    /// Centre of the other end [m].
    pub to: Vec3,
    /// Radii there [m].
    pub radius: [Real; 2],
}

impl Strut {
    /// Distance to the surface [m], negative inside; exact for a rod that does not taper.
    #[inline]
    pub fn distance(&self, x: &Vec3) -> Real {
        let (away, radius) = self.axis(x);
        away - radius
    }

    /// Distance to the axis, and the radius at the nearest point of it [m].
    #[inline]
    pub(super) fn axis(&self, x: &Vec3) -> (Real, Real) {
        let axis = self.to - self.from;
        let along = ((x - self.from).dot(&axis) / axis.norm_squared().max(1e-30)).clamp(0.0, 1.0);
        let [first, second] = self.radius;
        (
            (x - self.from - axis * along).norm(),
            first + (second - first) * along,
        )
    }
}

/// All struts of a bone, ready to be searched.
pub(super) struct Network {
    /// Those whose thickness follows a porosity that varies are in pieces.
    pub(super) struts: Vec<Strut>,
    /// How many there are, in pieces or not.
    pub(super) count: usize,
    /// Mean diameter of the horizontal struts of each region [m].
    pub(super) diameters: Vec<Real>,
    /// The largest radius [m].
    thickest: Real,
    tree: Bvh,
}

impl Network {
    /// Grows the struts of every region inside `mesh`, whose distance is `distance`.
    pub(super) fn grow(
        settings: &BoneSettings,
        sources: &Sources,
        mesh: &TriMesh,
        distance: &MeshDistance,
    ) -> Result<Self, BoneError> {
        let bounds = mesh.bounds();
        let nodes = Nodes::scatter(settings, sources, distance, &bounds)?;
        let joined = nodes.join(settings);
        let mut struts: Vec<Strut> = Vec::new();
        let mut diameters = Vec::new();
        for (region, what) in settings.regions.iter().enumerate() {
            // With the ratio to the region's radius in place of the radius, until that is known.
            let of_region = joined.iter().filter(|(owner, _)| *owner == region);
            let mut own: Vec<Strut> = of_region.map(|(_, strut)| *strut).collect();
            let thick = match what.struts {
                Struts::Diameter(diameter) => {
                    let radius = [0.5 * diameter; 2];
                    own.iter().map(|strut| strut.thick(|_| radius[0])).collect()
                }
                Struts::Porosity(_) | Struts::Varying(_) => {
                    if matches!(what.struts, Struts::Varying(_)) {
                        let longest = PIECE * what.period;
                        own = own.iter().flat_map(|s| s.pieces(longest)).collect();
                    }
                    let samples =
                        Samples::inside(settings, sources, region, &struts, mesh, distance);
                    thickness::solve(&samples, &own, |x| sources.asked(&what.struts, x))
                }
            };
            let ratio = |(strut, thick): (&Strut, &Strut)| {
                let sum = |s: &Strut| s.radius[0] + s.radius[1];
                sum(thick) / sum(strut)
            };
            let sum: Real = own.iter().zip(&thick).map(ratio).sum();
            diameters.push(2.0 * sum / own.len().max(1) as Real);
            struts.extend(thick);
        }
        let tree = tree_of(&struts);
        let thickest = struts.iter().flat_map(|s| s.radius).fold(0.0, Real::max);
        Ok(Self {
            struts,
            count: joined.len(),
            diameters,
            thickest,
            tree,
        })
    }

    /// Struts whose surface may come within `reach` [m] of `centre`.
    pub(super) fn near(&self, centre: &Vec3, reach: Real) -> Vec<Strut> {
        let square = (reach + self.thickest).powi(2);
        self.tree
            .leaves(|node: &BvhNode| square_to_box(centre, node) <= square)
            .map(|s| self.struts[s as usize])
            .filter(|strut| strut.distance(centre) <= reach)
            .collect()
    }
}

impl Strut {
    /// Cut into equal pieces no longer than `longest` [m], for a strut that does not taper.
    fn pieces(&self, longest: Real) -> impl Iterator<Item = Strut> {
        let axis = self.to - self.from;
        let count = (axis.norm() / longest).ceil().max(1.0);
        let (from, radius) = (self.from, self.radius);
        let at = move |n: u32| from + axis * (Real::from(n) / count);
        (0..count as u32).map(move |n| Strut {
            from: at(n),
            to: at(n + 1),
            radius,
        })
    }

    /// Radii from ratios: `radius` [m] of the mean strut at a point.
    pub(super) fn thick(&self, radius: impl Fn(&Vec3) -> Real) -> Self {
        let [first, second] = self.radius;
        Self {
            radius: [first * radius(&self.from), second * radius(&self.to)],
            ..*self
        }
    }
}

/// Boxes around the axes, not the surfaces.
pub(super) fn tree_of(struts: &[Strut]) -> Bvh {
    let boxes: Vec<_> = struts
        .iter()
        .map(|s| {
            let (low, high) = (s.from.inf(&s.to), s.from.sup(&s.to));
            parry3d_f64::bounding_volume::Aabb::new(low.into(), high.into())
        })
        .collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}
