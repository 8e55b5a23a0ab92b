//! The walk through a VDB file: header, descriptors, trees.

use super::codec::{Fault, Input, Packing, is_set};
use super::{VdbError, VdbFile, VdbGrid, transform};
use crate::grid::{BRICK, BrickGrid};
use crate::math::Real;
use std::path::Path;

const MAGIC: i64 = 0x5644_4220;
/// A grid that unpacks to more bricks of 8³ voxels than this (2 GB) is refused.
pub const MAX_BRICKS: usize = 1_000_000;

/// Reads all scalar grids of a file.
pub fn read_vdb(path: &Path) -> Result<VdbFile, VdbError> {
    let file = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => parse_vdb(&bytes, &file),
        Err(source) => Err(VdbError::Read { file, source }),
    }
}

/// Reads all scalar grids of the `bytes` of a file; `file` is its name in messages.
pub fn parse_vdb(bytes: &[u8], file: &str) -> Result<VdbFile, VdbError> {
    let mut input = Input::new(bytes);
    let read = grids(&mut input).map_err(|fault| VdbError::Damaged {
        file: file.to_owned(),
        problem: fault.problem,
        at: fault.at,
    })?;
    if read.grids.is_empty() {
        let names: Vec<String> = read
            .passed_over
            .iter()
            .map(|(name, kind)| format!("`{name}` is a {kind}"))
            .collect();
        return Err(VdbError::Nothing {
            file: file.to_owned(),
            found: if names.is_empty() {
                "it is empty".to_owned()
            } else {
                names.join(", ")
            },
        });
    }
    Ok(read)
}

fn grids(input: &mut Input<'_>) -> Result<VdbFile, Fault> {
    if input.left() < 8 || input.i64()? != MAGIC {
        input.at = 0;
        return input.fault("this is no OpenVDB file, or its start is damaged");
    }
    let version = input.u32()?;
    if !(222..=224).contains(&version) {
        return input.fault(format!(
            "OpenVDB format version {version}: 222 to 224 can be read; save it anew with a current program"
        ));
    }
    input.take(8)?;
    let has_offsets = input.u8()? != 0;
    input.take(36)?;
    metadata(input)?;
    let count = input.u32()?;
    let mut file = VdbFile::default();
    let mut bricks = 0;
    for _ in 0..count {
        let unique = input.string()?;
        let kind = input.string()?;
        let parent = input.string()?;
        let [_, _, end] = [input.i64()?, input.i64()?, input.i64()?];
        let name = unique.split('\x1e').next().unwrap_or("").to_owned();
        let half = kind.ends_with("_HalfFloat");
        let tree = kind.trim_end_matches("_HalfFloat");
        let double = tree == "Tree_double_5_4_3";
        if (double || tree == "Tree_float_5_4_3") && parent.is_empty() {
            let packing = Packing {
                flags: 0,
                half,
                double,
                background: 0.0,
            };
            file.grids.push(grid(input, name, packing, &mut bricks)?);
        } else if has_offsets {
            file.passed_over.push((name, kind));
            // Only forwards: a grid that is said to end before it starts would be read for ever.
            if end < input.at as i64 {
                return input.fault("damaged: a grid ends before it starts");
            }
            input.seek(end)?;
        } else {
            return input.fault(format!(
                "grid `{name}` is a {kind}, and the file does not say where it ends"
            ));
        }
    }
    Ok(file)
}

/// Entries by name; only texts are kept.
fn metadata(input: &mut Input<'_>) -> Result<Vec<(String, String)>, Fault> {
    let count = input.u32()?;
    let mut texts = Vec::new();
    for _ in 0..count {
        let (name, kind) = (input.string()?, input.string()?);
        let length = input.u32()? as usize;
        let value = input.take(length)?;
        if kind == "string" {
            texts.push((name, String::from_utf8_lossy(value).into_owned()));
        }
    }
    Ok(texts)
}

fn grid(
    input: &mut Input<'_>,
    name: String,
    mut packing: Packing,
    bricks: &mut usize,
) -> Result<VdbGrid, Fault> {
    packing.flags = input.u32()?;
    if packing.flags > 7 {
        return input.fault(format!("damaged: {} is no way of packing", packing.flags));
    }
    let texts = metadata(input)?;
    let class = texts.into_iter().find(|(name, _)| name == "class");
    let to_world = transform::read(input)?;
    if input.u32()? != 1 {
        return input.fault("a grid of several buffers is not supported");
    }
    packing.background = packing.value(input)?;
    let mut tree = Tree {
        packing,
        leaves: Vec::new(),
        values: BrickGrid::new(crate::math::Vec3::zeros(), 1.0, packing.background),
        bricks,
        stats: Stats::default(),
    };
    tree.topology(input)?;
    tree.buffers(input)?;
    let Tree { values, stats, .. } = tree;
    if stats.active > 0 && !stats.sum.is_finite() {
        return input.fault(format!("grid `{name}` holds values that are no numbers"));
    }
    Ok(VdbGrid {
        name,
        class: class.map_or("unknown".to_owned(), |(_, class)| class),
        packing: describe(&packing),
        to_world,
        values,
        active: stats.active,
        bounds: (stats.low, stats.high),
        range: [
            stats.least,
            stats.sum / stats.active.max(1) as Real,
            stats.greatest,
        ],
    })
}

