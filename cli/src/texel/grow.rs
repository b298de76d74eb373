//! `pelage texel grow`: grow a kind, build its texel, write it.

use std::path::{Path, PathBuf};

use clap::Args;
use pelage::scene_file::TexelEntry;
use pelage::texel::file::{FileOptions, Metadata};
use pelage::texel::{BuildOptions, Procedure};
use pelage::texel_file::{check_texel, write_texel};
use pelage::{Field, build};

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Volume, say};
use crate::render::{pool, stage};
use crate::run_args::RunArgs;
use crate::stats::Stats;

const NOTES: &str = "\
`pelage texel kinds` lists what grows, `pelage texel kinds fur` what can be set of fur. The file remembers the kind and
every parameter, so that the texel can be judged by the geometry that it was made from.

Examples:
  pelage texel grow fur -o fur.texel
      Long fur.
  pelage texel grow grass -o hay.texel --preset meadow --set dry=0.6 --set dry_color=0.6,0.5,0.2 --seed 7
      A meadow in August, another one than the usual.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct GrowArgs {
    /// What grows: fur, grass, moss, pile, foliage, needles, …
    kind: String,

    /// The texel: .texel
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Which of its presets the settings change [default: the first that `pelage texel kinds` names]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,

    /// Voxels a side: a power of two from 2 to 512 [default: 128]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    resolution: Option<String>,

    /// Which of the many with these settings
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    seed: Option<String>,

    /// Sets a parameter; may be repeated. Colours and pairs are numbers with commas between
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// What the texel is called [default: as its file]
    #[arg(long)]
    name: Option<String>,

    /// Under which terms it may be used, as in CC0-1.0
    #[arg(long, default_value = "")]
    licence: String,

    #[command(flatten)]
    run: RunArgs,
}

/// Grows what the arguments describe.
pub fn run(args: &GrowArgs) -> Result<(), Failure> {
    let mut settings = args.set.iter().map(|text| setting(text)).collect::<Result<Vec<_>, _>>()?;
    let flags = [("preset", &args.preset), ("resolution", &args.resolution), ("seed", &args.seed)];
    for (key, value) in flags {
        settings.extend(value.iter().map(|value| (key.to_owned(), value.clone())));
    }
    let entry = TexelEntry::grown(&args.kind, &settings).map_err(Failure::Usage)?;
    // Asked now: after minutes of building is too late.
    check_texel(&args.output)?;
    interrupt::listen()?;
    pool(args.run.threads)?.install(|| grow(args, entry))
}

fn grow(args: &GrowArgs, entry: TexelEntry) -> Result<(), Failure> {
    let TexelEntry::Grown { kind, resolution } = entry else {
        return Err(Failure::Usage(format!("{}: a texel file does not grow", args.kind)));
    };
    let volume = args.run.volume();
    let mut stats = Stats::default();
    let file_stem = args.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = args.name.clone().unwrap_or(file_stem);
    let options = BuildOptions { depth: resolution.ilog2(), ..BuildOptions::standard() };
    let origin = kind.name().to_owned();
    let parameters =
        kind.parameters().into_iter().map(|p| (p.name.to_owned(), p.value.to_string())).collect();
    let texel = stage("build", volume, &mut stats, |stage| {
        let built = build(&name, kind, &options, &|f| stage.update(f));
        built.map_err(|source| pelage::Error::Texel { field: Field::whole(Path::new(&origin)), source })
    })?;
    if volume == Volume::Verbose {
        for level in texel.levels() {
            say(format_args!("{}³: {} voxels", level.resolution(), level.len()));
        }
    }
    let metadata = Metadata { licence: args.licence.clone(), origin, parameters };
    let file = FileOptions { metadata, ..FileOptions::default() };
    stage("write", volume, &mut stats, |_| write_texel(&texel, &args.output, &file))?;
    Ok(())
}

fn setting(text: &str) -> Result<(String, String), Failure> {
    match text.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
        Some((key, value)) if !key.is_empty() && !value.is_empty() => Ok((key.into(), value.into())),
        _ => Err(Failure::Usage(format!("--set {text}: expected KEY=VALUE, as in count=300"))),
    }
}
