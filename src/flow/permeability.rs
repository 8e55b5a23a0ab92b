//! How permeable the inside of a bone is: `permeability.json`, from the solid that voxelise left.

use super::{Event, FlowError, Job, Observer};
use crate::bone::Sample;
use crate::cache;
use crate::math::{Real, Vec3};
use crate::mesh::{LengthUnit, MeshDistance, UpAxis, read_obj};
use serde_json::json;

/// Voxels along the edge of the cube, at most.
const MOST: usize = 96;

impl Job {
    /// Lets a creeping flow through the largest cube of trabeculae around the middle of the bone's domain, along each
    /// axis; says and writes its permeability.
    pub fn measure_permeability(&self, observer: &mut Observer<'_>) -> Result<(), FlowError> {
        let Some(bone) = &self.scene.bone else {
            return Ok(());
        };
        let solid = cache::read_solid(&self.folder.solid())?;
        let Some(grid) = solid.grids.last() else {
            return Ok(());
        };
        let outer = read_obj(&self.folder.bone_mesh(), LengthUnit::Metre, UpAxis::Y)?;
        let domain = &self.scene.sim.domain;
        let bounds = outer.bounds();
        let centre = (bounds.min.sup(&domain.min) + bounds.max.inf(&domain.max)) * 0.5;
        let settings = &bone.settings;
        let shell = settings.shell_thickness.max(settings.endplate_thickness);
        let distance = MeshDistance::new(&outer);
        let (centre, depth) = deepest(&distance, centre, bounds.extent().max() * 0.1);
        // Beyond the domain nothing is built.
        let to_rim = (centre - domain.min).min().min((domain.max - centre).min());
        let half = ((depth - shell) / libm::sqrt(3.0)).min(to_rim);
        let edge = ((2.0 * half / grid.voxel) as usize).min(MOST);
        if edge < 16 {
            return Err(FlowError::Unfit {
                path: bone.file.path.clone(),
                problem: "has no room for a cube of 16 voxels inside its shell".to_owned(),
            });
        }
        let sample = Sample::cut(&centre, edge, grid.voxel, |x| grid.value(x));
        let along = [0, 1, 2].map(|axis| sample.permeability(axis));
        let told = along.map(|k| k.map_or("no steady flow".to_owned(), |k| format!("{k:.2e} m²")));
        let note = format!(
            "a cube of {:.1} mm, {:.3} open, has the permeability {} along x, {} along y, {} along z",
            edge as Real * grid.voxel * 1e3,
            sample.porosity(),
            told[0],
            told[1],
            told[2]
        );
        observer(Event::Note(&bone.file.path, &note));
        let report = json!({
            "centre_m": centre,
            "edge_m": edge as Real * grid.voxel,
            "voxel_m": grid.voxel,
            "porosity": sample.porosity(),
            "permeability_m2": along,
        });
        Ok(cache::write_json(&self.folder.permeability(), &report)?)
    }
}

/// Uphill from `x` to a point that is deepest inside, and its depth [m].
fn deepest(distance: &MeshDistance, mut x: Vec3, mut step: Real) -> (Vec3, Real) {
    let mut depth = -distance.signed(&x);
    for _ in 0..24 {
        let neighbours = (0..6).map(|k| {
            let mut y = x;
            y[k / 2] += if k % 2 == 0 { step } else { -step };
            (y, -distance.signed(&y))
        });
        match neighbours.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((y, deeper)) if deeper > depth => (x, depth) = (y, deeper),
            _ => step *= 0.5,
        }
    }
    (x, depth)
}
