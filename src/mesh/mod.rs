//! Triangle meshes: OBJ in and out, inspection, signed distance.

use crate::math::Vec3;

/// Triangles over shared vertices, counter-clockwise seen from outside; metres, z up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions [m].
    pub positions: Vec<Vec3>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}
