//! The 256 cases of marching cubes, made from one rule instead of typed in [Lorensen87].
//!
//! On each face of a cube, seen from outside and walked counter-clockwise, every run of inside corners is cut off by
//! a segment from the edge where the walk enters the run to the edge where it leaves. Both cubes at a face see the
//! same runs, so their segments agree: the surface is closed. A cut edge is entered on one of its faces and left on
//! the other, so segments chain into loops, and each cut edge lies on one loop only: around a vertex, the four
//! cubes at its edge form one ring. Loops are cut into triangles by diagonals between edges that share no face: such a
//! diagonal belongs to one cube only, so every edge of the mesh has exactly two triangles. Hence the surface is closed,
//! manifold and oriented for any values at the nodes.

use std::sync::LazyLock;

/// An edge of the cube: its lower corner and its axis. Corner c lies at (c>>2, c>>1 & 1, c & 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub corner: usize,
    pub axis: usize,
}

/// The bit of a corner that tells its place on an axis.
const fn bit(axis: usize) -> usize {
    4 >> axis
}

/// The twelve edges.
pub const EDGES: [Edge; 12] = {
    let mut edges = [Edge { corner: 0, axis: 0 }; 12];
    let (mut count, mut corner) = (0, 0);
    while corner < 8 {
        let mut axis = 0;
        while axis < 3 {
            if corner & bit(axis) == 0 {
                edges[count] = Edge { corner, axis };
                count += 1;
            }
            axis += 1;
        }
        corner += 1;
    }
    edges
};

/// Triangles (as numbers of edges) for each set of inside corners, counter-clockwise seen from outside.
pub static CASES: LazyLock<Vec<Vec<[u8; 3]>>> = LazyLock::new(|| {
    (0..256)
        .map(|inside| {
            loops(inside)
                .iter()
                .flat_map(|ring| {
                    triangulate(ring).expect("each loop has a triangulation without face diagonals")
                })
                .collect()
        })
        .collect()
});

fn edge_between(a: usize, b: usize) -> u8 {
    let axis = (0..3).find(|&axis| a ^ b == bit(axis));
    EDGES
        .iter()
        .position(|e| e.corner == a & b && Some(e.axis) == axis)
        .expect("neighbours on a face share an edge") as u8
}

/// The loops of cut edges around one set of inside corners.
fn loops(inside: usize) -> Vec<Vec<u8>> {
    let mut next = [None; 12];
    for axis in 0..3 {
        // Counter-clockwise about +axis; the face on the low side is seen from the other direction.
        let (u, v) = (bit((axis + 1) % 3), bit((axis + 2) % 3));
        for face in [
            [bit(axis), bit(axis) | u, bit(axis) | u | v, bit(axis) | v],
            [0, v, u | v, u],
        ] {
            let is_inside = |k: usize| inside >> face[k % 4] & 1 == 1;
            for k in 0..4 {
                if !is_inside(k) && is_inside(k + 1) {
                    let last = (k + 1..k + 4)
                        .find(|&l| !is_inside(l + 1))
                        .expect("corner k is outside");
                    let entered = edge_between(face[k], face[(k + 1) % 4]);
                    let left = edge_between(face[last % 4], face[(last + 1) % 4]);
                    next[entered as usize] = Some(left);
                }
            }
        }
    }
    let mut rings = Vec::new();
    for start in 0..12 {
        let mut ring = Vec::new();
        let mut edge = start;
        while let Some(following) = next[edge].take() {
            ring.push(edge as u8);
            edge = following as usize;
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    rings
}

/// Whether two edges lie on one face: some side of an axis holds both.
fn share_a_face(a: u8, b: u8) -> bool {
    let (a, b) = (EDGES[a as usize], EDGES[b as usize]);
    (0..3).any(|axis| {
        a.axis != axis && b.axis != axis && a.corner & bit(axis) == b.corner & bit(axis)
    })
}

/// Triangles of a ring whose diagonals lie on no face; `None` if there are none.
fn triangulate(ring: &[u8]) -> Option<Vec<[u8; 3]>> {
    let last = ring.len() - 1;
    if last < 2 {
        return Some(Vec::new());
    }
    let allowed = |i: usize, j: usize| j - i == 1 || !share_a_face(ring[i], ring[j]);
    (1..last)
        .filter(|&apex| allowed(0, apex) && allowed(apex, last))
        .find_map(|apex| {
            let mut triangles = triangulate(&ring[..=apex])?;
            triangles.push([ring[0], ring[apex], ring[last]]);
            triangles.extend(triangulate(&ring[apex..])?);
            Some(triangles)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_cut_edge_lies_on_one_loop_and_every_loop_has_triangles() {
        for inside in 0..256_usize {
            let rings = loops(inside);
            let mut edges: Vec<u8> = rings.concat();
            edges.sort_unstable();
            let cut: Vec<u8> = (0..12)
                .filter(|&e| {
                    let Edge { corner, axis } = EDGES[e as usize];
                    inside >> corner & 1 != inside >> (corner | bit(axis)) & 1
                })
                .collect();
            assert_eq!(edges, cut);
            let triangles: usize = rings.iter().map(|r| r.len() - 2).sum();
            assert_eq!(CASES[inside].len(), triangles);
        }
    }

    #[test]
    fn diagonals_stay_inside_the_cube_and_segments_match_across_each_face() {
        // Directed boundary segments on the faces of two stacked cubes must cancel, for every pair that agrees there.
        for inside in 0..256_usize {
            let mut balance = BTreeMap::new();
            for t in &CASES[inside] {
                for k in 0..3 {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    *balance.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
                }
            }
            for ((a, b), count) in balance {
                assert_eq!(count != 0, share_a_face(a, b), "case {inside}");
                assert!(count == 0 || i32::abs(count) == 1);
            }
        }
    }

    #[test]
    fn one_inside_corner_is_seen_from_the_other_seven() {
        let middle = |e: u8| {
            let Edge { corner, axis } = EDGES[e as usize];
            let mut p = [corner >> 2, corner >> 1 & 1, corner & 1].map(|c| c as f64);
            p[axis] += 0.5;
            crate::math::Vec3::from(p)
        };
        for corner in 0..8 {
            let [t] = CASES[1 << corner][..] else {
                panic!("one triangle")
            };
            let [a, b, c] = t.map(middle);
            let centre = crate::math::Vec3::repeat(0.5);
            assert!((b - a).cross(&(c - a)).dot(&(centre - a)) > 0.0);
        }
    }
}
