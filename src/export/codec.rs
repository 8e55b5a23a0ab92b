//! How the values of a VDB file are stored: as floats or halves, plain or packed.

use flate2::{Compression, write::ZlibEncoder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::io::Write;

/// Packing of values. All give the same values back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Codec {
    /// LZ4 over shuffled bytes: quick, and what OpenVDB does by default.
    #[default]
    Blosc,
    /// zlib: smaller, slower to write.
    Zip,
    /// As they are.
    None,
}

impl Codec {
    /// OpenVDB's flag for it.
    pub(super) fn flag(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Zip => 1,
            Self::Blosc => 4,
        }
    }

    /// Appends values of `width` bytes each to `file`, as OpenVDB stores an array.
    pub(super) fn put(self, file: &mut Vec<u8>, values: &[u8], width: usize) {
        let packed = match self {
            Self::None => return file.extend(values),
            Self::Zip => zip(values),
            Self::Blosc => blosc(values, width),
        };
        // A size below 0 says that packing did not help.
        let (size, bytes) = match &packed {
            Some(packed) if packed.len() < values.len() => (packed.len() as i64, &packed[..]),
            _ => (-(values.len() as i64), values),
        };
        file.extend(size.to_le_bytes());
        file.extend(bytes);
    }
}

fn zip(values: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(values).ok()?;
    encoder.finish().ok()
}

/// One Blosc-1 frame of one block.
fn blosc(values: &[u8], width: usize) -> Option<Vec<u8>> {
    const LEAST: usize = 48;
    const BLOCK_AT: u32 = 20;
    /// Shuffled bytes, blocks not split by byte, LZ4.
    const FLAGS: u8 = 0x31;
    if values.len() < LEAST {
        return None;
    }
    let count = values.len() / width;
    let mut shuffled = vec![0; values.len()];
    for (i, value) in values.chunks_exact(width).enumerate() {
        for (byte, v) in value.iter().enumerate() {
            shuffled[byte * count + i] = *v;
        }
    }
    let packed = lz4_flex::block::compress(&shuffled);
    let mut frame = vec![2, 1, FLAGS, width as u8];
    let whole = BLOCK_AT as usize + 4 + packed.len();
    for number in [values.len(), values.len(), whole] {
        frame.extend(u32::try_from(number).ok()?.to_le_bytes());
    }
    frame.extend(BLOCK_AT.to_le_bytes());
    frame.extend((packed.len() as u32).to_le_bytes());
    frame.extend(packed);
    Some(frame)
}
