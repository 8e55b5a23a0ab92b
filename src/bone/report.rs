//! Measures a bone on its grid: what was asked and what was made, and whether cement can pass.

use super::build::{BoneBrick, CLASSES, Tally, place};
use super::hold;
use super::network::Network;
use super::settings::{BoneSettings, Struts};
use crate::grid::{BrickMask, BrickNeighbours, count};
use crate::math::{Real, Wide, widest};
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
    /// Share of the struts below the shell that hang together with that piece [1].
    #[serde(default)]
    pub struts_connected: Real,
    /// Share of those struts that does not, but ends where the domain cuts the bone: it may beyond that [1].
    #[serde(default)]
    pub struts_cut: Real,
    /// Share of the pores inside the shell that hang together in one piece [1].
    pub pores_connected: Real,
    /// Share of the pores that hung together with nothing and were closed [1].
    #[serde(default)]
    pub pockets_closed: Real,
    /// How much of the pores balls of growing size get to.
    pub reach: Vec<Reach>,
    /// By region.
    pub regions: Vec<RegionReport>,
}

/// How far a ball gets through the pores, as mercury does under a pressure: what it can fill, to a node of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Diameter of the ball in particle spacings.
    pub ball_in_spacings: Real,
    /// Share of the pores that such balls fill, wherever they come from [1].
    pub fits: Real,
    /// Share of the pores that those fill which come from the bores, or without bores from the largest piece [1].
    pub reached: Real,
}

impl BoneReport {
    /// Widths of the widest ways to the pores: from and to [particle spacings], and the share of the pores that is
    /// reached on such ways. The last class has no upper end; what is missing from a sum of 1 is narrower than all.
    pub fn throats(&self) -> Vec<(Real, Option<Real>, Real)> {
        let next = self.reach.iter().skip(1).map(Some).chain([None]);
        let class = |(reach, next): (&Reach, Option<&Reach>)| {
            (
                reach.ball_in_spacings,
                next.map(|next| next.ball_in_spacings),
                reach.reached - next.map_or(0.0, |next| next.reached),
            )
        };
        self.reach.iter().zip(next).map(class).collect()
    }

    /// Share of the pores that balls of so many spacings reach [1], by the largest of those tried that is no larger.
    pub fn reached(&self, ball_in_spacings: Real) -> Real {
        let tried = self.reach.iter();
        let last = tried.take_while(|reach| reach.ball_in_spacings <= ball_in_spacings);
        last.last().map_or(1.0, |reach| reach.reached)
    }
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
    /// Share of the region that lies in pores which balls of [`ACROSS`] spacings fill [1]: there, flow is resolved.
    pub resolvable_porosity: Real,
    /// Where the asked porosity varies: asked and made in each twentieth that a hundredth of the region falls into [1].
    pub classes: Vec<[Real; 2]>,
    /// Surface of the struts in the volume of pores and struts [1/m].
    pub specific_surface: Real,
    /// Permeability φ³/(K S²) by Kozeny and Carman [m²]: what a creeping flow through struts finds, within a third.
    pub kozeny_permeability: Real,
    /// Its constant K [1], that of rods in all directions at this porosity [Happel59]. For packed grains it is 5, which
    /// gives two to three times too much for the few rods of porous bone.
    pub kozeny_constant: Real,
    /// Mean diameter of the horizontal struts [m]; each is up to a fifth thicker or thinner.
    pub strut_diameter: Real,
    /// Mean diameter of the largest ball around a point of the pores that still fits between the struts [m].
    pub pore_diameter: Real,
    /// Diameter of the largest ball that can travel through most of the pores [m], to a grid voxel.
    pub throat_diameter: Real,
    /// The same in particle spacings: below 3, flow through the throats is not resolved.
    pub throat_in_spacings: Real,
    /// The spacing that would resolve it: [`ACROSS`] of them across the throat [m].
    pub resolving_spacing: Real,
}

/// Spacings across a pore from which on the flow through it is resolved.
pub const ACROSS: Real = 3.0;

/// Balls whose way through the pores is tried, in spacings.
const BALLS: [Real; 8] = [0.5, 1.0, 1.5, 2.0, ACROSS, 4.0, 6.0, 8.0];

