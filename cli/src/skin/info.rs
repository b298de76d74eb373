//! `pelage skin info`: load, extrude and groom, and tell how it went.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use pelage::compile::{Dressed, Loaded};
use pelage::scene_file::SceneFile;

use crate::failure::Failure;
use crate::run_args::AllowArgs;

const NOTES: &str = "\
The stretch of a patch is by how much a copy of the texel is longer, or shorter, there than all over the skin, in the
direction in which that is the most; 1 is none. A chart is a part of the skin over which the texel goes on without a
break, and a seam is an edge where it does not.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct InfoArgs {
    /// The scene: .toml, .json, .gltf, .glb or .obj, as for render
    scene: PathBuf,

    /// List so many charts of each skin, the largest first
    #[arg(long, value_name = "N", default_value_t = 8)]
    charts: usize,

    #[command(flatten)]
    allow: AllowArgs,
}

/// Tells of the skins that the arguments describe.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut scene = SceneFile::open(&args.scene)?;
    scene.allow_dirs.clone_from(&args.allow.allow_dir);
    let loaded = Loaded::new(scene)?;
    let mut text = String::new();
    for dressed in &loaded.extrude()? {
        let mesh = &loaded.imported.meshes[dressed.mesh].name;
        let _ = writeln!(text, "skin[{}] on `{mesh}`", dressed.entry);
        tell(dressed, args.charts, &mut text);
    }
    std::io::stdout().write_all(text.as_bytes()).map_err(Failure::Stdout)
}

fn tell(dressed: &Dressed, most: usize, text: &mut String) {
    let skin = &dressed.skin;
    for line in skin.report.to_string().lines() {
        let _ = writeln!(text, "  {line}");
    }
    for (step, effect) in dressed.effects.iter().enumerate() {
        let _ = writeln!(text, "  groom[{step}]: {effect}");
    }
    let distortion = skin.distortion();
    let _ = writeln!(text, "  {distortion}");
    if most > 0 {
        let _ = writeln!(text, "  chart   patches     area (m²)   stretch: mean    worst");
    }
    for (i, chart) in distortion.charts.iter().take(most).enumerate() {
        let _ = writeln!(
            text,
            "  {i:5}  {:8}  {:12.5}  {:14.3}  {:7.3}",
            chart.patches, chart.area, chart.mean, chart.worst
        );
    }
    if let Some(left @ 1..) = distortion.charts.len().checked_sub(most) {
        let _ = writeln!(text, "  and {left} more");
    }
    let folds = skin.report.folds.len() - skin.report.mended() - skin.report.left_out();
    let _ = writeln!(text, "  {folds} boxes are still folded, {} were left out", skin.report.left_out());
}
