//! Marching cubes over bricks: where the lattice edges are cut, and the triangles between the cuts [Lorensen87].
//!
//! A brick owns the cubes, and the edges, whose lower corner is one of its nodes. Cuts are numbered brick by brick, node
//! by node, axis by axis, so the mesh does not depend on the number of threads.

use super::cases::{CASES, EDGES};
use rayon::prelude::*;

/// Nodes along the edge of a brick and of the first layer of the next ones.
const SIDE: usize = 9;
/// Cuts stay this far from the nodes [cube edges]: no two of them meet, so no triangle is degenerate.
const MARGIN: f32 = 1e-3;
/// Bricks whose triangles are in memory twice.
const AT_ONCE: usize = 4096;

/// Values at the nodes of a brick; a node is inside if its value is above 0.
#[derive(Clone, Debug)]
pub enum Brick {
    /// All nodes are on one side, and far enough from 0 for a stand-in.
    Uniform(f32),
    /// Value of each node, z running fastest.
    Nodes(Box<[f32; 512]>),
}

/// A lattice edge with one end inside.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Three times the node of the brick at its lower end (0..512, z running fastest), plus its axis.
    edge: u16,
    /// Whether the lower end is inside.
    pub rising: bool,
    /// Where the surface cuts it, from 0 at the lower end to 1.
    pub t: f32,
}

impl Cut {
    /// Direction of the edge.
    pub fn axis(self) -> usize {
        usize::from(self.edge % 3)
    }

    /// The lower end: its place in the brick on each axis, 0..8.
    pub fn node(self) -> [usize; 3] {
        unpack(usize::from(self.edge / 3))
    }

    /// Place in the brick [cube edges].
    pub fn place(self) -> [f32; 3] {
        let mut place = self.node().map(|n| n as f32);
        place[self.axis()] += self.t;
        place
    }
}

/// Values on the bricks around a surface.
pub struct Cubes<'a> {
    /// Keys of the bricks, ascending; cubes whose lower corner lies in no brick are not cut.
    pub keys: &'a [[i32; 3]],
    /// The bricks.
    pub bricks: &'a [Brick],
    /// Value where there is no brick, below 0.
    pub outside: f32,
}

/// Values at the nodes of a brick's cubes, and which of them are inside.
struct Padded {
    values: [f32; SIDE * SIDE * SIDE],
    /// Bit z of row x, y.
    inside: [[u16; SIDE]; SIDE],
}

