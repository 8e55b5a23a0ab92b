//! Meshes as scans and artists leave them, made fit to say what is inside.
//!
//! In this order: vertices at one place are joined, copies of a triangle are dropped, triangles are turned to agree
//! and to face outwards, holes are closed. Each step that had something to do leaves a note. What crosses itself, or
//! has holes too large to close, stays as it is: [`super::MeshDistance`] asks the winding number there.

use super::{Inspection, TriMesh, holes, inspect, orient, welded};
use crate::math::{Real, Vec3};
use std::collections::HashSet;

/// What was repaired on the way in, worth a line to the user.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshNote {
    /// All triangles faced inwards.
    InsideOut,
    /// Patches that did not share vertices were joined.
    Welded {
        /// Open edges as stored.
        open_edges: usize,
        /// How far apart joined vertices were at most [m].
        reach: Real,
    },
    /// Copies of other triangles were dropped.
    Copies(usize),
    /// Triangles that disagreed with their neighbours were turned.
    Turned(usize),
    /// Holes were closed.
    Closed {
        /// Their number.
        holes: usize,
        /// Their area, in that of the mesh.
        area: Real,
    },
    /// Holes stay open: their area would be too large a guess.
    Open {
        /// Edges of their rims.
        edges: usize,
        /// The least area over them, in that of the mesh.
        area: Real,
    },
}

impl std::fmt::Display for MeshNote {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::InsideOut => write!(f, "the mesh was inside out (negative volume): turned it"),
            Self::Welded { open_edges, reach } if *reach == 0.0 => write!(
                f,
                "vertices at the same place were joined: there were {open_edges} open edges"
            ),
            Self::Welded { open_edges, reach } => write!(
                f,
                "vertices up to {:.2e} mm apart were joined: there were {open_edges} open edges",
                reach * 1e3
            ),
            Self::Copies(count) => write!(f, "{count} copies of other triangles were dropped"),
            Self::Turned(count) => {
                write!(f, "{count} triangles that faced the wrong way were turned")
            }
            Self::Closed { holes, area } => write!(
                f,
                "{holes} holes, {:.2} % of the area, were closed",
                area * 100.0
            ),
            Self::Open { edges, area } => write!(
                f,
                "holes with {edges} edges would add {:.0} % to the area and stay open: \
                 what is inside is told by the winding number",
                area * 100.0
            ),
        }
    }
}

/// The mesh does not enclose a volume.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OpenMesh {
    /// Too much of it is missing.
    #[error(
        "the mesh is not closed and encloses next to nothing: {open} open, {non_manifold} non-manifold edges of \
         {triangles} triangles, the first at ({:.5}, {:.5}, {:.5}) m (z up); \
         close its holes in a mesh editor (Blender: Mesh > Clean Up > Fill Holes)",
        .at.x, .at.y, .at.z
    )]
    Edges {
        /// Edges with one triangle.
        open: usize,
        /// Edges with more than two triangles.
        non_manifold: usize,
        /// Triangles in all.
        triangles: usize,
        /// Middle of the first such edge [m].
        at: Vec3,
    },
    /// Closed, but flat or empty.
    #[error("the mesh encloses no volume ({triangles} triangles)")]
    NoVolume {
        /// Triangles in all.
        triangles: usize,
    },
}

/// Holes are closed up to this share of the area.
const MOST_CLOSED: Real = 0.25;
/// Enclosed volume of an open mesh, in its area to the 3/2, below which it is a sheet: a ball has 0.094.
const SHEET: Real = 2e-3;
/// Vertices this far apart, in the size of the mesh, may have been one.
const REACHES: [Real; 5] = [0.0, 1e-7, 1e-6, 1e-5, 1e-4];

/// The mesh with triangles that face outwards and, where that is no guess, closed; and what was done for it.
pub fn repaired(mesh: TriMesh) -> Result<(TriMesh, Vec<MeshNote>), OpenMesh> {
    let triangles = mesh.triangles.len();
    if triangles == 0 {
        return Err(OpenMesh::NoVolume { triangles });
    }
    let mut notes = Vec::new();
    let mut mesh = mesh;
    let stored = inspect(&mesh);
    if !stored.is_closed() {
        mesh = weld(mesh, &stored, &mut notes);
        let before = mesh.triangles.len();
        drop_copies(&mut mesh);
        if mesh.triangles.len() < before {
            notes.push(MeshNote::Copies(before - mesh.triangles.len()));
        }
    }
    let turned = orient::orient(&mut mesh);
    if turned.some > 0 {
        notes.push(MeshNote::Turned(turned.some));
    }
    if turned.all {
        notes.push(MeshNote::InsideOut);
    }
    let open = inspect(&mesh).open_edges;
    if open > 0 {
        let mut closed = mesh.clone();
        let (holes, area) = holes::close(&mut closed);
        let area = area / mesh.area().max(Real::MIN_POSITIVE);
        if area <= MOST_CLOSED {
            mesh = closed;
            notes.push(MeshNote::Closed { holes, area });
        } else {
            notes.push(MeshNote::Open { edges: open, area });
        }
    }
    let volume = mesh.signed_volume();
    let scale = libm::pow(mesh.area(), 1.5);
    if let Some(at) = stored.first_fault.filter(|_| volume <= SHEET * scale) {
        return Err(OpenMesh::Edges {
            open: stored.open_edges,
            non_manifold: stored.non_manifold_edges,
            triangles,
            at,
        });
    }
    if volume.is_nan() || volume <= Real::EPSILON * scale {
        return Err(OpenMesh::NoVolume { triangles });
    }
    Ok((mesh, notes))
}

/// Joins vertices over the shortest reach that leaves the fewest open edges.
fn weld(mesh: TriMesh, stored: &Inspection, notes: &mut Vec<MeshNote>) -> TriMesh {
    let size = mesh.bounds().extent().max();
    let most = 0.2 * short_edge(&mesh);
    let mut best = (stored.open_edges, mesh, None);
    for reach in REACHES.map(|share| share * size) {
        if best.0 == 0 || reach > most {
            break;
        }
        let joined = welded(&best.1, reach);
        let open = inspect(&joined).open_edges;
        if open < best.0 {
            best = (open, joined, Some(reach));
        }
    }
    if let Some(reach) = best.2 {
        notes.push(MeshNote::Welded {
            open_edges: stored.open_edges,
            reach,
        });
    }
    best.1
}

/// Length [m] that nineteen of twenty edges exceed.
fn short_edge(mesh: &TriMesh) -> Real {
    let mut lengths: Vec<Real> = (0..mesh.triangles.len())
        .flat_map(|t| {
            let [a, b, c] = mesh.corners(t);
            [(b - a).norm(), (c - b).norm(), (a - c).norm()]
        })
        .collect();
    let at = lengths.len() / 20;
    *lengths.select_nth_unstable_by(at, Real::total_cmp).1
}

/// Keeps the first of triangles over the same three vertices.
fn drop_copies(mesh: &mut TriMesh) {
    let mut seen = HashSet::new();
    mesh.triangles.retain(|triangle| {
        let mut key = *triangle;
        key.sort_unstable();
        seen.insert(key)
    });
}
