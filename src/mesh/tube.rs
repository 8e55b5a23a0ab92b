//! A tube as a mesh, for example the shaft of a cannula.

use super::TriMesh;
use crate::math::{Real, Vec3};

/// Facets around.
const SIDES: u32 = 48;

/// The closed surface of a tube wall between the radii `inner` and `outer` [m], from `base` along the unit vector
/// `axis`.
pub fn tube(base: &Vec3, axis: &Vec3, length: Real, inner: Real, outer: Real) -> TriMesh {
    let helper = if axis.x.abs() < 0.9 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let u = (helper - axis * helper.dot(axis)).normalize();
    let v = axis.cross(&u);
    let mut mesh = TriMesh::default();
    for side in 0..SIDES {
        let angle = core::f64::consts::TAU * Real::from(side) / Real::from(SIDES);
        let outward = u * libm::cos(angle) + v * libm::sin(angle);
        // The corners of the wall's cross-section, counter-clockwise with `outward` to the right and `axis` up.
        for (radius, along) in [(inner, 0.0), (outer, 0.0), (outer, length), (inner, length)] {
            mesh.positions.push(base + outward * radius + axis * along);
        }
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            let there = (side + 1) % SIDES * 4;
            let here = side * 4;
            let [a, b, c, d] = [here + corner, there + corner, there + next, here + next];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    #[test]
    fn it_is_closed_and_has_the_volume_of_its_wall() {
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        let found = inspect(&tube(&Vec3::repeat(0.3), &axis, 2.0, 0.5, 0.7));
        assert!(found.is_closed() && found.components == 1, "{found:?}");
        let exact = core::f64::consts::PI * (0.49 - 0.25) * 2.0;
        assert!(
            (found.signed_volume / exact - 1.0).abs() < 0.005,
            "{found:?}"
        );
    }
}
