//! Pores that hang together with nothing are closed: where a process is hardly thicker than its shell, the shell leaves
//! pockets in it, which are cortex in a bone, and which no cement can ever reach.

use super::build::{BoneBrick, place};
use super::report::Pores;
use crate::grid::{BrickMask, count};
use crate::math::Real;

/// Of more of the pores than this, the bone is rather in parts, and all of them stay open.
const MOST: Real = 0.1;

/// Closes pores from which no way leads to the largest piece of them or to a bore; says how much of the pores that
/// was [1].
pub(super) fn close(bricks: &mut [BoneBrick], voxel: Real) -> Real {
    let pores = Pores::new(bricks, voxel);
    let all = pores.open();
    let largest = pores.reached(&all, None);
    let bores = pores.masks(|phi, place| phi > 0.0 && place == place::BORE);
    let from_bores = pores.reached(&all, Some(&bores));
    let cut_off: Vec<BrickMask> = all
        .iter()
        .zip(largest.iter().zip(&from_bores))
        .map(|(all, (a, b))| std::array::from_fn(|x| all[x] & !a[x] & !b[x]))
        .collect();
    let total: u64 = all.iter().map(count).sum();
    let closed: u64 = cut_off.iter().map(count).sum();
    let share = closed as Real / total.max(1) as Real;
    if closed == 0 || share > MOST {
        return 0.0;
    }
    for (brick, mask) in bricks.iter_mut().zip(&cut_off) {
        for node in (0..512).filter(|node| mask[node >> 6] >> (node & 63) & 1 == 1) {
            // The surface is at least as far as that of the pocket was.
            brick.phi[node] = -brick.phi[node];
            brick.place[node] = place::ELSEWHERE;
        }
    }
    share
}
