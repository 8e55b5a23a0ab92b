//! Closed, oriented, manifold surface of a distance field that is given as a function (surface nets).
//!
//! Each lattice cell that the surface passes through gets one vertex; each lattice edge that the surface cuts gets
//! a quad between the four cells around it. That is a manifold exactly when no cell holds two separate pieces of
//! surface, so such cells are filled first: the inside then is well composed [Latecki95].
//!
//! Of a node that the surface does not pass only its side is kept, as one bit; numbers are kept near the surface.

use super::bits::{BitRows, bits_of};
use super::{Lattice, TriMesh};
use crate::math::{Aabb, Real, Vec3};
use rayon::prelude::*;

/// The surface `distance` = 0 (negative inside) on a lattice of edge `step` [m] over `bounds`; what would leave
/// `bounds` is closed there. Vertices are moved onto the surface.
pub fn surface_nets(bounds: &Aabb, step: Real, distance: impl Fn(&Vec3) -> Real + Sync) -> TriMesh {
    let reach = 0.05 * step;
    let gradient = |x: &Vec3| {
        let along = |axis: usize| {
            let mut offset = Vec3::zeros();
            offset[axis] = reach;
            (distance(&(x + offset)) - distance(&(x - offset))) / (2.0 * reach)
        };
        (distance(x), Vec3::from_fn(|axis, _| along(axis)))
    };
    nets(bounds, step, |_, _| &distance, gradient, |_| 0)
}

/// The same of a field that changes along an axis by no more than the way is long. `along` gives its value on the way
/// from one point to another, and `sample` the gradient beside it.
pub fn surface_nets_of<V: Fn(&Vec3) -> Real>(
    bounds: &Aabb,
    step: Real,
    along: impl Fn(&Vec3, &Vec3) -> V + Sync,
    sample: impl Fn(&Vec3) -> (Real, Vec3) + Sync,
) -> TriMesh {
    // A little less than that: a shell may change its thickness.
    let alike = |value: Real| (0.8 * value.abs() / step) as usize;
    nets(bounds, step, along, sample, alike)
}

/// With `along` the value on the way from one point to another, `sample` the value and the gradient, and `alike` how
/// many nodes further a value keeps its sign.
fn nets<V: Fn(&Vec3) -> Real>(
    bounds: &Aabb,
    step: Real,
    along: impl Fn(&Vec3, &Vec3) -> V + Sync,
    sample: impl Fn(&Vec3) -> (Real, Vec3) + Sync,
    alike: impl Fn(Real) -> usize + Sync,
) -> TriMesh {
    let lattice = Lattice {
        // Off the round numbers, where symmetric shapes would put nodes exactly on the surface.
        origin: bounds.min.add_scalar(-1.013 * step),
        step,
        count: std::array::from_fn(|axis| (bounds.extent()[axis] / step).ceil() as usize + 3),
    };
    let on_rim =
        |place: [usize; 3]| (0..3).any(|a| place[a] == 0 || place[a] + 1 == lattice.count[a]);
    let distance_in = |[x, y]: [usize; 2]| {
        let last = lattice.count[2] - 1;
        along(&lattice.at([x, y, 0]), &lattice.at([x, y, last]))
    };
    let mut inside = BitRows::new(lattice.count, |row @ [x, y]| {
        let distance = distance_in(row);
        let (lattice, alike) = (&lattice, &alike);
        move |z| {
            let value = distance(&lattice.at([x, y, z]));
            (value < 0.0, alike(value))
        }
    });
    inside.clear_rim();
    while fill_critical_cells(&mut inside, on_rim) {}

    let cells = inside.mixed();
    let near = cells.corners();
    // What was filled is just inside, and what the rim closes just outside.
    let values = near.map_by_row(|row| {
        let distance = distance_in(row);
        let (lattice, inside) = (&lattice, &inside);
        move |place| {
            let told = distance(&lattice.at(place));
            match (inside.get(place), told < 0.0) {
                (true, false) => -0.01 * step,
                (false, true) => 0.01 * step,
                _ => told,
            }
        }
    });
    let value = |place: [usize; 3]| values[near.rank(place)];
    let mut mesh = TriMesh {
        positions: cells.map(|cell| middle(cell, &lattice, &inside, value)),
        ..TriMesh::default()
    };
    mesh.triangles = (0..inside.rows())
        .into_par_iter()
        .map(|row| quads_of_row(near.row(row), &inside, &cells, &mesh.positions))
        .flatten_iter()
        .collect();
    settle(&mut mesh, step, sample);
    mesh
}

/// Corner `c` of the cell above `place`: bit 0 is x, bit 1 y, bit 2 z.
fn corner(place: [usize; 3], c: usize) -> [usize; 3] {
    std::array::from_fn(|axis| place[axis] + (c >> axis & 1))
}

/// Makes a node inside wherever a face of a cell is a checkerboard, or only two opposite corners of a cell differ
/// from the rest; says whether there was one. The inside only grows, so this ends.
fn fill_critical_cells(inside: &mut BitRows, on_rim: impl Fn([usize; 3]) -> bool) -> bool {
    let mut filled = false;
    for row in 0..inside.rows() {
        for word in 0..inside.words() {
            for bit in bits_of(inside.mixed_word(row, word)) {
                let cell = inside.place(row, word * 64 + bit);
                let code = (0..8).fold(0_u8, |code, c| {
                    code | u8::from(inside.get(corner(cell, c))) << c
                });
                let Some(first) = critical_corner(code) else {
                    continue;
                };
                // The rim stays outside; a critical cell there has another outside corner off the rim.
                let mut candidates = (0..8).map(|s| (first + s) % 8);
                let outside = candidates.find(|&c| code >> c & 1 == 0 && !on_rim(corner(cell, c)));
                if let Some(c) = outside {
                    inside.set(corner(cell, c));
                    filled = true;
                }
            }
        }
    }
    filled
}

