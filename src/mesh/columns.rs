//! Which nodes of a lattice lie inside a closed mesh, by signed crossings along columns.
//!
//! Every triangle that a column (a line along z) passes through adds ±1 above its height: +1 where it faces down, −1
//! where it faces up. A half-open rule gives a column that hits an edge or a vertex to exactly one of the triangles
//! there, so the sum is the winding number for any closed mesh. Where a column does not come back to 0, the mesh has a
//! hole: then columns along all three axes vote.

use super::TriMesh;
use crate::math::{Real, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Nodes `origin + step · (i, j, k)`, 0 ≤ i < count, z running fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Position of the first node [m].
    pub origin: Vec3,
    /// Distance between nodes [m].
    pub step: Real,
    /// Nodes along each axis.
    pub count: [usize; 3],
}

impl Lattice {
    /// Nodes in the middle of the cells of edge `step` that cover the box from `min` to `max`.
    pub fn cells(bounds: &crate::math::Aabb, step: Real) -> Self {
        Self {
            origin: bounds.min.add_scalar(0.5 * step),
            step,
            count: std::array::from_fn(|axis| {
                (bounds.extent()[axis] / step).ceil().max(1.0) as usize
            }),
        }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.count.iter().product()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of node `index` [m].
    pub fn position(&self, index: usize) -> Vec3 {
        let z = index % self.count[2];
        let xy = index / self.count[2];
        self.at([xy / self.count[1], xy % self.count[1], z])
    }

    /// Position of the node at a place [m].
    pub fn at(&self, place: [usize; 3]) -> Vec3 {
        self.origin + Vec3::from(place.map(|n| n as Real)) * self.step
    }
}

/// For each node of `lattice`, whether it is inside `mesh`, whose triangles face outwards.
pub fn inside_columns(mesh: &TriMesh, lattice: &Lattice) -> Vec<bool> {
    let (along_z, whole) = along_columns(mesh, lattice);
    if whole {
        return along_z;
    }
    // Turned so that x, then y, takes the place of z.
    let turned = |shift: usize| {
        let turn = |p: &Vec3| Vec3::from_fn(|axis, _| p[(axis + shift) % 3]);
        let mesh = TriMesh {
            positions: mesh.positions.iter().map(turn).collect(),
            triangles: mesh.triangles.clone(),
        };
        let lattice = Lattice {
            origin: turn(&lattice.origin),
            step: lattice.step,
            count: std::array::from_fn(|axis| lattice.count[(axis + shift) % 3]),
        };
        (along_columns(&mesh, &lattice).0, lattice.count)
    };
    let votes = [turned(1), turned(2)];
    let [_, ny, nz] = lattice.count;
    along_z
        .par_iter()
        .enumerate()
        .map(|(index, &inside)| {
            let node = [index / (ny * nz), index / nz % ny, index % nz];
            let mut sum = u8::from(inside);
            for (shift, (inside, count)) in votes.iter().enumerate() {
                let [i, j, k] = std::array::from_fn(|axis| node[(axis + shift + 1) % 3]);
                sum += u8::from(inside[(i * count[1] + j) * count[2] + k]);
            }
            sum >= 2
        })
        .collect()
}

/// Inside by columns along z, and whether every column came back to winding number 0.
fn along_columns(mesh: &TriMesh, lattice: &Lattice) -> (Vec<bool>, bool) {
    let [nx, ny, nz] = lattice.count;
    let mut inside = vec![false; lattice.len()];
    if inside.is_empty() {
        return (inside, true);
    }
    let whole = AtomicBool::new(true);
    // Triangles by the rows of columns (fixed x) that they reach.
    let mut in_row: Vec<Vec<u32>> = vec![Vec::new(); nx];
    let reach = |low: Real, high: Real, axis: usize, count: usize| {
        let node = |x: Real| (x - lattice.origin[axis]) / lattice.step;
        let first = (node(low).floor() - 1.0).max(0.0) as usize;
        let last = (node(high).ceil() + 1.0).clamp(-1.0, count as Real - 1.0);
        first..(last + 1.0) as usize
    };
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let x = triangle.map(|v| mesh.positions[v as usize].x);
        let (low, high) = (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]));
        for row in reach(low, high, 0, nx) {
            in_row[row].push(t as u32);
        }
    }
    inside
        .par_chunks_mut(ny * nz)
        .zip(&in_row)
        .enumerate()
        .for_each(|(i, (nodes, triangles))| {
            let x = lattice.origin.x + lattice.step * i as Real;
            let mut crossings: Vec<Vec<(Real, i32)>> = vec![Vec::new(); ny];
            for &t in triangles {
                let corners = mesh.corners(t as usize);
                let y = corners.map(|c| c.y);
                let (low, high) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
                for j in reach(low, high, 1, ny) {
                    let column_y = lattice.origin.y + lattice.step * j as Real;
                    crossings[j].extend(crossing(x, column_y, &corners));
                }
            }
            for (j, crossings) in crossings.iter_mut().enumerate() {
                if crossings.iter().map(|crossing| crossing.1).sum::<i32>() != 0 {
                    whole.store(false, Ordering::Relaxed);
                }
                crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let mut winding = 0;
                let mut passed = 0;
                for k in 0..nz {
                    let z = lattice.origin.z + lattice.step * k as Real;
                    while passed < crossings.len() && crossings[passed].0 <= z {
                        winding += crossings[passed].1;
                        passed += 1;
                    }
                    nodes[j * nz + k] = winding > 0;
                }
            }
        });
    (inside, whole.into_inner())
}

