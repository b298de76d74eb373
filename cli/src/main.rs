//! The `pelage` command.
//!
//! | subcommand | room |
//! |---|---|
//! | `render` | [`render`]: its stages; [`args`]: its flags |
//!
//! stdout carries only data that was asked for; everything said to people goes to stderr.

mod args;
mod failure;
mod interrupt;
mod progress;
mod render;
mod stats;

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
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 the rendering failed; 2 usage or an input file; 3 the output could not be written; \
130 interrupted (the partial picture is kept).";

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            progress::say(format_args!("pelage: {failure}"));
            failure.exit_code()
        }
    }
}
