//! Exact distance to a mesh, negative inside.
//!
//! The closest point comes from a bounding-volume tree; the sign from the pseudo-normal of the feature (face, edge or
//! vertex) that holds it: normals of the triangles around it, weighted by their angles there. That is the one choice
//! of normal whose sign is right everywhere [Baerentzen05], as long as the mesh is closed and does not cross itself.
//! Where it does, or has a hole, the winding number decides; triangles with inside on both sides, such as those of a
//! shell pushed into another, are no surface and are left out.

use super::edges::Edges;
use super::winding::Winding;
use super::{TriMesh, crossing, shown};
use crate::math::{Real, Vec3};
use nalgebra::{Isometry3, Point3};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};

/// A mesh made ready for distance queries.
pub struct MeshDistance {
    corners: Vec<[Vec3; 3]>,
    /// Pseudo-normals of each triangle: its face, its edges ab, bc, ca, its vertices a, b, c.
    normals: Vec<[Vec3; 7]>,
    /// Bit f of a triangle: the normal of its feature f tells nothing.
    unsure: Vec<u8>,
    /// Place in the mesh of each triangle kept.
    kept: Vec<u32>,
    winding: Option<Winding>,
    tree: Bvh,
}

/// Triangles near a point, ascending by their distance from it.
pub struct Nearby {
    centre: Vec3,
    nearest: Vec<(Real, u32)>,
}

impl Nearby {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.nearest.is_empty()
    }
}

/// Closest point so far: squared distance [m²], triangle, point [m], feature as in `MeshDistance::normals`.
#[derive(Clone, Copy)]
struct Closest {
    square: Real,
    triangle: u32,
    point: Vec3,
    feature: usize,
}

impl Closest {
    const NONE: Self = Self {
        square: Real::INFINITY,
        triangle: u32::MAX,
        point: Vec3::new(0.0, 0.0, 0.0),
        feature: 0,
    };
}

impl MeshDistance {
    /// Prepares `mesh`, whose triangles must face outwards (see [`super::repaired`]) for signs to mean anything.
    pub fn new(mesh: &TriMesh) -> Self {
        let count = mesh.triangles.len();
        let edges = Edges::of(mesh);
        let crossing = crossing::crossing(mesh);
        let (winding, kept) = match shown::shown(mesh, &edges, &crossing) {
            None => (None, (0..count as u32).collect()),
            Some((winding, kept)) => (Some(winding), kept),
        };
        let (mut normals, mut unsure) = features(mesh, &edges, &crossing);
        // In place: of millions of triangles two copies would be a gigabyte more.
        for (place, &t) in kept.iter().enumerate() {
            normals[place] = normals[t as usize];
            unsure[place] = unsure[t as usize];
        }
        normals.truncate(kept.len());
        unsure.truncate(kept.len());
        let corners: Vec<[Vec3; 3]> = kept.iter().map(|&t| mesh.corners(t as usize)).collect();
        Self {
            normals,
            unsure,
            kept,
            winding,
            tree: tree_of(&corners),
            corners,
        }
    }

    /// Of the mesh in another place: what was found out about it stays.
    #[must_use]
    pub fn transformed(mut self, motion: &Isometry3<Real>) -> Self {
        for corner in self.corners.as_flattened_mut() {
            *corner = motion.transform_point(&Point3::from(*corner)).coords;
        }
        for normal in self.normals.as_flattened_mut() {
            *normal = motion.rotation * *normal;
        }
        Self {
            winding: self.winding.map(|winding| winding.transformed(motion)),
            tree: tree_of(&self.corners),
            ..self
        }
    }

    /// The triangle of the mesh that is closest to `x`, if there is any.
    pub fn closest_triangle(&self, x: &Vec3) -> Option<usize> {
        let closest = self.find(x);
        let kept = self.kept.get(closest.triangle as usize);
        kept.map(|&t| t as usize)
    }

    /// Distance to the surface [m], negative inside, and the closest point on it.
    pub fn closest(&self, x: &Vec3) -> (Real, Vec3) {
        let closest = self.find(x);
        (self.signed_distance(x, &closest), closest.point)
    }

    fn find(&self, x: &Vec3) -> Closest {
        let found = self.tree.find_best(
            Real::MAX,
            |node: &BvhNode, _| square_to_box(x, node),
            |t, _| {
                let candidate = self.closest_on(x, t);
                Some((candidate.square, candidate))
            },
        );
        found.map_or(Closest::NONE, |(_, (_, closest))| closest)
    }

    /// Distance to the surface [m], negative inside.
    pub fn signed(&self, x: &Vec3) -> Real {
        self.closest(x).0
    }

    /// Triangles within `radius` [m] of `centre`, ascending.
    pub fn within(&self, centre: &Vec3, radius: Real) -> Vec<u32> {
        let square = radius * radius;
        let mut near: Vec<u32> = self
            .tree
            .leaves(|node: &BvhNode| square_to_box(centre, node) <= square)
            .filter(|&t| self.closest_on(centre, t).square <= square)
            .collect();
        near.sort_unstable();
        near
    }

