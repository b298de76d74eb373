//! Why a file cannot be read: which file, where in it, and what is wrong there.

use std::fmt;
use std::path::{Path, PathBuf};

use pelage_geom::MeshError;

/// Where in a file something is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
    /// A field, as in `nodes[3].mesh`.
    Field(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
            Self::Field(field) => write!(f, ": {field}"),
        }
    }
}

/// What is wrong with a file that was to be read.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The system would not let us read it.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// A file that another refers to cannot be found.
    #[error("refers to `{reference}`, which cannot be read: {source}")]
    Reference {
        /// The reference, as it is written.
        reference: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A folder, a device or a pipe.
    #[error("is not a regular file")]
    NotRegular,
    /// The name's extension is none that is known.
    #[error("has an unknown extension: expected {expected}")]
    Extension {
        /// The extensions that are known.
        expected: &'static str,
    },
    /// A reference leads out of the scene's folder, or is no plain relative path.
    #[error("refers to `{0}`, which is outside of the scene's folder")]
    Outside(String),
    /// A cap of [`Limits`](crate::import::Limits) is exceeded.
    #[error("{what}: {found} is over the limit of {limit}")]
    Limit {
        /// What there is too much of.
        what: &'static str,
        /// How much there is.
        found: u64,
        /// The cap.
        limit: u64,
    },
    /// The format's own rules are broken.
    #[error("{0}")]
    Syntax(String),
    /// A number is NaN, infinite, or too large to compute with.
    #[error("`{0}` is not a usable number")]
    NotANumber(String),
    /// Something names what does not exist.
    #[error("{what} {index} does not exist: there are {count}")]
    Index {
        /// The kind of thing named.
        what: &'static str,
        /// The index, as in the file.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// The file cannot be understood without an extension that is not supported.
    #[error("requires the glTF extension `{0}`, which is not supported")]
    RequiredExtension(String),
    /// There is no surface in it.
    #[error("holds no faces")]
    NoFaces,
    /// A mesh turned out to be unusable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl Fault {
    /// The fault of a file that another refers to as `reference`.
    pub(crate) fn of(self, reference: &str) -> Self {
        let reference = reference.to_owned();
        match self {
            Self::Io(source) => Self::Reference { reference, source },
            Self::Syntax(reason) => Self::Syntax(format!("`{reference}`: {reason}")),
            other => other,
        }
    }

    /// The fault, at a place of a file.
    pub fn at(self, file: &Path, place: Place) -> ImportError {
        ImportError { file: file.to_owned(), place, fault: self }
    }
}

/// A file that cannot be read. The message is one line: file, place, reason.
#[derive(Debug, thiserror::Error)]
#[error("{}{place}: {fault}", file.display())]
pub struct ImportError {
    /// Which file.
    pub file: PathBuf,
    /// Where in it.
    pub place: Place,
    /// What is wrong.
    pub fault: Fault,
}

/// Something in a file that was left out or read differently than it may have been meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Which file.
    pub file: PathBuf,
    /// Where in it.
    pub place: Place,
    /// What was done about what.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}: {}", self.file.display(), self.place, self.message)
    }
}
