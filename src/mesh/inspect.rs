//! Is a mesh closed and oriented? Counts what is wrong along its edges.

use super::edges::Edges;
use super::{TriMesh, orient};
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

/// Counts what is wrong with the edges of `mesh`; connectivity is by vertex index.
pub fn inspect(mesh: &TriMesh) -> Inspection {
    let edges = Edges::of(mesh);
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
    for around in edges.iter() {
        let fault = match around {
            [_] => &mut found.open_edges,
            [a, b] if a.forward == b.forward => &mut found.inconsistent_edges,
            [_, _] => continue,
            _ => &mut found.non_manifold_edges,
        };
        *fault += 1;
        let (a, b) = (around[0].low as usize, around[0].high as usize);
        found
            .first_fault
            .get_or_insert((mesh.positions[a] + mesh.positions[b]) * 0.5);
    }
    found.components = orient::pieces(&edges, mesh.triangles.len()).count();
    found
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

        let mut turned = whole.clone();
        turned.triangles[0].swap(0, 1);
        assert_eq!(inspect(&turned).inconsistent_edges, 3);

        let mut doubled = whole.clone();
        doubled.triangles.push(doubled.triangles[0]);
        assert_eq!(inspect(&doubled).non_manifold_edges, 3);

        let mut two = whole.clone();
        let other = torus(5.0, 1.0, 12, 8);
        let shift = two.positions.len() as u32;
        two.positions.extend(&other.positions);
        two.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
        assert_eq!(inspect(&two).components, 2);
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
