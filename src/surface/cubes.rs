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

/// A lattice edge with one end inside.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Node of the brick at its lower end, 0..512, z running fastest.
    pub node: usize,
    /// Direction of the edge.
    pub axis: usize,
    /// Where the surface cuts it, from 0 at the lower end to 1.
    pub t: f32,
    /// Whether the lower end is inside.
    pub rising: bool,
}

impl Cut {
    fn key(&self) -> usize {
        self.node * 3 + self.axis
    }
}

/// Values on the bricks around a surface.
pub struct Cubes<'a> {
    /// Keys of the bricks, ascending; cubes whose lower corner lies in no brick are not cut.
    pub keys: &'a [[i32; 3]],
    /// Values at the nodes of each brick, z running fastest.
    pub values: &'a [Box<[f32; 512]>],
    /// A node is inside if its value is larger.
    pub threshold: f32,
}

impl Cubes<'_> {
    /// Cuts of each brick in ascending order.
    pub fn cuts(&self) -> Vec<Vec<Cut>> {
        (0..self.keys.len())
            .into_par_iter()
            .map(|brick| {
                let values = self.padded(brick);
                let mut cuts = Vec::new();
                if !self.crossed(&values) {
                    return cuts;
                }
                for node in 0..512 {
                    let at = padded_place(node, 0);
                    for axis in 0..3 {
                        let ends = [values[at], values[at + [SIDE * SIDE, SIDE, 1][axis]]];
                        let rising = ends[0] > self.threshold;
                        if rising != (ends[1] > self.threshold) {
                            let t = (self.threshold - ends[0]) / (ends[1] - ends[0]);
                            cuts.push(Cut {
                                node,
                                axis,
                                t: t.clamp(MARGIN, 1.0 - MARGIN),
                                rising,
                            });
                        }
                    }
                }
                cuts
            })
            .collect()
    }

    /// Triangles between the cuts, numbered in the order of [`Cubes::cuts`].
    pub fn triangles(&self, cuts: &[Vec<Cut>]) -> Vec<[u32; 3]> {
        let first: Vec<usize> = cuts
            .iter()
            .scan(0, |sum, cuts| {
                Some(std::mem::replace(sum, *sum + cuts.len()))
            })
            .collect();
        let per_brick: Vec<Vec<[u32; 3]>> = (0..self.keys.len())
            .into_par_iter()
            .map(|brick| {
                let values = self.padded(brick);
                let mut triangles = Vec::new();
                if !self.crossed(&values) {
                    return triangles;
                }
                let around: [Option<usize>; 8] = std::array::from_fn(|c| self.neighbour(brick, c));
                let vertex = |node: usize, edge: u8| {
                    let edge = EDGES[edge as usize];
                    let step = [edge.corner >> 2, edge.corner >> 1 & 1, edge.corner & 1];
                    let place: [usize; 3] =
                        std::array::from_fn(|a| (node >> (6 - 3 * a) & 7) + step[a]);
                    let owner = around[place.iter().fold(0, |c, p| c << 1 | p >> 3)]
                        .expect("a brick without values has no node inside");
                    let key = place.iter().fold(0, |n, p| n << 3 | p & 7) * 3 + edge.axis;
                    let cut = cuts[owner]
                        .binary_search_by_key(&key, Cut::key)
                        .expect("an edge of a triangle is cut");
                    (first[owner] + cut) as u32
                };
                for node in 0..512 {
                    let inside = (0..8).fold(0, |set, corner| {
                        let value = values[padded_place(node, corner)];
                        set | usize::from(value > self.threshold) << corner
                    });
                    for triangle in &CASES[inside] {
                        triangles.push(triangle.map(|edge| vertex(node, edge)));
                    }
                }
                triangles
            })
            .collect();
        per_brick.concat()
    }

    /// The brick at `corner` of the 2³ bricks from this one on.
    fn neighbour(&self, brick: usize, corner: usize) -> Option<usize> {
        let step = [corner >> 2, corner >> 1 & 1, corner & 1];
        let key: [i32; 3] = std::array::from_fn(|a| self.keys[brick][a] + step[a] as i32);
        self.keys.binary_search(&key).ok()
    }

    /// Values at the nodes of the brick's cubes.
    fn padded(&self, brick: usize) -> [f32; SIDE * SIDE * SIDE] {
        let mut padded = [0.0; SIDE * SIDE * SIDE];
        for corner in 0..8 {
            let Some(from) = self.neighbour(brick, corner) else {
                continue;
            };
            let span = |bit: usize| if corner >> bit & 1 == 1 { 8..9 } else { 0..8 };
            for x in span(2) {
                for y in span(1) {
                    for z in span(0) {
                        padded[(x * SIDE + y) * SIDE + z] =
                            self.values[from][(x & 7) << 6 | (y & 7) << 3 | z & 7];
                    }
                }
            }
        }
        padded
    }

    fn crossed(&self, values: &[f32]) -> bool {
        let first = values[0] > self.threshold;
        values.iter().any(|&v| (v > self.threshold) != first)
    }
}

/// Place among the padded values of a corner of the cube at `node`.
fn padded_place(node: usize, corner: usize) -> usize {
    let [x, y, z] = [
        (node >> 6) + (corner >> 2),
        (node >> 3 & 7) + (corner >> 1 & 1),
        (node & 7) + (corner & 1),
    ];
    (x * SIDE + y) * SIDE + z
}
