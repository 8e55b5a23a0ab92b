//! Connected pieces of a set of nodes, kept as one bit a node in bricks.

use super::BRICK;
use crate::math::Real;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// The nodes of one brick: 8 words, one per x; bit `8 y + z` of a word.
pub type BrickMask = [u64; 8];

/// Which bricks come before and after which along the axes; one mask a brick is to be given, in their order.
pub struct BrickNeighbours {
    pub(super) before: Vec<[u32; 3]>,
    pub(super) after: Vec<[u32; 3]>,
}

/// Bricks whose pieces are listed together.
const CHUNK: usize = 4096;

/// No brick.
pub(super) const NONE: u32 = u32::MAX;

impl BrickNeighbours {
    /// Of bricks with these first nodes.
    pub fn new(first: &[[i32; 3]]) -> Self {
        let place: HashMap<[i32; 3], u32> = first
            .iter()
            .enumerate()
            .map(|(b, first)| (*first, b as u32))
            .collect();
        let next = |first: &[i32; 3], step: i32| {
            [0, 1, 2].map(|axis| {
                let mut next = *first;
                next[axis] += step;
                place.get(&next).copied().unwrap_or(NONE)
            })
        };
        Self {
            before: first.par_iter().map(|first| next(first, -BRICK)).collect(),
            after: first.par_iter().map(|first| next(first, BRICK)).collect(),
        }
    }

    /// Share of the marked nodes that hang together in the largest piece (1 if none is marked); nodes are neighbours
    /// along the three axes.
    pub fn connected_share(&self, masks: &[BrickMask]) -> Real {
        let pieces = self.pieces(masks);
        let marked: u64 = pieces.size.iter().sum();
        if marked == 0 {
            return 1.0;
        }
        pieces.size.iter().max().copied().unwrap_or(0) as Real / marked as Real
    }

    /// The marked nodes that hang together with a seed, or without seeds those of the largest piece.
    pub fn reached(&self, masks: &[BrickMask], seeds: Option<&[BrickMask]>) -> Vec<BrickMask> {
        let pieces = self.pieces(masks);
        let mut wanted = vec![false; pieces.size.len()];
        if let Some(seeds) = seeds {
            for (b, seeds) in seeds.iter().enumerate() {
                for p in pieces.of_brick(b) {
                    let seeded = (0..8).any(|x| pieces.all[p][x] & seeds[x] != 0);
                    wanted[pieces.root[p]] |= seeded;
                }
            }
        } else {
            // The first of equally large ones.
            let largest = (0..pieces.size.len()).rev().max_by_key(|p| pieces.size[*p]);
            if let Some(largest) = largest {
                wanted[largest] = true;
            }
        }
        let of_brick = |b: usize| {
            let wanted = pieces.of_brick(b).filter(|p| wanted[pieces.root[*p]]);
            wanted.fold([0; 8], |reached: BrickMask, p| {
                std::array::from_fn(|x| reached[x] | pieces.all[p][x])
            })
        };
        (0..masks.len()).into_par_iter().map(of_brick).collect()
    }

    /// The nodes on those faces of bricks that no brick follows.
    pub fn rim(&self) -> Vec<BrickMask> {
        let of_brick = |(before, after): (&[u32; 3], &[u32; 3])| {
            std::array::from_fn(|x| {
                let ends = [
                    (before[0] == NONE && x == 0, !0),
                    (after[0] == NONE && x == 7, !0),
                    (before[1] == NONE, 0xff),
                    (after[1] == NONE, 0xff << 56),
                    (before[2] == NONE, Z_LOW),
                    (after[2] == NONE, Z_HIGH),
                ];
                let faces = ends.iter().filter(|(ends, _)| *ends);
                faces.fold(0, |word, (_, face)| word | face)
            })
        };
        self.before.iter().zip(&self.after).map(of_brick).collect()
    }

    fn pieces(&self, masks: &[BrickMask]) -> Pieces {
        // Lists of many bricks: one for each would be millions to ask memory for, and to give back.
        let of_chunk = |masks: &[BrickMask]| {
            let mut all = Vec::with_capacity(masks.len());
            let ends: Vec<usize> = masks
                .iter()
                .map(|mask| {
                    split(mask, &mut all);
                    all.len()
                })
                .collect();
            (all, ends)
        };
        let chunks: Vec<_> = masks.par_chunks(CHUNK).map(of_chunk).collect();
        let mut all = Vec::with_capacity(chunks.iter().map(|(all, _)| all.len()).sum());
        let mut first_of = Vec::with_capacity(masks.len() + 1);
        first_of.push(0);
        for (pieces, ends) in chunks {
            first_of.extend(ends.into_iter().map(|end| all.len() + end));
            all.extend(pieces);
        }
        let mut pieces = Pieces {
            root: (0..all.len()).collect(),
            size: vec![0; all.len()],
            all,
            first_of,
        };

        for (b, after) in self.after.iter().enumerate() {
            for (axis, &n) in after.iter().enumerate().filter(|(_, n)| **n != NONE) {
                for low in pieces.of_brick(b) {
                    for high in pieces.of_brick(n as usize) {
                        if touch(&pieces.all[low], &pieces.all[high], axis) {
                            let parent = &mut pieces.root;
                            let (a, c) = (root(parent, low), root(parent, high));
                            parent[a.max(c)] = a.min(c);
                        }
                    }
                }
            }
        }
        for (piece, mask) in pieces.all.iter().enumerate() {
            let root = root(&mut pieces.root, piece);
            pieces.root[piece] = root;
            pieces.size[root] += count(mask);
        }
        pieces
    }
}

