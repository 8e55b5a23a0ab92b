//! Triangle meshes: OBJ in and out, inspection, signed distance, inside by columns, surface of a distance field.

mod bits;
mod columns;
mod crossing;
mod crumbs;
mod decimal;
mod distance;
mod edges;
mod extract;
mod holes;
mod inspect;
mod obj_frame;
mod obj_read;
mod obj_write;
mod orient;
mod paint;
mod pieces;
mod repair;
mod shown;
mod survey;
mod tube;
mod weld;
mod winding;

pub use columns::{Lattice, inside_columns};
pub use crumbs::{Crumbs, without_crumbs};
pub(crate) use decimal::{put_digits, put_number};
pub use distance::{MeshDistance, Nearby};
pub(crate) use distance::{closest_on_triangle, square_to_box};
pub use extract::{surface_nets, surface_nets_of};
pub use inspect::{Inspection, inspect};
pub use obj_frame::{LengthUnit, UpAxis};
pub use obj_read::{ObjError, parse_obj, read_obj};
pub use obj_write::{ObjStyle, write_obj, write_obj_with};
pub use paint::Painted;
pub use repair::{MeshNote, OpenMesh, repaired};
pub use survey::{Fault, Survey, painted_faults, survey};
pub use tube::tube;
pub use weld::welded;
pub use winding::Winding;

use crate::math::{Aabb, Real, Vec3};
use nalgebra::{Isometry3, Point3};

/// Triangles over shared vertices, counter-clockwise seen from outside; metres, z up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions [m].
    pub positions: Vec<Vec3>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The corners of triangle `t` [m].
    #[inline]
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// The smallest box around all vertices.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(&self.positions)
    }

    /// Enclosed volume, negative if the triangles face inwards [m³].
    pub fn signed_volume(&self) -> Real {
        let pivot = self.pivot();
        self.tetrahedra(&pivot).map(|(volume, _)| volume).sum()
    }

    /// Centre of the enclosed volume [m].
    pub fn centroid(&self) -> Vec3 {
        let pivot = self.pivot();
        let (volume, moment) = self
            .tetrahedra(&pivot)
            .fold((0.0, Vec3::zeros()), |(v, m), (volume, centre)| {
                (v + volume, m + centre * volume)
            });
        pivot + moment / volume
    }

    /// Total area of the triangles [m²].
    pub fn area(&self) -> Real {
        (0..self.triangles.len())
            .map(|t| 0.5 * self.area_normal(t).norm())
            .sum()
    }

    /// The mesh in another place.
    #[must_use]
    pub fn transformed(&self, motion: &Isometry3<Real>) -> Self {
        Self {
            positions: self
                .positions
                .iter()
                .map(|p| motion.transform_point(&Point3::from(*p)).coords)
                .collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Adds the triangles of `other`.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        let moved = other.triangles.iter().map(|t| t.map(|v| first + v));
        self.triangles.extend(moved);
    }

    /// The mesh turned inside out.
    #[must_use]
    pub fn flipped(mut self) -> Self {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }

    /// Unit normals of the vertices, weighted by area.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let normal = self.area_normal(t);
            for v in triangle {
                normals[*v as usize] += normal;
            }
        }
        for normal in &mut normals {
            *normal = normal.try_normalize(0.0).unwrap_or(Vec3::z());
        }
        normals
    }

    /// Twice the area of a triangle, along its normal [m²].
    fn area_normal(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a))
    }

    /// A point near the mesh: volumes measured from it lose no digits when the mesh is far from the origin.
    fn pivot(&self) -> Vec3 {
        if self.positions.is_empty() {
            Vec3::zeros()
        } else {
            self.bounds().centre()
        }
    }

    /// Signed volume and centre (relative to `pivot`) of the tetrahedron between each triangle and `pivot`.
    fn tetrahedra<'a>(&'a self, pivot: &'a Vec3) -> impl Iterator<Item = (Real, Vec3)> + 'a {
        (0..self.triangles.len()).map(move |t| {
            let [a, b, c] = self.corners(t).map(|corner| corner - pivot);
            (a.dot(&b.cross(&c)) / 6.0, (a + b + c) / 4.0)
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// An axis-aligned box of 12 triangles.
    pub(crate) fn cuboid(min: Vec3, max: Vec3) -> TriMesh {
        let positions = (0..8)
            .map(|c| {
                Vec3::new(
                    if c & 1 == 0 { min.x } else { max.x },
                    if c & 2 == 0 { min.y } else { max.y },
                    if c & 4 == 0 { min.z } else { max.z },
                )
            })
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .collect();
        TriMesh {
            positions,
            triangles,
        }
    }

    /// A real bone from the folder `OSTEOFLOW_SHARED`, closed; `None`, said aloud, when that is not set.
    pub(crate) fn shared(name: &str, unit: LengthUnit) -> Option<TriMesh> {
        let Some(folder) = std::env::var_os("OSTEOFLOW_SHARED") else {
            eprintln!("skipped: OSTEOFLOW_SHARED is not set, so there is no {name}");
            return None;
        };
        let path = std::path::Path::new(&folder).join("bones").join(name);
        let mesh = read_obj(&path, unit, UpAxis::Z).unwrap();
        Some(repaired(mesh).unwrap().0)
    }

    /// A torus around z with `n` × `m` quads.
    pub(crate) fn torus(ring: Real, tube: Real, n: u32, m: u32) -> TriMesh {
        let turn = 2.0 * core::f64::consts::PI;
        let mut mesh = TriMesh::default();
        for i in 0..n {
            let u = turn * Real::from(i) / Real::from(n);
            for j in 0..m {
                let v = turn * Real::from(j) / Real::from(m);
                let r = ring + tube * libm::cos(v);
                mesh.positions.push(Vec3::new(
                    r * libm::cos(u),
                    r * libm::sin(u),
                    tube * libm::sin(v),
                ));
                let id = |a: u32, b: u32| (a % n) * m + b % m;
                let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    #[test]
    fn volume_centroid_and_area_of_a_box_far_from_the_origin() {
        let min = Vec3::new(1000.0, -2000.0, 500.0);
        let mesh = cuboid(min, min + Vec3::new(1.0, 2.0, 3.0));
        assert!((mesh.signed_volume() - 6.0).abs() < 1e-9);
        assert!((mesh.flipped().signed_volume() + 6.0).abs() < 1e-9);
        let mesh = cuboid(min, min + Vec3::new(1.0, 2.0, 3.0));
        assert!((mesh.centroid() - min - Vec3::new(0.5, 1.0, 1.5)).norm() < 1e-9);
        assert!((mesh.area() - 22.0).abs() < 1e-9);
    }

    #[test]
    fn torus_approaches_its_closed_form() {
        let mesh = torus(2.0, 0.5, 400, 200);
        let exact = 2.0 * core::f64::consts::PI.powi(2) * 2.0 * 0.25;
        assert!((mesh.signed_volume() / exact - 1.0).abs() < 5e-4);
        assert!(mesh.centroid().norm() < 1e-9);
    }
}
