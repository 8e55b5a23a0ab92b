//! OBJ out: Y-up metres unless told otherwise, unit normals, colours on vertices.

use super::decimal::{put_digits, put_number};
use super::{LengthUnit, TriMesh, UpAxis};
use crate::math::{Real, Vec3};
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
    let mut text = Text {
        out,
        buffer: Vec::with_capacity(FLUSH + 256),
    };
    for comment in style.comments {
        text.buffer
            .extend(format!("# {}\n", comment.replace('\n', " ")).bytes());
    }
    text.buffer
        .extend(format!("# unit {}\n# up {}\n", style.unit, style.up).bytes());

    // A tenth of a micrometre, whatever the unit.
    let scale = 1.0 / style.unit.metres();
    let decimals = style.unit.decimals();
    for (v, position) in mesh.positions.iter().enumerate() {
        text.line(b"v", style.up.outward(position) * scale, decimals);
        if let Some(colours) = colours {
            for channel in colours[v] {
                text.number(channel.into(), 4);
            }
        }
        text.end()?;
    }
    for normal in normals.into_iter().flatten() {
        text.line(b"vn", style.up.outward(normal), 5);
        text.end()?;
    }
    let mut groups = style.groups.iter().peekable();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        while let Some((name, _)) = groups.next_if(|(_, first)| *first <= t) {
            text.buffer.extend(format!("g {name}").bytes());
            text.end()?;
        }
        text.buffer.push(b'f');
        for v in triangle {
            let id = u64::from(*v) + 1;
            text.buffer.push(b' ');
            put_digits(&mut text.buffer, id);
            if normals.is_some() {
                text.buffer.extend(b"//");
                put_digits(&mut text.buffer, id);
            }
        }
        text.end()?;
    }
    text.out.write_all(&text.buffer)
}

const FLUSH: usize = 1 << 16;

struct Text<'a, W: Write> {
    out: &'a mut W,
    buffer: Vec<u8>,
}

impl<W: Write> Text<'_, W> {
    fn line(&mut self, keyword: &[u8], numbers: Vec3, decimals: u32) {
        self.buffer.extend(keyword);
        for &number in &numbers {
            self.number(number, decimals);
        }
    }

    fn number(&mut self, number: Real, decimals: u32) {
        self.buffer.push(b' ');
        put_number(&mut self.buffer, number, decimals);
    }

    fn end(&mut self) -> io::Result<()> {
        self.buffer.push(b'\n');
        if self.buffer.len() >= FLUSH {
            self.out.write_all(&self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
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
