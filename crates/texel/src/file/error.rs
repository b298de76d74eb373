//! Why a texel file cannot be read or written, sorted by who is to blame.

use super::PartKind;
use crate::{BuildError, TexelError};

/// Why a texel file cannot be read or written. Every message is one line, to stand after the file's name.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system says so.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// It does not begin as texel files do.
    #[error("is not a texel file")]
    Foreign,
    /// It is of a version that this program does not know.
    #[error("is of version {version}, and this program reads versions up to {known}")]
    Newer {
        /// The file's.
        version: u32,
        /// The latest that is known.
        known: u32,
    },
    /// It is of a version from before the first release.
    #[error("is of version {version}, and this program reads version {known}: it has to be built again")]
    Older {
        /// The file's.
        version: u32,
        /// The first that is known.
        known: u32,
    },
    /// It ends too early.
    #[error("ends within {}", PartKind::or_header(*part))]
    Truncated {
        /// In which part; `None` for the header.
        part: Option<PartKind>,
    },
    /// Its bytes are not those that were written: a checksum does not match.
    #[error("{} is damaged: its checksum does not match", PartKind::or_header(*part))]
    Damaged {
        /// Which part; `None` for the header.
        part: Option<PartKind>,
    },
    /// It goes on after its end.
    #[error("goes on after its {length} bytes")]
    Trailing {
        /// Where it should end.
        length: u64,
    },
    /// It asks for more than is allowed.
    #[error("{what} would be {size}, and at most {limit} is allowed")]
    TooLarge {
        /// What would.
        what: &'static str,
        /// How much it asks for.
        size: u64,
        /// The limit.
        limit: u64,
    },
    /// The header or its directory holds what cannot be.
    #[error("the header {what}")]
    Header {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A part holds what cannot be.
    #[error("{part} {what}")]
    Malformed {
        /// Which part.
        part: PartKind,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The kind that grew it is none that this program can grow.
    #[error("the kind cannot be grown: {reason}")]
    Kind {
        /// What is not known of it.
        reason: String,
    },
    /// The levels are no sound texel.
    #[error(transparent)]
    Texel(#[from] TexelError),
    /// The source is none that a texel can be made from.
    #[error("the source: {0}")]
    Source(#[from] BuildError),
    /// The effort of packing is out of its domain.
    #[error("the effort of packing is {effort}, which is not in 1 to 22")]
    Effort {
        /// What was asked for.
        effort: i32,
    },
}
