//! Why a command failed, and the exit code that says so.

use std::fmt;
use std::process::ExitCode;

use miette::Severity;
use pelage::output::OutputError;
use pelage::{Blame, Error};
use pelage_validate::PictureError;

use crate::progress::say;
use crate::report::tell;

/// Why a command failed.
pub enum Failure {
    /// The library says why.
    Library(Error),
    /// The flags, a picture to be read, or the machine.
    Usage(String),
    /// A validation failed, or found that a goal was missed.
    Study(String),
    /// What was asked for on stdout could not be written there.
    Stdout(std::io::Error),
    /// It was stopped; the partial picture is where the message says.
    Interrupted(String),
}

impl Failure {
    /// Says it in a line; of a field of a scene file, also where it stands there.
    pub fn tell(&self) {
        let line = format_args!("pelage: {self}");
        let located =
            if let Self::Library(error) = self { error.field().zip(Some(error.remark())) } else { None };
        match located {
            Some((field, remark)) => tell(line, field, &remark, Severity::Error),
            None => say(line),
        }
    }

    /// The exit code of `pelage --help`.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Library(error) => match error.blame() {
                Blame::Render => 1,
                Blame::Input => 2,
                Blame::Output => 3,
                Blame::Interruption => 130,
            },
            Self::Study(_) => 1,
            Self::Usage(_) => 2,
            Self::Stdout(_) => 3,
            Self::Interrupted(_) => 130,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Library(error) => error.fmt(f),
            Self::Usage(message) | Self::Study(message) | Self::Interrupted(message) => f.write_str(message),
            Self::Stdout(error) => write!(f, "stdout: {error}"),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Library(error)
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::Library(error.into())
    }
}
