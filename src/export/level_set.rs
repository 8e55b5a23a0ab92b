//! The signed distance from a surface in a band of voxels around it: a level set, negative inside.
//!
//! A voxel's distance is that to the triangles around the vertex nearest to it. The triangles of a surface are not
//! larger than its voxels, so that this is the distance to the surface but for a hair where two sheets meet.

use super::{Class, Grid, Leaf, Leaves, y_up};
use crate::grid::{BRICK, PointBricks};
use crate::math::{Real, Vec3};
use crate::mesh::{TriMesh, closest_on_triangle};
use rayon::prelude::*;

/// Half the width of the band [voxels]; OpenVDB's own.
const BAND: Real = 3.0;

/// The level set of a closed surface. `inside` says for voxels of the leaves `filled` (multiples of 8) that are farther
/// from the surface than the band on which side they are.
pub fn from_surface(
    mesh: &TriMesh,
    normals: &[Vec3],
    voxel: Real,
    filled: &[[i32; 3]],
    inside: impl Fn([i32; 3]) -> bool + Sync,
) -> Grid {
    let in_file = |p: &Vec3| Vec3::new(p.x, p.z, -p.y);
    let vertices: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|p| y_up([p.x as f32, p.y as f32, p.z as f32]))
        .collect();
    let points = PointBricks::new(&vertices, voxel, (BAND + 1.0) * voxel);
    let around = Fans::new(mesh);
    let mut keys = points.touched();
    keys.extend(filled.iter().map(|first| first.map(|f| f / BRICK)));
    keys.par_sort_unstable();
    keys.dedup();

    let background = (BAND * voxel) as f32;
    let distance = |x: &Vec3, vertex: u32| {
        let mut best = (Real::INFINITY, 1.0);
        for &t in around.of(vertex as usize) {
            let corners = mesh.corners(t as usize).map(|c| in_file(&c));
            let (point, _) = closest_on_triangle(x, &corners);
            let square = (x - point).norm_squared();
            if square < best.0 {
                // The vertices' mean normal at the point: the face's own may look past it at an edge.
                let normal: Vec3 = mesh.triangles[t as usize]
                    .iter()
                    .zip(corners)
                    .map(|(v, corner)| {
                        in_file(&normals[*v as usize]) / ((point - corner).norm() + 1e-3 * voxel)
                    })
                    .sum();
                best = (square, (x - point).dot(&normal));
            }
        }
        let distance = best.0.sqrt() as f32;
        if best.1 < 0.0 { -distance } else { distance }
    };
    let leaves = keys
        .par_iter()
        .filter_map(|&key| {
            let nearest = points.near(key).nearest_nodes();
            let first = key.map(|k| k * BRICK);
            let mut leaf = Leaf {
                first,
                active: [0; 8],
                values: Box::new([background; 512]),
            };
            for i in 0..512 {
                let inner = [i >> 6, i >> 3 & 7, i & 7];
                let at: [i32; 3] = std::array::from_fn(|a| first[a] + inner[a] as i32);
                let found = nearest[i].map(|point| {
                    let x = Vec3::from(at.map(Real::from)) * voxel;
                    distance(&x, points.order[point as usize])
                });
                leaf.values[i] = match found {
                    Some(found) if found.abs() < background => {
                        leaf.active[i >> 6] |= 1 << (i & 63);
                        found
                    }
                    Some(found) => background.copysign(found),
                    None if inside(at) => -background,
                    None => background,
                };
            }
            let outside = leaf.active == [0; 8] && leaf.values.iter().all(|v| *v > 0.0);
            (!outside).then_some(leaf)
        })
        .collect();
    Grid {
        name: "surface".into(),
        class: Class::LevelSet { background },
        origin: Vec3::zeros(),
        voxel,
        leaves: Leaves::Float(leaves),
    }
}

/// The triangles at each vertex.
struct Fans {
    first: Vec<u32>,
    index: Vec<u32>,
}

impl Fans {
    fn new(mesh: &TriMesh) -> Self {
        let mut first = vec![0_u32; mesh.positions.len() + 1];
        for v in mesh.triangles.iter().flatten() {
            first[*v as usize + 1] += 1;
        }
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut next = first.clone();
        let mut index = vec![0; 3 * mesh.triangles.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for v in triangle {
                let place = &mut next[*v as usize];
                index[*place as usize] = t as u32;
                *place += 1;
            }
        }
        Self { first, index }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.index[self.first[v] as usize..self.first[v + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface_nets;

    #[test]
    fn a_ball_has_its_distance_in_the_band_and_its_sides_beyond() {
        let (centre, radius) = (Vec3::new(0.3, -0.2, 0.1), 1.2);
        let bounds = crate::math::Aabb {
            min: centre.add_scalar(-1.5),
            max: centre.add_scalar(1.5),
        };
        let ball = surface_nets(&bounds, 0.05, |x| (x - centre).norm() - radius);
        let voxel = 0.1;
        // The ball in the file, y up.
        let away = |at: [i32; 3]| {
            (Vec3::from(at.map(f64::from)) * voxel - Vec3::new(0.3, 0.1, 0.2)).norm() - radius
        };
        let mut filled = Vec::new();
        for x in -2..=2 {
            for y in -2..=2 {
                filled.extend((-2..=2).map(|z| [8 * x, 8 * y, 8 * z]));
            }
        }
        let normals = ball.vertex_normals();
        let grid = from_surface(&ball, &normals, voxel, &filled, |at| away(at) < 0.0);
        let Leaves::Float(leaves) = &grid.leaves else {
            panic!("numbers")
        };
        let mut band = 0;
        for leaf in leaves {
            for i in 0..512 {
                let inner = [i >> 6, i >> 3 & 7, i & 7];
                let exact = away(std::array::from_fn(|a| leaf.first[a] + inner[a] as i32));
                let found = f64::from(leaf.values[i]);
                if leaf.active[i >> 6] >> (i & 63) & 1 == 1 {
                    band += 1;
                    assert!((found - exact).abs() < 2e-3, "{found} {exact}");
                } else {
                    assert!(exact.abs() > 0.298 && (found - 0.3_f64.copysign(exact)).abs() < 1e-6);
                }
            }
        }
        // 4 π r² times the width of the band.
        let expected = 4.0 * std::f64::consts::PI * (radius * radius + 0.03) * 0.6 / voxel.powi(3);
        assert!(
            (f64::from(band) / expected - 1.0).abs() < 0.02,
            "{band} {expected}"
        );
    }
}
