//! How thick struts must be to leave the porosity that was asked for.
//!
//! Where one porosity is asked for, the radius is a quantile: of the distances from points of the region to the
//! nearest axis, each in radii of its strut, the share of bone is to be below 1. Where it varies, points are sorted
//! into classes by what is asked of them; each class has a radius, struts take theirs from between the classes, and
//! the radii are corrected until every class has what it asked for.

use super::network::{Strut, tree_of};
use super::settings::BoneSettings;
use super::sources::Sources;
use crate::math::{Real, Vec3};
use crate::mesh::{Lattice, MeshDistance, TriMesh, inside_columns, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhNode};
use rayon::prelude::*;

/// Points in the bone's bounding box from which a porosity is solved.
const MOST: Real = 1.5e6;
/// Classes of asked porosity.
const CLASSES: usize = 8;
/// Corrections of their radii.
const ROUNDS: usize = 8;
/// Porosities closer than this are one.
const SAME: Real = 1e-3;

/// Points of a region inside the shell.
pub(super) struct Samples {
    /// Where, and whether struts of regions before this one fill it already.
    points: Vec<(Vec3, bool)>,
    /// Radius if there are none, or no struts [m].
    fallback: Real,
}

impl Samples {
    pub(super) fn inside(
        settings: &BoneSettings,
        sources: &Sources,
        region: usize,
        others: &[Strut],
        mesh: &TriMesh,
        distance: &MeshDistance,
    ) -> Self {
        let bounds = mesh.bounds();
        let extent = bounds.extent();
        let by_count = libm::cbrt(extent.x * extent.y * extent.z / MOST);
        let period = settings.regions[region].period;
        // Not a simple fraction of the period: samples would always hit the same places.
        let step = (period / 7.31).max(by_count);
        let lattice = Lattice::cells(&bounds, step);
        let inside = inside_columns(mesh, &lattice);
        let tree = tree_of(others);
        let thickest = others.iter().flat_map(|s| s.radius).fold(0.0, Real::max);
        let filled = |x: &Vec3| {
            let square = thickest * thickest;
            tree.leaves(|node: &BvhNode| square_to_box(x, node) <= square)
                .any(|s| others[s as usize].distance(x) < 0.0)
        };
        let points = (0..lattice.len())
            .into_par_iter()
            .filter(|&index| inside[index])
            .filter_map(|index| {
                let x = lattice.position(index);
                let deep = |x: &Vec3| {
                    let (depth, surface) = distance.closest(x);
                    depth <= -settings.shell_at(&(x - surface))
                };
                let wanted = sources.region_at(settings, &x) == region && deep(&x);
                wanted.then(|| (x, filled(&x)))
            })
            .collect();
        Self {
            points,
            fallback: 0.25 * period,
        }
    }
}

