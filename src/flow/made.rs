//! What is written beside a vertebra that was made: a picture from three sides, the bone section of a recipe.

use super::{FlowError, preview};
use crate::bone::Preset;
use crate::cache;
use crate::mesh::TriMesh;
use crate::preview::{
    Background, Camera, Colours, Lettering, Material, MeshLayer, PictureSettings, Scene, colour,
    render,
};
use image::{RgbImage, imageops};
use std::path::Path;

/// Edge of each of the three pictures [pixels].
const EDGE: u32 = 560;
const FIELD_OF_VIEW: f64 = 0.25;
/// Azimuth and elevation [rad]: whoever looks straight down has no upwards, so a hair less.
const SIDES: [(&str, f64, f64); 3] = [
    ("from the front", 0.0, 0.0),
    ("from the left", std::f64::consts::FRAC_PI_2, 0.0),
    ("from above", 0.0, std::f64::consts::FRAC_PI_2 - 1e-3),
];

/// Writes a picture of a mesh with z up and its back at y from the front, the left and above, at one scale.
pub fn draw_three_sides(path: &Path, mesh: &TriMesh) -> Result<(), FlowError> {
    let bytes = preview::png(path, &three_sides(mesh))?;
    Ok(cache::write(path, &bytes)?)
}

fn three_sides(mesh: &TriMesh) -> RgbImage {
    let normals = mesh.vertex_normals();
    let cameras = SIDES.map(|(_, azimuth, elevation)| {
        Camera::fitting(&mesh.positions, 1.0, azimuth, elevation, FIELD_OF_VIEW)
    });
    let away = |camera: &Camera| (camera.position - camera.target).norm();
    let farthest = cameras.iter().map(away).fold(0.0, f64::max);
    let settings = PictureSettings {
        width: EDGE,
        height: EDGE,
        samples: 9,
        background: Background::White,
    };
    let mut all = RgbImage::new(EDGE * SIDES.len() as u32, EDGE);
    for (n, (camera, (name, ..))) in cameras.iter().zip(SIDES).enumerate() {
        let back = (camera.position - camera.target) * (farthest / away(camera).max(1e-12));
        let scene = Scene {
            meshes: vec![MeshLayer {
                positions: &mesh.positions,
                triangles: &mesh.triangles,
                normals: Some(&normals),
                colours: Colours::Uniform(colour::from_srgb(colour::BONE)),
                material: Material::BONE,
                cut: None,
            }],
            spheres: &[],
            camera: Camera {
                position: camera.target + back,
                ..*camera
            },
            lettering: Lettering {
                label: Some(name.to_owned()),
                legend: None,
                scale_bar: true,
            },
        };
        let left = i64::from(EDGE) * n as i64;
        imageops::replace(&mut all, &render(&scene, &settings), left, 0);
    }
    all
}

/// Writes the bone section of a recipe for the vertebra in the file `mesh`: a state of health, by parts of the mesh.
pub fn write_bone_section(path: &Path, mesh: &str, preset: Preset) -> Result<(), FlowError> {
    // The arch carries with its cortex and loses little of what is inside.
    let arch = Preset::Healthy.region(1.0);
    let name = preset.name();
    let text = format!(
        r#"# The bone of a recipe, by the parts of the mesh; everything else is the preset's. Struts of true size need spacings
# near 0.2 mm: `scale` and longer periods make a teaching scale.
[bone]
mesh = {mesh:?}
unit = "mm"
up = "z"
frame = "anatomical"
preset = "{name}"

[[bone.region]]
name = "arch and processes"
part = "arch"
strut_period = "{:.2} mm"
porosity = {:.2}
"#,
        arch.period * 1e3,
        crate::bone::HEALTHY_POROSITY,
    );
    Ok(cache::write(path, text.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::vertebra::{self, VertebraSettings};

    /// Each of the three pictures shows bone in its middle and paper at its rim.
    #[test]
    fn a_vertebra_stands_in_all_three_pictures() {
        let settings = VertebraSettings {
            resolution: 3e-3,
            ..Default::default()
        };
        let picture = three_sides(&vertebra::make(&settings));
        assert_eq!(picture.dimensions(), (3 * EDGE, EDGE));
        let dark = |x: u32, y: u32| picture.get_pixel(x, y).0[2] < 230;
        for n in 0..3 {
            let columns = n * EDGE..(n + 1) * EDGE;
            // Below the label and above the scale bar.
            let rows = EDGE / 6..EDGE - EDGE / 6;
            let shown = |x: u32| rows.clone().filter(|y| dark(x, *y)).count();
            let widest = columns.clone().map(shown).max().unwrap_or(0);
            let across = columns.clone().filter(|x| shown(*x) > 0).count();
            assert!(widest > EDGE as usize / 4, "{n}: {widest}");
            assert!(
                (EDGE / 2..EDGE - 20).contains(&(across as u32)),
                "{n}: {across}"
            );
        }
    }
}
