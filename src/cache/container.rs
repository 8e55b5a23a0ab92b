//! The binary file of this project: named arrays behind a readable header, with a checksum.
//!
//! ```text
//! "osteoflo" | u32 version | u32 header bytes | header (JSON) | arrays, little-endian, in order | u32 CRC-32 of all before
//! ```
//! The header says what the arrays are called, their types and lengths. A reader allocates nothing that the length
//! of the file does not cover.

use super::CacheError;
use super::atomic;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"osteoflo";
const VERSION: u32 = 1;
/// Magic, version, header length.
const PREAMBLE: usize = 16;
const CHECKSUM: usize = 4;

/// Values of one type.
pub(super) enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I16(Vec<i16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Type {
    F32,
    F64,
    I16,
    I32,
    U32,
}

impl Type {
    fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::I16 => 2,
            Self::F32 | Self::I32 | Self::U32 => 4,
        }
    }
}

#[derive(Serialize, Deserialize)]
struct ArrayHeader {
    name: String,
    r#type: Type,
    length: u64,
}

#[derive(Serialize, Deserialize)]
struct Header {
    kind: String,
    meta: serde_json::Value,
    arrays: Vec<ArrayHeader>,
}

/// A file in memory.
pub(super) struct Container {
    path: PathBuf,
    meta: serde_json::Value,
    arrays: Vec<(String, Values)>,
}

/// Appends the next values to what is there, if there are any more.
type Pieces<'a> = Box<dyn FnMut(&mut Vec<u8>) + 'a>;

/// An array to be written: taken from where it stands, never copied whole.
pub(super) struct Column<'a> {
    header: ArrayHeader,
    next: Pieces<'a>,
}

impl<'a> Column<'a> {
    /// The values of all rows, one after the other.
    pub fn new<T: Element, const N: usize>(
        name: &str,
        rows: impl ExactSizeIterator<Item = [T; N]> + 'a,
    ) -> Self {
        let header = ArrayHeader {
            name: name.to_owned(),
            r#type: T::TYPE,
            length: (N * rows.len()) as u64,
        };
        let mut rows = rows;
        let next = move |bytes: &mut Vec<u8>| {
            for value in rows.by_ref().take(PIECE).flatten() {
                value.append_to(bytes);
            }
        };
        Self {
            header,
            next: Box::new(next),
        }
    }
}

/// Rows that are turned into bytes at once.
const PIECE: usize = 4096;

/// Writes a file of the given kind.
pub(super) fn write(
    path: &Path,
    kind: &str,
    meta: &impl Serialize,
    columns: Vec<Column<'_>>,
) -> Result<(), CacheError> {
    let (arrays, contents): (Vec<_>, Vec<_>) =
        columns.into_iter().map(|c| (c.header, c.next)).unzip();
    let header = Header {
        kind: kind.to_owned(),
        meta: serde_json::to_value(meta).map_err(|e| CacheError::damaged(path, e.to_string()))?,
        arrays,
    };
    let header =
        serde_json::to_vec(&header).map_err(|e| CacheError::damaged(path, e.to_string()))?;
    let length = u32::try_from(header.len())
        .map_err(|_| CacheError::damaged(path, "the header is too long"))?;
    let mut bytes = [&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes()].concat();
    bytes.extend(header);
    atomic::write_with(path, |file| {
        let mut hash = crc32fast::Hasher::new();
        let mut put = |bytes: &mut Vec<u8>| {
            hash.update(bytes);
            file.write_all(bytes)?;
            bytes.clear();
            Ok::<_, io::Error>(())
        };
        put(&mut bytes)?;
        for mut next in contents {
            next(&mut bytes);
            while !bytes.is_empty() {
                put(&mut bytes)?;
                next(&mut bytes);
            }
        }
        file.write_all(&hash.finalize().to_le_bytes())
    })
}

