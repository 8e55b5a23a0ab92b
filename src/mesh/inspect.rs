//! Is a mesh closed and oriented? Counts what is wrong, and repairs what has one obvious repair.

use super::{TriMesh, welded};
use crate::math::{Real, Vec3};

/// What a look at the edges of a mesh finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Number of triangles.
    pub triangles: usize,
    /// Edges with one triangle: the rim of a hole.
    pub open_edges: usize,
    /// Edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles run along them in the same direction: one of them is turned.
    pub inconsistent_edges: usize,
    /// Triangles without area.
    pub degenerate_triangles: usize,
    /// Pieces that share no edge.
    pub components: usize,
    /// Enclosed volume, negative when turned inside out [m³].
    pub signed_volume: Real,
    /// Middle of the first edge that is not as it should be [m].
    pub first_fault: Option<Vec3>,
}

impl Inspection {
    /// Whether every edge has its two triangles, in opposite directions.
    pub fn is_closed(&self) -> bool {
        self.first_fault.is_none() && self.triangles > 0
    }
}

/// What was repaired on the way in, worth a line to the user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshNote {
    /// All triangles faced inwards.
    Flipped,
    /// Patches that did not share vertices were joined.
    Welded {
        /// Open edges as stored.
        open_edges: usize,
    },
}

impl std::fmt::Display for MeshNote {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Flipped => write!(f, "the mesh was inside out (negative volume): turned it"),
            Self::Welded { open_edges } => write!(
                f,
                "vertices at the same place were joined: closed {open_edges} open edges"
            ),
        }
    }
}

/// The mesh does not enclose a volume.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OpenMesh {
    /// Faulty edges remain.
    #[error(
        "the mesh is not closed: {open} open, {non_manifold} non-manifold, {inconsistent} inconsistently wound edges \
         of {triangles} triangles, the first at ({:.5}, {:.5}, {:.5}) m (z up); \
         close holes and make normals consistent in a mesh editor (Blender: Mesh > Clean Up > Fill Holes, Mesh > Normals > Recalculate Outside)",
        .at.x, .at.y, .at.z
    )]
    Edges {
        /// Edges with one triangle.
        open: usize,
        /// Edges with more than two triangles.
        non_manifold: usize,
        /// Edges between triangles of opposite winding.
        inconsistent: usize,
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

/// Counts what is wrong with the edges of `mesh`; connectivity is by vertex index.
pub fn inspect(mesh: &TriMesh) -> Inspection {
    // Edge as (low, high, forward, triangle): sorted, the triangles around an edge stand together.
    let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), a < b, t as u32));
        }
    }
    edges.sort_unstable();

    let mut found = Inspection {
        triangles: mesh.triangles.len(),
        open_edges: 0,
        non_manifold_edges: 0,
        inconsistent_edges: 0,
        degenerate_triangles: (0..mesh.triangles.len())
            .filter(|&t| mesh.area_normal(t).norm() == 0.0)
            .count(),
        components: 0,
        signed_volume: mesh.signed_volume(),
        first_fault: None,
    };
    let mut pieces = Pieces::new(mesh.triangles.len());
    for around in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for pair in around.windows(2) {
            pieces.join(pair[0].3, pair[1].3);
        }
        let fault = match around {
            [_] => &mut found.open_edges,
            [a, b] if a.2 == b.2 => &mut found.inconsistent_edges,
            [_, _] => continue,
            _ => &mut found.non_manifold_edges,
        };
        *fault += 1;
        let (a, b) = (around[0].0 as usize, around[0].1 as usize);
        found
            .first_fault
            .get_or_insert((mesh.positions[a] + mesh.positions[b]) * 0.5);
    }
    found.components = pieces.count();
    found
}

