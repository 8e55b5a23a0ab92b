//! Closed, oriented, manifold surface of a distance field that is given as a function (surface nets).
//!
//! Each lattice cell that the surface passes through gets one vertex; each lattice edge that the surface cuts gets
//! a quad between the four cells around it. That is a manifold exactly when no cell holds two separate pieces of
//! surface, so such cells are filled first: the inside then is well composed [Latecki95].

use super::{Lattice, TriMesh};
use crate::math::{Aabb, Real, Vec3};
use rayon::prelude::*;

/// The surface `distance` = 0 (negative inside) on a lattice of edge `step` [m] over `bounds`; what would leave
/// `bounds` is closed there. Vertices are moved onto the surface.
pub fn surface_nets(bounds: &Aabb, step: Real, distance: impl Fn(&Vec3) -> Real + Sync) -> TriMesh {
    let lattice = Lattice {
        // Off the round numbers, where symmetric shapes would put nodes exactly on the surface.
        origin: bounds.min.add_scalar(-1.013 * step),
        step,
        count: std::array::from_fn(|axis| (bounds.extent()[axis] / step).ceil() as usize + 3),
    };
    let mut values: Vec<Real> = (0..lattice.len())
        .into_par_iter()
        .map(|index| distance(&lattice.position(index)))
        .collect();
    let nodes = Nodes(lattice.count);
    for index in 0..values.len() {
        if nodes.on_rim(index) {
            values[index] = values[index].max(0.01 * step);
        }
    }
    fill_critical_cells(&nodes, &mut values, step);
    let mut mesh = net(&lattice, &nodes, &values);
    settle(&mut mesh, step, distance);
    mesh
}

/// Index arithmetic of a lattice.
struct Nodes([usize; 3]);

impl Nodes {
    fn stride(&self, axis: usize) -> usize {
        [self.0[1] * self.0[2], self.0[2], 1][axis]
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let xy = index / self.0[2];
        [xy / self.0[1], xy % self.0[1], index % self.0[2]]
    }

    fn on_rim(&self, index: usize) -> bool {
        let place = self.place(index);
        (0..3).any(|axis| place[axis] == 0 || place[axis] + 1 == self.0[axis])
    }

    /// The eight nodes of the cell above `index`; bit 0 of the corner is x, bit 1 y, bit 2 z.
    fn corners(&self, index: usize) -> [usize; 8] {
        std::array::from_fn(|c| {
            index + (0..3).map(|a| (c >> a & 1) * self.stride(a)).sum::<usize>()
        })
    }

    fn is_cell(&self, index: usize) -> bool {
        let place = self.place(index);
        (0..3).all(|axis| place[axis] + 1 < self.0[axis])
    }
}

/// Makes a node inside wherever a face of a cell is a checkerboard, or only two opposite corners of a cell differ
/// from the rest. The inside only grows, so this ends.
fn fill_critical_cells(nodes: &Nodes, values: &mut [Real], step: Real) {
    loop {
        let mut filled = false;
        for index in 0..values.len() {
            if !nodes.is_cell(index) {
                continue;
            }
            let corners = nodes.corners(index);
            let inside = |c: usize, values: &[Real]| values[corners[c]] < 0.0;
            let code = (0..8).fold(0_u8, |code, c| code | u8::from(inside(c, values)) << c);
            if let Some(corner) = critical_corner(code) {
                // The rim stays outside; a critical cell there has another outside corner off the rim.
                let candidates = (0..8).map(|s| (corner + s) % 8);
                let outside = candidates
                    .filter(|&c| code >> c & 1 == 0 && !nodes.on_rim(corners[c]))
                    .map(|c| corners[c])
                    .next();
                if let Some(node) = outside {
                    values[node] = -0.01 * step;
                    filled = true;
                }
            }
        }
        if !filled {
            return;
        }
    }
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

fn net(lattice: &Lattice, nodes: &Nodes, values: &[Real]) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut vertex_of_cell = vec![u32::MAX; values.len()];
    for index in 0..values.len() {
        if !nodes.is_cell(index) {
            continue;
        }
        let corners = nodes.corners(index);
        let mut sum = Vec3::zeros();
        let mut count = 0.0;
        for c in 0..8 {
            for axis in 0..3 {
                let (a, b) = (corners[c], corners[c | 1 << axis]);
                if c >> axis & 1 == 0 && (values[a] < 0.0) != (values[b] < 0.0) {
                    let t = values[a] / (values[a] - values[b]);
                    sum += lattice.position(a).lerp(&lattice.position(b), t);
                    count += 1.0;
                }
            }
        }
        if count > 0.0 {
            vertex_of_cell[index] = mesh.positions.len() as u32;
            mesh.positions.push(sum / count);
        }
    }
    for index in 0..values.len() {
        let place = nodes.place(index);
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            if place[axis] + 1 >= nodes.0[axis] || place[u] == 0 || place[v] == 0 {
                continue;
            }
            let (a, b) = (
                values[index] < 0.0,
                values[index + nodes.stride(axis)] < 0.0,
            );
            if a == b {
                continue;
            }
            let (du, dv) = (nodes.stride(u), nodes.stride(v));
            let mut quad =
                [index - du - dv, index - dv, index, index - du].map(|cell| vertex_of_cell[cell]);
            if b {
                quad.reverse();
            }
            mesh.triangles.extend(split(&mesh.positions, quad));
        }
    }
    mesh
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
fn settle(mesh: &mut TriMesh, step: Real, distance: impl Fn(&Vec3) -> Real + Sync) {
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
                let landed = land(&even, step, &distance);
                start[v] + (landed - start[v]).cap_magnitude(0.5 * step)
            })
            .collect();
        mesh.positions = moved;
    }
}

/// One Newton step along the gradient.
fn land(x: &Vec3, step: Real, distance: &impl Fn(&Vec3) -> Real) -> Vec3 {
    let reach = 0.05 * step;
    let gradient = Vec3::from_fn(|axis, _| {
        let mut offset = Vec3::zeros();
        offset[axis] = reach;
        (distance(&(x + offset)) - distance(&(x - offset))) / (2.0 * reach)
    });
    // A flat gradient says little about where the surface is.
    x - gradient * (distance(x) / gradient.norm_squared().max(0.1))
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
