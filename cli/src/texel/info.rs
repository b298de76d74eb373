//! `pelage texel info`: what a texel file holds.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;

#[derive(Args)]
pub struct InfoArgs {
    /// The texel: .texel
    file: PathBuf,
}

/// Tells what the file holds.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    Err(Failure::Usage(format!("{}: texel files cannot be read yet", args.file.display())))
}
