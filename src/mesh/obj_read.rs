//! OBJ in: positions and faces, any unit, either up axis; says the line of whatever is wrong.
//!
//! Texture coordinates and normals are passed over: two faces are neighbours when they share positions, whatever
//! normals they carry.

use super::TriMesh;
use crate::math::{Real, Vec3};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Unit of the coordinates in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LengthUnit {
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
}

impl LengthUnit {
    /// Metres per unit.
    pub fn metres(self) -> Real {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
        }
    }

    /// Decimals that show a tenth of a micrometre.
    pub(super) fn decimals(self) -> u32 {
        match self {
            Self::Metre => 7,
            Self::Centimetre => 5,
            Self::Millimetre => 4,
        }
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
        })
    }
}

/// Vertical axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// As artists' tools have it.
    Y,
    /// As inside this program.
    Z,
}

impl UpAxis {
    /// From the file's axes to ours.
    fn inward(self, p: &Vec3) -> Vec3 {
        match self {
            Self::Y => Vec3::new(p.x, -p.z, p.y),
            Self::Z => *p,
        }
    }

    /// From our axes to the file's.
    pub(super) fn outward(self, p: &Vec3) -> Vec3 {
        match self {
            Self::Y => Vec3::new(p.x, p.z, -p.y),
            Self::Z => *p,
        }
    }
}

impl std::fmt::Display for UpAxis {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

/// Why an OBJ file was refused.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// The file could not be read.
    #[error("{file}: {source}")]
    Read {
        /// Path as given.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line is wrong.
    #[error("{file}:{line}: {problem}")]
    Line {
        /// Path as given.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// There is nothing in it.
    #[error(
        "{file}: no faces found ({vertices} vertices): expected an OBJ mesh with `v` and `f` lines"
    )]
    Empty {
        /// Path as given.
        file: String,
        /// Vertices that were read.
        vertices: usize,
    },
}

/// Reads the triangles of an OBJ file into metres, z up.
pub fn read_obj(path: &Path, unit: LengthUnit, up: UpAxis) -> Result<TriMesh, ObjError> {
    let file = path.display().to_string();
    match std::fs::read(path) {
        Ok(text) => parse_obj(&text, &file, unit, up),
        Err(source) => Err(ObjError::Read { file, source }),
    }
}

/// Reads the triangles of OBJ `text`; `file` is its name in messages.
///
/// Polygons become fans. Faces that name a position twice enclose nothing and are left out, as are positions
/// that no face uses. Vertices are not joined.
pub fn parse_obj(
    text: &[u8],
    file: &str,
    unit: LengthUnit,
    up: UpAxis,
) -> Result<TriMesh, ObjError> {
    let mut mesh = TriMesh::default();
    let mut line_of_triangle = Vec::new();
    let mut corners = Vec::new();
    for (index, bytes) in text.split(|&b| b == b'\n').enumerate() {
        let line = index + 1;
        let at = |problem: String| ObjError::Line {
            file: file.to_owned(),
            line,
            problem,
        };
        // Comments and names may be in any encoding.
        let content = String::from_utf8_lossy(bytes.split(|&b| b == b'#').next().unwrap_or(&[]));
        let mut words = content.split_ascii_whitespace();
        match words.next() {
            None => {}
            Some("v") => {
                let position = parse_position(&mut words).map_err(at)?;
                mesh.positions.push(up.inward(&position) * unit.metres());
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    corners.push(parse_corner(word, mesh.positions.len()).map_err(at)?);
                }
                if corners.len() < 3 {
                    return Err(at(format!(
                        "a face needs at least 3 vertices, found {}",
                        corners.len()
                    )));
                }
                for k in 1..corners.len() - 1 {
                    mesh.triangles
                        .push([corners[0], corners[k], corners[k + 1]]);
                    line_of_triangle.push(line as u32);
                }
            }
            Some(keyword) if PASSED_OVER.contains(&keyword) => {}
            Some(keyword) => {
                let shown: String = keyword
                    .chars()
                    .take(20)
                    .flat_map(char::escape_default)
                    .collect();
                return Err(at(format!(
                    "unknown keyword `{shown}`: is this an OBJ file?"
                )));
            }
        }
    }
    let count = mesh.positions.len();
    let outside = |t: &[u32; 3]| t.iter().copied().find(|&v| v as usize >= count);
    for (triangle, &line) in mesh.triangles.iter().zip(&line_of_triangle) {
        if let Some(vertex) = outside(triangle) {
            return Err(ObjError::Line {
                file: file.to_owned(),
                line: line as usize,
                problem: format!(
                    "face refers to vertex {}, the mesh has {count}",
                    u64::from(vertex) + 1
                ),
            });
        }
    }
    compact(&mut mesh);
    if mesh.triangles.is_empty() {
        return Err(ObjError::Empty {
            file: file.to_owned(),
            vertices: count,
        });
    }
    Ok(mesh)
}

/// Keywords of the format that say nothing about the shape of a polygon mesh.
const PASSED_OVER: [&str; 19] = [
    "vn", "vt", "vp", "vc", "g", "o", "s", "mg", "l", "p", "usemtl", "mtllib", "usemap", "maplib",
    "bevel", "c_interp", "d_interp", "lod", "end",
];

fn parse_position<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<Vec3, String> {
    let mut position = Vec3::zeros();
    for axis in 0..3 {
        let word = words
            .next()
            .ok_or_else(|| format!("a vertex needs 3 coordinates, found {axis}"))?;
        position[axis] = word
            .parse()
            .map_err(|_| format!("expected a coordinate, found `{}`", clipped(word)))?;
        // Up to 1000 km in any unit; beyond, volumes overflow and cells do not fit their indices.
        if position[axis].is_nan() || position[axis].abs() > 1e9 {
            return Err(format!("coordinate {} is not usable", clipped(word)));
        }
    }
    Ok(position)
}

