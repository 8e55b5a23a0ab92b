//! Walls that move: built where they are at the start, each in files of its own.

use super::voxelise::{self, closed, write_mesh};
use super::{FlowError, Job, Observer};
use crate::cache;
use crate::math::{Aabb, Vec3};
use crate::mesh::{self, TriMesh};
use crate::scene::{MovingWall, Region};
use crate::sim::{MovingSolid, Path, SimSettings};
use crate::solid::{self, Solid};

/// Edge of the lattice on which a shape is drawn, in spacings.
const DRAWN: f64 = 0.5;

/// Builds all of them.
pub(super) fn build(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let sim = &job.scene.sim;
    for (n, mover) in job.scene.movers.iter().enumerate() {
        let (solid, drawn) = match &mover.region {
            Region::Shape(shape) => {
                let solid = Solid {
                    shapes: vec![shape.clone()],
                    grids: Vec::new(),
                };
                let bounds = shape.bounds().filter(|_| !shape.is_hollow());
                let drawn = bounds.map(|bounds| {
                    let step = DRAWN * sim.spacing;
                    mesh::surface_nets(&bounds.grown(step), step, |x| solid.phi(x))
                });
                (solid, drawn)
            }
            Region::Mesh(file) => {
                let mesh = closed(file, observer)?;
                (voxelise::mesh_solid(&mesh, sim.spacing), Some(mesh))
            }
        };
        let region = region(sim, mover, drawn.as_ref());
        let depth = voxelise::wall_depth(sim);
        let particles = solid::wall_particles(&solid, &region, sim.spacing, depth);
        cache::write_walls(&job.folder.mover_walls(n), &particles)?;
        cache::write_solid(&job.folder.mover_solid(n), &solid)?;
        write_mesh(&job.folder.mover_mesh(n), &drawn.unwrap_or_default())?;
    }
    Ok(())
}

/// Reads all of them.
pub(super) fn read(job: &Job) -> Result<Vec<MovingSolid>, FlowError> {
    let movers = job.scene.movers.iter().enumerate();
    movers
        .map(|(n, mover)| {
            Ok(MovingSolid {
                motion: mover.motion,
                solid: cache::read_solid(&job.folder.mover_solid(n))?,
                particles: cache::read_walls(&job.folder.mover_walls(n))?,
            })
        })
        .collect()
}

/// Where its particles stand at the start: all of it that can come to lie in the domain.
fn region(sim: &SimSettings, mover: &MovingWall, drawn: Option<&TriMesh>) -> Aabb {
    let support = sim.support_ratio * sim.spacing;
    let domain = &sim.domain;
    let mut region = match mover.motion.path {
        Path::Turning { point, .. } => {
            let corners = [domain.min, domain.max].map(|corner| (corner - point).abs());
            let reach = corners[0].sup(&corners[1]).norm();
            Aabb {
                min: point,
                max: point,
            }
            .grown(reach + support)
        }
        _ => domain.grown(support + mover.motion.most_shift(sim.duration)),
    };
    let own = match &mover.region {
        Region::Shape(shape) => shape.bounds(),
        Region::Mesh(_) => drawn.map(TriMesh::bounds),
    };
    if let Some(own) = own {
        region.min = region.min.sup(&(own.min - Vec3::repeat(support)));
        region.max = region.max.inf(&(own.max + Vec3::repeat(support)));
    }
    // Half-open, so that the lattice closes on itself around a periodic axis.
    for axis in (0..3).filter(|&axis| sim.periodic[axis]) {
        region.min[axis] = region.min[axis].max(domain.min[axis]);
        region.max[axis] = region.max[axis].min(domain.max[axis]);
    }
    region
}