/// Measures `bricks`, whose nodes are `voxel` [m] apart.
pub(super) fn measure(
    settings: &BoneSettings,
    network: &Network,
    bricks: &[BoneBrick],
    voxel: Real,
    spacing: Real,
) -> BoneReport {
    let cell = voxel * voxel * voxel;
    let mut shell = 0.0;
    let mut tallies = vec![[Tally::default(); CLASSES]; settings.regions.len()];
    for brick in bricks {
        shell += brick.shell;
        for (total, of_brick) in tallies.iter_mut().zip(&brick.tallies) {
            for (total, class) in total.iter_mut().zip(of_brick) {
                total.add(class);
            }
        }
    }
    let struts_below: Real = tallies.iter().flatten().map(|class| class.solid).sum();
    let pores = Pores::new(bricks, voxel);
    let all_pores = pores.open();
    let hold = hold::measure(&pores);
    let resolved = pores.grown(&pores.room(ACROSS * spacing), &all_pores, ACROSS * spacing);
    let regions = (0..settings.regions.len())
        .map(|r| {
            let mut all = Tally::default();
            for class in &tallies[r] {
                all.add(class);
            }
            let share = |sum: Real, of: &Tally| if of.nodes > 0.0 { sum / of.nodes } else { 0.0 };
            let code = place::FIRST_REGION + r as u8;
            let throat = pores.throat_diameter(code);
            let struts = &settings.regions[r].struts;
            let classes = tallies[r].iter().filter(|class| {
                matches!(struts, Struts::Varying(_)) && class.nodes > 0.01 * all.nodes
            });
            let porosity = 1.0 - share(all.solid, &all);
            let specific_surface = share(all.layer, &all) / voxel;
            let open = pores.masks(|phi, place| phi > 0.0 && place == code);
            RegionReport {
                name: settings.regions[r].name.clone(),
                volume: all.nodes * cell,
                asked_porosity: (!matches!(struts, Struts::Diameter(_)))
                    .then(|| share(all.asked, &all)),
                porosity,
                resolvable_porosity: porosity * share_in(&resolved, &open),
                classes: classes
                    .map(|class| [share(class.asked, class), 1.0 - share(class.solid, class)])
                    .collect(),
                specific_surface,
                kozeny_permeability: kozeny(porosity, specific_surface),
                kozeny_constant: kozeny_constant(porosity),
                strut_diameter: network.diameters[r],
                pore_diameter: pores.pore_diameter(code),
                throat_diameter: throat,
                throat_in_spacings: throat / spacing,
                resolving_spacing: throat / ACROSS,
            }
        })
        .collect();
    let seeds = pores.masks(|_, place| place == place::BORE);
    let seeds = seeds.iter().any(|mask| *mask != [0; 8]).then_some(seeds);
    let reach = BALLS.into_iter().map(|ball| {
        let room = pores.room(ball * spacing);
        let reached = pores.reached(&room, seeds.as_deref());
        let share = |centres| {
            let filled = pores.grown(centres, &all_pores, ball * spacing);
            share_in(&filled, &all_pores)
        };
        let fits = share(&room);
        Reach {
            ball_in_spacings: ball,
            fits,
            reached: if reached == room {
                fits
            } else {
                share(&reached)
            },
        }
    });
    // Beyond the first ball that fits nowhere there is nothing to know.
    let mut none_before = false;
    let reach = reach.take_while(|reach| {
        let wanted = !none_before;
        none_before = reach.fits == 0.0;
        wanted
    });
    let reach = reach.collect();
    BoneReport {
        bone_volume: (shell + struts_below) * cell,
        shell_volume: shell * cell,
        struts: network.count,
        bone_connected: hold.bone,
        struts_connected: hold.struts,
        struts_cut: hold.struts_cut,
        pores_connected: pores.neighbours.connected_share(&all_pores),
        pockets_closed: 0.0,
        reach,
        regions,
    }
}

/// k = φ³/(K S²); 0 where there is no surface to tell it.
fn kozeny(porosity: Real, specific_surface: Real) -> Real {
    let below = kozeny_constant(porosity) * specific_surface * specific_surface;
    if below > 0.0 {
        porosity.powi(3) / below
    } else {
        0.0
    }
}

