//! A uniform grid of cells, for finding what lies within a radius.

use crate::math::{Aabb, Real, Vec3, Wide, widest};

/// Which axes wrap around, and at what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// The box [m].
    pub bounds: Aabb,
    /// Whether opposite faces are one.
    pub periodic: [bool; 3],
}

impl Domain {
    /// The shortest of the vectors between the images of two points [m].
    #[inline(always)]
    pub fn shortest(&self, mut x_ij: Vec3) -> Vec3 {
        for axis in 0..3 {
            if self.periodic[axis] {
                let length = self.bounds.max[axis] - self.bounds.min[axis];
                x_ij[axis] -= length * (x_ij[axis] / length).round();
            }
        }
        x_ij
    }

    /// The image of `x` inside the box on the periodic axes.
    pub fn wrapped(&self, mut x: Vec3) -> Vec3 {
        for axis in 0..3 {
            if self.periodic[axis] {
                let (low, high) = (self.bounds.min[axis], self.bounds.max[axis]);
                let turns = ((x[axis] - low) / (high - low)).floor();
                x[axis] -= turns * (high - low);
                // Rounding may land exactly on the upper face, which is the lower one.
                if x[axis] >= high {
                    x[axis] = low;
                }
            }
        }
        x
    }
}

/// Points sorted into cells at least `radius` wide.
#[derive(Clone, Debug)]
pub struct Cells {
    origin: Vec3,
    width: Vec3,
    count: [i64; 3],
    domain: Domain,
    square: Real,
    start: Vec<u32>,
    order: Vec<u32>,
    /// Coordinates in the order of the cells, and some more so that lanes may read beyond the end.
    sorted: [Vec<Real>; 3],
}

/// Candidates looked at side by side.
const LANES: usize = 8;
/// Candidates that are sieved at once, and about as many that are near are visited at once.
const CANDIDATES: usize = 64;

/// Above this many cells per axis product the cells are made wider: memory stays bounded.
const MOST_CELLS: Real = 2e7;

impl Cells {
    /// Sorts `points`; those of one cell stay in ascending order.
    pub fn new(points: &[Vec3], radius: Real, domain: &Domain) -> Self {
        let mut bounds = Aabb::around(points);
        if bounds.is_empty() {
            bounds = Aabb {
                min: Vec3::zeros(),
                max: Vec3::zeros(),
            };
        }
        for axis in 0..3 {
            if domain.periodic[axis] {
                bounds.min[axis] = domain.bounds.min[axis];
                bounds.max[axis] = domain.bounds.max[axis];
            }
        }
        let extent = bounds.extent();
        let most = MOST_CELLS.min(64.0 * points.len() as Real + 4096.0);
        let mut wide = radius;
        while extent
            .iter()
            .map(|e| (e / wide).floor() + 1.0)
            .product::<Real>()
            > most
        {
            wide *= 1.5;
        }
        let mut count = [1_i64; 3];
        let mut width = Vec3::repeat(wide);
        for axis in 0..3 {
            if domain.periodic[axis] {
                count[axis] = ((extent[axis] / wide).floor() as i64).max(1);
                width[axis] = extent[axis] / count[axis] as Real;
            } else {
                count[axis] = (extent[axis] / wide).floor() as i64 + 1;
            }
        }
        let mut cells = Self {
            origin: bounds.min,
            width,
            count,
            domain: *domain,
            square: radius * radius,
            start: Vec::new(),
            order: vec![0; points.len()],
            sorted: Default::default(),
        };
        let total = (count[0] * count[1] * count[2]) as usize;
        let mut start = vec![0_u32; total + 1];
        let keys: Vec<u32> = points.iter().map(|x| cells.key(x) as u32).collect();
        for &key in &keys {
            start[key as usize + 1] += 1;
        }
        for c in 0..total {
            start[c + 1] += start[c];
        }
        let mut next = start.clone();
        for (i, &key) in keys.iter().enumerate() {
            cells.order[next[key as usize] as usize] = i as u32;
            next[key as usize] += 1;
        }
        cells.start = start;
        cells.sorted = std::array::from_fn(|axis| {
            let inside = cells.order.iter().map(|&i| points[i as usize][axis]);
            inside.chain([Real::INFINITY; LANES]).collect()
        });
        cells
    }

    #[inline(always)]
    fn coordinate(&self, x: &Vec3, axis: usize) -> i64 {
        ((x[axis] - self.origin[axis]) / self.width[axis]).floor() as i64
    }

    fn key(&self, x: &Vec3) -> usize {
        let c: [i64; 3] =
            std::array::from_fn(|a| self.coordinate(x, a).clamp(0, self.count[a] - 1));
        ((c[0] * self.count[1] + c[1]) * self.count[2] + c[2]) as usize
    }

    /// Cell indices along one axis that lie within one cell of `x`, each once.
    #[inline(always)]
    fn reach(&self, x: &Vec3, axis: usize) -> ([i64; 3], usize) {
        let (n, centre) = (self.count[axis], self.coordinate(x, axis));
        let mut found = ([0; 3], 0);
        for offset in -1..=1 {
            let mut c = centre + offset;
            if self.domain.periodic[axis] {
                c = c.rem_euclid(n);
            } else if c < 0 || c >= n {
                continue;
            }
            if !found.0[..found.1].contains(&c) {
                found.0[found.1] = c;
                found.1 += 1;
            }
        }
        found
    }

