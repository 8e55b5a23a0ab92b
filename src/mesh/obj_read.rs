//! OBJ in: positions and faces, any unit, either up axis; says the line of whatever is wrong.
//!
//! tobj reads; this door shows it the lines that make the shape and no others. Normals, texture coordinates, groups
//! and materials are passed over: two faces are neighbours when they share positions, whatever else they carry.
//! Memory grows with the length of the file, whatever numbers stand in it.

use super::{LengthUnit, TriMesh, UpAxis};
use crate::math::{Real, Vec3};
use std::io::BufRead;
use std::path::Path;

/// Why an OBJ file was refused.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// The file could not be read.
    #[error("cannot read the mesh {file}")]
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
/// that no face uses. Vertices are not joined; they come in the order in which faces use them.
pub fn parse_obj(
    text: &[u8],
    file: &str,
    unit: LengthUnit,
    up: UpAxis,
) -> Result<TriMesh, ObjError> {
    let at = |(line, problem): (usize, String)| ObjError::Line {
        file: file.to_owned(),
        line,
        problem,
    };
    let mut lines = ShapeLines::new(text);
    let options = tobj::LoadOptions {
        triangulate: true,
        ..Default::default()
    };
    let (positions, indices) =
        match tobj::load_obj_buf(&mut lines, &options, |_| Ok(<_>::default())) {
            // Without names of groups and materials there is one model.
            Ok((models, _)) => models
                .into_iter()
                .next()
                .map_or_else(Default::default, |m| (m.mesh.positions, m.mesh.indices)),
            // Only known at the end, because a face may stand before its vertices.
            Err(tobj::LoadError::FaceVertexOutOfBounds) => {
                let found = stray_corner(text);
                return Err(at(
                    found.unwrap_or((lines.line, "a face refers to no vertex".into()))
                ));
            }
            Err(error) => return Err(at((lines.line, lines.refused(error)))),
        };
    let mut mesh = TriMesh {
        positions: positions
            .chunks_exact(3)
            .map(|p| up.inward(&Vec3::new(p[0], p[1], p[2])) * unit.metres())
            .collect(),
        triangles: indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    };
    compact(&mut mesh);
    if mesh.triangles.is_empty() || positions.iter().any(|c| !usable(*c)) {
        return Err(unusable_coordinate(text).map_or_else(
            || ObjError::Empty {
                file: file.to_owned(),
                vertices: vertices(text),
            },
            at,
        ));
    }
    Ok(mesh)
}

/// Up to 1000 km in any unit; beyond, volumes overflow and cells do not fit their indices.
fn usable(coordinate: Real) -> bool {
    coordinate.abs() <= 1e9
}

/// Keywords of the format that say nothing about the shape of a polygon mesh.
const PASSED_OVER: [&str; 19] = [
    "vn", "vt", "vp", "vc", "g", "o", "s", "mg", "l", "p", "usemtl", "mtllib", "usemap", "maplib",
    "bevel", "c_interp", "d_interp", "lod", "end",
];

/// The words of a line that say something about the shape: `v` and three coordinates, or `f` and all its corners.
///
/// Without comments, colours and weights, normals, names: so tobj sees one mesh whose vertices are positions.
fn shape_words(line: &str) -> Result<Vec<&str>, String> {
    let content = line.split('#').next().unwrap_or("");
    let mut words: Vec<&str> = content.split_whitespace().collect();
    match words.first().copied() {
        Some("v") => words.truncate(4),
        Some("f") if words.len() < 4 => {
            let found = words.len() - 1;
            return Err(format!("a face needs at least 3 vertices, found {found}"));
        }
        Some("f") => {}
        Some(keyword) if !PASSED_OVER.contains(&keyword) => {
            let shown = clipped(keyword);
            return Err(format!("unknown keyword `{shown}`: is this an OBJ file?"));
        }
        _ => words.clear(),
    }
    Ok(words)
}

/// Hands tobj the shape of a file line by line, and knows at which line it is.
struct ShapeLines<'a> {
    lines: std::slice::Split<'a, u8, fn(&u8) -> bool>,
    /// Number of the line handed out last, from 1.
    line: usize,
    words: String,
    taken: usize,
    problem: Option<String>,
}

impl<'a> ShapeLines<'a> {
    fn new(text: &'a [u8]) -> Self {
        Self {
            lines: text.split(|byte| *byte == b'\n'),
            line: 0,
            words: String::new(),
            taken: 0,
            problem: None,
        }
    }

