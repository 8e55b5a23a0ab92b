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
    #[inline]
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
/// Candidates of which one call finds those that are near.
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

    fn coordinate(&self, x: &Vec3, axis: usize) -> i64 {
        ((x[axis] - self.origin[axis]) / self.width[axis]).floor() as i64
    }

    fn key(&self, x: &Vec3) -> usize {
        let c: [i64; 3] =
            std::array::from_fn(|a| self.coordinate(x, a).clamp(0, self.count[a] - 1));
        ((c[0] * self.count[1] + c[1]) * self.count[2] + c[2]) as usize
    }

    /// Cell indices along one axis that lie within one cell of `x`, each once.
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
        let reach: [_; 3] = std::array::from_fn(|axis| self.reach(x, axis));
        let cells = |axis: usize| &reach[axis].0[..reach[axis].1];
        for &cx in cells(0) {
            for &cy in cells(1) {
                let row = (cx * self.count[1] + cy) * self.count[2];
                if self.domain.periodic.contains(&true) {
                    for &cz in cells(2) {
                        let key = (row + cz) as usize;
                        for place in self.start[key] as usize..self.start[key + 1] as usize {
                            let x_ij = self.domain.shortest(x - self.point(place));
                            let squared = x_ij.norm_squared();
                            if squared < self.square {
                                visit(self.order[place] as usize, x_ij, squared);
                            }
                        }
                    }
                } else if let (Some(first), Some(last)) = (cells(2).first(), cells(2).last()) {
                    // Cells that follow each other along z are one run of points.
                    let mut from = self.start[(row + first) as usize] as usize;
                    let end = self.start[(row + last) as usize + 1] as usize;
                    while from < end {
                        let to = end.min(from + CANDIDATES);
                        let mut found = [0; CANDIDATES];
                        let count = widest(Sieve {
                            cells: self,
                            x,
                            from,
                            to,
                            found: &mut found,
                        });
                        for &place in &found[..count] {
                            let place = place as usize;
                            let x_ij = x - self.point(place);
                            visit(self.order[place] as usize, x_ij, x_ij.norm_squared());
                        }
                        from = to;
                    }
                }
            }
        }
    }

    #[inline]
    fn point(&self, place: usize) -> Vec3 {
        let [x, y, z] = &self.sorted;
        Vec3::new(x[place], y[place], z[place])
    }
}

/// Finds which of a run of candidates are near.
struct Sieve<'a> {
    cells: &'a Cells,
    x: &'a Vec3,
    from: usize,
    to: usize,
    found: &'a mut [u32; CANDIDATES],
}

impl Wide for Sieve<'_> {
    /// How many it found.
    type Out = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let mut count = 0;
        let mut at = self.from;
        while at < self.to {
            let mut squared = [0.0; LANES];
            for axis in 0..3 {
                let those = &self.cells.sorted[axis][at..at + LANES];
                for lane in 0..LANES {
                    let apart = self.x[axis] - those[lane];
                    squared[lane] += apart * apart;
                }
            }
            for lane in 0..LANES.min(self.to - at) {
                self.found[count] = (at + lane) as u32;
                count += usize::from(squared[lane] < self.cells.square);
            }
            at += LANES;
        }
        count
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
