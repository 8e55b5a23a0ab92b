//! Whether bone hangs together: in one piece, or perhaps beyond where the part of it that is built ends.

use super::build::place;
use super::report::{Pores, share_in};
use crate::grid::BrickMask;
use crate::math::Real;

/// Shares of bone that hang together [1].
pub(super) struct Hold {
    /// Of all bone, what hangs together in one piece.
    pub(super) bone: Real,
    /// Of the struts below the shell, what hangs together with that piece.
    pub(super) struts: Real,
    /// Of the struts, what does not, but goes on where the built part ends.
    pub(super) struts_cut: Real,
}

/// Measures what is built. Bone reaches a face without a brick behind it only where the built part ends: around the
/// bone, bricks go on until its surface is out of sight.
pub(super) fn measure(pores: &Pores<'_>) -> Hold {
    let bones = pores.masks(|phi, _| phi <= 0.0);
    let struts = pores.masks(|phi, place| phi <= 0.0 && place >= place::FIRST_REGION);
    let one_piece = pores.reached(&bones, None);
    let loose = |(all, one): (&BrickMask, &BrickMask)| std::array::from_fn(|x| all[x] & !one[x]);
    let loose: Vec<BrickMask> = bones.iter().zip(&one_piece).map(loose).collect();
    let cut = pores.reached(&loose, Some(&pores.rim()));
    Hold {
        bone: 1.0 - share_in(&loose, &bones),
        struts: 1.0 - share_in(&loose, &struts),
        struts_cut: share_in(&cut, &struts),
    }
}

#[cfg(test)]
mod tests {
    use crate::bone::build::build_alone;
    use crate::bone::{BoneSettings, Sources};
    use crate::math::{Aabb, Vec3};
    use crate::mesh::tests::cuboid;

    /// Struts that hang together in the whole are in parts in a box within it: all those parts end at the box.
    #[test]
    fn struts_that_a_box_cuts_off_are_told_apart_from_loose_ones() {
        let block = cuboid(Vec3::zeros(), Vec3::new(0.014, 0.012, 0.016));
        let made = |within| {
            let settings = BoneSettings {
                within,
                ..Default::default()
            };
            let built = build_alone(&block, &settings, &Sources::default(), 0.5e-3, &[]);
            built.unwrap().report
        };
        let whole = made(None);
        assert!(whole.struts_connected > 0.999, "{whole:?}");
        assert!(whole.struts_cut < 1e-4, "{whole:?}");
        let part = made(Some(Aabb {
            min: Vec3::new(4.5e-3, 4.5e-3, 5e-3),
            max: Vec3::new(7.5e-3, 7.5e-3, 9e-3),
        }));
        assert!(part.struts_connected < 0.999, "{part:?}");
        assert!(part.struts_cut > 1e-3, "{part:?}");
        assert!(part.struts_connected + part.struts_cut > 0.9999, "{part:?}");
    }
}
