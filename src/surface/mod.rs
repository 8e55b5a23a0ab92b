//! The surface of the cement: a colour field around its particles, marching cubes through it, and smoothing.
//!
//! Against the exact body (`tests/surface_exact.rs`) the farthest point converges with order 1.4 to 1.9 in the spacing where
//! particles lie in layers along the surface, as a flow leaves them. Of a body cut from a lattice it stays half a spacing away
//! at every size: a flat face may lie anywhere between two layers, and the particles do not say where.

mod attributes;
mod cases;
mod cubes;
mod field;
mod pieces;
mod settings;
mod smooth;

pub use pieces::LeftOut;
pub use settings::SurfaceSettings;

use crate::cache::Frame;
use crate::math::{Real, Vec3};
use crate::mesh::TriMesh;
use crate::solid::Solid;
use attributes::{Carried, Surroundings, Table};
use cubes::{Cubes, Cut};
use field::Field;
use pieces::{Pieces, keep, leave_out};
use rayon::prelude::*;

/// How far a vertex is moved at most for the sake of volume, and how deep in a wall it may end [spacings].
const FARTHEST: Real = 0.5;

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
    /// Pressure [Pa].
    pub pressure: Vec<f32>,
    /// √(2 D:D) of the rate of strain D [1/s].
    pub shear_rate: Vec<f32>,
    /// Age: which millilitre came to lie here, counted from the first that there was [ml].
    pub millilitre: Vec<f32>,
    /// What was too small to be shown.
    pub left_out: LeftOut,
}

impl Surface {
    /// Length of the velocity at each vertex [m/s].
    pub fn speed(&self) -> Vec<f32> {
        let length = |[u, v, w]: &[f32; 3]| (u * u + v * v + w * w).sqrt();
        self.velocity.iter().map(length).collect()
    }
}

/// The surface of the cement in `frame`, which ends where `solid` begins; the same bits on any number of threads.
pub fn reconstruct(frame: &Frame, solid: Option<&Solid>, settings: &SurfaceSettings) -> Surface {
    reconstruct_moving(frame, &frame.velocity, solid, settings)
}

/// The same, its vertices carrying another `velocity` [m/s] of the particles than they have at the moment.
pub fn reconstruct_moving(
    frame: &Frame,
    velocity: &[[f32; 3]],
    solid: Option<&Solid>,
    settings: &SurfaceSettings,
) -> Surface {
    if frame.position.is_empty() {
        return Surface::default();
    }
    let mut field = Field::new(frame, solid, settings);
    let (mut mesh, cuts) = triangulate(&mut field);
    let table = Table::new(frame, velocity, &field);
    let mut carried: Vec<Carried> = (0..field.keys.len())
        .into_par_iter()
        .flat_map_iter(|brick| {
            let around =
                (!cuts[brick].is_empty()).then(|| Surroundings::new(&field, &table, brick));
            let carried = |cut: &Cut| {
                around
                    .as_ref()
                    .map_or_else(Carried::default, |a| a.at(*cut))
            };
            cuts[brick].iter().map(carried).collect::<Vec<_>>()
        })
        .collect();

    let mut left_out = LeftOut::default();
    if settings.smallest_piece > 0.0 {
        let smallest = settings.smallest_piece * frame.rest_volume;
        let pieces = Pieces::new(&mesh);
        let kept;
        (kept, left_out) = leave_out(&mut mesh, &pieces, smallest);
        keep(&mut carried, &kept);
    }
    let farthest = FARTHEST * frame.spacing;
    let free = free_of(&mesh, solid, frame.spacing);
    if settings.rounds > 0 {
        let weight: Vec<f32> = (free.iter().zip(&carried))
            .map(|(free, carried)| free * smooth::weight(carried.neighbours))
            .collect();
        let pieces = Pieces::new(&mesh);
        smooth::smooth(&mut mesh, &weight, settings.rounds, &pieces, farthest);
    }
    if settings.keep_volume {
        let volume = field.points.order.len() as Real * frame.rest_volume - left_out.volume;
        let whole = Pieces::whole(&mesh);
        let weight: Vec<f32> = (free.iter().zip(&carried))
            .map(|(free, carried)| giving(*free, carried.neighbours, settings.wall_overlap))
            .collect();
        smooth::restore(&mut mesh, &weight, &whole, &[volume], farthest);
    }
    let normal = if solid.is_some() || settings.rounds > 0 || settings.keep_volume {
        mesh.vertex_normals()
    } else {
        carried.iter().map(|c| c.normal).collect()
    };
    Surface {
        mesh,
        normal,
        polymer_fraction: carried.iter().map(|c| c.polymer_fraction).collect(),
        velocity: carried.iter().map(|c| c.velocity).collect(),
        pressure: carried.iter().map(|c| c.pressure).collect(),
        shear_rate: carried.iter().map(|c| c.shear_rate).collect(),
        millilitre: carried.iter().map(|c| c.millilitre).collect(),
        left_out,
    }
}

/// The bare triangles of the colour field, neither smoothed nor with anything on their vertices.
pub fn bare(frame: &Frame, solid: Option<&Solid>, settings: &SurfaceSettings) -> TriMesh {
    triangulate(&mut Field::new(frame, solid, settings)).0
}

/// Triangles, and the cuts of each brick, one a vertex. The field's values are used up.
fn triangulate(field: &mut Field) -> (TriMesh, Vec<Vec<Cut>>) {
    let bricks = std::mem::take(&mut field.bricks);
    let cubes = Cubes {
        keys: &field.keys,
        bricks: &bricks,
        outside: field.outside,
    };
    let cuts = cubes.cuts();
    let triangles = cubes.triangles(&cuts);
    let place = |key: &[i32; 3], cut: &Cut| {
        let (node, t) = (cut.node(), Vec3::ith(cut.axis(), cut.t.into()));
        let node = Vec3::from_fn(|a, _| Real::from(key[a] * 8) + node[a] as Real);
        (node + t) * field.cube
    };
    let mut positions = Vec::with_capacity(cuts.iter().map(Vec::len).sum());
    for (key, cuts) in field.keys.iter().zip(&cuts) {
        positions.extend(cuts.iter().map(|cut| place(key, cut)));
    }
    (
        TriMesh {
            positions,
            triangles,
        },
        cuts,
    )
}

/// How freely each vertex may move [1]: not at all where it touches a wall.
fn free_of(mesh: &TriMesh, solid: Option<&Solid>, spacing: Real) -> Vec<f32> {
    // Free within a spacing, so that the rim of a contact does not show as a step.
    let free =
        |x: &Vec3| solid.map_or(1.0, |s| ((s.phi(x) / spacing - 0.25) * 1.5).clamp(0.0, 1.0));
    let positions = mesh.positions.par_iter();
    positions.map(|x| free(x) as f32).collect()
}

/// How far each vertex may go for the sake of volume [1]: the face of a body all the way, a thread half of it; where it
/// touches a wall, no farther than the wall itself and [`FARTHEST`] into it. In a narrow vessel there is little else that
/// could give way.
fn giving(free: f32, neighbours: f32, overlap: Real) -> f32 {
    let contact = (overlap.min(FARTHEST - overlap).max(0.0) / FARTHEST) as f32;
    let body = 0.5 + smooth::weight(neighbours).min(0.5);
    contact + (body - contact) * free
}

#[cfg(test)]
mod tests;
