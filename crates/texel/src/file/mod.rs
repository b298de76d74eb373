//! Texels in files. The bytes are drawn in `docs/texel-file.md`.
//!
//! ```text
//! header     magic, version, lengths, checksum
//! directory  what each part is, how long, packed and unpacked, and its checksum
//! parts      META: a JSON object    LEVL: one a level, coarsest first    KIND or MESH: the source
//! ```
//!
//! Everything is little endian, and every part a Zstandard frame (RFC 8878). A file is believed in nothing: its checksums
//! are compared and its sizes held against [`Limits`] before anything of that size is allocated, and the texel is
//! [validated](Texel::validate) before it is handed out.

mod error;
mod header;
mod level;
mod mesh;
mod meta;
mod planes;

use std::io::{Read, Write};

pub use error::FileError;
pub use header::{Part, PartKind};
pub use meta::Metadata;
use rayon::prelude::*;

use crate::{Level, Source, Texel};
use header::Header;

/// What goes into a file besides the levels.
#[derive(Clone, Debug, PartialEq)]
pub struct FileOptions {
    /// What is told about the texel; its name is the texel's own.
    pub metadata: Metadata,
    /// Whether the triangles that it was made from go along: the largest part by far, but without them it cannot be
    /// judged. The parameters of a kind that grew it always do; they take no place.
    pub with_triangles: bool,
    /// How hard the parts are packed: 1 (fast) to 22 (small), as Zstandard counts. From 16 on a match has to be worth its
    /// place, which most in a level are not.
    pub effort: i32,
}

impl Default for FileOptions {
    fn default() -> Self {
        Self { metadata: Metadata::default(), with_triangles: false, effort: 17 }
    }
}

/// How much a file may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of all parts once unpacked.
    pub unpacked: u64,
    /// The finest level.
    pub depth: u32,
}

impl Default for Limits {
    /// 2 GiB, and level 10: 1024 voxels a side.
    fn default() -> Self {
        Self { unpacked: 2 << 30, depth: 10 }
    }
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelFile {
    /// The texel itself.
    pub texel: Texel,
    /// What is told about it.
    pub metadata: Metadata,
    /// The parts of the file, in their order.
    pub parts: Vec<Part>,
    /// Bytes of the whole file.
    pub length: u64,
    /// CRC-32 of the header and directory, and so of all: the directory has those of the parts.
    pub checksum: u32,
}

impl Texel {
    /// Writes it in the form of `docs/texel-file.md`: the same bytes every time.
    ///
    /// # Errors
    /// What `out` says; [`FileError::Effort`] for an effort that there is none of.
    pub fn write(&self, out: &mut impl Write, options: &FileOptions) -> Result<(), FileError> {
        if !(1..=22).contains(&options.effort) {
            return Err(FileError::Effort { effort: options.effort });
        }
        self.validate_properties()?;
        self.source().validate()?;
        let metadata = meta::encode(self, &options.metadata).map_err(std::io::Error::from)?;
        let mut contents = vec![(PartKind::Metadata, metadata)];
        contents
            .extend((0..).zip(self.levels()).map(|(l, level)| (PartKind::Level(l), level::encode(level))));
        match self.source() {
            Source::Grown(kind) => {
                contents.push((PartKind::Kind, meta::encode_kind(kind).map_err(std::io::Error::from)?));
            }
            Source::Geometry(geometry) if options.with_triangles => {
                contents.push((PartKind::Triangles, mesh::encode(geometry)));
            }
            _ => {}
        }
        let pack = |(kind, content): (PartKind, Vec<u8>)| -> std::io::Result<(Part, Vec<u8>)> {
            let bytes = zstd::bulk::compress(&content, options.effort)?;
            let (stored, unpacked) = (bytes.len() as u64, content.len() as u64);
            Ok((Part { kind, stored, unpacked, checksum: crc32fast::hash(&bytes) }, bytes))
        };
        let packed: Vec<_> = contents.into_par_iter().map(pack).collect::<Result<_, _>>()?;
        let header = Header { parts: packed.iter().map(|(part, _)| *part).collect() };
        out.write_all(&header.encode())?;
        packed.iter().try_for_each(|(_, bytes)| out.write_all(bytes))?;
        Ok(())
    }

    /// Reads a texel, and forgets what else the file says. See [`TexelFile::read`].
    ///
    /// # Errors
    /// As [`TexelFile::read`].
    pub fn read(input: impl Read, limits: &Limits) -> Result<Self, FileError> {
        TexelFile::read(input, limits).map(|file| file.texel)
    }
}

impl TexelFile {
    /// Reads a whole file and validates what it holds.
    ///
    /// # Errors
    /// The [`FileError`] that says what is wrong with it: it is no texel file, is of a newer version, ends early, is
    /// damaged, is larger than `limits`, or holds what no texel can.
    pub fn read(mut input: impl Read, limits: &Limits) -> Result<Self, FileError> {
        let header = Header::read(&mut input, limits)?;
        let Some((first, rest)) = header.parts.split_first() else {
            return Err(FileError::Header { what: "lists no parts" });
        };
        let malformed = |part: PartKind| move |what| FileError::Malformed { part, what };
        let content = unpack(&mut input, first)?;
        let (properties, metadata) = meta::decode(&content).map_err(malformed(first.kind))?;
        let mut levels: Vec<Level> = Vec::new();
        let mut source = Source::Unknown;
        for part in rest {
            let content = unpack(&mut input, part)?;
            let malformed = malformed(part.kind);
            match part.kind {
                PartKind::Level(l) => {
                    levels.push(level::decode(l, properties.periodic, &content).map_err(malformed)?);
                }
                PartKind::Kind => source = meta::decode_kind(&content)?.into(),
                PartKind::Triangles => source = mesh::decode(&content).map_err(malformed)?.into(),
                PartKind::Metadata => return Err(malformed("stands twice")),
            }
        }
        if input.read(&mut [0])? > 0 {
            return Err(FileError::Trailing { length: header.length() });
        }
        source.validate()?;
        let material = [properties.specular, properties.roughness];
        let texel = Texel::new(&properties.name, source, material, properties.periodic, levels);
        texel.validate()?;
        let (length, checksum) = (header.length(), header.checksum());
        Ok(Self { texel, metadata, parts: header.parts, length, checksum })
    }
}

/// The content of the next part of `input`.
fn unpack(input: &mut impl Read, part: &Part) -> Result<Vec<u8>, FileError> {
    // Both lists grow with what arrives, not with what is claimed.
    let mut stored = Vec::new();
    input.by_ref().take(part.stored).read_to_end(&mut stored)?;
    if (stored.len() as u64) < part.stored {
        return Err(FileError::Truncated { part: Some(part.kind) });
    }
    if crc32fast::hash(&stored) != part.checksum {
        return Err(FileError::Damaged { part: Some(part.kind) });
    }
    let malformed = |what| FileError::Malformed { part: part.kind, what };
    let mut content = Vec::new();
    let mut frame = zstd::Decoder::with_buffer(&stored[..])?;
    // 128 MiB of history, the most that packing at any effort needs.
    frame.window_log_max(27)?;
    let unpacked = frame.take(part.unpacked.saturating_add(1)).read_to_end(&mut content);
    unpacked.map_err(|_| malformed("is no Zstandard frame"))?;
    if content.len() as u64 != part.unpacked {
        return Err(malformed("unpacks to another length than the directory says"));
    }
    Ok(content)
}

#[cfg(test)]
mod tests;
