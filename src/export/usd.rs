//! The take as one USD scene: `scene.usda` beside a layer a frame.
//!
//! The mesh is animated by value clips: a client that opens the scene reads a frame's layer when it shows that frame.
//! The volumes are OpenVDB files, one asset path a frame.

use super::Column;
use crate::math::{Real, Vec3};
use crate::mesh::{TriMesh, put_digits, put_number};
use std::fmt::Write as _;

/// What a take consists of.
#[derive(Clone, Copy, Debug)]
pub struct Take<'a> {
    /// Frames that there are, ascending.
    pub frames: &'a [u32],
    /// Frames a second.
    pub frames_per_second: Real,
    /// Names of the grids in the VDB files.
    pub grids: &'a [&'a str],
    /// Names of the numbers on the vertices.
    pub numbers: &'a [&'a str],
}

/// Digits behind the point that show a tenth of a micrometre.
const PLACE: u32 = 7;

/// `scene.usda`: meshes are `usd/cement.0001.usda`, volumes `vdb/cement.0001.vdb`.
pub fn scene(take: &Take) -> String {
    let (first, last) = (
        take.frames.first().unwrap_or(&0),
        take.frames.last().unwrap_or(&0),
    );
    let mut text = format!(
        "#usda 1.0\n(\n    defaultPrim = \"Take\"\n    upAxis = \"Y\"\n    metersPerUnit = 1\n\
         \x20   startTimeCode = {first}\n    endTimeCode = {last}\n    timeCodesPerSecond = {0}\n    framesPerSecond = {0}\n)\n\n\
         def Xform \"Take\"\n{{\n\
         \x20   def Mesh \"Cement\" (\n        clips = {{\n            dictionary default = {{\n\
         \x20               asset[] assetPaths = [{1}]\n\
         \x20               string primPath = \"/Cement\"\n\
         \x20               asset manifestAssetPath = @usd/manifest.usda@\n\
         \x20               double2[] active = [{2}]\n\
         \x20               double2[] times = [{3}]\n\
         \x20           }}\n        }}\n    )\n    {{\n\
         \x20       uniform token subdivisionScheme = \"none\"\n{4}    }}\n",
        take.frames_per_second,
        list(take, |_, n| format!("@usd/cement.{n:04}.usda@")),
        list(take, |i, n| format!("({n}, {i})")),
        list(take, |_, n| format!("({n}, {n})")),
        declared(take),
    );
    text += "\n    def Volume \"Volume\"\n    {\n";
    for grid in take.grids {
        let _ = writeln!(text, "        rel field:{grid} = </Take/Volume/{grid}>");
    }
    let files = list(take, |_, n| format!("{n}: @vdb/cement.{n:04}.vdb@"));
    for grid in take.grids {
        let _ = write!(
            text,
            "\n        def OpenVDBAsset \"{grid}\"\n        {{\n            token fieldName = \"{grid}\"\n\
             \x20           asset filePath.timeSamples = {{ {files} }}\n        }}\n"
        );
    }
    text + "    }\n}\n"
}

fn list(take: &Take, item: impl Fn(usize, u32) -> String) -> String {
    let items: Vec<String> = take
        .frames
        .iter()
        .enumerate()
        .map(|(i, &n)| item(i, n))
        .collect();
    items.join(", ")
}

/// `usd/manifest.usda`: what the clips animate.
pub fn manifest(take: &Take) -> String {
    format!(
        "#usda 1.0\n\ndef Mesh \"Cement\"\n{{\n{}}}\n",
        declared(take)
    )
}

/// What is animated, without values. The scene has to name it as well, or clients do not look for it.
fn declared(take: &Take) -> String {
    let vertex = " (\n            interpolation = \"vertex\"\n        )";
    let mut text = String::new();
    for (kind, said) in [
        ("point3f[] points", ""),
        ("int[] faceVertexCounts", ""),
        ("int[] faceVertexIndices", ""),
        ("float3[] extent", ""),
        ("vector3f[] velocities", ""),
        ("normal3f[] normals", vertex),
        ("color3f[] primvars:displayColor", vertex),
    ] {
        let _ = writeln!(text, "        {kind}{said}");
    }
    for name in take.numbers {
        let _ = writeln!(text, "        float[] primvars:{name}{vertex}");
    }
    text
}

