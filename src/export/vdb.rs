//! OpenVDB files, format version 224, as OpenVDB 10 and later and Blender read them [Museth13].
//!
//! A tree has a root, nodes of 32³ and of 16³ children, and leaves of 8³ voxels. A grid's topology comes first, then
//! the values of all leaves in the same order. Only active values are stored (compression flag `ACTIVE_MASK`).
//!
//! Based on: [Museth13] and OpenVDB's own files.   Does not: pack the values, or write tiles and level sets.

use super::{Grid, Leaf, Leaves};
use std::io::{self, Write};

const ACTIVE_MASK: u32 = 2;
/// "All inactive values are the background": the only case that fog volumes need.
const INACTIVE_IS_BACKGROUND: u8 = 0;
/// Where the file's identity stands, as text.
const UUID: std::ops::Range<usize> = 21..57;

/// Writes `grids` as one file. The same grids give the same bytes. Fails if two grids have one name.
pub fn write(out: &mut impl Write, grids: &[Grid]) -> io::Result<()> {
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
            Leaves::Float(leaves) => put_grid(&mut file, grid, leaves),
            Leaves::Vec3(leaves) => put_grid(&mut file, grid, leaves),
        }
    }
    let uuid = identity(&file[UUID.end..]);
    file[UUID].copy_from_slice(uuid.as_bytes());
    out.write_all(&file)
}

/// A type of voxel that the file can hold.
trait Voxel: Copy {
    const TREE: &str;
    /// What a client must know to turn it with the grid.
    const VECTOR_TYPE: Option<&str>;
    const BACKGROUND: Self;
    fn put(self, file: &mut Vec<u8>);
}

impl Voxel for f32 {
    const TREE: &str = "Tree_float_5_4_3";
    const VECTOR_TYPE: Option<&str> = None;
    const BACKGROUND: Self = 0.0;
    fn put(self, file: &mut Vec<u8>) {
        put(file, &self.to_le_bytes());
    }
}

impl Voxel for [f32; 3] {
    const TREE: &str = "Tree_vec3s_5_4_3";
    const VECTOR_TYPE: Option<&str> = Some("contravariant relative");
    const BACKGROUND: Self = [0.0; 3];
    fn put(self, file: &mut Vec<u8>) {
        for component in self {
            component.put(file);
        }
    }
}

fn put_grid<T: Voxel>(file: &mut Vec<u8>, grid: &Grid, leaves: &[Leaf<T>]) {
    let mut leaves: Vec<&Leaf<T>> = leaves.iter().collect();
    leaves.sort_unstable_by_key(|leaf| place(leaf.first));

    put_string(file, &grid.name);
    put_string(file, T::TREE);
    put_string(file, "");
    let offsets = file.len();
    file.resize(offsets + 24, 0);
    let mark = |file: &mut Vec<u8>, which: usize| {
        let here = file.len() as i64;
        file[offsets + 8 * which..][..8].copy_from_slice(&here.to_le_bytes());
    };

    mark(file, 0);
    put(file, &ACTIVE_MASK.to_le_bytes());
    put_metadata(file, grid, &leaves);
    put_transform(file, grid);
    put_topology(file, &leaves);
    mark(file, 1);
    for leaf in leaves {
        put_words(file, &leaf.active);
        let active = (0..512).filter(|i| leaf.active[i >> 6] >> (i & 63) & 1 == 1);
        put_values(file, active.map(|i| leaf.values[i]));
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

fn put_topology<T: Voxel>(file: &mut Vec<u8>, leaves: &[&Leaf<T>]) {
    let roots = || leaves.chunk_by(|a, b| place(a.first).0 == place(b.first).0);
    put(file, &1_u32.to_le_bytes());
    T::BACKGROUND.put(file);
    put(file, &0_u32.to_le_bytes());
    put(file, &(roots().count() as u32).to_le_bytes());
    for root in roots() {
        for x in place(root[0].first).0 {
            put(file, &x.to_le_bytes());
        }
        let nodes = || root.chunk_by(|a, b| place(a.first).1 == place(b.first).1);
        put_inner_node::<T>(file, 32 * 32 * 32, nodes().map(|n| place(n[0].first).1));
        for node in nodes() {
            put_inner_node::<T>(file, 16 * 16 * 16, node.iter().map(|l| place(l.first).2));
            for leaf in node {
                put_words(file, &leaf.active);
            }
        }
    }
}

/// A node with children and no tiles.
fn put_inner_node<T: Voxel>(
    file: &mut Vec<u8>,
    size: usize,
    children: impl Iterator<Item = usize>,
) {
    let mut mask = vec![0_u64; size / 64];
    for child in children {
        mask[child >> 6] |= 1 << (child & 63);
    }
    put_words(file, &mask);
    mask.fill(0);
    put_words(file, &mask);
    put_values(file, std::iter::empty::<T>());
}

/// The active values of a node; a packer for them belongs here.
fn put_values<T: Voxel>(file: &mut Vec<u8>, active: impl Iterator<Item = T>) {
    file.push(INACTIVE_IS_BACKGROUND);
    for value in active {
        value.put(file);
    }
}

fn put_metadata<T: Voxel>(file: &mut Vec<u8>, grid: &Grid, leaves: &[&Leaf<T>]) {
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
        ("class", "string", "fog volume".into()),
        (
            "creator",
            "string",
            concat!("osteoflow ", env!("CARGO_PKG_VERSION")).into(),
        ),
        ("file_bbox_max", "vec3i", bytes(high)),
        ("file_bbox_min", "vec3i", bytes(low)),
        ("file_voxel_count", "int64", count.to_le_bytes().to_vec()),
        ("is_saved_as_half_float", "bool", vec![0]),
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
