//! `pelage skin`: looks at skins without rendering them.
//!
//! | subcommand | room |
//! |---|---|
//! | `export` | [`export`]: boxes as lines |
//! | `info` | [`info`]: boxes, folds, charts, seams and stretch, as text |
//! | `mesh-table` | [`mesh_table`]: the paper's table of meshes |

mod export;
mod info;
mod mesh_table;

use clap::Subcommand;

use crate::failure::Failure;

/// What is done with skins.
#[derive(Subcommand)]
pub enum SkinCommand {
    /// Write the boxes of a scene's skins as lines, coloured by how near they are to folding.
    Export(export::ExportArgs),
    /// Print what became of a scene's skins: boxes, folds, charts, seams and how much the texel is stretched.
    Info(info::InfoArgs),
    /// Print vertices, errors, time and memory of meshes of one surface, coarse to fine.
    MeshTable(mesh_table::MeshTableArgs),
}

/// Does it.
pub fn run(command: &SkinCommand) -> Result<(), Failure> {
    match command {
        SkinCommand::Export(args) => export::run(args),
        SkinCommand::Info(args) => info::run(args),
        SkinCommand::MeshTable(args) => mesh_table::run(args),
    }
}