impl Container {
    /// Reads a file and checks everything that a container can: kind, lengths, checksum.
    pub fn read(path: &Path, kind: &str) -> Result<Self, CacheError> {
        let damaged = |what: String| CacheError::damaged(path, what);
        let mut file = File::open(path).map_err(|e| CacheError::io(path, e))?;
        let size = file.metadata().map_err(|e| CacheError::io(path, e))?.len();

        let mut preamble = [0; PREAMBLE];
        if size < (PREAMBLE + CHECKSUM) as u64 {
            return Err(damaged(format!(
                "{size} bytes are too few for any file of ours"
            )));
        }
        file.read_exact(&mut preamble)
            .map_err(|e| CacheError::io(path, e))?;
        let word = |at: usize| {
            u32::from_le_bytes([
                preamble[at],
                preamble[at + 1],
                preamble[at + 2],
                preamble[at + 3],
            ])
        };
        if preamble[..8] != *MAGIC {
            return Err(damaged("it is not one of our files".to_owned()));
        }
        let (version, header_bytes) = (word(8), u64::from(word(12)));
        if version != VERSION {
            return Err(damaged(format!(
                "version {version}, this program reads {VERSION}"
            )));
        }
        if header_bytes > size - (PREAMBLE + CHECKSUM) as u64 {
            return Err(damaged("it ends inside its header".to_owned()));
        }

        let mut header = vec![0; header_bytes as usize];
        file.read_exact(&mut header)
            .map_err(|e| CacheError::io(path, e))?;
        let parsed: Header =
            serde_json::from_slice(&header).map_err(|e| damaged(format!("its header: {e}")))?;
        if parsed.kind != kind {
            return Err(damaged(format!(
                "it holds a {}, wanted a {kind}",
                parsed.kind
            )));
        }
        let data = parsed.arrays.iter().try_fold(0_u64, |sum, array| {
            sum.checked_add(array.length.checked_mul(array.r#type.bytes())?)
        });
        let expected =
            data.and_then(|d| d.checked_add(header_bytes + (PREAMBLE + CHECKSUM) as u64));
        if expected != Some(size) {
            let described = expected.map_or("more than any file".to_owned(), |n| n.to_string());
            return Err(damaged(format!(
                "{size} bytes long, its header describes {described}"
            )));
        }

        let mut rest = Vec::new();
        let wanted = size - PREAMBLE as u64 - header_bytes;
        file.take(wanted)
            .read_to_end(&mut rest)
            .map_err(|e| CacheError::io(path, e))?;
        if rest.len() as u64 != wanted {
            return Err(damaged("it was cut short while being read".to_owned()));
        }
        let (data, checksum) = rest.split_at(rest.len() - CHECKSUM);
        let mut hash = crc32fast::Hasher::new();
        hash.update(&preamble);
        hash.update(&header);
        hash.update(data);
        if hash.finalize().to_le_bytes() != *checksum {
            return Err(damaged("its checksum is wrong".to_owned()));
        }

        let mut data = data;
        let mut arrays = Vec::with_capacity(parsed.arrays.len());
        for array in parsed.arrays {
            let (mine, after) = data.split_at((array.length * array.r#type.bytes()) as usize);
            arrays.push((array.name, Values::from_bytes(array.r#type, mine)));
            data = after;
        }
        Ok(Self {
            path: path.to_owned(),
            meta: parsed.meta,
            arrays,
        })
    }

    /// The readable part of the header.
    pub fn meta<T: DeserializeOwned>(&self) -> Result<T, CacheError> {
        serde_json::from_value(self.meta.clone())
            .map_err(|e| CacheError::damaged(&self.path, format!("its header: {e}")))
    }

    /// Takes an array out by name and type.
    pub fn take<T: Element>(&mut self, name: &str) -> Result<Vec<T>, CacheError> {
        let found = self.arrays.iter_mut().find(|(given, _)| given == name);
        found
            .and_then(|(_, values)| T::take(values))
            .ok_or_else(|| {
                CacheError::damaged(&self.path, format!("no array `{name}` of the right type"))
            })
    }

    /// Takes out an array of points, as many as `count` if it is given, all of them finite.
    pub fn take_points<T: Element + Finite>(
        &mut self,
        name: &str,
        count: Option<usize>,
    ) -> Result<Vec<[T; 3]>, CacheError> {
        let flat = self.take_finite(name, count.map(|n| 3 * n))?;
        let (points, rest) = flat.as_chunks::<3>();
        if rest.is_empty() {
            Ok(points.to_vec())
        } else {
            Err(CacheError::damaged(
                &self.path,
                format!("`{name}` is not in threes"),
            ))
        }
    }

    /// Takes out an array of numbers, as many as `count` if it is given, all of them finite.
    pub fn take_finite<T: Element + Finite>(
        &mut self,
        name: &str,
        count: Option<usize>,
    ) -> Result<Vec<T>, CacheError> {
        let values = self.take::<T>(name)?;
        if count.is_some_and(|n| n != values.len()) {
            return Err(CacheError::damaged(
                &self.path,
                format!("`{name}` has the wrong length"),
            ));
        }
        if !values.iter().all(Finite::finite) {
            return Err(CacheError::damaged(
                &self.path,
                format!("`{name}` holds a number that is not finite"),
            ));
        }
        Ok(values)
    }
}

/// A type that arrays are made of.
pub(super) trait Element: Copy {
    const TYPE: Type;
    fn take(values: &mut Values) -> Option<Vec<Self>>;
    fn append_to(self, bytes: &mut Vec<u8>);
}

/// A number that may be infinite, but should not.
pub(super) trait Finite {
    fn finite(&self) -> bool;
}

impl Finite for f32 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Finite for f64 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

/// One line a type: reading, writing and naming it.
macro_rules! elements {
    ($($variant:ident $type:ty),*) => {
        $(impl Element for $type {
            const TYPE: Type = Type::$variant;

            fn take(values: &mut Values) -> Option<Vec<Self>> {
                match values {
                    Values::$variant(values) => Some(std::mem::take(values)),
                    _ => None,
                }
            }

            fn append_to(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        })*

        impl Values {
            fn from_bytes(r#type: Type, bytes: &[u8]) -> Self {
                match r#type {
                    $(Type::$variant => Self::$variant(
                        bytes.as_chunks().0.iter().map(|b| <$type>::from_le_bytes(*b)).collect(),
                    ),)*
                }
            }
        }
    };
}

elements!(F32 f32, F64 f64, I16 i16, I32 i32, U32 u32);
