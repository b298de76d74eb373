//! `pelage texel bake`: read a model, place and cut it, build, write.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use pelage::bake::{ContentOptions, Fit, content, read};
use pelage::import::{Up, Warning};
use pelage::texel::BuildOptions;
use pelage::texel::file::{FileOptions, Metadata};
use pelage::texel_file::{check_texel, write_texel};
use pelage::{Field, build};

use crate::args::{choice, positive};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Volume, say};
use crate::render::{pool, stage};
use crate::run_args::RunArgs;
use crate::stats::Stats;

const NOTES: &str = "\
Colours follow the base colour, its texture and the colours of vertices to about one voxel. What alpha cuts away
(glTF MASK, at its cutoff) is not there; what it makes transparent (glTF BLEND, `d` and `map_d` of OBJ) is holes smaller
than a voxel. A texel has one specular albedo and one roughness, the means of the model's, and gives off no light. All
faces are seen from both sides. Lines (glTF LINES, LINE_STRIP and LINE_LOOP, `l` of OBJ) are strands, as thick as their
attribute _RADIUS or --radius says.

Examples:
  pelage texel bake leaf.glb -o leaf.texel --resolution 256 --licence CC0-1.0
      A model, scaled into the cube.
  pelage texel bake turf.obj -o turf.texel --fit keep --tile
      Made for the unit cube: what leaves it on one side enters it on the other.
  pelage texel bake hair.glb -o hair.texel --fit floor --radius 0.0004 --tip-radius 0
      Strands with a point, standing on the skin.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct BakeArgs {
    /// The model: .glb, .gltf or .obj
    model: PathBuf,

    /// The texel: .texel
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Voxels a side: a power of two from 2 to 512
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = resolution, allow_hyphen_values = true)]
    resolution: u32,

    /// How it is put into the texel: cube scales it until it fits and puts its middle in the middle; floor does the same,
    /// but it stands on the skin; keep takes the model's unit cube, 0 to 1 along each axis, as the texel
    #[arg(long, default_value = "cube", value_parser = choice::<Fit>)]
    fit: Fit,

    /// Part of the texel's edge that is left free on each side, 0 to 0.45; not with --fit keep [default: 0.02, with --tile 0]
    #[arg(long, value_name = "PART", value_parser = number, allow_hyphen_values = true)]
    margin: Option<f32>,

    /// The axis of the model that points away from the skin: y or z
    #[arg(long, default_value = "y", value_parser = choice::<Up>)]
    up: Up,

    /// It repeats: what leaves the texel on one side enters it on the other
    #[arg(long)]
    tile: bool,

    /// Half the thickness of strands that have none of their own, in units of the model
    #[arg(long, value_parser = positive, allow_hyphen_values = true)]
    radius: Option<f32>,

    /// The same at their ends; 0 for a point [default: as --radius]
    #[arg(long, value_name = "RADIUS", requires = "radius", value_parser = number, allow_hyphen_values = true)]
    tip_radius: Option<f32>,

    /// What the texel is called [default: as its file]
    #[arg(long)]
    name: Option<String>,

    /// Under which terms it may be used, as in CC0-1.0
    #[arg(long, default_value = "")]
    licence: String,

    /// Keep the triangles in the file too, so that the texel can be judged by them: much larger
    #[arg(long)]
    with_source: bool,

    #[command(flatten)]
    run: RunArgs,
}

/// Bakes what the arguments describe.
pub fn run(args: &BakeArgs) -> Result<(), Failure> {
    if args.margin.is_some() && args.fit == Fit::Keep {
        return Err(Failure::Usage("--margin: means nothing with --fit keep, which does not scale".into()));
    }
    // Asked now: after minutes of baking is too late.
    check_texel(&args.output)?;
    interrupt::listen()?;
    pool(args.run.threads)?.install(|| bake(args))
}

fn bake(args: &BakeArgs) -> Result<(), Failure> {
    let volume = args.run.volume();
    let warn = |warnings: &[Warning]| {
        for warning in warnings.iter().filter(|_| volume > Volume::Quiet) {
            say(format_args!("warning: {warning}"));
        }
    };
    let mut stats = Stats::default();
    let default = ContentOptions::default();
    let options = ContentOptions {
        up: args.up,
        fit: args.fit,
        // What repeats should meet its next copy.
        margin: args.margin.unwrap_or(if args.tile { 0.0 } else { default.margin }),
        tile: args.tile,
        resolution: args.resolution,
        radius: args.radius,
        tip_radius: args.tip_radius,
    };
    let model = stage("load", volume, &mut stats, |_| Ok(read(&args.model)?))?;
    warn(&model.warnings);
    let content = stage("cut", volume, &mut stats, |stage| {
        Ok(content(&args.model, &model, &options, &|f| stage.update(f))?)
    })?;
    drop(model);
    warn(&content.warnings);
    if volume == Volume::Verbose {
        say(format_args!("{} triangles", content.geometry.triangles.len()));
    }
    let file_stem = args.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = args.name.clone().unwrap_or(file_stem);
    let depth = args.resolution.ilog2();
    let build_options = BuildOptions { depth, periodic: args.tile, ..BuildOptions::standard() };
    let texel = stage("build", volume, &mut stats, |stage| {
        let built = build(&name, content.geometry, &build_options, &|f| stage.update(f));
        built.map_err(|source| pelage::Error::Texel { field: Field::whole(&args.model), source })
    })?;
    if volume == Volume::Verbose {
        for level in texel.levels() {
            say(format_args!("{}³: {} voxels", level.resolution(), level.len()));
        }
    }
    let metadata = Metadata {
        licence: args.licence.clone(),
        origin: args.model.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        parameters: parameters(&options),
    };
    let file = FileOptions { metadata, with_triangles: args.with_source, ..FileOptions::default() };
    stage("write", volume, &mut stats, |_| write_texel(&texel, &args.output, &file))?;
    Ok(())
}

/// How it was made, for the file.
fn parameters(options: &ContentOptions) -> BTreeMap<String, String> {
    let fit = match options.fit {
        Fit::Cube => "cube",
        Fit::Floor => "floor",
        Fit::Keep => "keep",
    };
    let up = if options.up == Up::Y { "y" } else { "z" };
    let mut parameters = vec![
        ("resolution", options.resolution.to_string()),
        ("fit", fit.into()),
        ("up", up.into()),
        ("tile", options.tile.to_string()),
    ];
    if options.fit != Fit::Keep {
        parameters.push(("margin", options.margin.to_string()));
    }
    for (name, radius) in [("radius", options.radius), ("tip-radius", options.tip_radius)] {
        parameters.extend(radius.map(|radius| (name, radius.to_string())));
    }
    parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn resolution(text: &str) -> Result<u32, String> {
    let number = text.parse::<u32>().ok().filter(|n| n.is_power_of_two() && (2..=512).contains(n));
    number.ok_or_else(|| "expected a power of two from 2 to 512".into())
}

/// A number from 0 on.
fn number(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|x| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "expected a number from 0 on".into())
}
