//! Generalised winding number: how often a triangle soup goes around a point, holes and all.
//!
//! ```text
//! w(x) = Σ Ω_t(x) / 4π,     Ω_t: signed solid angle of triangle t                             [Jacobson13] (Eq. 5)
//! ```
//!
//! 1 inside a closed mesh and 0 outside; through a hole it passes smoothly from one to the other, so that w > ½ is
//! the natural inside of an open mesh. Far groups of triangles act as one dipole [Barill18].

use super::TriMesh;
use crate::math::{Real, Vec3};
use nalgebra::{Isometry3, Point3};
use std::f64::consts::PI;

/// A group is far when it is this many of its radii away: all dipoles together then err by less than 0.05.
const FAR: Real = 3.0;
/// Triangles in a leaf.
const LEAF: usize = 8;

/// A mesh made ready for winding numbers.
pub struct Winding {
    corners: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

struct Node {
    centre: Vec3,
    radius: Real,
    /// Σ area · normal [m²].
    dipole: Vec3,
    /// Triangles of a leaf, or the place of the second child; the first child comes next.
    content: Content,
}

enum Content {
    Leaf(std::ops::Range<usize>),
    Second(usize),
}

impl Winding {
    /// Prepares the triangles of `mesh` that `pick` wants.
    pub fn new(mesh: &TriMesh, pick: impl Fn(usize) -> bool) -> Self {
        let picked = (0..mesh.triangles.len()).filter(|&t| pick(t));
        let mut corners: Vec<[Vec3; 3]> = picked.map(|t| mesh.corners(t)).collect();
        let mut nodes = Vec::with_capacity(2 * corners.len() / LEAF + 1);
        let count = corners.len();
        if count > 0 {
            split(&mut corners, 0..count, &mut nodes);
        }
        Self { corners, nodes }
    }

    /// Of the mesh in another place.
    #[must_use]
    pub fn transformed(mut self, motion: &Isometry3<Real>) -> Self {
        let place = |p: &Vec3| motion.transform_point(&Point3::from(*p)).coords;
        for corner in self.corners.as_flattened_mut() {
            *corner = place(corner);
        }
        for node in &mut self.nodes {
            node.centre = place(&node.centre);
            node.dipole = motion.rotation * node.dipole;
        }
        self
    }

    /// w at `x`.
    pub fn at(&self, x: &Vec3) -> Real {
        let mut sum = 0.0;
        let mut stack = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n];
            let to = node.centre - x;
            let distance = to.norm();
            if distance > FAR * node.radius {
                sum += node.dipole.dot(&to) / (distance * distance * distance);
                continue;
            }
            match &node.content {
                Content::Leaf(range) => {
                    for corners in &self.corners[range.clone()] {
                        sum += solid_angle(x, corners);
                    }
                }
                Content::Second(second) => stack.extend([*second, n + 1]),
            }
        }
        sum / (4.0 * PI)
    }
}

/// Signed solid angle of a triangle [Oosterom83]; 0 seen from a point in its plane.
fn solid_angle(x: &Vec3, corners: &[Vec3; 3]) -> Real {
    let [a, b, c] = corners.map(|corner| corner - x);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let volume = a.dot(&b.cross(&c));
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    if volume == 0.0 {
        0.0
    } else {
        2.0 * libm::atan2(volume, below)
    }
}

fn area_normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)) * 0.5
}

/// Adds the node of `range` and those below it; halves are split at the median of the longest axis.
fn split(corners: &mut [[Vec3; 3]], range: std::ops::Range<usize>, nodes: &mut Vec<Node>) {
    let mine = &mut corners[range.clone()];
    let middle = |t: &[Vec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
    let (mut dipole, mut area, mut moment) = (Vec3::zeros(), 0.0, Vec3::zeros());
    let mut bounds = crate::math::Aabb::empty();
    for triangle in mine.iter() {
        let normal = area_normal(triangle);
        let weight = normal.norm();
        dipole += normal;
        area += weight;
        moment += middle(triangle) * weight;
        bounds.include(&middle(triangle));
    }
    let centre = if area > 0.0 {
        moment / area
    } else {
        bounds.centre()
    };
    let reach = |t: &[Vec3; 3]| t.iter().map(|c| (c - centre).norm()).fold(0.0, Real::max);
    let radius = mine.iter().map(reach).fold(0.0, Real::max);
    let place = nodes.len();
    nodes.push(Node {
        centre,
        radius,
        dipole,
        content: Content::Leaf(range.clone()),
    });
    if mine.len() <= LEAF {
        return;
    }
    let axis = bounds.extent().imax();
    let half = mine.len() / 2;
    mine.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let cut = range.start + half;
    split(corners, range.start..cut, nodes);
    nodes[place].content = Content::Second(nodes.len());
    split(corners, cut..range.end, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::torus;

    #[test]
    fn it_is_one_inside_and_zero_outside_of_a_torus() {
        let mesh = torus(2.0, 0.5, 120, 60);
        let winding = Winding::new(&mesh, |_| true);
        let mut random = crate::math::Stream::new(8, "winding");
        let mut worst: Real = 0.0;
        for _ in 0..3000 {
            let x = random.cube().component_mul(&Vec3::new(3.0, 3.0, 1.0));
            let exact = (x.xy().norm() - 2.0).hypot(x.z) - 0.5;
            if exact.abs() > 5e-3 {
                let w = winding.at(&x);
                worst = worst.max((w - Real::from(u8::from(exact < 0.0))).abs());
            }
        }
        assert!(worst < 0.05, "{worst}");
    }

    /// Seen from the centre of a ball, a hole takes away its share of the sphere.
    #[test]
    fn a_hole_takes_its_solid_angle() {
        let bounds = crate::math::Aabb {
            min: Vec3::repeat(-1.2),
            max: Vec3::repeat(1.2),
        };
        let mut mesh = crate::mesh::surface_nets(&bounds, 0.05, |x| x.norm() - 1.0);
        let positions = mesh.positions.clone();
        mesh.triangles
            .retain(|t| t.iter().any(|v| positions[*v as usize].z < 0.5));
        let w = Winding::new(&mesh, |_| true).at(&Vec3::zeros());
        // A cap above z = ½ is a quarter of the sphere.
        assert!((w - 0.75).abs() < 0.02, "{w}");
    }
}
