//! What is doubtful about the meshes that a recipe names, said before an hour is spent on them.

use super::FlowError;
use crate::bone::landmarks;
use crate::fluid::Cement;
use crate::mesh::{self, MeshDistance, TriMesh};
use crate::scene::{Bone, BoneFrame, MeshFile, Region, Scene};
use crate::sim::Inlet;
use nalgebra::{Isometry3, Point3};

/// Bones, syringes and tanks are longer than this and shorter than that [m].
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 2e-3..=0.5;

/// One sentence for each doubt.
pub fn doubts(scene: &Scene) -> Result<Vec<String>, FlowError> {
    let mut doubts = outside_the_paper(&scene.sim.cement);
    let movers = scene.movers.iter().filter_map(|mover| match &mover.region {
        Region::Mesh(file) => Some(file),
        Region::Shape(_) => None,
    });
    for file in scene.meshes.iter().chain(&scene.fillings).chain(movers) {
        let mesh = read(file)?;
        doubts.extend(size(file, &mesh));
    }
    let Some(bone) = &scene.bone else {
        return Ok(doubts);
    };
    let mesh = read(&bone.file)?;
    doubts.extend(size(&bone.file, &mesh));
    if bone.channels.is_empty() {
        doubts.extend(buried(scene, bone, mesh));
    }
    Ok(doubts)
}

/// Inlets inside the bone, where nothing is cleared for them.
fn buried(scene: &Scene, bone: &Bone, mesh: TriMesh) -> Vec<String> {
    // What cannot be repaired or has no landmarks, `voxelise` says, with the place.
    let Ok((outer, _)) = mesh::repaired(mesh) else {
        return Vec::new();
    };
    let distance = MeshDistance::new(&outer);
    let to_frame = match bone.frame {
        BoneFrame::AsIs => Some(Isometry3::identity()),
        BoneFrame::Anatomical => landmarks::find(&outer, &distance)
            .ok()
            .map(|l| l.to_frame()),
    };
    let Some(from_frame) = to_frame.map(|motion| motion.inverse()) else {
        return Vec::new();
    };
    let depth = |inlet: &Inlet| {
        let place = from_frame.transform_point(&Point3::from(inlet.position));
        -distance.signed(&place.coords)
    };
    let inlets = scene.sim.inlets.iter().filter(|inlet| depth(inlet) > 0.0);
    inlets
        .map(|inlet| {
            format!(
                "inlet \"{}\" opens {:.1} mm inside the bone, where nothing is cleared for it: give it a cannula",
                inlet.name,
                depth(inlet) * 1e3
            )
        })
        .collect()
}

/// Material constants beyond those that [IMM-CT] (Table I) was tried with.
fn outside_the_paper(cement: &Cement) -> Vec<String> {
    let constants = [
        ("relaxation_time", cement.relaxation_time, "s"),
        ("thinning", cement.thinning, "1/s"),
        ("diffusion", cement.diffusion, "m2/s"),
    ];
    constants
        .into_iter()
        .filter(|(_, value, _)| !(0.0..=1.0).contains(value))
        .map(|(name, value, unit)| {
            format!("cement.{name} = {value} {unit} lies outside what the method was published for, 0 to 1 {unit}")
        })
        .collect()
}

fn read(file: &MeshFile) -> Result<TriMesh, FlowError> {
    Ok(mesh::read_obj(&file.path, file.unit, file.up)?)
}

fn size(file: &MeshFile, mesh: &TriMesh) -> Option<String> {
    let longest = mesh.bounds().extent().max();
    (!PLAUSIBLE.contains(&longest)).then(|| {
        format!(
            "{} is {longest:.3} m long with unit = \"{}\": is that meant?",
            file.path.display(),
            file.unit
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::scene;
    use std::path::Path;

    fn doubts(set: &[&str]) -> Vec<String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline/vertebra.toml");
        let sets: Vec<String> = set.iter().map(ToString::to_string).collect();
        let (_, scene) = scene::load(&path, &sets).unwrap();
        super::doubts(&scene).unwrap()
    }

    #[test]
    fn a_vertebra_of_many_metres_and_a_buried_inlet_are_doubted() {
        assert!(doubts(&[]).is_empty());
        let slow = doubts(&["cement.relaxation_time=3 s"]);
        assert!(
            slow.len() == 1 && slow[0].contains("relaxation_time = 3 s"),
            "{slow:?}"
        );
        let huge = doubts(&["bone.unit=m"]);
        assert!(huge[0].contains("m long"), "{huge:?}");
        let open = scene_without_cannula();
        assert!(open[0].contains("left pedicle"), "{open:?}");
    }

    /// The main job with its cannula taken away.
    fn scene_without_cannula() -> Vec<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
        let text = include_str!("../../pipeline/vertebra.toml");
        let lines = text.lines().filter(|line| !line.starts_with("cannula"));
        let text: Vec<&str> = lines.collect();
        let (_, scene) = scene::read("r.toml", &text.join("\n"), &folder, &[]).unwrap();
        super::doubts(&scene).unwrap()
    }
}
