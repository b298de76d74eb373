//! `pelage check`: everything that is wrong with scenes, at once.

use std::path::{Path, PathBuf};

use clap::Args;
use miette::Severity;
use pelage::check::{Findings, check};

use crate::failure::Failure;
use crate::progress::say;
use crate::report::tell;
use crate::run_args::AllowArgs;

const NOTES: &str = "\
Every field, name and file is looked at, meshes are read and skins are raised; no texel is baked, and nothing rendered.
Exit code 2 if anything is wrong.

Examples:
  pelage check fluff.toml
      Each mistake with its place in the file, and what is worth a second look.
  pelage check scenes/*.toml -q
      Only what is wrong.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct CheckArgs {
    /// The scenes: .toml, .json, .gltf, .glb or .obj, as for render
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,

    #[command(flatten)]
    allow: AllowArgs,

    /// Say only what is wrong
    #[arg(short, long)]
    quiet: bool,
}

/// Checks what the arguments name.
pub fn run(args: &CheckArgs) -> Result<(), Failure> {
    let mut wrong = Vec::new();
    for scene in &args.scenes {
        let findings = check(scene, &args.allow.allow_dir);
        report(scene, &findings, args.quiet);
        if !findings.errors.is_empty() {
            wrong.push(format!("{}: {}", scene.display(), counted(findings.errors.len(), "error")));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(Failure::Usage(wrong.join("; "))) }
}

fn report(scene: &Path, findings: &Findings, quiet: bool) {
    for error in &findings.errors {
        match error.field() {
            Some(field) => tell(format_args!("error: {error}"), field, &error.remark(), Severity::Error),
            None => say(format_args!("error: {error}")),
        }
    }
    if quiet {
        return;
    }
    for remark in &findings.remarks {
        tell(format_args!("warning: {remark}"), &remark.field, &remark.reason, Severity::Warning);
    }
    for warning in &findings.warnings {
        say(format_args!("warning: {warning}"));
    }
    for layout in &findings.layouts {
        say(format_args!("note: {layout}"));
    }
    if findings.errors.is_empty() {
        let warnings = findings.remarks.len() + findings.warnings.len();
        let [meshes, boxes] =
            [(findings.meshes, "mesh"), (findings.boxes, "box")].map(|(n, what)| counted(n, what));
        let warnings = if warnings == 0 { "nothing is wrong".into() } else { counted(warnings, "warning") };
        say(format_args!("{}: {warnings}: {meshes}, {boxes}", scene.display()));
    }
}

/// As in `2 boxes`.
fn counted(n: usize, what: &str) -> String {
    let plural = if what.ends_with('h') || what.ends_with('x') { "es" } else { "s" };
    format!("{n} {what}{}", if n == 1 { "" } else { plural })
}
