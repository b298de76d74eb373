//! `pelage texel`: makes texels, keeps them in files, and shows what is in them.
//!
//! | subcommand | room |
//! |---|---|
//! | `bake` | [`bake`]: a model |
//! | `grow` | [`grow`]: a kind, by its parameters |
//! | `info` | [`info`] |
//! | `kinds` | [`kinds`]: what grows, and what can be set of it |
//! | `view` | [`view`] |

mod bake;
mod grow;
mod info;
mod kinds;
mod view;

use clap::Subcommand;

use crate::failure::Failure;

/// What is done with texels.
#[derive(Subcommand)]
pub enum TexelCommand {
    /// Make a texel of a model: any mesh with its materials and textures, and strands.
    Bake(Box<bake::BakeArgs>),
    /// Make a texel that grows: fur, grass, moss, carpet, …
    Grow(Box<grow::GrowArgs>),
    /// Tell what a texel file holds.
    Info(info::InfoArgs),
    /// List what grows, its presets and its parameters.
    Kinds(kinds::KindsArgs),
    /// Draw a texel from all sides, and each of its levels.
    View(view::ViewArgs),
}

/// Does it.
pub fn run(command: &TexelCommand) -> Result<(), Failure> {
    match command {
        TexelCommand::Bake(args) => bake::run(args),
        TexelCommand::Grow(args) => grow::run(args),
        TexelCommand::Info(args) => info::run(args),
        TexelCommand::Kinds(args) => kinds::run(args),
        TexelCommand::View(args) => view::run(args),
    }
}
