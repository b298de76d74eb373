//! The `pelage` command.
//!
//! | subcommand | room |
//! |---|---|
//! | `render` | [`render`]: its stages; [`args`]: its flags |
//! | `check` | [`check`] |
//! | `schema` | [`schema`] |
//! | `expand` | [`expand`] |
//! | `compare` | [`compare`] |
//! | `skin` | [`skin`]: a file for each of its own subcommands |
//! | `texel` | [`texel`]: a file for each of its own subcommands |
//! | `validate` | [`validate`] |
//! | `bench` | [`bench`]: its scenes, what is measured and what is told |
//!
//! Flags that many of them share are in [`run_args`], what goes wrong is told by [`report`].
//!
//! stdout carries only data that was asked for; everything said to people goes to stderr.

mod args;
mod bench;
mod check;
mod compare;
mod expand;
mod failure;
mod interrupt;
mod progress;
mod render;
mod report;
mod run_args;
mod schema;
mod skin;
mod stats;
mod texel;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Dresses meshes in fur and renders them with a multithreaded CPU cone tracer.
#[derive(Parser)]
#[command(name = "pelage", version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to a picture.
    Render(Box<args::RenderArgs>),
    /// Tell everything that is wrong with a scene, and where.
    Check(check::CheckArgs),
    /// Print the JSON Schema of scene files, for editors.
    Schema(schema::SchemaArgs),
    /// Write a scene as explicit triangles, for other programs.
    Expand(expand::ExpandArgs),
    /// Measure how far a picture is from its reference.
    Compare(compare::CompareArgs),
    /// Look at skins without rendering them.
    #[command(subcommand)]
    Skin(skin::SkinCommand),
    /// Make texels, keep them in files, and see what is in them.
    #[command(subcommand)]
    Texel(texel::TexelCommand),
    /// Measure how far a scene's cone pictures are from what its geometry shows, at every distance.
    Validate(Box<validate::ValidateArgs>),
    /// Measure how long whole scenes take, and in how much memory.
    Bench(bench::BenchArgs),
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 the rendering failed, or a goal was missed (validate --strict); 2 usage or an input file; 3 the output could not be written; \
130 interrupted (the partial picture is kept).";

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Expand(args) => expand::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Skin(command) => skin::run(&command),
        Command::Texel(command) => texel::run(&command),
        Command::Validate(args) => validate::run(&args),
        Command::Bench(args) => bench::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.tell();
            failure.exit_code()
        }
    }
}
