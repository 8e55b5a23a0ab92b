//! Connected pieces of a set of nodes, kept as one bit a node in bricks.

use super::BRICK;
use crate::math::Real;
use rayon::prelude::*;
use std::collections::HashMap;

/// The nodes of one brick: 8 words, one per x; bit `8 y + z` of a word.
pub type BrickMask = [u64; 8];

/// Share of the marked nodes that hang together in the largest piece (1 if none is marked); nodes are neighbours
/// along the three axes. `bricks` are first nodes and masks.
pub fn connected_share(bricks: &[([i32; 3], BrickMask)]) -> Real {
    let (sizes, _) = sizes(bricks, |_| [0; 8]);
    let marked: u64 = sizes.iter().sum();
    if marked == 0 {
        return 1.0;
    }
    sizes.iter().max().copied().unwrap_or(0) as Real / marked as Real
}

/// Share of the marked nodes that hang together with a seed (0 if there is none); `seeds` marks those of a brick.
pub fn reached_share(bricks: &[([i32; 3], BrickMask)], seeds: impl Fn(usize) -> BrickMask) -> Real {
    let (sizes, seeded) = sizes(bricks, seeds);
    let reached = sizes.iter().zip(seeded).filter(|(_, seeded)| *seeded);
    let reached: u64 = reached.map(|(size, _)| size).sum();
    reached as Real / sizes.iter().sum::<u64>().max(1) as Real
}

/// Nodes of each piece, at its root, and whether one of them is a seed.
fn sizes(
    bricks: &[([i32; 3], BrickMask)],
    seeds: impl Fn(usize) -> BrickMask,
) -> (Vec<u64>, Vec<bool>) {
    let pieces: Vec<Vec<BrickMask>> = bricks.par_iter().map(|(_, mask)| split(mask)).collect();
    let mut first_of = Vec::with_capacity(bricks.len());
    let mut total = 0;
    for of_brick in &pieces {
        first_of.push(total);
        total += of_brick.len();
    }
    let place: HashMap<[i32; 3], usize> = bricks
        .iter()
        .enumerate()
        .map(|(b, (first, _))| (*first, b))
        .collect();

    let mut parent: Vec<usize> = (0..total).collect();
    for (b, (first, _)) in bricks.iter().enumerate() {
        for axis in 0..3 {
            let mut next = *first;
            next[axis] += BRICK;
            let Some(&n) = place.get(&next) else {
                continue;
            };
            for (i, low) in pieces[b].iter().enumerate() {
                for (j, high) in pieces[n].iter().enumerate() {
                    if touch(low, high, axis) {
                        let (a, c) = (
                            root(&mut parent, first_of[b] + i),
                            root(&mut parent, first_of[n] + j),
                        );
                        parent[a.max(c)] = a.min(c);
                    }
                }
            }
        }
    }

    let mut size = vec![0_u64; total];
    let mut seeded = vec![false; total];
    for (b, of_brick) in pieces.iter().enumerate() {
        let seeds = seeds(b);
        for (p, mask) in of_brick.iter().enumerate() {
            let root = root(&mut parent, first_of[b] + p);
            let count: u64 = mask.iter().map(|word| u64::from(word.count_ones())).sum();
            size[root] += count;
            seeded[root] |= (0..8).any(|x| mask[x] & seeds[x] != 0);
        }
    }
    (size, seeded)
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

/// The connected pieces of one brick.
fn split(mask: &BrickMask) -> Vec<BrickMask> {
    let mut rest = *mask;
    let mut pieces = Vec::new();
    while let Some(x) = rest.iter().position(|&word| word != 0) {
        let mut piece = [0; 8];
        piece[x] = 1 << rest[x].trailing_zeros();
        loop {
            let mut grown = piece;
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
            }
            if grown == piece {
                break;
            }
            piece = grown;
        }
        for x in 0..8 {
            rest[x] &= !piece[x];
        }
        pieces.push(piece);
    }
    pieces
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
            let share = connected_share(&bricks);
            assert!((share - Real::from(largest) / nodes.len() as Real).abs() < 1e-12);
        }
        assert_eq!(connected_share(&[]), 1.0);

        // Two slabs two nodes apart: a seed in one reaches half of them.
        let slab = |x: usize| std::array::from_fn(|w| if w == x { !0 } else { 0 });
        let bricks: Vec<([i32; 3], BrickMask)> = vec![([0; 3], slab(0)), ([8, 0, 0], slab(1))];
        assert_eq!(
            reached_share(&bricks, |b| if b == 1 { slab(1) } else { [0; 8] }),
            0.5
        );
        assert_eq!(reached_share(&bricks, |_| [0; 8]), 0.0);
    }
}