/// The mesh as a closed one whose triangles face outwards, and what had to be repaired for it.
pub fn require_closed(mesh: TriMesh) -> Result<(TriMesh, Vec<MeshNote>), OpenMesh> {
    let mut notes = Vec::new();
    let mut mesh = mesh;
    let mut found = inspect(&mesh);
    if !found.is_closed() && found.triangles > 0 {
        // A millionth of the size joins what rounding in the file tore apart, and nothing else.
        let tolerance = mesh.bounds().extent().max() * 1e-6;
        for reach in [0.0, tolerance] {
            let joined = welded(&mesh, reach);
            let after = inspect(&joined);
            if after.is_closed() {
                notes.push(MeshNote::Welded {
                    open_edges: found.open_edges,
                });
                (mesh, found) = (joined, after);
                break;
            }
        }
    }
    if let Some(at) = found.first_fault {
        return Err(OpenMesh::Edges {
            open: found.open_edges,
            non_manifold: found.non_manifold_edges,
            inconsistent: found.inconsistent_edges,
            triangles: found.triangles,
            at,
        });
    }
    if found.signed_volume.abs() <= Real::EPSILON * mesh.bounds().extent().max().powi(3)
        || found.triangles == 0
    {
        return Err(OpenMesh::NoVolume {
            triangles: found.triangles,
        });
    }
    if found.signed_volume < 0.0 {
        mesh = mesh.flipped();
        notes.push(MeshNote::Flipped);
    }
    Ok((mesh, notes))
}

/// Disjoint sets of triangles.
struct Pieces(Vec<u32>);

impl Pieces {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut t: u32) -> u32 {
        while self.0[t as usize] != t {
            self.0[t as usize] = self.0[self.0[t as usize] as usize];
            t = self.0[t as usize];
        }
        t
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    fn count(&self) -> usize {
        (0..self.0.len())
            .filter(|&t| self.0[t] as usize == t)
            .count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::{cuboid, shared, torus};

    #[test]
    fn faults_are_counted_and_placed() {
        let whole = cuboid(Vec3::zeros(), Vec3::repeat(1.0));
        assert!(inspect(&whole).is_closed());
        assert_eq!(inspect(&whole).components, 1);

        let mut holed = whole.clone();
        holed.triangles.pop();
        assert_eq!(inspect(&holed).open_edges, 3);
        let error = require_closed(holed).unwrap_err().to_string();
        assert!(error.contains("3 open"), "{error}");

        let mut turned = whole.clone();
        turned.triangles[0].swap(0, 1);
        assert_eq!(inspect(&turned).inconsistent_edges, 3);

        let mut doubled = whole.clone();
        doubled.triangles.push(doubled.triangles[0]);
        assert_eq!(inspect(&doubled).non_manifold_edges, 3);

        let (mesh, notes) = require_closed(whole.clone().flipped()).unwrap();
        assert_eq!(notes, [MeshNote::Flipped]);
        assert!(mesh.signed_volume() > 0.0);

        let mut two = whole.clone();
        let other = torus(5.0, 1.0, 12, 8);
        let shift = two.positions.len() as u32;
        two.positions.extend(&other.positions);
        two.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
        assert_eq!(inspect(&two).components, 2);

        assert!(matches!(
            require_closed(TriMesh::default()),
            Err(OpenMesh::NoVolume { triangles: 0 })
        ));
    }

    #[test]
    fn real_bones_are_closed_in_one_piece_once_welded() {
        use crate::mesh::LengthUnit::{Metre, Millimetre};
        for (name, unit, volume) in [
            ("vhm_L3_m.obj", Metre, 8.06e-5),
            ("ssm_mean_L3_mm.obj", Millimetre, 6.327e-5),
            ("vhm_L3_body_unwelded_m.obj", Metre, 4.49e-5),
        ] {
            let Some(mesh) = shared(name, unit) else {
                return;
            };
            let found = inspect(&mesh);
            assert!(found.is_closed() && found.components == 1, "{found:?}");
            assert!(
                (found.signed_volume / volume - 1.0).abs() < 2e-3,
                "{found:?}"
            );
        }
    }
}