fn describe(packing: &Packing) -> String {
    let codec = match packing.flags & 5 {
        0 => "unpacked",
        1 => "zip",
        _ => "blosc",
    };
    let active = if packing.flags & 2 != 0 {
        ", active values only"
    } else {
        ""
    };
    let half = if packing.half { ", half floats" } else { "" };
    format!("{codec}{active}{half}")
}

struct Tree<'a> {
    packing: Packing,
    /// First voxel of every leaf, in the order of the file, and its active voxels.
    leaves: Vec<([i32; 3], [u64; 8])>,
    values: BrickGrid,
    bricks: &'a mut usize,
    stats: Stats,
}

#[derive(Default)]
struct Stats {
    active: u64,
    sum: Real,
    least: Real,
    greatest: Real,
    low: [i32; 3],
    high: [i32; 3],
}

impl Stats {
    fn add(&mut self, low: [i32; 3], edge: i32, value: f32) {
        let value = Real::from(value);
        let high = low.map(|l| l + edge - 1);
        if self.active == 0 {
            (self.least, self.greatest, self.low, self.high) = (value, value, low, high);
        }
        self.least = self.least.min(value);
        self.greatest = self.greatest.max(value);
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(low[axis]);
            self.high[axis] = self.high[axis].max(high[axis]);
        }
        let voxels = u64::from(edge.unsigned_abs()).pow(3);
        self.active += voxels;
        self.sum += value * voxels as Real;
    }
}

/// Voxels along the edge of a child of each kind of node, and children along the edge of the node.
const LEVELS: [(i32, i32); 2] = [(128, 32), (8, 16)];
/// Farther voxels are refused, so that no index overflows.
const FARTHEST: i32 = 1 << 30;

impl Tree<'_> {
    fn topology(&mut self, input: &mut Input<'_>) -> Result<(), Fault> {
        let (tiles, children) = (input.u32()?, input.u32()?);
        for _ in 0..tiles {
            let first = origin(input)?;
            let value = self.packing.value(input)?;
            if input.u8()? != 0 {
                return input.fault(format!(
                    "a tile of 4096³ voxels is filled with {value} at {first:?}: cut the volume to what matters"
                ));
            }
        }
        for _ in 0..children {
            let first = origin(input)?;
            self.node(input, first, 0)?;
        }
        Ok(())
    }

    /// A node of 32³ or 16³ children; those of the latter are leaves.
    fn node(&mut self, input: &mut Input<'_>, first: [i32; 3], level: usize) -> Result<(), Fault> {
        let (edge, side) = LEVELS[level];
        let count = (side * side * side) as usize;
        let children = input.mask(count)?;
        let active = input.mask(count)?;
        let values = self.packing.values(input, &active)?;
        let place = |n: usize| {
            let n = n as i32;
            let at = [n / (side * side), n / side % side, n % side];
            std::array::from_fn(|axis| first[axis] + at[axis] * edge)
        };
        for n in 0..count {
            let first = place(n);
            if is_set(&children, n) {
                if level == 0 {
                    self.node(input, first, 1)?;
                } else {
                    let mask = input.mask(512)?;
                    self.leaves
                        .push((first, mask.try_into().expect("eight words")));
                    self.count(input, 1)?;
                }
            } else if is_set(&active, n) || values[n] != self.packing.background {
                self.tile(input, first, edge, values[n], is_set(&active, n))?;
            }
        }
        Ok(())
    }

    fn tile(
        &mut self,
        input: &Input<'_>,
        first: [i32; 3],
        edge: i32,
        value: f32,
        active: bool,
    ) -> Result<(), Fault> {
        let side = edge / BRICK;
        self.count(input, (side * side * side) as usize)?;
        if active {
            self.stats.add(first, edge, value);
        }
        for n in 0..side * side * side {
            let at = [n / (side * side), n / side % side, n % side];
            let brick = std::array::from_fn(|axis| first[axis] + at[axis] * BRICK);
            self.values.insert_brick(brick, Box::new([value; 512]));
        }
        Ok(())
    }

    fn count(&mut self, input: &Input<'_>, more: usize) -> Result<(), Fault> {
        *self.bricks += more;
        if *self.bricks > MAX_BRICKS {
            return input.fault(format!(
                "unpacks to more than {MAX_BRICKS} bricks of 8³ voxels: cut it to the bone, or resample it coarser"
            ));
        }
        Ok(())
    }

    fn buffers(&mut self, input: &mut Input<'_>) -> Result<(), Fault> {
        for (first, _) in std::mem::take(&mut self.leaves) {
            let mask = input.mask(512)?;
            let values = self.packing.values(input, &mask)?;
            for n in (0..512_i32).filter(|n| is_set(&mask, *n as usize)) {
                let at = [n >> 6, n >> 3 & 7, n & 7];
                let voxel = std::array::from_fn(|axis| first[axis] + at[axis]);
                self.stats.add(voxel, 1, values[n as usize]);
            }
            let values: Box<[f32]> = values.into();
            let values = values.try_into().expect("512 values");
            self.values.insert_brick(first, values);
        }
        Ok(())
    }
}

fn origin(input: &mut Input<'_>) -> Result<[i32; 3], Fault> {
    let first = [input.i32()?, input.i32()?, input.i32()?];
    if first.iter().any(|c| c % 4096 != 0 || c.abs() > FARTHEST) {
        return input.fault(format!("damaged: a node starts at {first:?}"));
    }
    Ok(first)
}
