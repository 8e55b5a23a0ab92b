//! Joins vertices that lie at the same place, so that neighbouring triangles share them.

use super::TriMesh;
use crate::math::{Real, Vec3};
use std::collections::HashMap;

/// The mesh with vertices closer than `tolerance` [m] joined (0: only equal ones), without triangles that
/// collapse by it and without vertices that no triangle uses.
///
/// A vertex joins the first one, in file order, within reach: the result does not depend on anything else.
pub fn welded(mesh: &TriMesh, tolerance: Real) -> TriMesh {
    let mut first_in_cell: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut joined = TriMesh::default();
    let mut place = vec![u32::MAX; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| {
            if place[v as usize] == u32::MAX {
                let position = mesh.positions[v as usize];
                place[v as usize] = representative(
                    &position,
                    tolerance,
                    &mut first_in_cell,
                    &mut joined.positions,
                );
            }
            place[v as usize]
        });
        if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
            joined.triangles.push(corners);
        }
    }
    joined
}

fn representative(
    position: &Vec3,
    tolerance: Real,
    first_in_cell: &mut HashMap<[i64; 3], Vec<u32>>,
    kept: &mut Vec<Vec3>,
) -> u32 {
    let reach = i64::from(tolerance > 0.0);
    let cell: [i64; 3] = if tolerance > 0.0 {
        std::array::from_fn(|axis| (position[axis] / tolerance).floor() as i64)
    } else {
        // + 0.0 makes −0 and 0 the same place.
        std::array::from_fn(|axis| (position[axis] + 0.0).to_bits().cast_signed())
    };
    let mut nearest: Option<u32> = None;
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                let key = [
                    cell[0].wrapping_add(x),
                    cell[1].wrapping_add(y),
                    cell[2].wrapping_add(z),
                ];
                for &candidate in first_in_cell.get(&key).into_iter().flatten() {
                    let near = (kept[candidate as usize] - position).norm() <= tolerance;
                    if near && nearest.is_none_or(|n| candidate < n) {
                        nearest = Some(candidate);
                    }
                }
            }
        }
    }
    nearest.unwrap_or_else(|| {
        let id = kept.len() as u32;
        kept.push(*position);
        first_in_cell.entry(cell).or_default().push(id);
        id
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{inspect, tests::torus};

    #[test]
    fn torn_triangles_become_one_closed_mesh_again() {
        let whole = torus(2.0, 0.5, 40, 20);
        let mut random = crate::math::Stream::new(2, "weld");
        let torn = |random: &mut crate::math::Stream, shake: Real| TriMesh {
            positions: (0..whole.triangles.len())
                .flat_map(|t| whole.corners(t))
                .map(|p| p + random.cube() * shake)
                .collect(),
            triangles: (0..whole.triangles.len() as u32)
                .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                .collect(),
        };
        assert_eq!(inspect(&torn(&mut random, 0.0)).open_edges, 4800);
        for (shake, tolerance) in [(0.0, 0.0), (1e-6, 1e-5)] {
            let mesh = welded(&torn(&mut random, shake), tolerance);
            assert_eq!(mesh.positions.len(), whole.positions.len());
            assert_eq!(inspect(&mesh).open_edges, 0);
        }
    }
}