/// The connected pieces within bricks, and what they hang together with.
struct Pieces {
    /// By brick.
    all: Vec<BrickMask>,
    /// Number of the first piece of each brick, and of all.
    first_of: Vec<usize>,
    /// By piece, the one that stands for all it hangs together with.
    root: Vec<usize>,
    /// Marked nodes, at the roots.
    size: Vec<u64>,
}

impl Pieces {
    /// Numbers of the pieces of brick `b`.
    fn of_brick(&self, b: usize) -> Range<usize> {
        self.first_of[b]..self.first_of[b + 1]
    }
}

/// Marked nodes of a brick.
pub fn count(mask: &BrickMask) -> u64 {
    mask.iter().map(|word| u64::from(word.count_ones())).sum()
}

fn root(parent: &mut [usize], mut piece: usize) -> usize {
    while parent[piece] != piece {
        parent[piece] = parent[parent[piece]];
        piece = parent[piece];
    }
    piece
}

const Z_LOW: u64 = 0x0101_0101_0101_0101;
const Z_HIGH: u64 = Z_LOW << 7;

/// Puts the connected pieces of one brick after others.
fn split(mask: &BrickMask, pieces: &mut Vec<BrickMask>) {
    let mut rest = *mask;
    while let Some(x) = rest.iter().position(|&word| word != 0) {
        let mut piece = [0; 8];
        piece[x] = 1 << rest[x].trailing_zeros();
        loop {
            let mut grown = piece;
            let mut new = 0;
            for x in 0..8 {
                let p = piece[x];
                let mut g = p | p << 8 | p >> 8 | (p & !Z_HIGH) << 1 | (p & !Z_LOW) >> 1;
                if x > 0 {
                    // The word before has grown already: a wave crosses the brick in one pass.
                    g |= grown[x - 1];
                }
                if x < 7 {
                    g |= piece[x + 1];
                }
                grown[x] = g & rest[x];
                new |= grown[x] ^ piece[x];
            }
            if new == 0 {
                break;
            }
            piece = grown;
        }
        for x in 0..8 {
            rest[x] &= !piece[x];
        }
        pieces.push(piece);
    }
}

/// Whether pieces of two bricks, the second one further along `axis`, share a face.
fn touch(low: &BrickMask, high: &BrickMask, axis: usize) -> bool {
    match axis {
        0 => low[7] & high[0] != 0,
        1 => (0..8).any(|x| (low[x] >> 56) & (high[x] & 0xff) != 0),
        _ => (0..8).any(|x| ((low[x] & Z_HIGH) >> 7) & (high[x] & Z_LOW) != 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn agrees_with_a_plain_flood_fill() {
        let mut random = crate::math::Stream::new(9, "connected");
        for density in [0.2, 0.32, 0.5] {
            let mut marked = BTreeMap::new();
            let mut bricks = Vec::new();
            for first in [
                [0, 0, 0],
                [8, 0, 0],
                [0, 8, 0],
                [0, 0, 8],
                [8, 8, 8],
                [-8, 0, 0],
            ] {
                let mut mask = [0; 8];
                for node in 0..512_i32 {
                    if random.unit() < density {
                        let [x, y, z] = [node >> 6, node >> 3 & 7, node & 7];
                        mask[x as usize] |= 1 << (8 * y + z);
                        marked.insert([first[0] + x, first[1] + y, first[2] + z], false);
                    }
                }
                bricks.push((first, mask));
            }
            let nodes: Vec<[i32; 3]> = marked.keys().copied().collect();
            let mut largest = 0;
            for start in &nodes {
                let mut stack = vec![*start];
                let mut size = 0;
                while let Some(node) = stack.pop() {
                    if marked.get(&node) != Some(&false) {
                        continue;
                    }
                    marked.insert(node, true);
                    size += 1;
                    for k in 0..6 {
                        let mut next = node;
                        next[k / 2] += if k % 2 == 0 { 1 } else { -1 };
                        stack.push(next);
                    }
                }
                largest = largest.max(size);
            }
            let (firsts, masks): (Vec<[i32; 3]>, Vec<BrickMask>) = bricks.into_iter().unzip();
            let share = BrickNeighbours::new(&firsts).connected_share(&masks);
            assert!((share - Real::from(largest) / nodes.len() as Real).abs() < 1e-12);
        }
        assert_eq!(BrickNeighbours::new(&[]).connected_share(&[]), 1.0);

        // Two slabs two nodes apart: a seed in one reaches half of them.
        let slab = |x: usize| std::array::from_fn(|w| if w == x { !0 } else { 0 });
        let neighbours = BrickNeighbours::new(&[[0; 3], [8, 0, 0]]);
        let masks = [slab(0), slab(1)];
        let seeds = [[0; 8], slab(1)];
        assert_eq!(neighbours.reached(&masks, Some(&seeds)), seeds);
        assert_eq!(neighbours.reached(&masks, Some(&[[0; 8]; 2])), [[0; 8]; 2]);
        assert_eq!(neighbours.reached(&masks, None), [slab(0), [0; 8]]);
        // Two bricks in a row have ten faces that nothing follows.
        let inner =
            |x: usize| (!0xff & !(0xff << 56) & !Z_LOW & !Z_HIGH) * u64::from(x > 0 && x < 15);
        for (b, rim) in neighbours.rim().iter().enumerate() {
            for (x, word) in rim.iter().enumerate() {
                assert_eq!(*word, !inner(8 * b + x), "{b} {x}");
            }
        }
    }
}