impl Cubes<'_> {
    /// Cuts of each brick in ascending order.
    pub fn cuts(&self) -> Vec<Vec<Cut>> {
        (0..self.keys.len())
            .into_par_iter()
            .map(|brick| {
                self.padded(&self.around(brick))
                    .map_or_else(Vec::new, |padded| padded.cuts())
            })
            .collect()
    }

    /// Triangles between the cuts, numbered in the order of [`Cubes::cuts`].
    pub fn triangles(&self, cuts: &[Vec<Cut>]) -> Vec<[u32; 3]> {
        let first: Vec<u32> = cuts
            .iter()
            .scan(0, |sum, cuts| {
                Some(std::mem::replace(sum, *sum + cuts.len() as u32))
            })
            .collect();
        let mut triangles = Vec::new();
        let bricks: Vec<usize> = (0..self.keys.len()).collect();
        for some in bricks.chunks(AT_ONCE) {
            let made: Vec<Vec<[u32; 3]>> = some
                .par_iter()
                .map(|&brick| self.brick_triangles(brick, cuts, &first))
                .collect();
            triangles.reserve(made.iter().map(Vec::len).sum());
            for some in made {
                triangles.extend(some);
            }
        }
        triangles
    }

    fn brick_triangles(&self, brick: usize, cuts: &[Vec<Cut>], first: &[u32]) -> Vec<[u32; 3]> {
        let around = self.around(brick);
        let Some(padded) = self.padded(&around) else {
            return Vec::new();
        };
        // Number of the vertex on each edge of the brick's cubes.
        let mut vertex = [u32::MAX; 3 * SIDE * SIDE * SIDE];
        for (corner, owner) in around.iter().enumerate() {
            let Some(owner) = *owner else { continue };
            let step = [corner >> 2, corner >> 1 & 1, corner & 1];
            for (number, cut) in cuts[owner].iter().enumerate() {
                let node = cut.node();
                if (0..3).all(|a| step[a] == 0 || node[a] == 0) {
                    let place: [usize; 3] = std::array::from_fn(|a| node[a] + 8 * step[a]);
                    vertex[3 * padded_place(place) + cut.axis()] = first[owner] + number as u32;
                }
            }
        }

        let cases = &*CASES;
        let edges = EDGES.map(|edge| {
            3 * padded_place([edge.corner >> 2, edge.corner >> 1 & 1, edge.corner & 1]) + edge.axis
        });
        let mut triangles = Vec::new();
        for x in 0..8 {
            for y in 0..8 {
                let rows = [(x, y), (x, y + 1), (x + 1, y), (x + 1, y + 1)];
                let rows = rows.map(|(x, y)| padded.inside[x][y]);
                if rows == [0; 4] || rows == [0x1ff; 4] {
                    continue;
                }
                for z in 0..8 {
                    let inside =
                        (0..4).fold(0, |set, r| set | usize::from(rows[r] >> z & 3) << (2 * r));
                    let start = 3 * padded_place([x, y, z]);
                    for triangle in &cases[inside] {
                        triangles.push(triangle.map(|edge| vertex[start + edges[edge as usize]]));
                    }
                }
            }
        }
        triangles
    }

    /// The 2³ bricks from this one on.
    fn around(&self, brick: usize) -> [Option<usize>; 8] {
        std::array::from_fn(|corner| {
            let step = [corner >> 2, corner >> 1 & 1, corner & 1];
            let key: [i32; 3] = std::array::from_fn(|a| self.keys[brick][a] + step[a] as i32);
            let after = &self.keys[brick..];
            let place = match corner {
                0 => Ok(0),
                1 => (after.get(1) == Some(&key)).then_some(1).ok_or(0),
                _ => after.binary_search(&key),
            };
            place.ok().map(|place| brick + place)
        })
    }

    /// Values at the nodes of the brick's cubes; none if all are on one side.
    fn padded(&self, around: &[Option<usize>; 8]) -> Option<Padded> {
        let outside = Brick::Uniform(self.outside);
        let around = around.map(|b| b.map_or(&outside, |b| &self.bricks[b]));
        let side = |brick: &Brick| match brick {
            Brick::Uniform(value) => Some(*value > 0.0),
            Brick::Nodes(_) => None,
        };
        if side(around[0]).is_some_and(|s| around.iter().all(|b| side(b) == Some(s))) {
            return None;
        }
        let mut padded = Padded {
            values: [0.0; SIDE * SIDE * SIDE],
            inside: [[0; SIDE]; SIDE],
        };
        for (corner, from) in around.iter().enumerate() {
            let span = |bit: usize| if corner >> bit & 1 == 1 { 8..9 } else { 0..8 };
            let (start, count) = if corner & 1 == 1 { (8, 1) } else { (0, 8) };
            for x in span(2) {
                for y in span(1) {
                    let to = &mut padded.values[padded_place([x, y, start])..][..count];
                    match from {
                        Brick::Uniform(value) => to.fill(*value),
                        Brick::Nodes(values) => {
                            let row = (x & 7) << 6 | (y & 7) << 3;
                            to.copy_from_slice(&values[row..row + count]);
                        }
                    }
                    for (z, value) in to.iter().enumerate() {
                        padded.inside[x][y] |= u16::from(*value > 0.0) << (start + z);
                    }
                }
            }
        }
        let rows = || padded.inside.iter().flatten();
        let crossed = rows().any(|&row| row != 0) && rows().any(|&row| row != 0x1ff);
        crossed.then_some(padded)
    }
}

impl Padded {
    fn cuts(&self) -> Vec<Cut> {
        let mut cuts = Vec::new();
        for x in 0..8 {
            for y in 0..8 {
                let row = self.inside[x][y];
                let crossed = [
                    (row ^ self.inside[x + 1][y]) & 0xff,
                    (row ^ self.inside[x][y + 1]) & 0xff,
                    (row ^ row >> 1) & 0xff,
                ];
                let mut any = crossed[0] | crossed[1] | crossed[2];
                while any != 0 {
                    let z = any.trailing_zeros() as usize;
                    any &= any - 1;
                    let at = padded_place([x, y, z]);
                    for axis in (0..3).filter(|&axis| crossed[axis] >> z & 1 == 1) {
                        let ends = [
                            self.values[at],
                            self.values[at + [SIDE * SIDE, SIDE, 1][axis]],
                        ];
                        let t = ends[0] / (ends[0] - ends[1]);
                        cuts.push(Cut {
                            edge: ((x << 6 | y << 3 | z) * 3 + axis) as u16,
                            rising: row >> z & 1 == 1,
                            t: t.clamp(MARGIN, 1.0 - MARGIN),
                        });
                    }
                }
            }
        }
        cuts
    }
}

fn unpack(node: usize) -> [usize; 3] {
    [node >> 6, node >> 3 & 7, node & 7]
}

/// Place of a node among the padded values.
#[inline]
fn padded_place([x, y, z]: [usize; 3]) -> usize {
    (x * SIDE + y) * SIDE + z
}
