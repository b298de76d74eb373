//! What can go wrong between a file and a picture, sorted by who is to blame.

use std::path::PathBuf;

use pelage_skin::SkinError;
use pelage_texel::BuildError;
use pelage_texel::file::FileError;
use pelage_tracer::reference::ReferenceError;
use pelage_tracer::{RenderError, SceneError};

use crate::bake::BakeError;
use crate::expand::ExpandError;
use crate::import::ImportError;
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
    /// A texel cannot be built as described.
    #[error("{field}: {source}")]
    Texel {
        /// Which entry of the scene, as in `skin[0].texel`.
        field: String,
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
        field: String,
        /// What is wrong.
        source: SkinError,
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

/// A field of a scene that does not make sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {field}: {reason}", file.display())]
pub struct FieldError {
    /// The scene's file.
    pub file: PathBuf,
    /// The field, as in `skin[0].height`.
    pub field: String,
    /// What is wrong with it.
    pub reason: String,
}