    /// Calls `visit(j, x − x_j, |x − x_j|²)` for every point within the radius of `x`, always in the same order.
    #[inline]
    pub fn near(&self, x: &Vec3, mut visit: impl FnMut(usize, Vec3, Real)) {
        widest(Near {
            cells: self,
            x,
            visit: |bunch: &[u32]| {
                for &place in bunch {
                    let x_ij = self.apart(x, place);
                    visit(self.number(place), x_ij, x_ij.norm_squared());
                }
            },
        });
    }

    /// Calls `visit` with the places of all points within the radius of `x`, in bunches, always in the same order. To be
    /// called from [`Wide`] work.
    #[inline(always)]
    pub(super) fn bunches(&self, x: &Vec3, mut visit: impl FnMut(&[u32])) {
        let (runs, number) = self.runs(x);
        let mut runs = runs[..number].iter();
        let mut found = [0; 2 * CANDIDATES];
        let (mut from, mut end) = (0, 0);
        // One call of `visit` alone: what is called at two places is not inlined.
        loop {
            let mut count = 0;
            while count <= CANDIDATES {
                if from == end {
                    let Some(&[first, last]) = runs.next() else {
                        break;
                    };
                    (from, end) = (first as usize, last as usize);
                }
                let to = end.min(from + CANDIDATES);
                count += self.sieve(x, from, to, &mut found[count..]);
                from = to;
            }
            if count == 0 {
                break;
            }
            visit(&found[..count]);
        }
    }

    /// Runs of points in the cells around `x`, from place to place, and how many runs there are.
    #[inline(always)]
    fn runs(&self, x: &Vec3) -> ([[u32; 2]; 27], usize) {
        let [(xs, nx), (ys, ny), (zs, nz)] = [0, 1, 2].map(|axis| self.reach(x, axis));
        let (mut runs, mut number) = ([[0; 2]; 27], 0);
        for &cx in &xs[..nx] {
            for &cy in &ys[..ny] {
                let row = (cx * self.count[1] + cy) * self.count[2];
                for &cz in &zs[..nz] {
                    let key = (row + cz) as usize;
                    let [first, last] = [self.start[key], self.start[key + 1]];
                    // Cells that follow each other are one run.
                    if number > 0 && runs[number - 1][1] == first {
                        runs[number - 1][1] = last;
                    } else {
                        runs[number] = [first, last];
                        number += 1;
                    }
                }
            }
        }
        (runs, number)
    }

    /// Which of a run of candidates are near: their places, and how many they are.
    #[inline(always)]
    fn sieve(&self, x: &Vec3, from: usize, to: usize, found: &mut [u32]) -> usize {
        let mut count = 0;
        if self.domain.periodic.contains(&true) {
            for place in from..to {
                found[count] = place as u32;
                count += usize::from(self.apart(x, place as u32).norm_squared() < self.square);
            }
            return count;
        }
        let mut at = from;
        while at < to {
            let mut squared = [0.0; LANES];
            for axis in 0..3 {
                let those = &self.sorted[axis][at..at + LANES];
                for lane in 0..LANES {
                    let apart = x[axis] - those[lane];
                    squared[lane] += apart * apart;
                }
            }
            let mut near = 0_u32;
            for lane in 0..LANES {
                near |= u32::from(squared[lane] < self.square) << lane;
            }
            near &= (1 << LANES.min(to - at)) - 1;
            while near != 0 {
                found[count] = at as u32 + near.trailing_zeros();
                count += 1;
                near &= near - 1;
            }
            at += LANES;
        }
        count
    }

    /// x − x_j of the point at a place [m], the shortest there is.
    #[inline(always)]
    pub(super) fn apart(&self, x: &Vec3, place: u32) -> Vec3 {
        let [xs, ys, zs] = &self.sorted;
        let place = place as usize;
        self.domain
            .shortest(x - Vec3::new(xs[place], ys[place], zs[place]))
    }

    /// Which point stands at a place.
    #[inline(always)]
    pub(super) fn number(&self, place: u32) -> usize {
        self.order[place as usize] as usize
    }
}

/// Work on all that is near a point.
struct Near<'a, F> {
    cells: &'a Cells,
    x: &'a Vec3,
    visit: F,
}

impl<F: FnMut(&[u32])> Wide for Near<'_, F> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        self.cells.bunches(self.x, self.visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn finds_the_same_as_brute_force_with_and_without_wrapping() {
        let mut random = Stream::new(2, "cells");
        let bounds = Aabb {
            min: Vec3::repeat(-1.0),
            max: Vec3::new(1.0, 1.0, -0.35),
        };
        for periodic in [[false; 3], [true, false, true], [true; 3]] {
            let domain = Domain { bounds, periodic };
            let points: Vec<Vec3> = (0..400)
                .map(|_| {
                    let x = random.cube();
                    Vec3::new(x.x, x.y, -0.675 + 0.325 * x.z)
                })
                .collect();
            let radius = 0.3;
            let cells = Cells::new(&points, radius, &domain);
            for x in &points {
                let mut found = Vec::new();
                cells.near(x, |j, x_ij, squared| {
                    assert_eq!(x_ij, domain.shortest(x - points[j]));
                    assert_eq!(squared, x_ij.norm_squared());
                    found.push(j);
                });
                found.sort_unstable();
                let near = |j: &usize| domain.shortest(x - points[*j]).norm() < radius;
                assert_eq!(found, (0..points.len()).filter(near).collect::<Vec<_>>());
            }
        }
    }
}
