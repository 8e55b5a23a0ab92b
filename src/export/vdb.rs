//! OpenVDB files, format version 224, as OpenVDB 10 and later and Blender read them [Museth13].
//!
//! A tree has a root, nodes of 32³ and of 16³ children, and leaves of 8³ voxels. A grid's topology comes first, then
//! the values of all leaves in the same order. Only active values are stored (compression flag `ACTIVE_MASK`).
//!
//! Based on: [Museth13] and OpenVDB's own files.   Does not: write tiles.

use super::{Class, Codec, ExportSettings, Grid, Leaf, Leaves};
use half::f16;
use rayon::prelude::*;
use std::io::{self, Write};

const ACTIVE_MASK: u32 = 2;
/// Which values the inactive voxels of a node have: the background, the background with its sign turned, or both, and
/// then a mask follows that says where the background is.
const INACTIVE_IS_BACKGROUND: u8 = 0;
const INACTIVE_IS_TURNED: u8 = 1;
const INACTIVE_IS_EITHER: u8 = 3;
/// Where the file's identity stands, as text.
const UUID: std::ops::Range<usize> = 21..57;

/// How values are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Storage {
    /// How they are packed.
    pub codec: Codec,
    /// As halves.
    pub half: bool,
}

impl From<&ExportSettings> for Storage {
    fn from(settings: &ExportSettings) -> Self {
        Self {
            codec: settings.codec,
            half: settings.half,
        }
    }
}

/// Writes `grids` as one file. The same grids give the same bytes. Fails if two grids have one name.
pub fn write(out: &mut impl Write, grids: &[Grid], storage: Storage) -> io::Result<()> {
    for (i, grid) in grids.iter().enumerate() {
        if grids[..i].iter().any(|other| other.name == grid.name) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("two grids are called \"{}\": rename one", grid.name),
            ));
        }
    }
    let mut file = Vec::new();
    put(&mut file, &0x5644_4220_i64.to_le_bytes());
    for version in [224_u32, 10, 0] {
        put(&mut file, &version.to_le_bytes());
    }
    let has_offsets = 1;
    file.push(has_offsets);
    file.resize(UUID.end, b'0');
    put(&mut file, &0_u32.to_le_bytes());
    put(&mut file, &(grids.len() as u32).to_le_bytes());
    for grid in grids {
        match &grid.leaves {
            Leaves::Float(leaves) => put_grid(&mut file, grid, leaves, storage),
            Leaves::Vec3(leaves) => put_grid(&mut file, grid, leaves, storage),
        }
    }
    let uuid = identity(&file[UUID.end..]);
    file[UUID].copy_from_slice(uuid.as_bytes());
    out.write_all(&file)
}

/// A type of voxel that the file can hold.
trait Voxel: Copy + Sync {
    const TREE: &str;
    /// What a client must know to turn it with the grid.
    const VECTOR_TYPE: Option<&str>;
    /// Its numbers.
    fn numbers(&self) -> &[f32];
    /// The same number throughout.
    fn all(number: f32) -> Self;
}

impl Voxel for f32 {
    const TREE: &str = "Tree_float_5_4_3";
    const VECTOR_TYPE: Option<&str> = None;
    fn numbers(&self) -> &[f32] {
        std::slice::from_ref(self)
    }
    fn all(number: f32) -> Self {
        number
    }
}

impl Voxel for [f32; 3] {
    const TREE: &str = "Tree_vec3s_5_4_3";
    const VECTOR_TYPE: Option<&str> = Some("contravariant relative");
    fn numbers(&self) -> &[f32] {
        self
    }
    fn all(number: f32) -> Self {
        [number; 3]
    }
}

/// Appends the numbers of a value at full size.
fn put_full<T: Voxel>(file: &mut Vec<u8>, value: &T) {
    file.extend(value.numbers().iter().flat_map(|n| n.to_le_bytes()));
}

