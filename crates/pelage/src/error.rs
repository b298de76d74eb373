//! What can go wrong between a file and a picture, sorted by who is to blame.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use pelage_skin::SkinError;
use pelage_texel::BuildError;
use pelage_texel::file::FileError;
use pelage_tracer::reference::ReferenceError;
use pelage_tracer::{RenderError, SceneError};

use crate::bake::BakeError;
use crate::expand::ExpandError;
use crate::import::{Fault, ImportError};
use crate::output::OutputError;

/// Who is to blame: what a command line's exit code tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The files or the options.
    Input,
    /// The rendering itself.
    Render,
    /// The place where the picture should go.
    Output,
    /// Nobody: it was asked to stop.
    Interruption,
}

/// Why there is no picture. Every message is one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A field of the scene does not make sense.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A file that a field of the scene refers to cannot be used.
    #[error("{field}: {fault}")]
    Referred {
        /// Which field, as in `geometry[0].file`.
        field: Field,
        /// What is wrong.
        fault: Fault,
    },
    /// A texel cannot be built as described.
    #[error("{field}: {source}")]
    Texel {
        /// Which entry of the scene, as in `skin[0].texel`, or the model that it is made of.
        field: Field,
        /// What is wrong.
        source: BuildError,
    },
    /// A model cannot become the content of a texel.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A texel file cannot be read, or a texel not be put in one.
    #[error("{}: {source}", path.display())]
    TexelFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: FileError,
    },
    /// A skin cannot be made as described.
    #[error("{field}: {source}")]
    Skin {
        /// Which entry of the scene, as in `skin[0]`.
        field: Field,
        /// What is wrong.
        source: Box<SkinError>,
    },
    /// The parts do not make a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// There is no film, or only a part of one.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// There is no reference picture, only a part of one, or no explicit content.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The explicit triangles could not be written.
    #[error(transparent)]
    Expand(#[from] ExpandError),
    /// The picture could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Error {
    /// The field of a scene file that is wrong, if it is one.
    pub fn field(&self) -> Option<&Field> {
        match self {
            Self::Field(error) => Some(&error.field),
            Self::Referred { field, .. } | Self::Texel { field, .. } | Self::Skin { field, .. } => {
                Some(field)
            }
            _ => None,
        }
    }

    /// What is wrong with it, or what may have been meant, in a few words to stand beside it.
    pub fn remark(&self) -> String {
        match self {
            Self::Field(error) => error.hint.clone().unwrap_or_else(|| error.reason.clone()),
            Self::Referred { fault, .. } => fault.to_string(),
            Self::Texel { source, .. } => source.to_string(),
            Self::Skin { source, .. } => source.to_string(),
            error => error.to_string(),
        }
    }

    /// Who is to blame.
    pub fn blame(&self) -> Blame {
        match self {
            Self::Render(RenderError::Cancelled { .. }) => Blame::Interruption,
            // A setting is the user's; anything else that may come is not.
            Self::Render(RenderError::Setting { .. }) => Blame::Input,
            Self::Reference(ReferenceError::Cancelled { .. }) => Blame::Interruption,
            Self::Expand(ExpandError::Stopped { .. }) => Blame::Interruption,
            Self::Output(error) | Self::Expand(ExpandError::Output(error)) => match error {
                OutputError::Film { .. } => Blame::Render,
                OutputError::Extension { .. } => Blame::Input,
                _ => Blame::Output,
            },
            _ => Blame::Input,
        }
    }
}

/// Where in a text file something stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
    /// From which byte of the file to which.
    pub bytes: Range<usize>,
}

impl Span {
    /// Where these bytes of `text` stand.
    pub(crate) fn of(text: &str, bytes: Range<usize>) -> Self {
        let before = text.get(..bytes.start).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = before.matches('\n').count() + 1;
        Self { line, column: before[line_start..].chars().count() + 1, bytes }
    }
}

/// A field of a scene file; or the whole file, where it has no name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Field {
    /// The file.
    pub file: PathBuf,
    /// As in `skin[0].height`.
    pub name: String,
    /// Where it stands, if the file is text and says anything of it.
    pub span: Option<Box<Span>>,
}

impl Field {
    /// A file as a whole.
    pub fn whole(file: &Path) -> Self {
        Self { file: file.to_owned(), ..Self::default() }
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.file.display().fmt(f)?;
        if let Some(Span { line, column, .. }) = self.span.as_deref() {
            write!(f, ":{line}:{column}")?;
        }
        if self.name.is_empty() { Ok(()) } else { write!(f, ": {}", self.name) }
    }
}

/// A field of a scene that does not make sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct FieldError {
    /// Which field.
    pub field: Field,
    /// What is wrong with it.
    pub reason: String,
    /// What may have been meant, or what may stand there.
    pub hint: Option<String>,
}

impl fmt::Display for FieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.field, self.reason)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, ": {hint}"))
    }
}
