//! Which triangles are surface: inside on one side, outside on the other.
//!
//! Where nothing crosses and every edge is passed as often one way as the other, the winding number is the same all
//! along a patch of neighbours: a few triangles answer for it. Elsewhere each triangle is asked.

use super::edges::{Edges, Side};
use super::pieces::Pieces;
use super::winding::Winding;
use super::{TriMesh, orient};
use crate::math::{Real, Vec3};
use rayon::prelude::*;

/// The winding number of the mesh and its surface triangles, ascending; none if pseudo-normals alone tell the inside
/// and all triangles are surface.
pub(super) fn shown(
    mesh: &TriMesh,
    edges: &Edges,
    crossing: &[bool],
) -> Option<(Winding, Vec<u32>)> {
    if is_simple(mesh, edges, crossing) {
        return None;
    }
    let winding = Winding::new(mesh, |_| true);
    let count = mesh.triangles.len() as u32;
    let asked = |t: u32, winding: &Winding| {
        let corners = mesh.corners(t as usize);
        is_surface(&corners, crossing[t as usize], winding)
    };
    let balanced =
        |around: &[Side]| 2 * around.iter().filter(|s| s.forward).count() == around.len();
    if !edges.iter().all(balanced) {
        let all = (0..count).into_par_iter();
        let kept = all.filter(|t| asked(*t, &winding)).collect();
        return Some((winding, kept));
    }
    let mut patches = Pieces::new(count as usize);
    for around in edges.iter().filter(|around| paired(around)) {
        let [a, b] = [around[0].triangle, around[1].triangle];
        if !crossing[a as usize] && !crossing[b as usize] {
            patches.join(a, b);
        }
    }
    let mut by_patch: Vec<(u32, u32)> = (0..count).map(|t| (patches.root(t), t)).collect();
    by_patch.sort_unstable();
    let patches: Vec<&[(u32, u32)]> = by_patch.chunk_by(|a, b| a.0 == b.0).collect();
    let mut kept: Vec<u32> = patches
        .into_par_iter()
        .flat_map_iter(|patch| {
            let asked = |t: &u32| asked(*t, &winding);
            let every = patch.iter().map(|(_, t)| *t);
            let few = every.clone().step_by(patch.len().div_ceil(PROBES));
            let mut answers = few.map(|t| asked(&t));
            let first = answers.next().unwrap_or(false);
            let alike = answers.all(|answer| answer == first);
            let kept: Vec<u32> = if alike {
                every.filter(|_| first).collect()
            } else {
                every.filter(asked).collect()
            };
            kept
        })
        .collect();
    kept.sort_unstable();
    Some((winding, kept))
}

/// Triangles of a patch that answer for it if they agree. They do not where triangles lie over each other in one plane,
/// which `crossing` leaves out: then each is asked.
const PROBES: usize = 8;

fn paired(around: &[Side]) -> bool {
    matches!(around, [a, b] if a.forward != b.forward)
}

/// Whether pseudo-normals alone tell the inside: closed, oriented, nothing crosses, shells lie in each other as
/// bubbles do.
fn is_simple(mesh: &TriMesh, edges: &Edges, crossing: &[bool]) -> bool {
    if crossing.contains(&true) || !edges.iter().all(paired) {
        return false;
    }
    let mut pieces = orient::pieces(edges, mesh.triangles.len());
    let count = pieces.count();
    if count < 2 {
        return true;
    }
    // One triangle a piece, the largest: next to it the winding number has to be 0 in front and 1 behind.
    let mut largest: Vec<Option<(Real, usize)>> = vec![None; mesh.triangles.len()];
    for t in 0..mesh.triangles.len() {
        let best = &mut largest[pieces.root(t as u32) as usize];
        let area = mesh.area_normal(t).norm();
        if best.is_none_or(|(most, _)| area > most) {
            *best = Some((area, t));
        }
    }
    let winding = Winding::new(mesh, |_| true);
    let probes: Vec<usize> = largest.iter().flatten().map(|(_, t)| *t).collect();
    probes.into_par_iter().all(|t| {
        let (front, back) = sides(&mesh.corners(t), [1.0 / 3.0; 3], &winding);
        front.abs() < 0.3 && (back - 1.0).abs() < 0.3
    })
}

/// Winding numbers in front of and behind a point of a triangle.
fn sides(corners: &[Vec3; 3], weights: [Real; 3], winding: &Winding) -> (Real, Real) {
    let [a, b, c] = corners;
    let at = a * weights[0] + b * weights[1] + c * weights[2];
    let normal = (b - a).cross(&(c - a));
    let size = normal.norm().sqrt();
    let step = normal.try_normalize(0.0).unwrap_or_default() * (size * 1e-3);
    (winding.at(&(at + step)), winding.at(&(at - step)))
}

/// Whether a triangle has inside on one side and outside on the other, somewhere; without others through it, it is the
/// same everywhere on it.
fn is_surface(corners: &[Vec3; 3], crossed: bool, winding: &Winding) -> bool {
    let near = 0.8;
    let far = 0.5 * (1.0 - near);
    let places = [
        [1.0 / 3.0; 3],
        [near, far, far],
        [far, near, far],
        [far, far, near],
    ];
    let places = if crossed { &places[..] } else { &places[..1] };
    places.iter().any(|weights| {
        let (front, back) = sides(corners, *weights, winding);
        (front > 0.5) != (back > 0.5)
    })
}