/// The struts, whose radii are ratios, with radii [m] that leave the porosity `asked` for.
pub(super) fn solve(
    samples: &Samples,
    struts: &[Strut],
    asked: impl Fn(&Vec3) -> Option<Real> + Sync,
) -> Vec<Strut> {
    let wanted: Vec<Real> = samples
        .points
        .par_iter()
        .map(|(x, _)| asked(x).unwrap_or(1.0))
        .collect();
    let mut sorted = wanted.clone();
    sorted.sort_unstable_by(Real::total_cmp);
    let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else {
        let radius = samples.fallback;
        return struts.iter().map(|s| s.thick(|_| radius)).collect();
    };
    let axes = Axes::new(struts);
    let distances: Vec<Real> = samples
        .points
        .par_iter()
        .map(|(x, filled)| {
            if *filled {
                0.0
            } else {
                axes.nearest(x).unwrap_or(Real::INFINITY)
            }
        })
        .collect();
    let quantile = |porosity: Real, of: &mut Vec<Real>| {
        let solid = ((1.0 - porosity) * of.len() as Real) as usize;
        let at = solid.min(of.len() - 1);
        let radius = *of.select_nth_unstable_by(at, Real::total_cmp).1;
        if radius.is_finite() {
            radius
        } else {
            samples.fallback
        }
    };
    if most - least < SAME {
        let radius = quantile(0.5 * (least + most), &mut distances.clone());
        return struts.iter().map(|s| s.thick(|_| radius)).collect();
    }

    let mut classes = Classes::new(&sorted);
    let of_point: Vec<usize> = wanted.iter().map(|p| classes.of(*p)).collect();
    for class in 0..classes.porosity.len() {
        let mine = of_point
            .iter()
            .zip(&distances)
            .filter(|(c, _)| **c == class);
        let mut mine: Vec<Real> = mine.map(|(_, d)| *d).collect();
        classes.radius[class] = quantile(classes.porosity[class], &mut mine);
    }
    let thick = |classes: &Classes| -> Vec<Strut> {
        let radius = |x: &Vec3| classes.radius_for(asked(x).unwrap_or(1.0));
        struts.iter().map(|s| s.thick(radius)).collect()
    };
    for _ in 0..ROUNDS {
        let now = thick(&classes);
        let axes = Axes::new(&now);
        let solid: Vec<bool> = samples
            .points
            .par_iter()
            .map(|(x, filled)| *filled || axes.holds(x))
            .collect();
        let mut made = vec![[0_u32; 2]; classes.porosity.len()];
        for (class, solid) in of_point.iter().zip(&solid) {
            made[*class][usize::from(*solid)] += 1;
        }
        for (class, [open, solid]) in made.into_iter().enumerate() {
            // The volume of rods goes with the square of their radius.
            let share = Real::from(solid) / Real::from((open + solid).max(1));
            let ratio = (1.0 - classes.porosity[class]) / share.max(1e-4);
            classes.radius[class] *= ratio.sqrt().clamp(0.7, 1.4);
        }
    }
    thick(&classes)
}

/// Classes of equally many points: mean porosity asked and radius that makes it.
struct Classes {
    /// Upper ends but the last.
    ends: Vec<Real>,
    porosity: Vec<Real>,
    radius: Vec<Real>,
}

impl Classes {
    fn new(sorted: &[Real]) -> Self {
        let parts: Vec<&[Real]> = sorted.chunks(sorted.len().div_ceil(CLASSES)).collect();
        let mut classes = Self {
            ends: Vec::new(),
            porosity: Vec::new(),
            radius: Vec::new(),
        };
        for part in parts {
            let mean = part.iter().sum::<Real>() / part.len() as Real;
            let last = classes.porosity.last().copied();
            if last.is_none_or(|last| mean - last > SAME) {
                if last.is_some() {
                    classes.ends.push(part[0]);
                }
                classes.porosity.push(mean);
                classes.radius.push(0.0);
            }
        }
        classes
    }

    fn of(&self, porosity: Real) -> usize {
        self.ends.partition_point(|end| *end <= porosity)
    }

    /// Between the classes' means linear, beyond them constant.
    fn radius_for(&self, porosity: Real) -> Real {
        let above = self.porosity.partition_point(|p| *p <= porosity);
        if above == 0 {
            return self.radius[0];
        }
        if above == self.porosity.len() {
            return self.radius[above - 1];
        }
        let (low, high) = (self.porosity[above - 1], self.porosity[above]);
        let t = (porosity - low) / (high - low);
        self.radius[above - 1] + (self.radius[above] - self.radius[above - 1]) * t
    }
}

/// Struts to be searched by the distance to their axes.
struct Axes<'a> {
    struts: &'a [Strut],
    thickest: Real,
    tree: Bvh,
}

impl<'a> Axes<'a> {
    fn new(struts: &'a [Strut]) -> Self {
        Self {
            struts,
            thickest: struts.iter().flat_map(|s| s.radius).fold(0.0, Real::max),
            tree: tree_of(struts),
        }
    }

    /// The least distance to an axis, in the radius there.
    fn nearest(&self, x: &Vec3) -> Option<Real> {
        let found = self.tree.find_best(
            Real::MAX,
            |node: &BvhNode, _| square_to_box(x, node).sqrt() / self.thickest,
            |s, _| {
                let (away, radius) = self.struts[s as usize].axis(x);
                Some(away / radius)
            },
        );
        found.map(|(_, scaled)| scaled)
    }

    fn holds(&self, x: &Vec3) -> bool {
        let square = self.thickest * self.thickest;
        self.tree
            .leaves(|node: &BvhNode| square_to_box(x, node) <= square)
            .any(|s| self.struts[s as usize].distance(x) < 0.0)
    }
}
