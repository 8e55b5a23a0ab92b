//! Meshes and shapes → `boundary/`: one signed distance, wall particles, and meshes to look at.

use super::bone as read;
use super::{Event, FlowError, Job, Observer, fillings, movers, slices, throats};
use crate::bone;
use crate::cache;
use crate::grid::BrickGrid;
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{self, TriMesh};
use crate::scene::Bone;
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
/// Larger meshes are written without normals.
const MOST_WITH_NORMALS: usize = 500_000;
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
        let mesh = read::solid_mesh(file, observer)?;
        solid.grids.extend(mesh_solid(&mesh, sim.spacing).grids);
        walls.append(&mesh);
    }
    let mut built = None;
    if let Some(bone) = &scene.bone {
        let (grid, outer) = build(job, bone, observer)?;
        solid.grids.push(grid);
        built = Some((bone, outer));
    }
    let mut tubes = TriMesh::default();
    for tube in &scene.tubes {
        if let Shape::Tube {
            base,
            axis,
            length,
            inner,
            outer,
        } = tube
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
    let fill = || -> Result<(), FlowError> {
        let particles = solid::wall_particles(&solid, &region, sim.spacing, wall_depth(sim));
        cache::write_walls(&job.folder.walls(), &particles)?;
        Ok(cache::write_solid(&job.folder.solid(), &solid)?)
    };
    let picture = || match (&built, solid.grids.last()) {
        (Some((bone, outer)), Some(grid)) => picture(job, bone, outer, grid),
        _ => Ok(()),
    };
    // Neither needs the other, and both are one thread's work in parts.
    let (filled, pictured) = rayon::join(fill, picture);
    filled.and(pictured)?;
    fillings::build(job, observer)?;
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

/// What of a bone no particle can touch is not built.
fn touched(sim: &SimSettings) -> Aabb {
    sim.domain.grown((sim.support_ratio + 1.0) * sim.spacing)
}

/// The inside of the bone and its outer surface; its report goes to the folder.
fn build(
    job: &Job,
    bone: &Bone,
    observer: &mut Observer<'_>,
) -> Result<(BrickGrid, TriMesh), FlowError> {
    let sim = &job.scene.sim;
    let path = &bone.file.path;
    let read::Read {
        outer,
        distance,
        landmarks,
        sources,
    } = read::read(bone, observer)?;
    let mut settings = bone.settings.clone();
    settings.within = Some(touched(sim));
    let built = bone::build(
        &outer,
        &distance,
        &settings,
        &sources,
        sim.spacing,
        &bone.channels,
    )?;
    for region in &built.report.regions {
        if region.volume > 0.0 && region.throat_in_spacings < bone::ACROSS {
            let note = format!(
                "throats are {:.1} spacings wide in region \"{}\": flow through them is not resolved; \
                 a spacing of {:.2} mm would resolve it",
                region.throat_in_spacings,
                region.name,
                region.resolving_spacing * 1e3
            );
            observer(Event::Note(path, &note));
        }
    }
    observer(Event::Bone(path, &built.report));
    let note = format!(
        "{:.2} % of the struts and {:.2} % of the pores hang together",
        built.report.struts_connected * 100.0,
        built.report.pores_connected * 100.0
    );
    observer(Event::Note(path, &note));
    let cut = format!("{:.2} %", built.report.struts_cut * 100.0);
    if cut != "0.00 %" {
        let note =
            format!("{cut} of the struts may hang together beyond the domain, which cuts them off");
        observer(Event::Note(path, &note));
    }
    let reached = |ball| built.report.reached(ball) * 100.0;
    let note = format!(
        "from {}, particles reach {:.1} % of the pores; {:.1} % on ways that are resolved, {} spacings wide",
        if bone.channels.is_empty() {
            "the largest pore"
        } else {
            "the bores"
        },
        reached(1.0),
        reached(bone::ACROSS),
        bone::ACROSS
    );
    observer(Event::Note(path, &note));
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
    let throats = throats::plot(&built.report, sim.spacing).to_png();
    cache::write(&job.folder.bone_throats(), &throats)?;
    Ok((built.solid, outer))
}

/// Slices and meshes of a bone, to look at.
fn picture(job: &Job, bone: &Bone, outer: &TriMesh, solid: &BrickGrid) -> Result<(), FlowError> {
    let sim = &job.scene.sim;
    let tip = bone.channels.first().map(|c| c.base + c.axis * c.length);
    let through = tip.unwrap_or_else(|| outer.bounds().centre());
    let picture = slices::draw(solid, outer, &touched(sim), &through, sim.spacing);
    slices::write(&job.folder.bone_slices(), &picture)?;
    write_mesh(&job.folder.bone_mesh(), outer)?;
    let inside = draw(solid, &outer.bounds(), &sim.domain, sim.spacing);
    write_mesh(&job.folder.inside_mesh(), &inside)
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
    let along = |from: &Vec3, to: &Vec3| {
        let row = solid.patch(from, to);
        move |x: &Vec3| row.value([0, 1, 2].map(|axis| row.between(axis, x[axis])))
    };
    mesh::surface_nets_of(&bounds, step, along, |x| solid.sample(x))
}

/// For artists and for the stages that draw: y up, metres. A mesh of nothing is no file.
pub(super) fn write_mesh(path: &Path, mesh: &TriMesh) -> Result<(), FlowError> {
    if mesh.triangles.is_empty() {
        return Ok(());
    }
    let mut text = Vec::new();
    // Normals would make the largest mesh twice as long, and who draws it finds them.
    let normals = (mesh.triangles.len() < MOST_WITH_NORMALS).then(|| mesh.vertex_normals());
    mesh::write_obj(&mut text, mesh, normals.as_deref(), None).map_err(FlowError::io(path))?;
    Ok(cache::write(path, &text)?)
}
