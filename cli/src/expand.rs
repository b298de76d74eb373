//! `pelage expand`: load, extrude, grow, compile, count, write.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use pelage::expand::{Bytes, ModelFormat, check_model, write_model};
use pelage::scene_file::SceneFile;
use pelage::tracer::reference::{Expansion, Fineness};

use crate::args::positive;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Volume, say};
use crate::render::{pool, stage, tell_of_input, tell_of_skins};
use crate::run_args::{AllowArgs, RunArgs};
use crate::stats::Stats;

const NOTES: &str = "\
What every texel was made from is carried into every box, and the opaque meshes come along, all with vertex colours.
Fur has about 10 000 triangles a copy: the size is known before the file is written, and refused above the limit.

Examples:
  pelage expand fluff.toml -o fluff.glb --limit 8GiB
      For Blender and others. GLB files end at 4 GiB, whatever the limit.
  pelage expand bunny.obj -o bunny.ply --tolerance 0.0005
      Curved content cut until it is within half a millimetre.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct ExpandArgs {
    /// The scene: .toml, .gltf, .glb or .obj, as for render
    scene: PathBuf,

    /// The triangles: .glb, .ply or .obj
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// How far flat triangles may be from curved content: metres, or with % a part of the height of each box
    #[arg(long, default_value = "1%", value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: Fineness,

    /// The largest file that is written: bytes, or with KiB, MiB, GiB, KB, MB, GB
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = bytes, allow_hyphen_values = true)]
    limit: u64,

    #[command(flatten)]
    allow: AllowArgs,

    #[command(flatten)]
    run: RunArgs,
}

/// Expands what the arguments describe.
pub fn run(args: &ExpandArgs) -> Result<(), Failure> {
    let mut scene = SceneFile::open(&args.scene)?;
    scene.allow_dirs.clone_from(&args.allow.allow_dir);
    let format = check_model(&args.output).map_err(pelage::Error::from)?;
    interrupt::listen()?;
    pool(args.run.threads)?.install(|| model(args, scene, format))
}

fn model(args: &ExpandArgs, scene: SceneFile, format: ModelFormat) -> Result<(), Failure> {
    let volume = args.run.volume();
    let mut stats = Stats::default();
    let loaded = stage("load", volume, &mut stats, |_| pelage::compile::Loaded::new(scene))?;
    tell_of_input(&loaded, volume);
    let skins = stage("extrude", volume, &mut stats, |_| loaded.extrude())?;
    tell_of_skins(&skins, &loaded, volume, &mut stats);
    let texels = stage("grow", volume, &mut stats, |_| loaded.unbaked())?;
    let prepared = stage("compile", volume, &mut stats, |_| loaded.compile(&texels, skins))?;
    let expansion =
        stage("count", volume, &mut stats, |_| Ok(Expansion::new(&prepared.scene, args.tolerance)?))?;

    interrupt::keep_partial_result();
    stage("write", volume, &mut stats, |stage| {
        let progress = |fraction| {
            stage.update(fraction);
            if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        Ok(write_model(&expansion, &args.output, format, args.limit, &progress)?)
    })?;
    if volume == Volume::Verbose {
        for part in expansion.parts() {
            say(format_args!("{}: {} triangles", part.name, part.triangles));
        }
        say(format_args!("{}: {}", args.output.display(), Bytes(format.size(&expansion))));
    }
    Ok(())
}

fn tolerance(text: &str) -> Result<Fineness, String> {
    let number = |text: &str| positive(text).map(f64::from);
    match text.strip_suffix('%') {
        Some(percent) => Ok(Fineness::OfHeight(0.01 * number(percent)?)),
        None => Ok(Fineness::Length(number(text)?)),
    }
}

fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let unit = match unit {
        "" | "B" => 1,
        "KB" => 1_000,
        "MB" => 1_000_000,
        "GB" => 1_000_000_000,
        "KiB" => 1 << 10,
        "MiB" => 1 << 20,
        "GiB" => 1 << 30,
        _ => 0,
    };
    let number = number.trim().parse::<f64>().ok().filter(|n| *n > 0.0 && unit > 0);
    number.map(|n| (n * unit as f64) as u64).ok_or_else(|| "expected a size, like 500MB or 4GiB".into())
}
