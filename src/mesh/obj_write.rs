//! OBJ out: Y-up metres unless told otherwise, unit normals, colours on vertices.

use super::decimal::{put_digits, put_number};
use super::{LengthUnit, TriMesh, UpAxis};
use crate::math::{Real, Vec3};
use rayon::prelude::*;
use std::io::{self, Write};

/// How an OBJ file is written.
#[derive(Clone, Debug)]
pub struct ObjStyle<'a> {
    /// Unit of the coordinates.
    pub unit: LengthUnit,
    /// Vertical axis of the file.
    pub up: UpAxis,
    /// Lines that go on top, each behind a `#`.
    pub comments: &'a [&'a str],
    /// Names of groups and the first triangle of each, ascending.
    pub groups: &'a [(&'a str, usize)],
}

impl Default for ObjStyle<'_> {
    fn default() -> Self {
        Self {
            unit: LengthUnit::Metre,
            up: UpAxis::Y,
            comments: &[],
            groups: &[],
        }
    }
}

/// Writes `mesh` Y-up in metres; `normals` (unit) and `colours` (sRGB, 0 to 1) are one a vertex.
pub fn write_obj(
    out: &mut impl Write,
    mesh: &TriMesh,
    normals: Option<&[Vec3]>,
    colours: Option<&[[f32; 3]]>,
) -> io::Result<()> {
    write_obj_with(out, &ObjStyle::default(), mesh, normals, colours)
}

/// Writes `mesh` in the given style.
pub fn write_obj_with(
    out: &mut impl Write,
    style: &ObjStyle,
    mesh: &TriMesh,
    normals: Option<&[Vec3]>,
    colours: Option<&[[f32; 3]]>,
) -> io::Result<()> {
    for comment in style.comments {
        writeln!(out, "# {}", comment.replace('\n', " "))?;
    }
    write!(out, "# unit {}\n# up {}\n", style.unit, style.up)?;

    // A tenth of a micrometre, whatever the unit.
    let scale = 1.0 / style.unit.metres();
    let decimals = style.unit.decimals();
    lines(out, mesh.positions.len(), |text, v| {
        text.push(b'v');
        let position = style.up.outward(&mesh.positions[v]) * scale;
        numbers(text, &position, decimals);
        if let Some(colours) = colours {
            numbers(text, &Vec3::from(colours[v].map(Real::from)), 4);
        }
    })?;
    let normals_or_none = normals.unwrap_or_default();
    lines(out, normals_or_none.len(), |text, v| {
        text.extend(b"vn");
        numbers(text, &style.up.outward(&normals_or_none[v]), 5);
    })?;
    lines(out, mesh.triangles.len(), |text, t| {
        let first = style.groups.partition_point(|(_, first)| *first < t);
        let groups = style.groups[first..].iter();
        for (name, _) in groups.take_while(|(_, first)| *first == t) {
            text.extend(format!("g {name}\n").bytes());
        }
        text.push(b'f');
        for v in mesh.triangles[t] {
            let id = u64::from(v) + 1;
            text.push(b' ');
            put_digits(text, id);
            if normals.is_some() {
                text.extend(b"//");
                put_digits(text, id);
            }
        }
    })
}

/// Lines that are made by one thread at a time.
const RUN: usize = 1 << 14;
/// Runs of lines that are in memory at once.
const AT_ONCE: usize = 16;

/// Writes `count` lines in order, made in parallel.
fn lines(
    out: &mut impl Write,
    count: usize,
    line: impl Fn(&mut Vec<u8>, usize) + Sync,
) -> io::Result<()> {
    let runs: Vec<usize> = (0..count).step_by(RUN).collect();
    for some in runs.chunks(AT_ONCE) {
        let texts: Vec<Vec<u8>> = some
            .par_iter()
            .map(|&first| {
                let mut text = Vec::new();
                for i in first..count.min(first + RUN) {
                    line(&mut text, i);
                    text.push(b'\n');
                }
                text
            })
            .collect();
        for text in texts {
            out.write_all(&text)?;
        }
    }
    Ok(())
}

fn numbers(text: &mut Vec<u8>, numbers: &Vec3, decimals: u32) {
    for &number in numbers {
        text.push(b' ');
        put_number(text, number, decimals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{parse_obj, tests::torus};

    #[test]
    fn what_is_written_is_read_back() {
        let mesh = torus(0.0213, 0.0054, 30, 20);
        let normals = mesh.vertex_normals();
        let colours = vec![[0.25, 0.5, 1.0]; mesh.positions.len()];
        for style in [
            ObjStyle::default(),
            ObjStyle {
                groups: &[],
                unit: LengthUnit::Millimetre,
                up: UpAxis::Z,
                comments: &["made by a test"],
            },
        ] {
            let mut text = Vec::new();
            write_obj_with(&mut text, &style, &mesh, Some(&normals), Some(&colours)).unwrap();
            let back = parse_obj(&text, "t.obj", style.unit, style.up).unwrap();
            assert_eq!(back.triangles.len(), mesh.triangles.len());
            assert!((back.signed_volume() / mesh.signed_volume() - 1.0).abs() < 1e-4);
            let bounds = (back.bounds(), mesh.bounds());
            assert!((bounds.0.max - bounds.1.max).norm() < 2e-7);
        }
    }

    #[test]
    fn file_is_y_up_metres_with_short_numbers() {
        let mesh = TriMesh {
            positions: vec![
                Vec3::new(1.0, 2.0, 3.0),
                Vec3::new(-0.5, 1e-9, -1e-9),
                Vec3::new(0.0, 0.25, 1e12),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let mut text = Vec::new();
        write_obj(
            &mut text,
            &mesh,
            Some(&[Vec3::z(); 3]),
            Some(&[[1.0, 0.5, 0.0]; 3]),
        )
        .unwrap();
        let text = String::from_utf8(text).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0..2], ["# unit m", "# up y"]);
        assert_eq!(lines[2], "v 1 3 -2 1 0.5 0");
        assert_eq!(lines[3], "v -0.5 0 0 1 0.5 0");
        assert_eq!(lines[5], "vn 0 1 0");
        assert_eq!(lines[8], "f 1//1 2//2 3//3");
    }
}
