//! Measures a bone on its grid: what was asked and what was made, and whether cement can pass.

use super::build::{BoneBrick, place, solid_share};
use super::network::Network;
use super::settings::{BoneSettings, Struts};
use crate::grid::{BrickMask, connected_share};
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
    /// By region.
    pub regions: Vec<RegionReport>,
}

/// One region of a bone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionReport {
    /// Name from the settings.
    pub name: String,
    /// Volume inside the shell, pores and struts [m³].
    pub volume: Real,
    /// Porosity that was asked for, if it was [1].
    pub asked_porosity: Option<Real>,
    /// Porosity that was made [1].
    pub porosity: Real,
    /// Mean diameter of the horizontal struts [m]; each is up to a fifth thicker or thinner.
    pub strut_diameter: Real,
    /// Mean diameter of the largest ball around a point of the pores that still fits between the struts [m].
    pub pore_diameter: Real,
    /// Diameter of the largest ball that can travel through most of the pores [m], to a grid voxel.
    pub throat_diameter: Real,
    /// The same in particle spacings: below 3, flow through the throats is not resolved.
    pub throat_in_spacings: Real,
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
    let mut region_nodes = vec![0_u64; settings.regions.len()];
    let mut region_solid = vec![0.0; settings.regions.len()];
    for brick in bricks {
        shell += brick.shell;
        for (total, of_brick) in region_solid.iter_mut().zip(&brick.struts) {
            *total += of_brick;
        }
        for node in 0..512 {
            bone += solid_share(brick.phi[node].into(), voxel);
            if brick.place[node] >= place::FIRST_REGION {
                let region = usize::from(brick.place[node] - place::FIRST_REGION);
                region_nodes[region] += 1;
            }
        }
    }
    let regions = (0..settings.regions.len())
        .map(|r| {
            let nodes = region_nodes[r] as Real;
            let code = place::FIRST_REGION + r as u8;
            let throat = throat_diameter(bricks, code, voxel);
            RegionReport {
                name: settings.regions[r].name.clone(),
                volume: nodes * cell,
                asked_porosity: match settings.regions[r].struts {
                    Struts::Porosity(porosity) => Some(porosity),
                    Struts::Diameter(_) => None,
                },
                porosity: if nodes > 0.0 {
                    1.0 - region_solid[r] / nodes
                } else {
                    1.0
                },
                strut_diameter: network.diameters[r],
                pore_diameter: pore_diameter(bricks, code, voxel),
                throat_diameter: throat,
                throat_in_spacings: throat / spacing,
            }
        })
        .collect();
    BoneReport {
        bone_volume: bone * cell,
        shell_volume: shell * cell,
        struts: network.struts.len(),
        bone_connected: share_of(bricks, |phi, _| phi <= 0.0),
        pores_connected: share_of(bricks, |phi, place| phi > 0.0 && place != place::ELSEWHERE),
        regions,
    }
}

/// Share of the nodes picked by `pick(φ, place)` that hang together.
fn share_of(bricks: &[BoneBrick], pick: impl Fn(f32, u8) -> bool + Sync) -> Real {
    let masks: Vec<([i32; 3], BrickMask)> = bricks
        .par_iter()
        .filter_map(|brick| {
            let mut mask = [0_u64; 8];
            for node in 0..512 {
                let picked = pick(brick.phi[node], brick.place[node]);
                mask[node >> 6] |= u64::from(picked) << (node & 63);
            }
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