    /// Those of `candidates` that are at most `slack` [m] farther from `centre` than the nearest of them.
    pub fn nearest_within(&self, centre: &Vec3, slack: Real, candidates: &[u32]) -> Nearby {
        let distance = |&t: &u32| (self.closest_on(centre, t).square.sqrt(), t);
        let mut nearest: Vec<(Real, u32)> = candidates.iter().map(distance).collect();
        nearest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let least = nearest.first().map_or(0.0, |(distance, _)| *distance);
        nearest.truncate(nearest.partition_point(|(distance, _)| *distance <= least + slack));
        Nearby {
            centre: *centre,
            nearest,
        }
    }

    /// Signed distance [m] when the closest triangle is known to be among `nearby`: for many points close together.
    pub fn signed_among(&self, x: &Vec3, nearby: &Nearby) -> Real {
        self.closest_among(x, nearby).0
    }

    /// The same, with the closest point.
    pub fn closest_among(&self, x: &Vec3, nearby: &Nearby) -> (Real, Vec3) {
        let mut closest = Closest::NONE;
        let away = (x - nearby.centre).norm();
        let mut reach = Real::INFINITY;
        for &(distance, t) in &nearby.nearest {
            // A hair more than the triangle inequality asks, for rounding.
            if distance > reach {
                break;
            }
            let candidate = self.closest_on(x, t);
            if candidate.square < closest.square {
                closest = candidate;
                reach = (closest.square.sqrt() + away) * (1.0 + 1e-12);
            }
        }
        (self.signed_distance(x, &closest), closest.point)
    }

    fn signed_distance(&self, x: &Vec3, closest: &Closest) -> Real {
        let Some(normals) = self.normals.get(closest.triangle as usize) else {
            return Real::INFINITY;
        };
        let distance = closest.square.sqrt();
        let told = self.unsure[closest.triangle as usize] >> closest.feature & 1 == 0;
        let inside = match &self.winding {
            Some(winding) if !told => winding.at(x) > 0.5,
            _ => (x - closest.point).dot(&normals[closest.feature]) < 0.0,
        };
        if inside { -distance } else { distance }
    }

    fn closest_on(&self, x: &Vec3, triangle: u32) -> Closest {
        let (point, feature) = closest_on_triangle(x, &self.corners[triangle as usize]);
        Closest {
            square: (x - point).norm_squared(),
            triangle,
            point,
            feature,
        }
    }
}

/// Pseudo-normals of all features of each triangle, and which of them tell nothing: where an edge has not its two
/// triangles, or they disagree, or one crosses another.
fn features(mesh: &TriMesh, edges: &Edges, crossing: &[bool]) -> (Vec<[Vec3; 7]>, Vec<u8>) {
    let count = mesh.triangles.len();
    let faces: Vec<Vec3> = (0..count)
        .map(|t| mesh.area_normal(t).try_normalize(0.0).unwrap_or_default())
        .collect();
    let mut at_vertex = vec![Vec3::zeros(); mesh.positions.len()];
    let mut odd_vertex = vec![false; mesh.positions.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|s| triangle[(k + s) % 3]);
            let [pa, pb, pc] = [a, b, c].map(|v| mesh.positions[v as usize]);
            let (u, v) = (pb - pa, pc - pa);
            let angle = libm::atan2(u.cross(&v).norm(), u.dot(&v));
            at_vertex[a as usize] += faces[t] * angle;
            odd_vertex[a as usize] |= crossing[t];
        }
    }
    let mut normals: Vec<[Vec3; 7]> = faces.iter().map(|face| [*face; 7]).collect();
    let mut unsure: Vec<u8> = crossing.iter().map(|c| if *c { 0x7f } else { 0 }).collect();
    for around in edges.iter() {
        let normal: Vec3 = around
            .iter()
            .map(|side| faces[side.triangle as usize])
            .sum();
        let odd = !matches!(around, [a, b] if a.forward != b.forward
            && !crossing[a.triangle as usize] && !crossing[b.triangle as usize]);
        for side in around {
            let t = side.triangle as usize;
            let corners = mesh.triangles[t];
            let from = if side.forward { side.low } else { side.high };
            let feature = 1 + corners.iter().position(|v| *v == from).unwrap_or(0);
            normals[t][feature] = normal;
            if odd {
                unsure[t] |= 1 << feature;
                odd_vertex[side.low as usize] = true;
                odd_vertex[side.high as usize] = true;
            }
        }
    }
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for (k, v) in corners.iter().enumerate() {
            normals[t][4 + k] = at_vertex[*v as usize];
            unsure[t] |= u8::from(odd_vertex[*v as usize]) << (4 + k);
        }
    }
    (normals, unsure)
}

fn tree_of(corners: &[[Vec3; 3]]) -> Bvh {
    let boxes: Vec<_> = corners
        .iter()
        .map(|&[a, b, c]| {
            let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            parry3d_f64::bounding_volume::Aabb::new(low.into(), high.into())
        })
        .collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}

