//! Smoothing that keeps threads, drops and volume [Loeschner23].
//!
//! Vertices move towards the mean of their neighbours, the more the more particles are around: in the open face of a
//! large body all the way, on a thread or a drop hardly at all. Where the cement touches a wall they stay. Each piece is
//! then moved out along its normals until it encloses what it did before.

use super::pieces::Pieces;
use crate::math::{Real, Vec3};
use crate::mesh::TriMesh;
use rayon::prelude::*;

/// Share of the way to the neighbours' mean in a round.
const STEP: Real = 1.0;
/// Number of times that volume is restored; each leaves about a tenth of the error.
const RESTORES: usize = 2;

/// How far each vertex follows its neighbours [1] if so many particles are around it.
///
/// In the middle of a lattice, Σ (1 − q²)₊ is 13.5 at a support of four particle radii, of which the particle itself is
/// one; the weights are [Loeschner23]'s.
pub(super) fn weight(neighbours: f32) -> f32 {
    let x = ((neighbours - 1.0) / 12.5).clamp(0.0, 1.0);
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

/// Smooths `mesh` in `rounds`; `weight` [1] is one a vertex. To give a piece back what it lost, no vertex moves farther
/// than `farthest` [m].
pub(super) fn smooth(
    mesh: &mut TriMesh,
    weight: &[f32],
    rounds: u32,
    pieces: &Pieces,
    farthest: Real,
) {
    let around = Neighbours::new(mesh);
    let before = pieces.volumes(mesh);
    for _ in 0..rounds {
        let old = &mesh.positions;
        mesh.positions = (0..old.len())
            .into_par_iter()
            .map(|v| {
                let ring = around.of(v);
                let sum: Vec3 = ring.iter().map(|&w| old[w as usize]).sum();
                let mean = sum / ring.len() as Real;
                old[v] + (mean - old[v]) * (STEP * Real::from(weight[v]))
            })
            .collect();
    }
    restore(mesh, weight, pieces, &before, farthest);
}

/// Moves vertices along their normals, by their `weight` [1] and no farther than `farthest` [m], until each piece encloses
/// its `volume` [m³].
pub(super) fn restore(
    mesh: &mut TriMesh,
    weight: &[f32],
    pieces: &Pieces,
    volume: &[Real],
    farthest: Real,
) {
    for _ in 0..RESTORES {
        // A third of the area of the triangles around a vertex, along their mean normal.
        let mut area = vec![Vec3::zeros(); mesh.positions.len()];
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a).cross(&(c - a)) / 6.0;
            for v in mesh.triangles[t] {
                area[v as usize] += normal;
            }
        }
        let mut free = vec![0.0; volume.len()];
        for v in 0..area.len() {
            free[pieces.of[v] as usize] += area[v].norm() * Real::from(weight[v]);
        }
        let now = pieces.volumes(mesh);
        for v in 0..area.len() {
            let piece = pieces.of[v] as usize;
            let missing = (volume[piece] - now[piece]) / free[piece];
            if let Some(normal) = area[v].try_normalize(0.0)
                && missing.is_finite()
            {
                let most = farthest / RESTORES as Real;
                let step = missing.clamp(-most, most);
                mesh.positions[v] += normal * (step * Real::from(weight[v]));
            }
        }
    }
}

/// The vertices next to each, on a closed manifold mesh.
struct Neighbours {
    first: Vec<u32>,
    index: Vec<u32>,
}

impl Neighbours {
    fn new(mesh: &TriMesh) -> Self {
        // Around a vertex of a closed mesh, the next corners of its triangles are its neighbours, each once.
        let mut first = vec![0_u32; mesh.positions.len() + 1];
        for v in mesh.triangles.iter().flatten() {
            first[*v as usize + 1] += 1;
        }
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut next = first.clone();
        let mut index = vec![0; 3 * mesh.triangles.len()];
        for [a, b, c] in &mesh.triangles {
            for (v, w) in [(a, b), (b, c), (c, a)] {
                let place = &mut next[*v as usize];
                index[*place as usize] = *w;
                *place += 1;
            }
        }
        Self { first, index }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.index[self.first[v] as usize..self.first[v + 1] as usize]
    }
}
