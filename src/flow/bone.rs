//! The bone of a scene: its mesh in its frame, with everything that is read beside it.

use super::{Event, FlowError, Observer};
use crate::bone::landmarks::{self, Landmarks};
use crate::bone::{Place, Sources, Struts, Varying, Volume};
use crate::grid::vdb::{self, VdbGrid};
use crate::mesh::{self, MeshDistance, Painted, TriMesh};
use crate::scene::{Bone, BoneFrame, MeshFile, VolumeFile, VolumeMeaning};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Closed pieces of a bone's surface that enclose less than this of its volume [1] are noise of a scan: of a vertebra,
/// balls 6 mm across. As bone, isles would hang in the air, and bubbles would get a cortex in the midst of the struts.
const CRUMB: f64 = 2e-3;

/// A mesh that encloses a volume; what had to be repaired is said.
pub(super) fn solid_mesh(
    file: &MeshFile,
    observer: &mut Observer<'_>,
) -> Result<TriMesh, FlowError> {
    let mut mesh = mesh::read_obj(&file.path, file.unit, file.up)?;
    for position in &mut mesh.positions {
        *position += file.at;
    }
    let (mesh, notes) = mesh::repaired(mesh).map_err(|source| FlowError::Open {
        path: file.path.clone(),
        source,
    })?;
    for note in notes {
        observer(Event::Note(&file.path, &note.to_string()));
    }
    Ok(mesh)
}

/// What was read of a bone, in the frame of the recipe.
pub(super) struct Read {
    /// The outer surface.
    pub(super) outer: TriMesh,
    /// The distance to it.
    pub(super) distance: MeshDistance,
    /// Where the frame lies in the file's.
    pub(super) landmarks: Option<Landmarks>,
    /// What else is known.
    pub(super) sources: Sources,
}

/// Reads a bone and what is told beside its mesh.
pub(super) fn read(bone: &Bone, observer: &mut Observer<'_>) -> Result<Read, FlowError> {
    let (mut outer, crumbs) = mesh::without_crumbs(solid_mesh(&bone.file, observer)?, CRUMB);
    if crumbs.isles + crumbs.bubbles > 0 {
        observer(Event::Note(&bone.file.path, &crumbs.to_string()));
    }
    let mut distance = MeshDistance::new(&outer);
    let landmarks = match bone.frame {
        BoneFrame::AsIs => None,
        BoneFrame::Anatomical => {
            let found = landmarks::find(&outer, &distance);
            Some(found.map_err(|source| FlowError::NoFrame {
                path: bone.file.path.clone(),
                source,
            })?)
        }
    };
    let to_frame = landmarks.map_or(Isometry3::identity(), |l| l.to_frame());
    if landmarks.is_some() {
        outer = outer.transformed(&to_frame);
        distance = distance.transformed(&to_frame);
    }
    // Paint, parts and volume go where the mesh goes.
    let from_file = to_frame * Translation3::from(bone.file.at);
    let sources = Sources {
        surface: surface(bone, &from_file)?,
        volume: match &bone.volume {
            Some(file) => Some(volume(file, &from_file, &outer, observer)?),
            None => None,
        },
    };
    Ok(Read {
        outer,
        distance,
        landmarks,
        sources,
    })
}

/// Paint and parts of the mesh, if a region asks for them.
fn surface(
    bone: &Bone,
    from_file: &Isometry3<f64>,
) -> Result<Option<(Painted, MeshDistance)>, FlowError> {
    let file = &bone.file;
    let painted = |struts: &Struts| matches!(struts, Struts::Varying(Varying::Painted { .. }));
    let regions = &bone.settings.regions;
    let wants_paint = regions.iter().any(|region| painted(&region.struts));
    let wants_parts = regions
        .iter()
        .any(|region| matches!(region.place, Place::Part(_)));
    if !wants_paint && !wants_parts {
        return Ok(None);
    }
    let text = std::fs::read(&file.path).map_err(FlowError::io(&file.path))?;
    let mut painted = Painted::parse(&text, file.unit, file.up);
    let refuse = |problem: String| FlowError::Unfit {
        path: file.path.clone(),
        problem,
    };
    if wants_paint && !painted.coloured {
        return Err(refuse(
            "has no vertex colours (`v x y z r g b`), and a region is `painted`".to_owned(),
        ));
    }
    let mut number = vec![u32::MAX; painted.names.len()];
    for (n, name) in bone.parts.iter().enumerate() {
        let Some(at) = painted.part_named(name) else {
            let known = painted.names.join(", ");
            return Err(refuse(format!(
                "has no group or material \"{name}\" (there are: {known})"
            )));
        };
        number[at as usize] = n as u32;
    }
    for part in &mut painted.part {
        *part = number[*part as usize];
    }
    painted.mesh = painted.mesh.transformed(from_file);
    let distance = MeshDistance::new(&painted.mesh);
    Ok(Some((painted, distance)))
}