/// A corner to fill if the cell's surface would not be one piece.
fn critical_corner(code: u8) -> Option<usize> {
    let inside = |c: usize| code >> c & 1 == 1;
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            let face = [side, side | u, side | u | v, side | v];
            let [a, b, c, d] = face.map(inside);
            if a == c && b == d && a != b {
                return Some(if a { face[1] } else { face[0] });
            }
        }
    }
    let alone = if code.count_ones() == 2 { code } else { !code };
    let opposite = (0..4).any(|c| alone == 1 << c | 1 << (7 - c));
    (opposite && alone.count_ones() == 2).then(|| (0..8).find(|&c| !inside(c)).unwrap_or(0))
}

/// The mean of the points where the surface cuts the edges of a cell.
fn middle(
    cell: [usize; 3],
    lattice: &Lattice,
    inside: &BitRows,
    value: impl Fn([usize; 3]) -> Real,
) -> Vec3 {
    let mut sum = Vec3::zeros();
    let mut count = 0.0;
    for c in 0..8 {
        for axis in 0..3 {
            let (a, b) = (corner(cell, c), corner(cell, c | 1 << axis));
            if c >> axis & 1 == 0 && inside.get(a) != inside.get(b) {
                let t = value(a) / (value(a) - value(b));
                sum += lattice.at(a).lerp(&lattice.at(b), t);
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Two triangles for each edge that the surface cuts and that begins at one of `nodes`.
fn quads_of_row(
    nodes: impl Iterator<Item = [usize; 3]>,
    inside: &BitRows,
    cells: &BitRows,
    positions: &[Vec3],
) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    // The rim is outside, so such an edge has cells all round.
    for place in nodes {
        for axis in 0..3 {
            let mut next = place;
            next[axis] += 1;
            if next[axis] == inside.count[axis] || inside.get(place) == inside.get(next) {
                continue;
            }
            let back = |u: usize, v: usize| {
                let mut cell = place;
                cell[(axis + 1) % 3] -= u;
                cell[(axis + 2) % 3] -= v;
                cells.rank(cell) as u32
            };
            let mut quad = [back(1, 1), back(0, 1), back(0, 0), back(1, 0)];
            if inside.get(next) {
                quad.reverse();
            }
            triangles.extend(split(positions, quad));
        }
    }
    triangles
}

/// Cuts a quad along its shorter diagonal.
fn split(positions: &[Vec3], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let length = |p: u32, q: u32| (positions[p as usize] - positions[q as usize]).norm_squared();
    if length(a, c) <= length(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[b, c, d], [b, d, a]]
    }
}

/// Evens the triangles out and puts the vertices on the surface, each within half a cell of where it was.
fn settle(mesh: &mut TriMesh, step: Real, sample: impl Fn(&Vec3) -> (Real, Vec3) + Sync) {
    let start = mesh.positions.clone();
    for _ in 0..4 {
        let mut sum = vec![(Vec3::zeros(), 0.0); start.len()];
        for triangle in &mesh.triangles {
            for k in 0..3 {
                let entry = &mut sum[triangle[k] as usize];
                entry.0 += mesh.positions[triangle[(k + 1) % 3] as usize];
                entry.1 += 1.0;
            }
        }
        let old = &mesh.positions;
        let moved = (0..start.len())
            .into_par_iter()
            .map(|v| {
                let (total, count) = sum[v];
                let even = old[v].lerp(&(total / count), 0.5);
                let landed = land(&even, sample(&even));
                start[v] + (landed - start[v]).cap_magnitude(0.5 * step)
            })
            .collect();
        mesh.positions = moved;
    }
}

/// One Newton step along the gradient.
fn land(x: &Vec3, (value, gradient): (Real, Vec3)) -> Vec3 {
    // A flat gradient says little about where the surface is.
    x - gradient * (value / gradient.norm_squared().max(0.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    #[test]
    fn sphere_is_closed_round_and_of_the_right_volume() {
        let bounds = Aabb {
            min: Vec3::repeat(-1.0),
            max: Vec3::repeat(1.0),
        };
        let mesh = surface_nets(&bounds, 0.1, |x| x.norm() - 0.8);
        assert!(inspect(&mesh).is_closed());
        assert_eq!(inspect(&mesh).components, 1);
        let exact = 4.0 / 3.0 * core::f64::consts::PI * 0.8_f64.powi(3);
        assert!((mesh.signed_volume() / exact - 1.0).abs() < 0.01);
        for p in &mesh.positions {
            assert!((p.norm() - 0.8).abs() < 1e-3);
        }
    }

    #[test]
    fn noise_far_below_the_lattice_still_gives_a_manifold() {
        let bounds = Aabb {
            min: Vec3::repeat(-1.0),
            max: Vec3::repeat(1.0),
        };
        for seed in 0..4 {
            let mesh = surface_nets(&bounds, 0.15, |x| {
                let cell = [x.x, x.y, x.z].map(|c| (c * 1e4).floor() as i64);
                crate::math::hash_unit(seed, cell, 0) - 0.3
            });
            let found = inspect(&mesh);
            assert!(found.is_closed(), "{found:?}");
            assert!(found.triangles > 1000 && found.signed_volume > 0.0);
        }
    }
}
