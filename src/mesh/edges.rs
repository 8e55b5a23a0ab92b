//! Edges of a mesh and the triangles around them.

use super::TriMesh;
use rayon::prelude::*;

/// A triangle's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The lower vertex of the edge.
    pub low: u32,
    /// The higher vertex.
    pub high: u32,
    /// Whether the triangle runs from low to high.
    pub forward: bool,
    /// Which triangle.
    pub triangle: u32,
}

/// All sides, sorted: those of one edge stand together.
pub(super) struct Edges(Vec<Side>);

impl Edges {
    pub fn of(mesh: &TriMesh) -> Self {
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                sides.push(Side {
                    low: a.min(b),
                    high: a.max(b),
                    forward: a < b,
                    triangle: t as u32,
                });
            }
        }
        sides.par_sort_unstable();
        Self(sides)
    }

    /// The sides at each edge.
    pub fn iter(&self) -> impl Iterator<Item = &[Side]> {
        self.0.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
    }

    /// Across each side of each triangle: the only other triangle there, and whether the two disagree.
    pub fn neighbours(&self, count: usize) -> Vec<Vec<(u32, bool)>> {
        let mut neighbours = vec![Vec::new(); count];
        for around in self.iter() {
            if let [a, b] = around {
                let opposed = a.forward == b.forward;
                neighbours[a.triangle as usize].push((b.triangle, opposed));
                neighbours[b.triangle as usize].push((a.triangle, opposed));
            }
        }
        neighbours
    }
}