fn volume(
    file: &VolumeFile,
    from_mesh: &Isometry3<f64>,
    bone: &TriMesh,
    observer: &mut Observer<'_>,
) -> Result<Volume, FlowError> {
    let read = vdb::read_vdb(&file.path)?;
    let names: Vec<&str> = read.grids.iter().map(|grid| grid.name.as_str()).collect();
    let at = match &file.grid {
        Some(name) => names.iter().position(|given| given == name),
        None => Some(0),
    };
    let Some(at) = at else {
        return Err(FlowError::Unfit {
            path: file.path.clone(),
            problem: format!(
                "has no grid \"{}\" (there are: {})",
                file.grid.as_deref().unwrap_or(""),
                names.join(", ")
            ),
        });
    };
    let grid: VdbGrid = read.grids.into_iter().nth(at).expect("found above");
    // The file's axes turned to z up, then moved as the mesh.
    let turn = file.up.inward_turn();
    let from_file =
        from_mesh * Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from(turn));
    let volume = Volume {
        metres: file.unit.metres(),
        back: from_file.inverse(),
        of_bone: file.holds == VolumeMeaning::BoneFraction,
        grid,
    };
    let share = volume.covers(bone);
    if share < 0.9 {
        let note = format!(
            "covers {:.0} % of the bone's mesh: outside it the greatest porosity is taken; \
             are unit, up axis and position those of the mesh?",
            share * 100.0
        );
        observer(Event::Note(&file.path, &note));
    }
    Ok(volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::{BoneSettings, Region};
    use crate::math::Vec3;
    use crate::mesh::{LengthUnit, UpAxis};

    /// A block that is black in front and white at the back, read where it is and put elsewhere: the same is asked of
    /// the same place of the bone.
    #[test]
    fn paint_moves_with_the_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("block.obj");
        let corners = (0..8).map(|corner| {
            let [x, y, z] = [corner & 1, corner >> 1 & 1, corner >> 2];
            format!("v {} {} {} {y} {y} {y}\n", 20 * x, 14 * y, 16 * z)
        });
        let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        std::fs::write(&path, corners.collect::<String>() + faces).unwrap();
        let struts = Struts::Varying(Varying::Painted {
            black: 0.7,
            white: 0.9,
        });
        let read_at = |at: Vec3| {
            let bone = Bone {
                file: MeshFile {
                    path: path.clone(),
                    unit: LengthUnit::Millimetre,
                    up: UpAxis::Z,
                    at,
                },
                frame: BoneFrame::AsIs,
                settings: BoneSettings {
                    regions: vec![Region {
                        name: "painted".into(),
                        place: Place::Everywhere,
                        period: 2e-3,
                        struts,
                        lost: 0.0,
                    }],
                    ..Default::default()
                },
                channels: Vec::new(),
                parts: Vec::new(),
                volume: None,
            };
            read(&bone, &mut |_| {}).unwrap()
        };
        let at = Vec3::new(0.3, -0.02, 0.011);
        let (here, there) = (read_at(Vec3::zeros()), read_at(at));
        assert!((there.outer.bounds().min - at).norm() < 1e-12);
        for (y, expected) in [(0.1e-3, 0.7), (7e-3, 0.8), (13.9e-3, 0.9)] {
            let x = Vec3::new(1e-3, y, 8e-3);
            let asked = here.sources.asked(&struts, &x).unwrap();
            assert!((asked - expected).abs() < 2e-3, "{asked} {expected}");
            let moved = there.sources.asked(&struts, &(x + at)).unwrap();
            assert!((moved - asked).abs() < 1e-9, "{moved} {asked}");
        }
    }
}
