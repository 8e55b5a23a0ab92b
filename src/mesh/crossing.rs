//! Triangles that pass through others of the same mesh.

use super::TriMesh;
use crate::math::Vec3;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use rayon::prelude::*;

/// For each triangle, whether an edge of it or of another passes through the inside of the other. Triangles that
/// share two vertices, or lie in one plane, are not compared.
pub(super) fn crossing(mesh: &TriMesh) -> Vec<bool> {
    let tree = tree_of(mesh);
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| {
            let mine = mesh.triangles[t];
            let corners = mesh.corners(t);
            let low = corners[0].inf(&corners[1]).inf(&corners[2]);
            let high = corners[0].sup(&corners[1]).sup(&corners[2]);
            let near = |node: &BvhNode| {
                let (from, to) = (node.mins(), node.maxs());
                from.x <= high.x
                    && from.y <= high.y
                    && from.z <= high.z
                    && low.x <= to.x
                    && low.y <= to.y
                    && low.z <= to.z
            };
            tree.leaves(near).any(|other| {
                let theirs = mesh.triangles[other as usize];
                let shared = theirs.iter().filter(|v| mine.contains(v)).count();
                let others = mesh.corners(other as usize);
                match shared {
                    0 => pass_through(&corners, &others),
                    1 => {
                        pierces(&opposite(mine, &corners, theirs), &others)
                            || pierces(&opposite(theirs, &others, mine), &corners)
                    }
                    _ => false,
                }
            })
        })
        .collect()
}

pub(super) fn tree_of(mesh: &TriMesh) -> Bvh {
    let boxes: Vec<_> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            parry3d_f64::bounding_volume::Aabb::new(low.into(), high.into())
        })
        .collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}

fn pass_through(p: &[Vec3; 3], q: &[Vec3; 3]) -> bool {
    let edges = |t: &[Vec3; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(p).iter().any(|edge| pierces(edge, q)) || edges(q).iter().any(|edge| pierces(edge, p))
}

/// The edge of a triangle opposite to the vertex that it shares with another: the two edges at it meet the other one there,
/// and nowhere else.
fn opposite(triangle: [u32; 3], corners: &[Vec3; 3], other: [u32; 3]) -> [Vec3; 2] {
    let shared = triangle.iter().position(|v| other.contains(v)).unwrap_or(0);
    [1, 2].map(|k| corners[(shared + k) % 3])
}

/// Whether a segment passes through the inside of a triangle.
fn pierces([a, b]: &[Vec3; 2], [p, q, r]: &[Vec3; 3]) -> bool {
    let volume = |u: &Vec3, v: &Vec3, w: &Vec3, x: &Vec3| (v - u).cross(&(w - u)).dot(&(x - u));
    if volume(p, q, r, a) * volume(p, q, r, b) >= 0.0 {
        return false;
    }
    let around = [(p, q), (q, r), (r, p)].map(|(u, v)| volume(a, b, u, v));
    around.iter().all(|side| *side > 0.0) || around.iter().all(|side| *side < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::{cuboid, torus};

    #[test]
    fn only_what_crosses_is_found() {
        assert!(!crossing(&torus(2.0, 0.5, 40, 20)).contains(&true));
        let mut two = cuboid(Vec3::zeros(), Vec3::repeat(1.0));
        let small = cuboid(Vec3::new(0.37, 0.2, 0.41), Vec3::new(0.6, 0.5, 1.4));
        two.append(&small);
        let found = crossing(&two);
        let crossed: Vec<usize> = (0..24).filter(|t| found[*t]).collect();
        // The lid of the large box, and the eight triangles of the small one's sides.
        assert!(crossed.len() >= 9 && crossed.iter().any(|t| *t < 12));
        for t in crossed {
            let [low, high] = [Vec3::inf, Vec3::sup].map(|pick| {
                two.corners(t)
                    .iter()
                    .fold(two.corners(t)[0], |m, c| pick(&m, c))
            });
            assert!(low.z <= 1.0 && high.z >= 1.0);
        }
    }
}
