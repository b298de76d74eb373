//! `pelage skin export`: load, extrude and groom, write.

use std::path::PathBuf;

use clap::Args;
use pelage::compile::Loaded;
use pelage::expand::check_model;
use pelage::outline::write_outline;
use pelage::scene_file::SceneFile;

use crate::failure::Failure;
use crate::progress::say;
use crate::run_args::AllowArgs;

const NOTES: &str = "\
Each vertex of a skin is two points, and the line between them is its vector. Red is a corner that is about to fold,
green one that is a right angle; PLY and GLB have the numbers too (det J and the scaled Jacobian).";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct ExportArgs {
    /// The scene: .toml, .json, .gltf, .glb or .obj, as for render
    scene: PathBuf,

    /// The lines: .obj, .ply or .glb
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    #[command(flatten)]
    allow: AllowArgs,

    /// Say only what went wrong
    #[arg(short, long)]
    quiet: bool,
}

/// Exports what the arguments describe.
pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let mut scene = SceneFile::open(&args.scene)?;
    scene.allow_dirs.clone_from(&args.allow.allow_dir);
    let format = check_model(&args.output).map_err(pelage::Error::from)?;
    let loaded = Loaded::new(scene)?;
    let skins = loaded.extrude()?;
    let named = |d: &pelage::compile::Dressed| {
        let mesh = &loaded.imported.meshes[d.mesh].name;
        (format!("skin {} on {mesh}", d.entry), d.skin.outline())
    };
    let outlines: Vec<_> = skins.iter().map(named).collect();
    write_outline(&outlines, &args.output, format).map_err(pelage::Error::from)?;
    for ((name, outline), dressed) in outlines.iter().zip(&skins).filter(|_| !args.quiet) {
        let worst = outline.qualities.iter().copied().filter(|q| *q > 0.0).fold(1.0, f32::min);
        say(format_args!("{name}: {} boxes, least scaled Jacobian {worst:.4}", dressed.skin.len()));
    }
    Ok(())
}