/// A frame's layer. Of the columns, the vectors `normal` and `velocity`, the colours and all numbers are used.
pub fn layer(frame: u32, mesh: &TriMesh, columns: &[Column]) -> Vec<u8> {
    let mut text = b"#usda 1.0\n\ndef Mesh \"Cement\"\n{\n".to_vec();
    let sample = format!(".timeSamples = {{ {frame}: [");
    let vertex = "(\n        interpolation = \"vertex\"\n    )";
    let bounds = mesh.bounds();
    let triangles = &mesh.triangles;

    let mut array = |declared: &str, rows: &mut dyn FnMut(&mut Vec<u8>)| {
        text.extend(b"    ");
        text.extend(declared.bytes());
        text.extend(sample.bytes());
        rows(&mut text);
        text.extend(b"] }\n");
    };
    array("point3f[] points", &mut |t| {
        let rows = mesh.positions.iter().map(|p| [p.x, p.z, -p.y]);
        put_rows(t, rows, |t, row| put_tuple(t, row, PLACE));
    });
    array("int[] faceVertexCounts", &mut |t| {
        put_rows(t, triangles.iter(), |t, _| t.push(b'3'));
    });
    array("int[] faceVertexIndices", &mut |t| {
        put_rows(t, triangles.iter().flatten(), |t, v| {
            put_digits(t, (*v).into());
        });
    });
    if !bounds.is_empty() {
        let corners = [
            Vec3::new(bounds.min.x, bounds.min.z, -bounds.max.y),
            Vec3::new(bounds.max.x, bounds.max.z, -bounds.min.y),
        ];
        array("float3[] extent", &mut |t| {
            put_rows(t, corners.iter(), |t, c| {
                put_tuple(t, [c.x, c.y, c.z], PLACE);
            });
        });
    }
    let turned = |[x, y, z]: &[f32; 3]| [(*x).into(), (*z).into(), Real::from(-y)];
    for column in columns {
        match column {
            Column::Vector("normal", rows) => array("normal3f[] normals", &mut |t| {
                put_rows(t, rows.iter(), |t, row| put_tuple(t, turned(row), 4));
            }),
            Column::Vector("velocity", rows) => array("vector3f[] velocities", &mut |t| {
                put_rows(t, rows.iter(), |t, row| put_tuple(t, turned(row), PLACE));
            }),
            Column::Vector(..) => {}
            Column::Number(name, rows) => array(&format!("float[] primvars:{name}"), &mut |t| {
                put_rows(t, rows.iter(), |t, row| put_number(t, (*row).into(), 5));
            }),
            Column::Colour(rows) => array("color3f[] primvars:displayColor", &mut |t| {
                put_rows(t, rows.iter(), |t, row| put_tuple(t, row.map(linear), 4));
            }),
        }
    }
    // What is said of a primvar stands apart from its samples.
    for column in columns {
        let declared = match column {
            Column::Vector("normal", _) => "normal3f[] normals".to_owned(),
            Column::Number(name, _) => format!("float[] primvars:{name}"),
            Column::Colour(_) => "color3f[] primvars:displayColor".to_owned(),
            Column::Vector(..) => continue,
        };
        text.extend(format!("    {declared} {vertex}\n").bytes());
    }
    text.extend(b"}\n");
    text
}

/// Scenes are lit with linear colours.
fn linear(byte: u8) -> Real {
    let srgb = Real::from(byte) / 255.0;
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        libm::pow((srgb + 0.055) / 1.055, 2.4)
    }
}

fn put_rows<T>(text: &mut Vec<u8>, rows: impl Iterator<Item = T>, put: impl Fn(&mut Vec<u8>, T)) {
    for (i, row) in rows.enumerate() {
        if i > 0 {
            text.push(b',');
        }
        put(text, row);
    }
}

fn put_tuple(text: &mut Vec<u8>, row: [Real; 3], decimals: u32) {
    for (i, number) in row.into_iter().enumerate() {
        text.push(if i == 0 { b'(' } else { b',' });
        put_number(text, number, decimals);
    }
    text.push(b')');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_holds_what_its_frame_does() {
        let mesh = TriMesh {
            positions: vec![Vec3::new(1.0, 2.0, 3.0), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        let columns = [
            Column::Vector("velocity", &[[1.0, 2.0, 3.0]; 3]),
            Column::Number("pressure", &[7.5; 3]),
            Column::Colour(&[[255, 0, 0]; 3]),
        ];
        let text = String::from_utf8(layer(12, &mesh, &columns)).unwrap();
        for part in [
            "point3f[] points.timeSamples = { 12: [(1,3,-2),(1,0,0),(0,0,-1)] }",
            "faceVertexIndices.timeSamples = { 12: [0,1,2] }",
            "float3[] extent.timeSamples = { 12: [(0,0,-2),(1,3,0)] }",
            "velocities.timeSamples = { 12: [(1,3,-2),",
            "primvars:pressure.timeSamples = { 12: [7.5,7.5,7.5] }",
            "displayColor.timeSamples = { 12: [(1,0,0),",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn a_scene_ties_the_take_together() {
        let take = Take {
            frames: &[0, 1, 2],
            frames_per_second: 24.0,
            grids: &["density", "velocity"],
            numbers: &["pressure"],
        };
        let text = scene(&take);
        for part in [
            "endTimeCode = 2",
            "timeCodesPerSecond = 24",
            "active = [(0, 0), (1, 1), (2, 2)]",
            "asset filePath.timeSamples = { 0: @vdb/cement.0000.vdb@, 1: @",
            "rel field:velocity = </Take/Volume/velocity>",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(manifest(&take).contains("float[] primvars:pressure ("));
    }
}