/// The constant of Kozeny and Carman for rods in all directions, from Happel's cells around rods of radius a = 2 c/S,
/// c = 1 − φ, a third along the flow, two thirds across:
///
/// ```text
/// K = φ³/(4 c² κ),   κ = k/a²,   κ_along = (4 c − c² − 3 − 2 ln c)/(8 c),   κ_across = (−ln c − (1 − c²)/(1 + c²))/(8 c)
/// ```
fn kozeny_constant(porosity: Real) -> Real {
    let c = 1.0 - porosity;
    if c <= 0.0 || porosity <= 0.0 {
        return 0.0;
    }
    let ln = libm::log(c);
    let along = (4.0 * c - c * c - 3.0 - 2.0 * ln) / (8.0 * c);
    let across = (-ln - (1.0 - c * c) / (1.0 + c * c)) / (8.0 * c);
    porosity.powi(3) / (4.0 * c * c * (along + 2.0 * across) / 3.0)
}

/// Share of the nodes of `whole` that are in `part` as well; 0 of none.
pub(super) fn share_in(part: &[BrickMask], whole: &[BrickMask]) -> Real {
    let of_both = |(a, b): (&BrickMask, &BrickMask)| count(&std::array::from_fn(|x| a[x] & b[x]));
    let both: u64 = part.iter().zip(whole).map(of_both).sum();
    let all: u64 = whole.iter().map(count).sum();
    both as Real / all.max(1) as Real
}

/// The nodes of a brick for which `pick(φ, place)` holds.
struct Picked<'a, P> {
    brick: &'a BoneBrick,
    pick: &'a P,
}

impl<P: Fn(f32, u8) -> bool> Wide for Picked<'_, P> {
    type Out = BrickMask;

    #[inline(always)]
    fn run(self) -> BrickMask {
        let mut picked = [0_u8; 512];
        for (node, picked) in picked.iter_mut().enumerate() {
            *picked = u8::from((self.pick)(self.brick.phi[node], self.brick.place[node]));
        }
        let (eights, _) = picked.as_chunks::<8>();
        std::array::from_fn(|word| {
            let of_word = eights[8 * word..8 * word + 8].iter().enumerate();
            of_word.fold(0, |mask, (byte, eight)| {
                // Gathers the lowest bits of eight bytes in the highest byte.
                let bits = u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
                mask | bits << (8 * byte)
            })
        })
    }
}

/// The bricks of a bone as sets of nodes.
pub(super) struct Pores<'a> {
    bricks: &'a [BoneBrick],
    neighbours: BrickNeighbours,
    voxel: Real,
}

impl<'a> Pores<'a> {
    pub(super) fn new(bricks: &'a [BoneBrick], voxel: Real) -> Self {
        let firsts: Vec<[i32; 3]> = bricks.iter().map(|brick| brick.first).collect();
        Self {
            bricks,
            neighbours: BrickNeighbours::new(&firsts),
            voxel,
        }
    }

    /// All pores.
    pub(super) fn open(&self) -> Vec<BrickMask> {
        self.masks(|phi, place| phi > 0.0 && place != place::ELSEWHERE)
    }

    /// The marked nodes that hang together with a seed, or without seeds those of the largest piece.
    pub(super) fn reached(
        &self,
        marked: &[BrickMask],
        seeds: Option<&[BrickMask]>,
    ) -> Vec<BrickMask> {
        self.neighbours.reached(marked, seeds)
    }

    /// The nodes without a brick behind them.
    pub(super) fn rim(&self) -> Vec<BrickMask> {
        self.neighbours.rim()
    }

    /// The nodes picked by `pick(φ, place)`.
    pub(super) fn masks(&self, pick: impl Fn(f32, u8) -> bool + Sync) -> Vec<BrickMask> {
        let mask_of = |brick: &BoneBrick| widest(Picked { brick, pick: &pick });
        self.bricks.par_iter().map(mask_of).collect()
    }

    /// Share of the nodes picked by `pick(φ, place)` that hang together.
    fn share_of(&self, pick: impl Fn(f32, u8) -> bool + Sync) -> Real {
        self.neighbours.connected_share(&self.masks(pick))
    }