/// Squared distance from a point to the box of a tree node [m²].
pub(crate) fn square_to_box(x: &Vec3, node: &BvhNode) -> Real {
    let (low, high) = (node.mins(), node.maxs());
    let excess = |x: Real, low: Real, high: Real| (low - x).max(x - high).max(0.0);
    let (a, b, c) = (
        excess(x.x, low.x, high.x),
        excess(x.y, low.y, high.y),
        excess(x.z, low.z, high.z),
    );
    a * a + b * b + c * c
}

/// Closest point of a triangle by its Voronoi regions [Ericson05], and which feature holds it.
pub(crate) fn closest_on_triangle(x: &Vec3, &[a, b, c]: &[Vec3; 3]) -> (Vec3, usize) {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (d1, d2) = (ab.dot(&ax), ac.dot(&ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, 4);
    }
    let bx = x - b;
    let (d3, d4) = (ab.dot(&bx), ac.dot(&bx));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, 5);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), 1);
    }
    let cx = x - c;
    let (d5, d6) = (ab.dot(&cx), ac.dot(&cx));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, 6);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), 3);
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        return (b + (c - b) * (along / (along + back)), 2);
    }
    let scale = 1.0 / (va + vb + vc);
    (a + ab * (vb * scale) + ac * (vc * scale), 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::{cuboid, torus};

    #[test]
    fn box_distance_and_sign_are_exact() {
        let (min, max) = (Vec3::new(-1.0, -2.0, -0.5), Vec3::new(1.0, 1.0, 0.5));
        let mesh = cuboid(min, max);
        let distance = MeshDistance::new(&mesh);
        let exact = |x: &Vec3| {
            let excess = (x - (min + max) * 0.5).abs() - (max - min) * 0.5;
            excess.map(|e| e.max(0.0)).norm() + excess.max().min(0.0)
        };
        let all: Vec<u32> = (0..12).collect();
        let nearby = distance.nearest_within(&Vec3::new(0.9, 0.3, 0.2), 20.0, &all);
        let mut random = crate::math::Stream::new(4, "distance");
        for _ in 0..5000 {
            let x = random.cube() * 3.0;
            assert!((distance.signed(&x) - exact(&x)).abs() < 1e-12);
            assert!((distance.signed_among(&x, &nearby) - exact(&x)).abs() < 1e-12);
        }
        assert!(distance.signed(&Vec3::new(2.0, 2.0, 1.5)) > 0.0);
        assert_eq!(distance.within(&Vec3::new(3.0, 0.0, 0.0), 2.04).len(), 2);
    }

    /// A spike between many thin triangles: the sign by plain face normals is wrong around its tip.
    #[test]
    fn sign_is_right_around_a_sharp_tip_and_a_torus() {
        let n = 7_u32;
        let mut cone = TriMesh::default();
        for i in 0..n {
            let angle = 2.0 * core::f64::consts::PI * Real::from(i) / Real::from(n);
            cone.positions
                .push(Vec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 0.1);
            let j = (i + 1) % n;
            cone.triangles.extend([[i, j, n], [j, i, n + 1]]);
        }
        cone.positions
            .extend([Vec3::new(0.3, 0.0, 1.0), Vec3::new(0.0, 0.0, 0.0)]);
        let distance = MeshDistance::new(&cone);
        let mut random = crate::math::Stream::new(5, "cone");
        for _ in 0..5000 {
            let x = Vec3::new(0.3, 0.0, 1.0) + random.cube() * 0.2;
            if x.z > 1.0 {
                assert!(distance.signed(&x) > 0.0);
            }
        }

        let mesh = torus(1.0, 0.4, 200, 100);
        let distance = MeshDistance::new(&mesh);
        for _ in 0..3000 {
            let x = random.cube().component_mul(&Vec3::new(1.6, 1.6, 0.6));
            let exact = (x.xy().norm() - 1.0).hypot(x.z) - 0.4;
            assert!((distance.signed(&x) - exact).abs() < 1.5e-3);
        }
    }

    /// Vertices moved by up to one and a half edges, as smoothing of a fluid's surface may: triangles fold over each other
    /// here and there, also those that share a vertex.
    #[test]
    fn folds_here_and_there_take_nothing_away_from_the_rest() {
        for seed in 0..20 {
            let mut mesh = torus(1.0, 0.4, 60, 30);
            let mut random = crate::math::Stream::new(seed, "folds");
            for x in mesh.positions.iter_mut().step_by(7) {
                *x += random.cube() * 0.15;
            }
            let distance = MeshDistance::new(&mesh);
            for _ in 0..200 {
                let x = random.cube().component_mul(&Vec3::new(1.6, 1.6, 0.6));
                let exact = (x.xy().norm() - 1.0).hypot(x.z) - 0.4;
                let found = distance.signed(&x);
                assert!((found - exact).abs() < 0.27, "{seed}: {found} {exact}");
            }
        }
    }
}
