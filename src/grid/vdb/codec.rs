//! Bytes of a VDB file, and the packing of values.
//!
//! A node's values come as a flag that tells its inactive values, those of them that are no background, and the
//! active ones, packed: raw, zlib or a Blosc frame (byte-shuffled LZ4), as floats or halves.

use std::io::Read;

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    pub at: usize,
    pub problem: String,
}

/// A cursor that gives no more than the file has.
pub(super) struct Input<'a> {
    bytes: &'a [u8],
    pub at: usize,
}

macro_rules! numbers {
    ($($name:ident: $type:ty),*) => {$(
        pub fn $name(&mut self) -> Result<$type, Fault> {
            let bytes = self.take(size_of::<$type>())?;
            Ok(<$type>::from_le_bytes(bytes.try_into().expect("as many as taken")))
        }
    )*};
}

impl<'a> Input<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    numbers!(u8: u8, u32: u32, i32: i32, i64: i64, f32: f32, f64: f64);

    pub fn fault<T>(&self, problem: impl Into<String>) -> Result<T, Fault> {
        Err(Fault {
            at: self.at,
            problem: problem.into(),
        })
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.at..];
        if count > rest.len() {
            let left = rest.len();
            return self.fault(format!(
                "damaged or cut short: {count} bytes are needed, {left} are left"
            ));
        }
        self.at += count;
        Ok(&rest[..count])
    }

    pub fn seek(&mut self, at: i64) -> Result<(), Fault> {
        match usize::try_from(at)
            .ok()
            .filter(|at| *at <= self.bytes.len())
        {
            Some(at) => self.at = at,
            None => return self.fault(format!("damaged: a grid is said to lie at byte {at}")),
        }
        Ok(())
    }

    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// A length and as many bytes of text.
    pub fn string(&mut self) -> Result<String, Fault> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// A bit set.
    pub fn mask(&mut self, bits: usize) -> Result<Vec<u64>, Fault> {
        let words = self.take(bits / 8)?.as_chunks::<8>().0;
        Ok(words.iter().map(|word| u64::from_le_bytes(*word)).collect())
    }
}

pub(super) fn is_set(mask: &[u64], bit: usize) -> bool {
    mask[bit >> 6] >> (bit & 63) & 1 == 1
}

/// How a grid's values are stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packing {
    /// Bits: 1 zlib, 2 active values only, 4 Blosc.
    pub flags: u32,
    pub half: bool,
    pub double: bool,
    pub background: f32,
}

impl Packing {
    /// A value in full size: of the tree's type, whatever its arrays are saved as.
    pub fn value(&self, input: &mut Input<'_>) -> Result<f32, Fault> {
        if self.double {
            Ok(input.f64()? as f32)
        } else {
            input.f32()
        }
    }

    fn bytes_each(&self) -> usize {
        match (self.half, self.double) {
            (true, _) => 2,
            (false, true) => 8,
            (false, false) => 4,
        }
    }

    /// All values of a node whose active voxels or tiles are `active`.
    pub fn values(&self, input: &mut Input<'_>, active: &[u64]) -> Result<Vec<f32>, Fault> {
        let count = 64 * active.len();
        let masked = self.flags & 2 != 0;
        let flag = if masked { input.u8()? } else { 6 };
        if flag > 6 {
            return input.fault(format!(
                "damaged: {flag} is no way to store inactive values"
            ));
        }
        let mut inactive = match flag {
            0 => [self.background; 2],
            _ => [-self.background, self.background],
        };
        if [2, 4, 5].contains(&flag) {
            inactive[0] = self.value(input)?;
        }
        if flag == 5 {
            inactive[1] = self.value(input)?;
        }
        let second = match flag {
            3..=5 => Some(input.mask(count)?),
            _ => None,
        };
        if flag == 6 {
            return self.array(input, count);
        }
        let stored = active.iter().map(|word| word.count_ones() as usize).sum();
        let mut given = self.array(input, stored)?.into_iter();
        let value = |i: usize| {
            if is_set(active, i) {
                given.next().unwrap_or(self.background)
            } else {
                inactive[usize::from(second.as_ref().is_some_and(|mask| is_set(mask, i)))]
            }
        };
        Ok((0..count).map(value).collect())
    }

    fn array(&self, input: &mut Input<'_>, count: usize) -> Result<Vec<f32>, Fault> {
        if self.half && count == 0 {
            return Ok(Vec::new());
        }
        let each = self.bytes_each();
        let bytes = self.unpacked(input, each * count)?;
        let bytes = bytes.as_ref();
        Ok(match each {
            2 => {
                let halves = bytes.as_chunks::<2>().0;
                halves
                    .iter()
                    .map(|h| half::f16::from_le_bytes(*h).to_f32())
                    .collect()
            }
            4 => {
                let floats = bytes.as_chunks::<4>().0;
                floats.iter().map(|f| f32::from_le_bytes(*f)).collect()
            }
            _ => {
                let doubles = bytes.as_chunks::<8>().0;
                doubles
                    .iter()
                    .map(|d| f64::from_le_bytes(*d) as f32)
                    .collect()
            }
        })
    }