    /// Why tobj stopped at the current line.
    fn refused(&self, error: tobj::LoadError) -> String {
        if let Some(problem) = &self.problem {
            return problem.clone();
        }
        let words: Vec<&str> = self.words.split_whitespace().skip(1).collect();
        let no_number = words.iter().find(|word| word.parse::<Real>().is_err());
        match (error, no_number) {
            (tobj::LoadError::PositionParseError, Some(word)) => {
                format!("expected a coordinate, found `{}`", clipped(word))
            }
            (tobj::LoadError::PositionParseError, None) => {
                format!("a vertex needs 3 coordinates, found {}", words.len())
            }
            (tobj::LoadError::FaceParseError, _) => format!(
                "expected a vertex such as `7`, `7/2` or `7//5`, found `{}`",
                clipped(&words.join(" "))
            ),
            _ => error.to_string(),
        }
    }
}

impl std::io::Read for ShapeLines<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = std::io::Read::read(&mut self.fill_buf()?, out)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for ShapeLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        while self.taken == self.words.len() {
            let Some(bytes) = self.lines.next() else {
                break;
            };
            self.line += 1;
            // Comments and names may be in any encoding.
            match shape_words(&String::from_utf8_lossy(bytes)) {
                Ok(words) if words.is_empty() => {}
                Ok(words) => {
                    self.words = words.join(" ") + "\n";
                    self.taken = 0;
                }
                Err(problem) => {
                    self.problem = Some(problem);
                    return Err(std::io::ErrorKind::InvalidData.into());
                }
            }
        }
        Ok(&self.words.as_bytes()[self.taken..])
    }

    fn consume(&mut self, count: usize) {
        self.taken += count;
    }
}

/// The first line for which `wrong` has words, given the words of the line and the vertices before it.
fn first_wrong(
    text: &[u8],
    wrong: impl Fn(&[&str], usize) -> Option<String>,
) -> Option<(usize, String)> {
    let mut before = 0;
    text.split(|byte| *byte == b'\n')
        .zip(1..)
        .find_map(|(bytes, line)| {
            let content = String::from_utf8_lossy(bytes);
            let words = shape_words(&content).unwrap_or_default();
            let found = wrong(&words, before);
            before += usize::from(words.first() == Some(&"v"));
            found.map(|problem| (line, problem))
        })
}

fn vertices(text: &[u8]) -> usize {
    let is_vertex = |bytes: &&[u8]| {
        let content = String::from_utf8_lossy(bytes);
        shape_words(&content).is_ok_and(|words| words.first() == Some(&"v"))
    };
    text.split(|byte| *byte == b'\n').filter(is_vertex).count()
}

fn unusable_coordinate(text: &[u8]) -> Option<(usize, String)> {
    first_wrong(text, |words, _| {
        let (_, coordinates) = words.split_first().filter(|(first, _)| **first == "v")?;
        let unusable = |word: &&&str| word.parse().is_ok_and(|c| !usable(c));
        let word = coordinates.iter().find(unusable)?;
        Some(format!("coordinate {} is not usable", clipped(word)))
    })
}

fn stray_corner(text: &[u8]) -> Option<(usize, String)> {
    let count = vertices(text) as i64;
    first_wrong(text, |words, before| {
        let (_, corners) = words.split_first().filter(|(first, _)| **first == "f")?;
        corners.iter().find_map(|corner| {
            let word = corner.split('/').next().unwrap_or("");
            let from_zero = match word.parse::<i64>() {
                Ok(index) if index < 0 => index + before as i64,
                Ok(index) => index - 1,
                Err(_) => -1,
            };
            let stray = from_zero < 0 || from_zero >= count;
            stray.then(|| format!("face refers to vertex {word}, the mesh has {count}"))
        })
    })
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
        // tobj alone would refuse the first and tear the second apart.
        let coloured = format!("{CORNERS}v 1 1 1 0.5 0.5 0.5\nf 1 2 5 # c\n");
        assert_eq!(parse(&coloured).unwrap().positions.len(), 3);
        let grouped = format!("f 1 3 2\n{CORNERS}g a\nf 1 2 4\no b\nf 2 3 4\nusemtl c\nf 3 1 4\n");
        assert!(inspect(&parse(&grouped).unwrap()).is_closed());
        let garbage: Vec<u8> = (0..=255).cycle().take(5000).collect();
        assert!(parse_obj(&garbage, "g", LengthUnit::Metre, UpAxis::Z).is_err());
    }

    proptest::proptest! {
        #[test]
        fn no_text_makes_it_panic(text in "([vf#] ?[-0-9/. ]{0,12}\n){0,12}") {
            let _ = parse(&text);
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..200)) {
            for start in ["", "v 0 0 0\nf 1 1 ", "v "] {
                let text = [start.as_bytes(), &bytes].concat();
                let _ = parse_obj(&text, "b", LengthUnit::Metre, UpAxis::Z);
            }
        }
    }
}
