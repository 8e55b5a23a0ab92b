//! How permeable the inside of a bone is: `permeability.json`, from the bone that voxelise built.

use super::{Event, FlowError, Job, Observer, bone as read};
use crate::bone::{self, BoneReport, Sample, landmarks};
use crate::cache;
use crate::math::{Aabb, Real};
use serde::Deserialize;
use serde_json::json;

/// Voxels along the edge of the cube, at most.
const MOST: usize = 96;
/// Voxels across the thinnest struts.
const ACROSS_STRUT: Real = 3.0;

#[derive(Deserialize)]
struct BoneFile {
    made: BoneReport,
}

impl Job {
    /// Lets a creeping flow through a cube of trabeculae around the middle of the bone's domain, along each axis;
    /// says and writes its permeability. The cube is built anew, as fine as its struts ask, whatever the spacing.
    pub fn measure_permeability(&self, observer: &mut Observer<'_>) -> Result<(), FlowError> {
        let Some(bone) = &self.scene.bone else {
            return Ok(());
        };
        let sim = &self.scene.sim;
        let path = self.folder.bone_report();
        let text = std::fs::read(&path).map_err(FlowError::io(&path))?;
        let refuse = |path: &std::path::Path, problem: String| FlowError::Unfit {
            path: path.to_path_buf(),
            problem,
        };
        let file: BoneFile = serde_json::from_slice(&text)
            .map_err(|error| refuse(&path, format!("is no report of a bone: {error}")))?;
        let built = file.made.regions.iter().filter(|r| r.volume > 0.0);
        let struts = built.map(|region| region.strut_diameter);
        let thinnest = struts.filter(|d| *d > 0.0).fold(Real::INFINITY, Real::min);
        let coarsest = sim.spacing / bone.settings.nodes_per_spacing;
        let voxel = coarsest.min(thinnest / ACROSS_STRUT);

        let read::Read {
            outer,
            distance,
            sources,
            ..
        } = read::read(bone, &mut |_| {})?;
        let domain = &sim.domain;
        let bounds = outer.bounds();
        let middle = (bounds.min.sup(&domain.min) + bounds.max.inf(&domain.max)) * 0.5;
        let (centre, depth) =
            landmarks::deepest_near(&distance, middle, bounds.extent().max() * 0.1);
        let mut settings = bone.settings.clone();
        let shell = settings.shell_thickness.max(settings.endplate_thickness);
        let half = (depth - shell) / libm::sqrt(3.0);
        let edge = ((2.0 * half / voxel).max(0.0) as usize).min(MOST);
        if edge < 16 {
            return Err(refuse(
                &bone.file.path,
                "has no room for a cube of 16 voxels inside its shell".to_owned(),
            ));
        }
        settings.nodes_per_spacing = sim.spacing / voxel;
        let point = Aabb {
            min: centre,
            max: centre,
        };
        settings.within = Some(point.grown(0.5 * edge as Real * voxel));
        let cube = bone::build(
            &outer,
            &distance,
            &settings,
            &sources,
            sim.spacing,
            &bone.channels,
        )?;
        let sample = Sample::cut(&centre, edge, voxel, |x| cube.solid.value(x));
        let along = [0, 1, 2].map(|axis| sample.permeability(axis));
        let told = along.map(|k| k.map_or("no steady flow".to_owned(), |k| format!("{k:.2e} m²")));
        let note = format!(
            "a cube of {:.1} mm, {:.3} open, has the permeability {} along x, {} along y, {} along z",
            edge as Real * voxel * 1e3,
            sample.porosity(),
            told[0],
            told[1],
            told[2]
        );
        observer(Event::Note(&bone.file.path, &note));
        let report = json!({
            "centre_m": centre,
            "edge_m": edge as Real * voxel,
            "voxel_m": voxel,
            "porosity": sample.porosity(),
            "permeability_m2": along,
        });
        Ok(cache::write_json(&self.folder.permeability(), &report)?)
    }
}
