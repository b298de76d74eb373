//! `pelage schema`: what a scene file may hold, for editors and other programs.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use pelage::output::replace;
use pelage::schema::schema;

use crate::failure::Failure;

const NOTES: &str = "\
Editors check and complete scene files by it. For TOML, with Taplo or the extension Even Better TOML, begin the file with
  #:schema ./pelage.schema.json
and for JSON, give the file a schema in the settings of the editor.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct SchemaArgs {
    /// Write it to this file [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Tells it.
pub fn run(args: &SchemaArgs) -> Result<(), Failure> {
    let text = format!("{:#}\n", schema());
    match &args.output {
        None => std::io::stdout().write_all(text.as_bytes()).map_err(Failure::Stdout),
        Some(path) => Ok(replace(path, |file| file.write_all(text.as_bytes()))?),
    }
}
