//! Meshes that are full of fluid at the start: their insides, each in a file of its own.

use super::bone::solid_mesh;
use super::{FlowError, Job, Observer, voxelise};
use crate::cache;
use crate::math::Aabb;
use crate::sim::{BodyShape, Inside, SimSettings};
use crate::solid::{Shape, Solid};
use std::sync::Arc;

/// Builds all of them.
pub(super) fn build(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let sim = &job.scene.sim;
    for (n, file) in job.scene.fillings.iter().enumerate() {
        let mesh = solid_mesh(file, observer)?;
        let Aabb { min, max } = mesh.bounds();
        let room = sim.domain.grown(1e-9 * sim.domain.extent().max());
        if !room.contains(&min) || !room.contains(&max) {
            let [low, high] = [min, max].map(|p| p * 1e3);
            return Err(FlowError::Unfit {
                path: file.path.clone(),
                problem: format!(
                    "reaches out of the domain, which a body must not: in the recipe it goes from ({:.2}, {:.2}, {:.2}) \
                     to ({:.2}, {:.2}, {:.2}) mm; are unit, up and at of its [body.mesh] right?",
                    low.x, low.y, low.z, high.x, high.y, high.z
                ),
            });
        }
        let mut inside = voxelise::mesh_solid(&mesh, sim.spacing);
        // Its box lies beside it: particles are spread evenly from face to face.
        let hollow = false;
        inside.shapes.push(Shape::Box { min, max, hollow });
        cache::write_solid(&job.folder.filling(n), &inside)?;
    }
    Ok(())
}

/// Reads all of them into the bodies that they are.
pub(super) fn read(job: &Job, settings: &mut SimSettings) -> Result<(), FlowError> {
    let bodies = settings.bodies.iter_mut();
    let meshes = bodies.filter_map(|body| match &mut body.shape {
        BodyShape::Mesh(inside) => Some(inside),
        _ => None,
    });
    for (n, inside) in meshes.enumerate() {
        let path = job.folder.filling(n);
        let Solid { mut shapes, grids } = cache::read_solid(&path)?;
        let bounds = shapes.pop().and_then(|shape| shape.bounds());
        let bounds = bounds.unwrap_or(settings.domain);
        let solid = Solid { shapes, grids };
        *inside = Inside(Some(Arc::new((bounds, solid))));
    }
    Ok(())
}
