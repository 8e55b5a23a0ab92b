//! Binary PLY: a surface with everything that its vertices carry. Y-up, metres.

use super::y_up;
use crate::mesh::TriMesh;
use std::io::{self, Write};

/// Bytes that are gathered before they are written.
const BUFFER: usize = 1 << 20;

/// Numbers on vertices or points, one row each.
#[derive(Clone, Copy, Debug)]
pub enum Column<'a> {
    /// One number a row.
    Number(&'a str, &'a [f32]),
    /// Vectors that turn with the axes of the file, such as velocities.
    Vector(&'a str, &'a [[f32; 3]]),
    /// sRGB colours from 0 to 255.
    Colour(&'a [[u8; 3]]),
}

impl Column<'_> {
    pub(super) fn rows(&self) -> usize {
        match self {
            Self::Number(_, rows) => rows.len(),
            Self::Vector(_, rows) => rows.len(),
            Self::Colour(rows) => rows.len(),
        }
    }

    fn describe(&self) -> String {
        let properties = |kind: &str, names: &[String]| -> String {
            let lines: Vec<String> = names
                .iter()
                .map(|name| format!("property {kind} {name}\n"))
                .collect();
            lines.concat()
        };
        match self {
            Self::Number(name, _) => properties("float", &[(*name).to_owned()]),
            Self::Vector("normal", _) => properties("float", &["nx", "ny", "nz"].map(String::from)),
            Self::Vector(name, _) => properties(
                "float",
                &["x", "y", "z"].map(|axis| format!("{name}_{axis}")),
            ),
            Self::Colour(_) => properties("uchar", &["red", "green", "blue"].map(String::from)),
        }
    }

    fn put(&self, row: usize, out: &mut Vec<u8>) {
        match self {
            Self::Number(_, rows) => out.extend(rows[row].to_le_bytes()),
            Self::Vector(_, rows) => {
                out.extend(y_up(rows[row]).map(f32::to_le_bytes).as_flattened());
            }
            Self::Colour(rows) => out.extend(rows[row]),
        }
    }
}

/// Writes `mesh` with `columns`, whose rows are its vertices. The vector `normal` becomes `nx ny nz`; a vector `v`
/// becomes `v_x v_y v_z`.
pub fn write(out: &mut impl Write, mesh: &TriMesh, columns: &[Column]) -> io::Result<()> {
    let vertices = mesh.positions.len();
    if columns.iter().any(|column| column.rows() != vertices) {
        let kind = io::ErrorKind::InvalidInput;
        return Err(io::Error::new(kind, "a column has not one row a vertex"));
    }
    let columns_said: String = columns.iter().map(Column::describe).collect();
    let mut bytes = Vec::with_capacity(BUFFER + 1024);
    bytes.extend(
        format!(
            "ply\nformat binary_little_endian 1.0\ncomment osteoflow, metres, y up\nelement vertex {vertices}\n\
             property float x\nproperty float y\nproperty float z\n{columns_said}\
             element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
            mesh.triangles.len(),
        )
        .bytes(),
    );
    for (v, position) in mesh.positions.iter().enumerate() {
        let place = y_up([position.x as f32, position.y as f32, position.z as f32]);
        bytes.extend(place.map(f32::to_le_bytes).as_flattened());
        for column in columns {
            column.put(v, &mut bytes);
        }
        flush(out, &mut bytes, BUFFER)?;
    }
    for triangle in &mesh.triangles {
        let mut face = [3_u8; 13];
        face[1..].copy_from_slice(triangle.map(u32::to_le_bytes).as_flattened());
        bytes.extend(face);
        flush(out, &mut bytes, BUFFER)?;
    }
    flush(out, &mut bytes, 0)
}

fn flush(out: &mut impl Write, bytes: &mut Vec<u8>, above: usize) -> io::Result<()> {
    if bytes.len() >= above {
        out.write_all(bytes)?;
        bytes.clear();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn a_triangle_comes_out_byte_by_byte() {
        let mesh = TriMesh {
            positions: vec![Vec3::new(1.0, 2.0, 3.0), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        let velocity = [[4.0, 5.0, 6.0]; 3];
        let columns = [
            Column::Vector("velocity", &velocity),
            Column::Number("pressure", &[7.0; 3]),
            Column::Colour(&[[8, 9, 10]; 3]),
        ];
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh, &columns).unwrap();
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..body]).unwrap();
        assert!(header.contains("element vertex 3\nproperty float x"));
        assert!(header.contains("velocity_z\nproperty float pressure\nproperty uchar red\n"));
        let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let row: Vec<f32> = (0..7).map(|k| number(body + 4 * k)).collect();
        assert_eq!(row, [1.0, 3.0, -2.0, 4.0, 6.0, -5.0, 7.0]);
        assert_eq!(bytes[body + 28..body + 31], [8, 9, 10]);
        assert_eq!(bytes.len(), body + 3 * 31 + 13);
        assert_eq!(bytes[body + 93], 3);
        assert!(write(&mut bytes, &mesh, &[Column::Number("short", &[1.0])]).is_err());
    }
}
