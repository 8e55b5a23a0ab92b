//! Measures a bone on its grid: what was asked and what was made, and whether cement can pass.

use super::build::{BoneBrick, CLASSES, Tally, place, solid_share};
use super::network::Network;
use super::settings::{BoneSettings, Struts};
use crate::grid::{BrickMask, connected_share, reached_share};
use crate::math::Real;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a bone turned out to be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoneReport {
    /// Volume of all bone: shell and struts [m³].
    pub bone_volume: Real,
    /// Volume of the shell [m³].
    pub shell_volume: Real,
    /// Number of struts.
    pub struts: usize,
    /// Share of the bone (shell and struts) that hangs together in one piece [1].
    pub bone_connected: Real,
    /// Share of the pores inside the shell that hang together in one piece [1].
    pub pores_connected: Real,
    /// How far balls of growing size get from the bores; empty without bores.
    pub reach: Vec<Reach>,
    /// By region.
    pub regions: Vec<RegionReport>,
}

/// How far a ball gets through the pores.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Diameter of the ball in particle spacings.
    pub ball_in_spacings: Real,
    /// Share of the pores where its centre has room [1].
    pub fits: Real,
    /// Share of those places that it can get to from the bores [1].
    pub reached: Real,
}

/// One region of a bone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionReport {
    /// Name from the settings.
    pub name: String,
    /// Volume inside the shell, pores and struts [m³].
    pub volume: Real,
    /// Porosity that was asked for, if it was; its mean where it varies [1].
    pub asked_porosity: Option<Real>,
    /// Porosity that was made [1].
    pub porosity: Real,
    /// Where the asked porosity varies: asked and made in each twentieth that a hundredth of the region falls into [1].
    pub classes: Vec<[Real; 2]>,
    /// Surface of the struts in the volume of pores and struts [1/m].
    pub specific_surface: Real,
    /// Permeability φ³/(5 S²) by Kozeny and Carman [m²].
    pub kozeny_permeability: Real,
    /// Mean diameter of the horizontal struts [m]; each is up to a fifth thicker or thinner.
    pub strut_diameter: Real,
    /// Mean diameter of the largest ball around a point of the pores that still fits between the struts [m].
    pub pore_diameter: Real,
    /// Diameter of the largest ball that can travel through most of the pores [m], to a grid voxel.
    pub throat_diameter: Real,
    /// The same in particle spacings: below 3, flow through the throats is not resolved.
    pub throat_in_spacings: Real,
    /// The spacing that would resolve it: a third of the throat [m].
    pub resolving_spacing: Real,
}

/// Measures `bricks`, whose nodes are `voxel` [m] apart.
pub(super) fn measure(
    settings: &BoneSettings,
    network: &Network,
    bricks: &[BoneBrick],
    voxel: Real,
    spacing: Real,
) -> BoneReport {
    let cell = voxel * voxel * voxel;
    let mut bone = 0.0;
    let mut shell = 0.0;
    let mut tallies = vec![[Tally::default(); CLASSES]; settings.regions.len()];
    for brick in bricks {
        shell += brick.shell;
        for (total, of_brick) in tallies.iter_mut().zip(&brick.tallies) {
            for (total, class) in total.iter_mut().zip(of_brick) {
                total.add(class);
            }
        }
        for node in 0..512 {
            let phi = Real::from(brick.phi[node]);
            bone += solid_share(phi, voxel);
        }
    }
    let regions = (0..settings.regions.len())
        .map(|r| {
            let mut all = Tally::default();
            for class in &tallies[r] {
                all.add(class);
            }
            let share = |sum: Real, of: &Tally| if of.nodes > 0.0 { sum / of.nodes } else { 0.0 };
            let code = place::FIRST_REGION + r as u8;
            let throat = throat_diameter(bricks, code, voxel);
            let struts = &settings.regions[r].struts;
            let classes = tallies[r].iter().filter(|class| {
                matches!(struts, Struts::Varying(_)) && class.nodes > 0.01 * all.nodes
            });
            let porosity = 1.0 - share(all.solid, &all);
            let specific_surface = share(all.layer, &all) / voxel;
            RegionReport {
                name: settings.regions[r].name.clone(),
                volume: all.nodes * cell,
                asked_porosity: (!matches!(struts, Struts::Diameter(_)))
                    .then(|| share(all.asked, &all)),
                porosity,
                classes: classes
                    .map(|class| [share(class.asked, class), 1.0 - share(class.solid, class)])
                    .collect(),
                specific_surface,
                kozeny_permeability: kozeny(porosity, specific_surface),
                strut_diameter: network.diameters[r],
                pore_diameter: pore_diameter(bricks, code, voxel),
                throat_diameter: throat,
                throat_in_spacings: throat / spacing,
                resolving_spacing: throat / 3.0,
            }
        })
        .collect();
    BoneReport {
        bone_volume: bone * cell,
        shell_volume: shell * cell,
        struts: network.struts.len(),
        bone_connected: share_of(bricks, |phi, _| phi <= 0.0),
        pores_connected: share_of(bricks, |phi, place| phi > 0.0 && place != place::ELSEWHERE),
        reach: BALLS
            .map(|ball| reach(bricks, ball, spacing))
            .into_iter()
            .flatten()
            .collect(),
        regions,
    }
}

