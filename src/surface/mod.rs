//! The surface of the cement: a colour field around its particles, and marching cubes through it.
//!
//! ```text
//! φ(x) = Σ_j V_j W(x − x_j),   V_j = 1 / Σ_k W(x_j − x_k)
//! ```
//!
//! φ is about 1 inside and falls to 0 outside. V_j is the volume that particle j stands for among its neighbours; with
//! the volume at rest instead, drops and filaments of a few particles would vanish.

mod cases;
mod cubes;

use crate::cache::Frame;
use crate::grid::{NearPoints, PointBricks, kernel, kernel_slope};
use crate::math::{Real, Vec3};
use crate::mesh::TriMesh;
use cubes::{Cubes, Cut};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the surface is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceSettings {
    /// Support radius of the colour field's kernel [spacings]. 2 is four particle radii, splashsurf's habit.
    pub smoothing: Real,
    /// Edge of a marching cube [spacings].
    pub cube: Real,
    /// Value of the colour field on the surface [1]. At the default smoothing, 0.6 keeps volume: faces of a filled
    /// box lie within 0.02 spacings of where they should, and a single particle still shows as 0.9 of its volume.
    pub threshold: Real,
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self {
            smoothing: 2.0,
            cube: 0.5,
            threshold: 0.6,
        }
    }
}

impl SurfaceSettings {
    /// What is out of range, if anything: outside it, memory explodes or the surface leaves the particles.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, range) in [
            ("smoothing", self.smoothing, 1.0..=4.0),
            ("cube", self.cube, 0.1..=1.0),
            ("threshold", self.threshold, 0.05..=0.95),
        ] {
            if !range.contains(&value) {
                let (low, high) = range.into_inner();
                return Err(format!(
                    "{key}: expected a number from {low} to {high}, found {value}"
                ));
            }
        }
        Ok(())
    }
}

/// A closed, oriented, manifold surface; everything else is per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Triangles, counter-clockwise seen from outside.
    pub mesh: TriMesh,
    /// Unit normal, away from the cement.
    pub normal: Vec<Vec3>,
    /// α of the polymer phase [1].
    pub polymer_fraction: Vec<f32>,
    /// Mixture velocity [m/s].
    pub velocity: Vec<[f32; 3]>,
}

impl Surface {
    /// Length of the velocity at each vertex [m/s].
    pub fn speed(&self) -> Vec<f32> {
        let length = |[u, v, w]: &[f32; 3]| (u * u + v * v + w * w).sqrt();
        self.velocity.iter().map(length).collect()
    }
}

/// The surface of the cement in `frame`, the same bits on any number of threads.
pub fn reconstruct(frame: &Frame, settings: &SurfaceSettings) -> Surface {
    if frame.position.is_empty() {
        return Surface::default();
    }
    let cube = settings.cube * frame.spacing;
    let points = PointBricks::new(&frame.position, cube, settings.smoothing * frame.spacing);
    let volume: Vec<f32> = points.crowding().iter().map(|sum| 1.0 / sum).collect();
    let keys = points.touched();
    let values: Vec<Box<[f32; 512]>> = keys
        .par_iter()
        .map(|&key| {
            let [sums] = points.near(key).node_sums(|j| [volume[j]]);
            sums
        })
        .collect();
    let cubes = Cubes {
        keys: &keys,
        values: &values,
        threshold: settings.threshold as f32,
    };
    let cuts = cubes.cuts();
    let triangles = cubes.triangles(&cuts);

    let vertices: Vec<Vec<Vertex>> = (0..keys.len())
        .into_par_iter()
        .map(|brick| {
            if cuts[brick].is_empty() {
                return Vec::new();
            }
            let around = Surroundings {
                near: points.near(keys[brick]),
                order: &points.order,
                volume: &volume,
                frame,
            };
            let vertex = |cut: &Cut| around.vertex(cut, keys[brick], cube);
            cuts[brick].iter().map(vertex).collect()
        })
        .collect();

    let mut surface = Surface::default();
    surface.mesh.triangles = triangles;
    for vertex in vertices.iter().flatten() {
        surface.mesh.positions.push(vertex.position);
        surface.normal.push(vertex.normal);
        surface.polymer_fraction.push(vertex.polymer_fraction);
        surface.velocity.push(vertex.velocity);
    }
    surface
}

struct Vertex {
    position: Vec3,
    normal: Vec3,
    polymer_fraction: f32,
    velocity: [f32; 3],
}

/// The particles around a brick.
struct Surroundings<'a> {
    near: NearPoints,
    order: &'a [u32],
    volume: &'a [f32],
    frame: &'a Frame,
}

impl Surroundings<'_> {
    fn vertex(&self, cut: &Cut, key: [i32; 3], cube: Real) -> Vertex {
        let node = [cut.node >> 6, cut.node >> 3 & 7, cut.node & 7];
        let mut local = node.map(|n| n as f32);
        local[cut.axis] += cut.t;
        let mut gradient = Vec3::zeros();
        // Σ V w, Σ V w α, Σ V w v.
        let mut sums = [0.0_f32; 5];
        let mut gather = |at: [f32; 3]| {
            self.near.visit(at, |j, offset, q| {
                let volume = self.volume[j];
                if q > 0.0 {
                    let slope = Real::from(volume * kernel_slope(q) / q);
                    gradient += Vec3::from(offset.map(Real::from)) * slope;
                }
                let weight = volume * kernel(q);
                let particle = self.order[j] as usize;
                let [u, v, w] = self.frame.velocity[particle];
                let row = [1.0, self.frame.polymer_fraction[particle], u, v, w];
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += weight * value;
                }
            });
            sums[0] > 0.0
        };
        if !gather(local) {
            // A wide cube may be cut where no particle reaches; its inside end is always in reach.
            let mut inside = node.map(|n| n as f32);
            inside[cut.axis] += if cut.rising { 0.0 } else { 1.0 };
            gather(inside);
        }
        let outward = if cut.rising { 1.0 } else { -1.0 };
        let along_edge = Vec3::ith(cut.axis, outward);
        Vertex {
            position: Vec3::from_fn(|a, _| {
                let t = if a == cut.axis {
                    Real::from(cut.t)
                } else {
                    0.0
                };
                (Real::from(key[a] * 8) + node[a] as Real + t) * cube
            }),
            normal: (-gradient).try_normalize(1e-9).unwrap_or(along_edge),
            polymer_fraction: sums[1] / sums[0],
            velocity: [2, 3, 4].map(|k| sums[k] / sums[0]),
        }
    }
}

#[cfg(test)]
mod tests;
