//! The pieces of a surface: drops, islands, bubbles.

use crate::math::{Real, Vec3};
use crate::mesh::TriMesh;

/// Which piece each vertex belongs to.
pub(super) struct Pieces {
    /// Number of the piece of each vertex, in the order of their first vertices.
    pub of: Vec<u32>,
    /// How many there are.
    pub count: usize,
}

impl Pieces {
    pub fn new(mesh: &TriMesh) -> Self {
        let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        for [a, b, c] in &mesh.triangles {
            for (v, w) in [(*a, *b), (*b, *c)] {
                let (v, w) = (root(&mut parent, v), root(&mut parent, w));
                // The lower number wins, so that a piece's root is its first vertex.
                parent[v.max(w) as usize] = v.min(w);
            }
        }
        let mut of = vec![0; parent.len()];
        let mut count = 0;
        for v in 0..parent.len() {
            let first = root(&mut parent, v as u32) as usize;
            of[v] = if first == v {
                count += 1;
                count as u32 - 1
            } else {
                of[first]
            };
        }
        Self { of, count }
    }

    /// Everything as one.
    pub fn whole(mesh: &TriMesh) -> Self {
        Self {
            of: vec![0; mesh.positions.len()],
            count: 1,
        }
    }

    /// Volume that each piece encloses, below 0 for bubbles [m³].
    pub fn volumes(&self, mesh: &TriMesh) -> Vec<Real> {
        // Measured from each piece's first vertex: far from the origin, no digits are lost.
        let mut pivot: Vec<Option<Vec3>> = vec![None; self.count];
        for (v, &piece) in self.of.iter().enumerate() {
            pivot[piece as usize].get_or_insert(mesh.positions[v]);
        }
        let mut volume = vec![0.0; self.count];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let piece = self.of[triangle[0] as usize] as usize;
            let pivot = pivot[piece].unwrap_or_default();
            let [a, b, c] = mesh.corners(t).map(|corner| corner - pivot);
            volume[piece] += a.dot(&b.cross(&c)) / 6.0;
        }
        volume
    }
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

/// Pieces that were left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// How many.
    pub pieces: usize,
    /// What they enclose, bubbles counted as positive [m³].
    pub volume: Real,
}

/// Leaves out pieces that enclose less than `smallest` [m³]; says which vertices are kept.
pub(super) fn leave_out(
    mesh: &mut TriMesh,
    pieces: &Pieces,
    smallest: Real,
) -> (Vec<bool>, LeftOut) {
    let volumes = pieces.volumes(mesh);
    let small = |piece: u32| volumes[piece as usize].abs() < smallest;
    let mut left_out = LeftOut::default();
    for piece in (0..pieces.count as u32).filter(|&piece| small(piece)) {
        left_out.pieces += 1;
        left_out.volume += volumes[piece as usize].abs();
    }
    let kept: Vec<bool> = pieces.of.iter().map(|&piece| !small(piece)).collect();
    let mut number = 0;
    let numbers: Vec<u32> = kept
        .iter()
        .map(|&kept| {
            number += u32::from(kept);
            number.wrapping_sub(1)
        })
        .collect();
    mesh.triangles.retain(|t| kept[t[0] as usize]);
    for v in mesh.triangles.iter_mut().flatten() {
        *v = numbers[*v as usize];
    }
    keep(&mut mesh.positions, &kept);
    (kept, left_out)
}

/// Keeps the rows that are `kept`.
pub(super) fn keep<T>(rows: &mut Vec<T>, kept: &[bool]) {
    let mut row = 0;
    rows.retain(|_| {
        row += 1;
        kept[row - 1]
    });
}