/// Balls whose way through the pores is tried, in spacings.
const BALLS: [Real; 5] = [0.5, 1.0, 2.0, 3.0, 4.0];

/// k = φ³/(5 S²); 0 where there is no surface to tell it.
fn kozeny(porosity: Real, specific_surface: Real) -> Real {
    if specific_surface > 0.0 {
        porosity.powi(3) / (5.0 * specific_surface * specific_surface)
    } else {
        0.0
    }
}

fn reach(bricks: &[BoneBrick], ball: Real, spacing: Real) -> Option<Reach> {
    let radius = (0.5 * ball * spacing) as f32;
    let pore = |brick: &BoneBrick, node: usize, radius: f32| {
        brick.phi[node] > radius && brick.place[node] != place::ELSEWHERE
    };
    let count = |radius: f32| -> u64 {
        let of = |brick: &BoneBrick| (0..512).filter(|n| pore(brick, *n, radius)).count() as u64;
        bricks.par_iter().map(of).sum()
    };
    let seeds: Vec<BrickMask> = bricks
        .iter()
        .map(|brick| mask_of(brick, |_, place| place == place::BORE))
        .collect();
    if seeds.iter().all(|mask| *mask == [0; 8]) {
        return None;
    }
    let masks: Vec<([i32; 3], BrickMask)> = bricks
        .par_iter()
        .map(|brick| {
            let mask = mask_of(brick, |phi, place| {
                phi > radius && place != place::ELSEWHERE
            });
            (brick.first, mask)
        })
        .collect();
    Some(Reach {
        ball_in_spacings: ball,
        fits: count(radius) as Real / count(0.0).max(1) as Real,
        reached: reached_share(&masks, |b| seeds[b]),
    })
}

fn mask_of(brick: &BoneBrick, pick: impl Fn(f32, u8) -> bool) -> BrickMask {
    let mut mask = [0_u64; 8];
    for node in 0..512 {
        let picked = pick(brick.phi[node], brick.place[node]);
        mask[node >> 6] |= u64::from(picked) << (node & 63);
    }
    mask
}

/// Share of the nodes picked by `pick(φ, place)` that hang together.
fn share_of(bricks: &[BoneBrick], pick: impl Fn(f32, u8) -> bool + Sync) -> Real {
    let masks: Vec<([i32; 3], BrickMask)> = bricks
        .par_iter()
        .filter_map(|brick| {
            let mask = mask_of(brick, &pick);
            (mask != [0; 8]).then_some((brick.first, mask))
        })
        .collect();
    connected_share(&masks)
}

/// As a mercury porosimeter sees it: the pores that a ball can enter stay one piece up to the throats' diameter, and
/// fall apart into cells beyond it.
fn throat_diameter(bricks: &[BoneBrick], region: u8, voxel: Real) -> Real {
    let largest = bricks.iter().flat_map(|brick| {
        let nodes = brick.phi.iter().zip(brick.place.iter());
        nodes
            .filter(|(_, place)| **place == region)
            .map(|(phi, _)| *phi)
    });
    let largest = largest.fold(0.0, f32::max);
    // In voxels: open at `low`, fallen apart or gone at `high`.
    let (mut low, mut high) = (0, (Real::from(largest) / voxel).ceil() as u32);
    while high > low + 1 {
        let middle = u32::midpoint(low, high);
        let radius = (Real::from(middle) * voxel) as f32;
        let share = share_of(bricks, |phi, place| place == region && phi > radius);
        if share > 0.5 {
            low = middle;
        } else {
            high = middle;
        }
    }
    2.0 * Real::from(low) * voxel
}

/// Twice the mean of the upper tenth of φ: the balls that sit in the middle of the pores.
fn pore_diameter(bricks: &[BoneBrick], region: u8, voxel: Real) -> Real {
    // Counted by fine classes: no list of millions of values needs to be sorted.
    const PER_VOXEL: Real = 16.0;
    let mut classes: Vec<u64> = Vec::new();
    for brick in bricks {
        for node in 0..512 {
            if brick.place[node] == region && brick.phi[node] > 0.0 {
                let class = (Real::from(brick.phi[node]) / voxel * PER_VOXEL) as usize;
                if classes.len() <= class {
                    classes.resize(class + 1, 0);
                }
                classes[class] += 1;
            }
        }
    }
    let tenth = classes.iter().sum::<u64>().div_ceil(10);
    let (mut left, mut sum) = (tenth, 0.0);
    for (class, &count) in classes.iter().enumerate().rev() {
        let taken = count.min(left);
        sum += taken as Real * (class as Real + 0.5);
        left -= taken;
    }
    2.0 * sum / tenth.max(1) as Real / PER_VOXEL * voxel
}
