//! What is doubtful about the meshes that a recipe names, said before an hour is spent on them.

use super::FlowError;
use crate::bone::landmarks;
use crate::fluid::Cement;
use crate::mesh::{self, MeshDistance, TriMesh};
use crate::scene::{BoneFrame, MeshFile, Region, Scene};

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
    let frame = match bone.frame {
        BoneFrame::AsIs => Some(mesh),
        // Without landmarks `voxelise` says so, with the place.
        BoneFrame::Anatomical => landmarks::find(&mesh)
            .ok()
            .map(|found| mesh.transformed(&found.to_frame())),
    };
    let Some((outer, _)) = frame.and_then(|mesh| mesh::repaired(mesh).ok()) else {
        return Ok(doubts);
    };
    let distance = MeshDistance::new(&outer);
    for inlet in &scene.sim.inlets {
        let depth = -distance.signed(&inlet.position);
        if bone.channels.is_empty() && depth > 0.0 {
            doubts.push(format!(
                "inlet \"{}\" opens {:.1} mm inside the bone, where nothing is cleared for it: give it a cannula",
                inlet.name,
                depth * 1e3
            ));
        }
    }
    Ok(doubts)
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