/// `7`, `7/2`, `7//5`, `7/2/5`, or negative: counted back from the latest vertex. Returns the index from 0.
fn parse_corner(word: &str, count: usize) -> Result<u32, String> {
    let wrong = || {
        format!(
            "expected a vertex such as `7`, `7/2` or `7//5`, found `{}`",
            clipped(word)
        )
    };
    let mut parts = word.split('/');
    let index: i64 = parts.next().unwrap_or("").parse().map_err(|_| wrong())?;
    let references = parts.clone().count();
    if references > 2 || parts.any(|part| !part.is_empty() && part.parse::<i64>().is_err()) {
        return Err(wrong());
    }
    let from_zero = if index < 0 {
        index.checked_add_unsigned(count as u64)
    } else {
        index.checked_sub(1)
    };
    match from_zero {
        Some(i) if index != 0 && i >= 0 && i < i64::from(u32::MAX) => Ok(i as u32),
        _ => Err(format!(
            "face refers to vertex {index}, the mesh has {count}"
        )),
    }
}

fn clipped(word: &str) -> String {
    word.chars()
        .take(40)
        .flat_map(char::escape_default)
        .collect()
}

/// Drops collapsed triangles and unused positions, keeping the order of the rest.
fn compact(mesh: &mut TriMesh) {
    mesh.triangles
        .retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let mut used = vec![false; mesh.positions.len()];
    for v in mesh.triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    let mut next = 0;
    let place: Vec<u32> = used
        .iter()
        .map(|&used| {
            next += u32::from(used);
            next.wrapping_sub(1)
        })
        .collect();
    let mut keep = used.iter();
    mesh.positions
        .retain(|_| *keep.next().expect("one flag a position"));
    for v in mesh.triangles.iter_mut().flatten() {
        *v = place[*v as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    fn parse(text: &str) -> Result<TriMesh, ObjError> {
        parse_obj(text.as_bytes(), "t.obj", LengthUnit::Metre, UpAxis::Z)
    }

    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

    #[test]
    fn every_way_to_name_a_corner_gives_the_same_tetrahedron() {
        let faces = [
            "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
            "f 1/1 3/1 2/2\nf 1/5 2/1 4/1\nf 2/1 3/1 4/1\nf 3/1 1/1 4/1\n",
            "vn 0 0 1\nf 1//1 3//1 2//1\nf 1//2 2//2 4//2\nf 2//3 3//3 4//3\nf 3//4 1//4 4//4\n",
            "f 1/1/1 3/1/1 2/1/1\nf 1/1/2 2/1/2 4/1/2\nf 2/1/3 3/1/3 4/1/3\nf 3/1/4 1/1/4 4/1/4\n",
            "f -4 -2 -3\r\nf -4 -3 -1\r\nf -3 -2 -1\r\nf -2 -4 -1\r\n",
            "v 9 9 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 1 2\n",
        ];
        for text in faces {
            let mesh = parse(&format!("# c\no x\n{CORNERS}{text}")).unwrap();
            assert_eq!(mesh.positions.len(), 4);
            assert!(inspect(&mesh).is_closed(), "{text}");
            assert!((mesh.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
        }
    }

    #[test]
    fn unit_and_up_axis_are_converted() {
        let text = b"v 1 2 3\nv 4 5 6 0.5 0.5 0.5\nv 7 8 10\nv 0 0 0\nf 1 2 3 4\n";
        let mesh = parse_obj(text, "t", LengthUnit::Millimetre, UpAxis::Y).unwrap();
        assert!((mesh.positions[0] - Vec3::new(1e-3, -3e-3, 2e-3)).norm() < 1e-15);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let cases = [
            ("v 0 0\n", "t.obj:1: a vertex needs 3"),
            ("v 0 0 nan\n", "t.obj:1: coordinate nan"),
            ("v 0 0 inf\n", "t.obj:1: coordinate inf"),
            ("v 0 0 1e400\n", "t.obj:1: coordinate 1e400"),
            ("v 0 0 x\n", "t.obj:1: expected a coordinate"),
            ("\n\nf 1 2\n", "t.obj:3: a face needs at least 3"),
            (
                "v 0 0 0\nf 1 1 9\n",
                "t.obj:2: face refers to vertex 9, the mesh has 1",
            ),
            ("v 0 0 0\nf 0 1 1\n", "t.obj:2: face refers to vertex 0"),
            ("v 0 0 0\nf -2 1 1\n", "t.obj:2: face refers to vertex -2"),
            ("v 0 0 0\nf 1/a 1 1\n", "t.obj:2: expected a vertex"),
            (
                "v 0 0 0\nf 99999999999999999999 1 1\n",
                "t.obj:2: expected a vertex",
            ),
            ("solid ascii-stl\n", "t.obj:1: unknown keyword `solid`"),
            ("", "no faces"),
            ("v 0 0 0\n", "no faces found (1 vertices)"),
        ];
        for (text, expected) in cases {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        let garbage: Vec<u8> = (0..=255).cycle().take(5000).collect();
        assert!(parse_obj(&garbage, "g", LengthUnit::Metre, UpAxis::Z).is_err());
    }

    proptest::proptest! {
        #[test]
        fn no_text_makes_it_panic(text in "([vf#] ?[-0-9/. ]{0,12}\n){0,12}") {
            let _ = parse(&text);
        }
    }
}
