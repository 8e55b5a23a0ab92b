//! Particles for ParaView: VTK's XML format for points, with binary data behind it. Y-up, metres.

use super::{Column, y_up};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes points [m] with `columns`, one row each.
pub fn write(out: &mut impl Write, points: &[[f32; 3]], columns: &[Column]) -> io::Result<()> {
    if columns.iter().any(|column| column.rows() != points.len()) {
        let kind = io::ErrorKind::InvalidInput;
        return Err(io::Error::new(kind, "a column has not one row a point"));
    }
    let mut file = Arrays::default();
    let mut data = String::new();
    for column in columns {
        data += &match column {
            Column::Number(name, rows) => file.add(
                name,
                "Float32",
                1,
                rows.iter().flat_map(|n| n.to_le_bytes()),
            ),
            Column::Vector(name, rows) => file.add(name, "Float32", 3, turned(rows)),
            Column::Colour(rows) => file.add("colour", "UInt8", 3, rows.iter().flatten().copied()),
        };
    }
    let place = file.add("position", "Float32", 3, turned(points));
    let number = |n: usize| (n as i64).to_le_bytes();
    let connectivity = file.add(
        "connectivity",
        "Int64",
        1,
        (0..points.len()).flat_map(number),
    );
    let offsets = file.add("offsets", "Int64", 1, (1..=points.len()).flat_map(number));
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <PolyData>\n\
         <Piece NumberOfPoints=\"{0}\" NumberOfVerts=\"{0}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n\
         <PointData>\n{data}</PointData>\n<Points>\n{place}</Points>\n<Verts>\n{connectivity}{offsets}</Verts>\n\
         </Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_",
        points.len()
    )?;
    out.write_all(&file.bytes)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

fn turned(rows: &[[f32; 3]]) -> impl Iterator<Item = u8> {
    rows.iter()
        .flat_map(|row| y_up(*row))
        .flat_map(f32::to_le_bytes)
}

/// Arrays behind the text, each after its length in bytes.
#[derive(Default)]
struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    /// Appends an array; gives the line that describes it.
    fn add(
        &mut self,
        name: &str,
        kind: &str,
        width: usize,
        bytes: impl Iterator<Item = u8>,
    ) -> String {
        let offset = self.bytes.len();
        self.bytes.extend([0; 8]);
        self.bytes.extend(bytes);
        let length = (self.bytes.len() - offset - 8) as u64;
        self.bytes[offset..offset + 8].copy_from_slice(&length.to_le_bytes());
        let mut line = String::new();
        let _ = writeln!(
            line,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"appended\" offset=\"{offset}\"/>"
        );
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_lie_where_the_header_says() {
        let mut file = Vec::new();
        let velocity = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let columns = [
            Column::Vector("velocity", &velocity),
            Column::Number("pressure", &[7.0, 8.0]),
        ];
        write(&mut file, &[[0.5, 0.25, 0.125], [1.0, 2.0, 3.0]], &columns).unwrap();
        let mark = b"encoding=\"raw\">\n_";
        let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
        let text = std::str::from_utf8(&file[..start]).unwrap();
        let floats = |name: &str| -> Vec<f32> {
            let line = text
                .lines()
                .find(|l| l.contains(&format!("\"{name}\"")))
                .unwrap();
            let offset = line
                .split("offset=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap();
            let at = start + offset.parse::<usize>().unwrap();
            let length = u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
            let body = file[at + 8..at + 8 + length].as_chunks::<4>().0;
            body.iter().map(|b| f32::from_le_bytes(*b)).collect()
        };
        assert_eq!(floats("velocity"), [1.0, 3.0, -2.0, 4.0, 6.0, -5.0]);
        assert_eq!(floats("pressure"), [7.0, 8.0]);
        assert_eq!(floats("position")[..3], [0.5, 0.125, -0.25]);
        assert!(file.ends_with(b"</VTKFile>\n"));
        assert!(write(&mut file, &[], &columns).is_err());
    }
}