    /// Where a ball of a `diameter` [m] has room for its centre.
    fn room(&self, diameter: Real) -> Vec<BrickMask> {
        let radius = (0.5 * diameter) as f32;
        self.masks(|phi, place| phi > radius && place != place::ELSEWHERE)
    }

    /// What balls of a `diameter` [m] around `centres` hold of the pores.
    fn grown(&self, centres: &[BrickMask], pores: &[BrickMask], diameter: Real) -> Vec<BrickMask> {
        let steps = (0.5 * diameter / self.voxel).ceil() as usize;
        let grown = self.neighbours.grown(centres, steps);
        let both = |(a, b): (&BrickMask, &BrickMask)| std::array::from_fn(|x| a[x] & b[x]);
        grown.par_iter().zip(pores).map(both).collect()
    }

    /// As a mercury porosimeter sees it: the pores that a ball can enter stay one piece up to the throats' diameter,
    /// and fall apart into cells beyond it.
    fn throat_diameter(&self, region: u8) -> Real {
        let largest = |brick: &BoneBrick| {
            let nodes = brick.phi.iter().zip(brick.place.iter());
            let of_region = nodes.filter(|(_, place)| **place == region);
            of_region.fold(0.0, |most: f32, (phi, _)| most.max(*phi))
        };
        let largest = self.bricks.par_iter().map(largest).reduce(|| 0.0, f32::max);
        // In voxels: open at `low`, fallen apart or gone at `high`.
        let (mut low, mut high) = (0, (Real::from(largest) / self.voxel).ceil() as u32);
        while high > low + 1 {
            let middle = u32::midpoint(low, high);
            let radius = (Real::from(middle) * self.voxel) as f32;
            let share = self.share_of(|phi, place| place == region && phi > radius);
            if share > 0.5 {
                low = middle;
            } else {
                high = middle;
            }
        }
        2.0 * Real::from(low) * self.voxel
    }

    /// Twice the mean of the upper tenth of φ: the balls that sit in the middle of the pores.
    fn pore_diameter(&self, region: u8) -> Real {
        // Counted by fine classes: no list of millions of values needs to be sorted.
        const PER_VOXEL: Real = 16.0;
        const BRICKS: usize = 1 << 12;
        let of_bricks = |bricks: &[BoneBrick]| {
            let mut classes: Vec<u64> = Vec::new();
            for brick in bricks {
                for node in 0..512 {
                    if brick.place[node] == region && brick.phi[node] > 0.0 {
                        let class = (Real::from(brick.phi[node]) / self.voxel * PER_VOXEL) as usize;
                        if classes.len() <= class {
                            classes.resize(class + 1, 0);
                        }
                        classes[class] += 1;
                    }
                }
            }
            classes
        };
        let parts: Vec<Vec<u64>> = self.bricks.par_chunks(BRICKS).map(of_bricks).collect();
        let most = parts.iter().map(Vec::len).max().unwrap_or(0);
        let of_class = |class: usize| parts.iter().filter_map(|part| part.get(class)).sum();
        let classes: Vec<u64> = (0..most).map(of_class).collect();
        let tenth = classes.iter().sum::<u64>().div_ceil(10);
        let (mut left, mut sum) = (tenth, 0.0);
        for (class, &count) in classes.iter().enumerate().rev() {
            let taken = count.min(left);
            sum += taken as Real * (class as Real + 0.5);
            left -= taken;
        }
        2.0 * sum / tenth.max(1) as Real / PER_VOXEL * self.voxel
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between the constants along and across, 7.31 and 11.03 at a porosity of 0.9, 31.1 and 53.8 at 0.99 [Happel59].
    #[test]
    fn the_constant_of_rods_lies_where_permeabilities_add_up() {
        for (porosity, along, across) in [(0.9, 7.31, 11.03), (0.99, 31.10, 53.83)] {
            let expected = 3.0 / (1.0 / along + 2.0 / across);
            let found = kozeny_constant(porosity);
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
        }
        assert_eq!(kozeny_constant(1.0), 0.0);
    }
}