/// Height at which the column (x, y) passes through a triangle, and the change of the winding number there.
///
/// An edge counts for a column in lower ≤ y < upper, and is always evaluated from its lower to its upper end, so
/// that both triangles at an edge see the same bits.
fn crossing(x: Real, y: Real, corners: &[Vec3; 3]) -> Option<(Real, i32)> {
    let mut winding = 0;
    for k in 0..3 {
        let (a, b) = (&corners[k], &corners[(k + 1) % 3]);
        let (low, high, direction) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
        if low.y <= y && y < high.y {
            let across = (high.x - low.x) * (y - low.y) - (x - low.x) * (high.y - low.y);
            if across > 0.0 {
                winding += direction;
            }
        }
    }
    if winding == 0 {
        return None;
    }
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    // The edges say that the column crosses; a triangle too steep for a stable height answers with its middle.
    let height = a.z - ((x - a.x) * normal.x + (y - a.y) * normal.y) / normal.z;
    let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    let height = if height.is_finite() {
        height.clamp(low, high)
    } else {
        0.5 * (low + high)
    };
    // Counter-clockwise seen from above: the triangle faces up, and the inside ends there.
    Some((height, -winding))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::mesh::tests::{cuboid, shared, torus};

    #[test]
    fn columns_through_vertices_and_edges_count_once() {
        // Nodes on the corners, edges and diagonals of the box: half-open counting gives 4³ of 5³.
        let mesh = cuboid(Vec3::zeros(), Vec3::repeat(4.0));
        let lattice = Lattice {
            origin: Vec3::repeat(-1.0),
            step: 1.0,
            count: [7; 3],
        };
        let inside = inside_columns(&mesh, &lattice);
        assert_eq!(inside.iter().filter(|&&i| i).count(), 64);
        for (index, &inside) in inside.iter().enumerate() {
            let p = lattice.position(index);
            if p.min() > 0.5 && p.max() < 3.5 {
                assert!(inside);
            }
            if p.min() < -0.5 || p.max() > 4.5 {
                assert!(!inside);
            }
        }
    }

    #[test]
    fn torus_volume_by_columns_on_any_number_of_threads() {
        let mesh = torus(2.0, 0.5, 100, 60);
        let lattice = Lattice::cells(&Aabb::around(&mesh.positions).grown(0.1), 0.0213);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| inside_columns(&mesh, &lattice))
        };
        let inside = on(1);
        assert_eq!(inside, on(2));
        let distance = crate::mesh::MeshDistance::new(&mesh);
        for index in (0..inside.len()).step_by(17) {
            let d = distance.signed(&lattice.position(index));
            assert!(inside[index] == (d < 0.0) || d.abs() < 1e-9);
        }
        let volume = inside.iter().filter(|&&i| i).count() as Real * lattice.step.powi(3);
        let error = volume / mesh.signed_volume() - 1.0;
        assert!(error.abs() < 1e-3, "{error}");
    }

    #[test]
    fn volume_of_a_real_vertebra() {
        let Some(mesh) = shared("vhm_L3_m.obj", crate::mesh::LengthUnit::Metre) else {
            return;
        };
        let lattice = Lattice::cells(&mesh.bounds(), 0.5e-3);
        let inside = inside_columns(&mesh, &lattice);
        let volume = inside.iter().filter(|&&i| i).count() as Real * lattice.step.powi(3);
        assert!((volume / 8.06e-5 - 1.0).abs() < 5e-3, "{volume}");
    }
}
