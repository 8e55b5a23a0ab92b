//! How thick struts must be to leave the porosity that was asked for.
//!
//! Where one porosity is asked for, the radius is a quantile: of the distances from points of the region to the
//! nearest axis, each in radii of its strut, the share of bone is to be below 1. Where it varies, points are sorted
//! into classes by what is asked of them; each class has a radius, struts take theirs from between the classes, and
//! the radii are corrected until every class has what it asked for.
//!
//! No class reaches over the edge of one that the report tells: what is right only on the whole of a wide class is
//! too thin at its one end and too thick at the other. And a strut is cut into pieces: where the porosity changes
//! within its length, its ends alone know too little of it.

use super::build::class_of;
use super::network::{Strut, tree_of};
use super::settings::{BoneSettings, Struts};
use super::sources::Sources;
use crate::math::{Real, Vec3};
use crate::mesh::{Lattice, MeshDistance, TriMesh, inside_columns, square_to_box};
use parry3d_f64::partitioning::{Bvh, BvhNode};
use rayon::prelude::*;

/// Points in the bone's bounding box from which one porosity is solved, and one that varies: rare values need enough.
const MOST: [Real; 2] = [1.5e6, 5e6];
/// Of more points than this, a class is judged by some.
const ENOUGH: usize = 60_000;
/// A class of asked porosity holds no more than this share of the points, and no fewer than this.
const SHARES: [Real; 2] = [0.125, 0.005];
/// Corrections of their radii, at most.
const ROUNDS: usize = 8;
/// Porosities closer than this are one.
const SAME: Real = 1e-3;
/// The volume of rods goes with the square of their radius. Rods of other classes reach into a class, so that its own
/// radius does less: a half more than the root converges sooner.
const EXPONENT: Real = 0.75;

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
        let what = &settings.regions[region];
        let most = MOST[usize::from(matches!(what.struts, Struts::Varying(_)))];
        let by_count = libm::cbrt(extent.x * extent.y * extent.z / most);
        let period = what.period;
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
    let mut of_class: Vec<Vec<usize>> = vec![Vec::new(); classes.porosity.len()];
    for (point, porosity) in wanted.iter().enumerate() {
        of_class[classes.of(*porosity)].push(point);
    }
    for (class, mine) in of_class.iter().enumerate() {
        let mut mine: Vec<Real> = mine.iter().map(|&point| distances[point]).collect();
        classes.radius[class] = quantile(classes.porosity[class], &mut mine);
    }
    let thick = |classes: &Classes| -> Vec<Strut> {
        let radius = |x: &Vec3| classes.radius_for(asked(x).unwrap_or(1.0));
        struts.iter().map(|s| s.thick(radius)).collect()
    };
    let judges: Vec<Vec<(Vec3, bool)>> = of_class
        .iter()
        .map(|mine| {
            let some = mine.iter().step_by(mine.len().div_ceil(ENOUGH));
            some.map(|&point| samples.points[point]).collect()
        })
        .collect();
    let mut best = (Real::INFINITY, classes.radius.clone());
    for _ in 0..ROUNDS {
        let now = thick(&classes);
        let axes = Axes::new(&now);
        let before = classes.radius.clone();
        let mut worst: Real = 0.0;
        for (class, mine) in judges.iter().enumerate() {
            let solid = mine
                .par_iter()
                .filter(|(x, filled)| *filled || axes.holds(x));
            let made = solid.count() as Real / mine.len() as Real;
            let asked = 1.0 - classes.porosity[class];
            worst = worst.max((made - asked).abs());
            let ratio = libm::pow(asked / made.max(1e-4), EXPONENT);
            classes.radius[class] *= ratio.clamp(0.7, 1.4);
        }
        if worst < best.0 {
            best = (worst, before);
        }
        if worst < SAME {
            break;
        }
    }
    classes.radius = best.1;
    thick(&classes)
}

/// Classes of points: mean porosity asked and radius that makes it. None is empty: each begins at what a point asks for.
struct Classes {
    /// Upper ends but the last.
    ends: Vec<Real>,
    porosity: Vec<Real>,
    radius: Vec<Real>,
}

impl Classes {
    fn new(sorted: &[Real]) -> Self {
        let [most, least] = SHARES.map(|share| (share * sorted.len() as Real).ceil() as usize);
        let mut ends = Vec::new();
        let (mut at, mut last) = (0, (0, sorted[0]));
        for told in sorted.chunk_by(|a, b| class_of(*a) == class_of(*b)) {
            let parts = told.len().div_ceil(most);
            for part in told.chunks(told.len().div_ceil(parts)) {
                let rare = at - last.0 < least || sorted.len() - at < least;
                if !rare && part[0] - last.1 > SAME {
                    ends.push(part[0]);
                    last = (at, part[0]);
                }
                at += part.len();
            }
        }
        let mut classes = Self {
            porosity: vec![0.0; ends.len() + 1],
            radius: vec![0.0; ends.len() + 1],
            ends,
        };
        let mut rest = sorted;
        for (class, mean) in classes.porosity.iter_mut().enumerate() {
            let end = classes.ends.get(class);
            let count = end.map_or(rest.len(), |end| rest.partition_point(|p| p < end));
            let (mine, after) = rest.split_at(count);
            *mean = mine.iter().sum::<Real>() / count as Real;
            rest = after;
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
