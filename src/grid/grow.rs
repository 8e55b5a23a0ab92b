//! Sets of nodes in bricks, grown.

use super::connected::{BrickMask, BrickNeighbours, NONE};
use rayon::prelude::*;

const Z_LOW: u64 = 0x0101_0101_0101_0101;

impl BrickNeighbours {
    /// The marked nodes and what is within `steps` nodes of them. Steps to the six neighbours along the axes and to
    /// all twenty-six take turns: the ball is met within a sixth of its radius. Nothing grows out of the bricks.
    pub fn grown(&self, masks: &[BrickMask], steps: usize) -> Vec<BrickMask> {
        let mut masks = masks.to_vec();
        for step in 0..steps {
            if step % 2 == 0 {
                let all = |b: usize| {
                    let along = [0, 1, 2].map(|axis| self.spread(&masks, axis, b));
                    std::array::from_fn(|x| along[0][x] | along[1][x] | along[2][x])
                };
                masks = (0..masks.len()).into_par_iter().map(all).collect();
            } else {
                for axis in 0..3 {
                    let grown = |b: usize| self.spread(&masks, axis, b);
                    masks = (0..masks.len()).into_par_iter().map(grown).collect();
                }
            }
        }
        masks
    }

    /// The marked nodes of brick `b`, grown by a node up and down an axis.
    fn spread(&self, masks: &[BrickMask], axis: usize, b: usize) -> BrickMask {
        let of = |b: u32| if b == NONE { [0; 8] } else { masks[b as usize] };
        let here = masks[b];
        let before = of(self.before[b][axis]);
        let after = of(self.after[b][axis]);
        std::array::from_fn(|x| {
            let w = here[x];
            w | match axis {
                0 => {
                    let low = if x > 0 { here[x - 1] } else { before[7] };
                    low | if x < 7 { here[x + 1] } else { after[0] }
                }
                1 => w << 8 | before[x] >> 56 | w >> 8 | after[x] << 56,
                _ => {
                    (w & !(Z_LOW << 7)) << 1
                        | before[x] >> 7 & Z_LOW
                        | (w & !Z_LOW) >> 1
                        | (after[x] & Z_LOW) << 7
                }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::count;

    /// One node near the corner of eight bricks grows to what a ball holds.
    #[test]
    fn a_node_grows_to_a_ball_across_bricks() {
        let mut firsts = Vec::new();
        for b in 0..64 {
            firsts.push([b / 16, b / 4 % 4, b % 4].map(|p| 8 * p));
        }
        let neighbours = BrickNeighbours::new(&firsts);
        let mut masks = vec![[0; 8]; 64];
        // The node (15, 16, 17).
        masks[16 + 8 + 2][7] = 1 << 1;
        for steps in 1..=8_i32 {
            let grown = neighbours.grown(&masks, steps as usize);
            let marked = |p: [i32; 3]| {
                let brick = p.map(|p| p as usize / 8);
                let word = grown[brick[0] * 16 + brick[1] * 4 + brick[2]][p[0] as usize % 8];
                word >> (p[1] % 8 * 8 + p[2] % 8) & 1 == 1
            };
            for axis in 0..3 {
                for away in [-steps, steps] {
                    let mut end = [15, 16, 17];
                    end[axis] += away;
                    assert!(marked(end));
                    end[axis] += away.signum();
                    assert!(!marked(end));
                }
            }
            let volume: u64 = grown.iter().map(count).sum();
            let radius = (f64::from(volume as u32) * 0.75 / std::f64::consts::PI).cbrt();
            let excess = radius / (f64::from(steps) + 0.5) - 1.0;
            assert!(steps < 3 || excess.abs() < 0.17, "{steps} {excess}");
        }
    }
}