fn put_grid<T: Voxel>(file: &mut Vec<u8>, grid: &Grid, leaves: &[Leaf<T>], storage: Storage) {
    let mut leaves: Vec<&Leaf<T>> = leaves.iter().collect();
    leaves.sort_unstable_by_key(|leaf| place(leaf.first));

    put_string(file, &grid.name);
    let half = if storage.half { "_HalfFloat" } else { "" };
    put_string(file, &format!("{}{half}", T::TREE));
    put_string(file, "");
    let offsets = file.len();
    file.resize(offsets + 24, 0);
    let mark = |file: &mut Vec<u8>, which: usize| {
        let here = file.len() as i64;
        file[offsets + 8 * which..][..8].copy_from_slice(&here.to_le_bytes());
    };

    mark(file, 0);
    let background = match grid.class {
        Class::Fog => 0.0,
        Class::LevelSet { background } => background,
    };
    put(file, &(ACTIVE_MASK | storage.codec.flag()).to_le_bytes());
    put_metadata(file, grid, &leaves, storage);
    put_transform(file, grid);
    put_topology(file, &leaves, T::all(background), storage);
    mark(file, 1);
    let packed: Vec<Vec<u8>> = leaves
        .par_iter()
        .map(|leaf| packed_leaf(leaf, background, storage))
        .collect();
    for leaf in packed {
        put(file, &leaf);
    }
    mark(file, 2);
}

/// Root child (its first voxel), child of the 32³ node, child of the 16³ node.
fn place(first: [i32; 3]) -> ([i32; 3], usize, usize) {
    debug_assert!(first.iter().all(|x| x % 8 == 0));
    let within = |shift: u32, bits: u32| {
        first.iter().fold(0, |offset, x| {
            offset << bits | (*x >> shift) as usize & ((1 << bits) - 1)
        })
    };
    (first.map(|x| x & !4095), within(7, 5), within(3, 4))
}

fn put_topology<T: Voxel>(
    file: &mut Vec<u8>,
    leaves: &[&Leaf<T>],
    background: T,
    storage: Storage,
) {
    let roots = || leaves.chunk_by(|a, b| place(a.first).0 == place(b.first).0);
    put(file, &1_u32.to_le_bytes());
    put_full(file, &background);
    put(file, &0_u32.to_le_bytes());
    put(file, &(roots().count() as u32).to_le_bytes());
    for root in roots() {
        for x in place(root[0].first).0 {
            put(file, &x.to_le_bytes());
        }
        let nodes = || root.chunk_by(|a, b| place(a.first).1 == place(b.first).1);
        let children = nodes().map(|n| place(n[0].first).1);
        put_inner_node(file, 32 * 32 * 32, children, storage);
        for node in nodes() {
            let children = node.iter().map(|l| place(l.first).2);
            put_inner_node(file, 16 * 16 * 16, children, storage);
            for leaf in node {
                put_words(file, &leaf.active);
            }
        }
    }
}

/// A node with children and no tiles: its own values are the background, and none is active.
fn put_inner_node(
    file: &mut Vec<u8>,
    size: usize,
    children: impl Iterator<Item = usize>,
    storage: Storage,
) {
    let mut mask = vec![0_u64; size / 64];
    for child in children {
        mask[child >> 6] |= 1 << (child & 63);
    }
    put_words(file, &mask);
    mask.fill(0);
    put_words(file, &mask);
    file.push(INACTIVE_IS_BACKGROUND);
    put_values::<f32>(file, &[], storage);
}

/// A leaf among the values: which voxels are active, what the others are, and the values of the active.
fn packed_leaf<T: Voxel>(leaf: &Leaf<T>, background: f32, storage: Storage) -> Vec<u8> {
    let mut bytes = Vec::new();
    put_words(&mut bytes, &leaf.active);
    let is_active = |i: usize| leaf.active[i >> 6] >> (i & 63) & 1 == 1;
    // Only a level set has a second value for inactive voxels.
    let mut plain = [0_u64; 8];
    for i in (0..512).filter(|&i| !is_active(i)) {
        if background == 0.0 || leaf.values[i].numbers()[0] > 0.0 {
            plain[i >> 6] |= 1 << (i & 63);
        }
    }
    if plain == [0; 8] && leaf.active != [u64::MAX; 8] {
        bytes.push(INACTIVE_IS_TURNED);
    } else if plain == leaf.active.map(|word| !word) {
        bytes.push(INACTIVE_IS_BACKGROUND);
    } else {
        bytes.push(INACTIVE_IS_EITHER);
        put_words(&mut bytes, &plain);
    }
    let active: Vec<T> = (0..512)
        .filter(|&i| is_active(i))
        .map(|i| leaf.values[i])
        .collect();
    put_values(&mut bytes, &active, storage);
    bytes
}

