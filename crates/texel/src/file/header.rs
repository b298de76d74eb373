//! The header of a texel file and the directory of its parts.
//!
//! ```text
//! byte  0  magic          89 "TEXEL" 0D 0A
//!       8  version        u32   4
//!      12  header length  u32   32 + 32 n: this and the directory of n parts
//!      16  file length    u64
//!      24  checksum       u32   CRC-32 of bytes 0 to 24 and of the directory
//!      28  zero           u32
//!      32  directory      n × 32
//!
//! byte  0  tag            "META", "LEVL", "KIND" or "MESH"
//!       4  level          u32   of LEVL; else 0
//!       8  stored         u64   bytes in the file
//!      16  unpacked       u64   bytes once unpacked
//!      24  checksum       u32   CRC-32 of the bytes in the file
//!      28  zero           u32
//! ```
//!
//! The first 32 bytes mean the same in every version, so that a damaged file is not taken for a newer one.

use std::fmt;
use std::io::Read;

use super::{FileError, Limits};

const MAGIC: [u8; 8] = *b"\x89TEXEL\r\n";
const VERSION: u32 = 6;
/// Bytes before the directory, and of each of its entries.
const FIXED: usize = 32;
const ENTRY: usize = 32;

/// What a part of a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartKind {
    /// What is told about the texel.
    Metadata,
    /// The level of this number.
    Level(u32),
    /// The kind that grew it, with its parameters.
    Kind,
    /// The triangles that it was made from.
    Triangles,
}

impl PartKind {
    /// For messages: the part, or the header where there is none.
    pub(super) fn or_header(part: Option<Self>) -> String {
        part.map_or("the header".into(), |part| part.to_string())
    }

    fn tag(self) -> ([u8; 4], u32) {
        match self {
            Self::Metadata => (*b"META", 0),
            Self::Level(l) => (*b"LEVL", l),
            Self::Kind => (*b"KIND", 0),
            Self::Triangles => (*b"MESH", 0),
        }
    }

    fn of_tag(tag: [u8; 4], level: u32) -> Option<Self> {
        match (&tag, level) {
            (b"META", 0) => Some(Self::Metadata),
            (b"LEVL", level) => Some(Self::Level(level)),
            (b"KIND", 0) => Some(Self::Kind),
            (b"MESH", 0) => Some(Self::Triangles),
            _ => None,
        }
    }
}

impl fmt::Display for PartKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Metadata => f.write_str("the metadata"),
            Self::Level(l) => write!(f, "level {l}"),
            Self::Kind => f.write_str("the kind"),
            Self::Triangles => f.write_str("the list of triangles"),
        }
    }
}

/// An entry of the directory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it holds.
    pub kind: PartKind,
    /// Bytes in the file.
    pub stored: u64,
    /// Bytes once unpacked.
    pub unpacked: u64,
    /// CRC-32 of the bytes in the file.
    pub checksum: u32,
}

/// The header, its lengths and checksum left to be counted.
#[derive(Default)]
pub(super) struct Header {
    pub parts: Vec<Part>,
}

impl Header {
    /// Bytes of the whole file.
    pub fn length(&self) -> u64 {
        let before = (FIXED + ENTRY * self.parts.len()) as u64;
        self.parts.iter().fold(before, |length, part| length.saturating_add(part.stored))
    }

    /// The header's bytes.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(((FIXED + ENTRY * self.parts.len()) as u32).to_le_bytes());
        bytes.extend(self.length().to_le_bytes());
        bytes.extend([0; 8]);
        for part in &self.parts {
            let (tag, level) = part.kind.tag();
            bytes.extend(tag);
            bytes.extend(level.to_le_bytes());
            bytes.extend(part.stored.to_le_bytes());
            bytes.extend(part.unpacked.to_le_bytes());
            bytes.extend(part.checksum.to_le_bytes());
            bytes.extend([0; 4]);
        }
        let checksum = checksum(&bytes);
        bytes[24..28].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Its checksum.
    pub fn checksum(&self) -> u32 {
        checksum(&self.encode())
    }