    fn unpacked<'a>(
        &self,
        input: &mut Input<'a>,
        wanted: usize,
    ) -> Result<std::borrow::Cow<'a, [u8]>, Fault> {
        if self.flags & 5 == 0 {
            return Ok(input.take(wanted)?.into());
        }
        let size = input.i64()?;
        if size <= 0 {
            // Packing did not help.
            if size.unsigned_abs() != wanted as u64 {
                return input.fault(format!(
                    "damaged: {} raw bytes where {wanted} belong",
                    size.unsigned_abs()
                ));
            }
            return Ok(input.take(wanted)?.into());
        }
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let packed = input.take(size)?;
        let unpacked = if self.flags & 4 != 0 {
            blosc(packed, wanted)
        } else {
            zlib(packed, wanted)
        };
        match unpacked {
            Ok(bytes) => Ok(bytes.into()),
            Err(problem) => input.fault(problem),
        }
    }
}

fn zlib(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(wanted);
    // One byte more than wanted shows a stream that is too long, and no more is ever unpacked.
    let mut stream = flate2::read::ZlibDecoder::new(packed).take(wanted as u64 + 1);
    match stream.read_to_end(&mut bytes) {
        Ok(_) if bytes.len() == wanted => Ok(bytes),
        Ok(_) => Err("damaged: a zlib stream has not the length that belongs here".to_owned()),
        Err(e) => Err(format!("damaged: zlib: {e}")),
    }
}

/// One Blosc-1 frame: a header of 16 bytes, then blocks, each of one or more streams.
fn blosc(frame: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let damaged = |what: &str| format!("damaged: a Blosc frame {what}");
    let word = |at: usize| {
        let bytes = frame
            .get(at..at + 4)
            .ok_or_else(|| damaged("is cut short"))?;
        Ok::<_, String>(u32::from_le_bytes(bytes.try_into().expect("4 bytes")) as usize)
    };
    let (total, block) = (word(4)?, word(8)?);
    let (flags, each) = (frame[2], usize::from(frame[3]).max(1));
    if total != wanted {
        return Err(damaged("has not the length that belongs here"));
    }
    if flags & 2 != 0 {
        let raw = frame
            .get(16..16 + wanted)
            .ok_or_else(|| damaged("is cut short"))?;
        return Ok(raw.to_vec());
    }
    if flags & 4 != 0 {
        return Err("Blosc's bit shuffle is not supported: save the file with zip".to_owned());
    }
    let codec = flags >> 5;
    if codec != 1 && codec != 3 {
        let names = ["BloscLZ", "LZ4", "Snappy", "zlib", "Zstd"];
        let name = names
            .get(usize::from(codec))
            .unwrap_or(&"of an unknown codec");
        return Err(format!(
            "Blosc with {name} is not supported: save the file with zip"
        ));
    }
    if block == 0 || block > total.max(1) {
        return Err(damaged("has blocks of an impossible size"));
    }
    let mut bytes = Vec::with_capacity(total);
    for n in 0..total.div_ceil(block) {
        let length = block.min(total - n * block);
        // A whole block may be split into one stream a byte of the type.
        let split = flags & 0x10 == 0 && each <= 16 && length == block && length % each == 0;
        let streams = if split { each } else { 1 };
        let mut at = word(16 + 4 * n)?;
        let mut unpacked = Vec::with_capacity(length);
        for _ in 0..streams {
            let size = word(at)?;
            let part = at + 4..(at + 4).saturating_add(size);
            let stream = frame
                .get(part.clone())
                .ok_or_else(|| damaged("is cut short"))?;
            at = part.end;
            let wanted = length / streams;
            if size == wanted {
                unpacked.extend_from_slice(stream);
            } else if codec == 1 {
                let found = lz4_flex::block::decompress(stream, wanted);
                unpacked.extend(found.map_err(|e| damaged(&format!("does not unpack: {e}")))?);
            } else {
                unpacked.extend(zlib(stream, wanted)?);
            }
        }
        if unpacked.len() != length {
            return Err(damaged("has a block of another length"));
        }
        if flags & 1 != 0 && each > 1 {
            bytes.extend(unshuffled(&unpacked, each));
        } else {
            bytes.extend(unpacked);
        }
    }
    Ok(bytes)
}

/// From all first bytes, all second bytes, … to value after value; what is no whole value stays at the end.
fn unshuffled(bytes: &[u8], each: usize) -> Vec<u8> {
    let count = bytes.len() / each;
    let mut values = bytes.to_vec();
    for i in 0..count {
        for b in 0..each {
            values[i * each + b] = bytes[b * count + i];
        }
    }
    values
}
