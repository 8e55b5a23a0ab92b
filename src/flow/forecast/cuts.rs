//! Where the domain cuts a bone open within reach of the cement.

use super::spread::Cells;
use crate::cache;
use crate::flow::{Event, FlowError, Job, Observer};
use crate::math::Real;
use crate::mesh::{LengthUnit, MeshDistance, UpAxis, read_obj};

/// Cement that finds its way easily spreads over pores of so many times its dose.
const STRAYS: Real = 3.0;

/// Says so. A domain may well be smaller than its bone: only cuts that the cement of an inlet can get to are doubtful.
pub(super) fn warn(job: &Job, observer: &mut Observer<'_>) -> Result<(), FlowError> {
    let sim = &job.scene.sim;
    let Some(bone) = job.scene.bone.as_ref().filter(|_| !sim.inlets.is_empty()) else {
        return Ok(());
    };
    let solid = cache::read_solid(&job.folder.solid())?;
    let surface = read_obj(&job.folder.bone_mesh(), LengthUnit::Metre, UpAxis::Y)?;
    let distance = MeshDistance::new(&surface);
    let mut cells = Cells::new(sim, &solid);
    for inlet in &sim.inlets {
        let most = (STRAYS * inlet.dose / sim.spacing.powi(3)) as usize;
        let (mut count, mut cut) = (0, None);
        cells.visit(inlet, |reached| {
            count += 1;
            // Where the bone's surface is closer than a spacing, it is not the domain that ends the bone.
            if reached.at_edge && distance.signed(&reached.x) < -sim.spacing {
                cut = Some(reached);
            }
            cut.is_none() && count < most
        });
        if let Some(cut) = cut {
            let at = cut.x * 1e3;
            let note = format!(
                "the domain cuts the bone open at ({:.1}, {:.1}, {:.1}) mm, {:.1} mm on the way of the cement from inlet \
                 \"{}\": what gets there leaves the simulation inside the bone; enlarge the domain on that side",
                at.x,
                at.y,
                at.z,
                cut.way * 1e3,
                inlet.name
            );
            observer(Event::Note(&bone.file.path, &note));
        }
    }
    Ok(())
}
