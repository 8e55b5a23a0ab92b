//! Meshes and shapes → `boundary/`: one signed distance, wall particles, and meshes to look at.

use super::{Event, FlowError, Job, Observer, movers};
use crate::bone::{self, landmarks};
use crate::cache;
use crate::grid::BrickGrid;
use crate::math::{Aabb, Real};
use crate::mesh::{self, TriMesh};
use crate::scene::{Bone, BoneFrame, MeshFile};
use crate::sim::SimSettings;
use crate::solid::{self, Shape, Solid};
use serde_json::json;
use std::path::Path;

/// Nodes along a spacing, for walls given as meshes.
const NODES: Real = 2.0;
/// Lattice on which the inside of a bone is drawn, in spacings.
const DRAWN: Real = 0.5;
/// It is made coarser when it would have more nodes than this.
const MOST_NODES: Real = 4e7;
/// Spacings across a throat below which the flow through it is not resolved.
const LEAST_ACROSS: Real = 3.0;
/// How much less than a support radius walls are deep, in spacings: fluid keeps off their surface.
const STANDOFF: Real = 0.4;

pub(super) fn work(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let scene = &job.scene;
    let sim = &scene.sim;
    let mut solid = Solid {
        shapes: scene.shapes.clone(),
        grids: Vec::new(),
    };
    let mut walls = TriMesh::default();
    for file in &scene.meshes {
        let mesh = closed(file, observer)?;
        solid.grids.extend(mesh_solid(&mesh, sim.spacing).grids);
        walls.append(&mesh);
    }
    if let Some(bone) = &scene.bone {
        solid.grids.push(build(job, bone, observer)?);
    }
    let mut tubes = TriMesh::default();
    for shape in &scene.shapes {
        if let Shape::Tube {
            base,
            axis,
            length,
            inner,
            outer,
        } = shape
        {
            tubes.append(&mesh::tube(base, axis, *length, *inner, *outer));
        }
    }
    for (path, mesh) in [
        (job.folder.wall_mesh(), walls),
        (job.folder.cannula_mesh(), tubes),
    ] {
        write_mesh(&path, &mesh)?;
    }

    let support = sim.support_ratio * sim.spacing;
    let mut region = sim.domain;
    for axis in (0..3).filter(|&axis| !sim.periodic[axis]) {
        region.min[axis] -= support;
        region.max[axis] += support;
    }
    let particles = solid::wall_particles(&solid, &region, sim.spacing, wall_depth(sim));
    cache::write_walls(&job.folder.walls(), &particles)?;
    cache::write_solid(&job.folder.solid(), &solid)?;
    movers::build(job, observer)
}

/// How deep wall particles stand [m].
pub(super) fn wall_depth(sim: &SimSettings) -> Real {
    (sim.support_ratio - STANDOFF) * sim.spacing
}

/// The inside of a closed mesh.
pub(super) fn mesh_solid(mesh: &TriMesh, spacing: Real) -> Solid {
    let grid = solid::mesh_grid(mesh, spacing / NODES, bone::BAND * spacing);
    Solid {
        shapes: Vec::new(),
        grids: vec![grid],
    }
}

/// The inside of the bone; its report and its meshes go to the folder.
fn build(job: &Job, bone: &Bone, observer: &mut Observer<'_>) -> Result<BrickGrid, FlowError> {
    let sim = &job.scene.sim;
    let path = &bone.file.path;
    let mut outer = closed(&bone.file, observer)?;
    let landmarks = match bone.frame {
        BoneFrame::AsIs => None,
        BoneFrame::Anatomical => {
            let found = landmarks::find(&outer);
            let landmarks = found.map_err(|source| FlowError::NoFrame {
                path: path.clone(),
                source,
            })?;
            outer = outer.transformed(&landmarks.to_frame());
            Some(landmarks)
        }
    };
    let built = bone::build(&outer, &bone.settings, sim.spacing, &bone.channels)?;
    for region in &built.report.regions {
        if region.volume > 0.0 && region.throat_in_spacings < LEAST_ACROSS {
            let note = format!(
                "throats are {:.1} spacings wide in region \"{}\": flow through them is not resolved",
                region.throat_in_spacings, region.name
            );
            observer(Event::Note(path, &note));
        }
    }
    let frame = landmarks.map(|found| {
        json!({
            "body_centre_m": found.body_centre,
            "body_radius_m": found.body_radius,
            "left": found.left,
            "posterior": found.posterior,
        })
    });
    let report = json!({ "frame": frame, "made": built.report });
    cache::write_json(&job.folder.bone_report(), &report)?;
    write_mesh(&job.folder.bone_mesh(), &outer)?;
    let inside = draw(&built.solid, &outer.bounds(), &sim.domain, sim.spacing);
    write_mesh(&job.folder.inside_mesh(), &inside)?;
    Ok(built.solid)
}

/// The surface of everything solid in a bone, where the domain is.
fn draw(solid: &BrickGrid, bone: &Aabb, domain: &Aabb, spacing: Real) -> TriMesh {
    let bounds = Aabb {
        min: bone.min.sup(&domain.min),
        max: bone.max.inf(&domain.max),
    };
    if bounds.is_empty() {
        return TriMesh::default();
    }
    let finest = libm::cbrt(bounds.extent().product() / MOST_NODES);
    let step = finest.max(DRAWN * spacing);
    mesh::surface_nets(&bounds, step, |x| solid.sample(x).0)
}

/// A mesh that encloses a volume; what had to be repaired is said.
pub(super) fn closed(file: &MeshFile, observer: &mut Observer<'_>) -> Result<TriMesh, FlowError> {
    let mut mesh = mesh::read_obj(&file.path, file.unit, file.up)?;
    for position in &mut mesh.positions {
        *position += file.at;
    }
    let (mesh, notes) = mesh::require_closed(mesh).map_err(|source| FlowError::Open {
        path: file.path.clone(),
        source,
    })?;
    for note in notes {
        observer(Event::Note(&file.path, &note.to_string()));
    }
    Ok(mesh)
}

/// For artists and for the stages that draw: y up, metres. A mesh of nothing is no file.
pub(super) fn write_mesh(path: &Path, mesh: &TriMesh) -> Result<(), FlowError> {
    if mesh.triangles.is_empty() {
        return Ok(());
    }
    let mut text = Vec::new();
    mesh::write_obj(&mut text, mesh, Some(&mesh.vertex_normals()), None)
        .map_err(FlowError::io(path))?;
    Ok(cache::write(path, &text)?)
}