    /// Reads it, and holds what it promises against `limits`.
    pub fn read(input: &mut impl Read, limits: &Limits) -> Result<Self, FileError> {
        let mut bytes = read_up_to(input, FIXED)?;
        if !bytes.starts_with(&MAGIC[..bytes.len().min(8)]) || bytes.is_empty() {
            return Err(FileError::Foreign);
        }
        let truncated = || FileError::Truncated { part: None };
        let fixed = Fields(bytes.get(..FIXED).ok_or_else(truncated)?);
        let (version, claimed, file_length) = (fixed.u32(8), fixed.u32(12) as usize, fixed.u64(16));
        let (stored, zero) = (fixed.u32(24), fixed.u32(28));
        // Metadata, a level each, and a source: nothing needs more than a few dozen parts.
        const MOST: usize = FIXED + ENTRY * 64;
        if !(FIXED..=MOST).contains(&claimed) || !(claimed - FIXED).is_multiple_of(ENTRY) {
            return Err(FileError::Damaged { part: None });
        }
        bytes.extend(read_up_to(input, claimed - FIXED)?);
        if bytes.len() < claimed {
            return Err(truncated());
        }
        if checksum(&bytes) != stored {
            return Err(FileError::Damaged { part: None });
        }
        if version > VERSION {
            return Err(FileError::Newer { version, known: VERSION });
        }
        if version < VERSION {
            return Err(FileError::Older { version, known: VERSION });
        }
        let wrong = |what| FileError::Header { what };
        if zero != 0 {
            return Err(wrong("has a padding that there is not"));
        }
        let mut parts = Vec::new();
        for entry in bytes[FIXED..].chunks_exact(ENTRY) {
            let fields = Fields(entry);
            let kind = PartKind::of_tag([entry[0], entry[1], entry[2], entry[3]], fields.u32(4));
            let kind = kind.filter(|_| fields.u32(28) == 0);
            let kind = kind.ok_or_else(|| wrong("names a part that there is not"))?;
            let (stored, unpacked) = (fields.u64(8), fields.u64(16));
            parts.push(Part { kind, stored, unpacked, checksum: fields.u32(24) });
        }
        let header = Self { parts };
        header.check(limits)?;
        if header.length() != file_length {
            return Err(wrong("gives a length that its parts have not"));
        }
        Ok(header)
    }

    /// The metadata, every level from 0 on, and at most one source; within the limits.
    fn check(&self, limits: &Limits) -> Result<(), FileError> {
        let wrong = |what| FileError::Header { what };
        let [first, rest @ ..] = &self.parts[..] else { return Err(wrong("lists no parts")) };
        let levels = rest.iter().take_while(|part| matches!(part.kind, PartKind::Level(_))).count();
        let in_order = (0..).zip(&rest[..levels]).all(|(l, part)| part.kind == PartKind::Level(l));
        let sourced = matches!(
            rest[levels..].iter().map(|part| part.kind).collect::<Vec<_>>()[..],
            [] | [PartKind::Kind] | [PartKind::Triangles]
        );
        if first.kind != PartKind::Metadata || !in_order || !sourced {
            return Err(wrong("lists its parts out of order"));
        }
        // Morton codes have 10 bits an axis.
        let (size, limit) = (levels.saturating_sub(1) as u64, limits.depth.min(10).into());
        if size > limit {
            return Err(FileError::TooLarge { what: "the finest level", size, limit });
        }
        let mut total = 0_u64;
        for part in &self.parts {
            total = total.saturating_add(part.unpacked);
            // Levels of flat sheets pack best, to some 1 : 50.
            let most = part.stored.saturating_mul(MOST_PACKED).saturating_add(SMALL);
            if part.unpacked > most {
                let (size, limit) = (part.unpacked, most);
                return Err(FileError::TooLarge { what: "an unpacked part", size, limit });
            }
        }
        if total > limits.unpacked {
            let (size, limit) = (total, limits.unpacked);
            return Err(FileError::TooLarge { what: "the unpacked bytes", size, limit });
        }
        Ok(())
    }
}

/// No part that is larger than [`SMALL`] is honestly packed to less than one part in so many.
const MOST_PACKED: u64 = 256;
/// Bytes that any part may unpack to.
const SMALL: u64 = 16 << 20;

/// CRC-32 [ISO 3309] of the header's bytes but for the checksum and the padding.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..24.min(bytes.len())]);
    hasher.update(bytes.get(28..).unwrap_or(&[]));
    hasher.finalize()
}

/// The next `count` bytes, or fewer where the input ends.
fn read_up_to(input: &mut impl Read, count: usize) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(count);
    input.take(count as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Numbers at places that exist.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|i| self.0[at + i]))
    }

    fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|i| self.0[at + i]))
    }
}