/// The active values of a node.
fn put_values<T: Voxel>(file: &mut Vec<u8>, active: &[T], storage: Storage) {
    let numbers = active.iter().flat_map(Voxel::numbers);
    if storage.half {
        // No values are nothing at all, not even the length 0 that full floats have.
        if !active.is_empty() {
            let bytes: Vec<u8> = numbers
                .flat_map(|&n| f16::from_f32(n).to_le_bytes())
                .collect();
            storage.codec.put(file, &bytes, 2);
        }
    } else {
        let bytes: Vec<u8> = numbers.flat_map(|n| n.to_le_bytes()).collect();
        storage.codec.put(file, &bytes, 4);
    }
}

fn put_metadata<T: Voxel>(file: &mut Vec<u8>, grid: &Grid, leaves: &[&Leaf<T>], storage: Storage) {
    let class = match grid.class {
        Class::Fog => "fog volume",
        Class::LevelSet { .. } => "level set",
    };
    // OpenVDB's own bounds of an empty grid.
    let (mut low, mut high, mut count) = ([i32::MAX; 3], [i32::MIN; 3], 0_i64);
    for leaf in leaves {
        for i in (0..512_i32).filter(|i| leaf.active[*i as usize >> 6] >> (i & 63) & 1 == 1) {
            let inner = [i >> 6, i >> 3 & 7, i & 7];
            for axis in 0..3 {
                let x = leaf.first[axis] + inner[axis];
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
            count += 1;
        }
    }
    let bytes = |corner: [i32; 3]| corner.map(i32::to_le_bytes).concat();
    let mut entries: Vec<(&str, &str, Vec<u8>)> = vec![
        ("class", "string", class.into()),
        (
            "creator",
            "string",
            concat!("osteoflow ", env!("CARGO_PKG_VERSION")).into(),
        ),
        ("file_bbox_max", "vec3i", bytes(high)),
        ("file_bbox_min", "vec3i", bytes(low)),
        ("file_voxel_count", "int64", count.to_le_bytes().to_vec()),
        ("is_saved_as_half_float", "bool", vec![storage.half.into()]),
        ("name", "string", grid.name.clone().into()),
    ];
    if let Some(kind) = T::VECTOR_TYPE {
        entries.push(("vector_type", "string", kind.into()));
    }
    put(file, &(entries.len() as u32).to_le_bytes());
    for (key, kind, value) in entries {
        put_string(file, key);
        put_string(file, kind);
        put(file, &(value.len() as u32).to_le_bytes());
        put(file, &value);
    }
}

fn put_transform(file: &mut Vec<u8>, grid: &Grid) {
    let scale = grid.voxel;
    put_string(file, "UniformScaleTranslateMap");
    for axis in 0..3 {
        put(file, &grid.origin[axis].to_le_bytes());
    }
    for derived in [
        scale,
        scale,
        1.0 / scale,
        1.0 / (scale * scale),
        0.5 / scale,
    ] {
        for _ in 0..3 {
            put(file, &derived.to_le_bytes());
        }
    }
}

fn put(file: &mut Vec<u8>, bytes: &[u8]) {
    file.extend_from_slice(bytes);
}

fn put_string(file: &mut Vec<u8>, text: &str) {
    put(file, &(text.len() as u32).to_le_bytes());
    put(file, text.as_bytes());
}

fn put_words(file: &mut Vec<u8>, words: &[u64]) {
    for word in words {
        put(file, &word.to_le_bytes());
    }
}

/// A UUID that depends on the content only: its 128-bit FNV-1a sum.
fn identity(content: &[u8]) -> String {
    let sum = content.iter().fold(
        0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128,
        |sum, byte| (sum ^ u128::from(*byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b),
    );
    let hex = format!("{sum:032x}");
    [
        &hex[..8],
        &hex[8..12],
        &hex[12..16],
        &hex[16..20],
        &hex[20..],
    ]
    .join("-")
}

#[cfg(test)]
mod tests;
