//! Flags that many commands share.

use std::path::PathBuf;

use clap::Args;

use crate::args::threads;
use crate::progress::Volume;

/// Which files a scene may refer to.
#[derive(Args)]
pub struct AllowArgs {
    /// Let the scene refer to files in this folder too; may be repeated
    #[arg(long, value_name = "FOLDER", help_heading = "Input")]
    pub allow_dir: Vec<PathBuf>,
}

/// How a command runs that takes its time.
#[derive(Args)]
pub struct RunArgs {
    /// Threads, at most 256; 0 for one a core
    #[arg(short, long, default_value_t = 0, value_parser = threads, allow_hyphen_values = true, help_heading = "Run")]
    pub threads: usize,

    /// Say only what went wrong
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Run")]
    quiet: bool,

    /// Say what was found and made
    #[arg(short, long, help_heading = "Run")]
    verbose: bool,
}

impl RunArgs {
    /// How much is said.
    pub fn volume(&self) -> Volume {
        match (self.quiet, self.verbose) {
            (true, _) => Volume::Quiet,
            (_, true) => Volume::Verbose,
            _ => Volume::Normal,
        }
    }
}
