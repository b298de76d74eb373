//! `pelage validate`: load, extrude, bake, compile, study, tell.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use pelage::compile::{Loaded, Prepared};
use pelage::output::{check_place, replace};
use pelage::scene_file::{SceneFile, SkinEntry, TexelEntry};
use pelage::tracer::{Lod, Rays};
use pelage_validate::{
    Distance, Goals, Lights, NORMAL_PPD, Plan, SightError, Study, StudyError, page, study, table,
};

use crate::args::{choice, positive, set_resolution};
use crate::compare::ppd;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Stage, Volume, say};
use crate::render::{pool, stage, tell_of_input, tell_of_skins};
use crate::run_args::{AllowArgs, RunArgs};
use crate::stats::Stats;

const NOTES: &str = "\
The camera goes along the line from the scene's own camera to a place on a coat near the middle of its picture.
Each distance is a width of the median box in pixels, or near (a finest voxel is two pixels wide), or a width and h:
the first place beyond that where two levels are blended half and half. The reference shows the geometry that the
texels were made from; both show the middle of the picture, at most --size pixels a side.

Examples:
  pelage validate assets/validate/*.toml -o report.html
      The standard table of the standard scenes: under 20 minutes on two cores.
  pelage validate teddy.toml --distances near,64,16h --spp 1024 --strict
      Three distances, more exactly; exit code 1 if a goal is missed.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct ValidateArgs {
    /// The scenes: .toml, .gltf, .glb or .obj, as for render
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,

    /// Also write a page with all pictures: .html
    #[arg(short, long, value_name = "HTML")]
    output: Option<PathBuf>,

    /// Tell in JSON: a list with one object a scene
    #[arg(long)]
    json: bool,

    /// Exit with code 1 if a goal is missed
    #[arg(long)]
    strict: bool,

    /// Samples a pixel of the reference, even
    #[arg(long, default_value_t = Plan::default().samples, value_parser = samples, allow_hyphen_values = true)]
    spp: u32,

    /// From how far, as widths of a box in pixels
    #[arg(long, value_delimiter = ',', default_values_t = Distance::STANDARD)]
    distances: Vec<Distance>,

    /// Three suns, one at a time, or the scene's own light
    #[arg(long, value_enum, default_value_t = LightsArg::Standard)]
    lights: LightsArg,

    /// The most pixels a side of each picture
    #[arg(long, value_name = "PIXELS", default_value_t = Plan::default().size, value_parser = side, allow_hyphen_values = true)]
    size: u32,

    /// Frames of the zoom that flicker is measured over; 0 leaves it out
    #[arg(long, default_value_t = Plan::default().frames, value_parser = frames, allow_hyphen_values = true)]
    frames: u32,

    /// Which goals [default: those of fur where the name of a texel says so]
    #[arg(long, value_enum)]
    goals: Option<GoalsArg>,

    /// Pixels a degree of the eye, for FLIP
    #[arg(long, default_value_t = NORMAL_PPD, value_parser = ppd, allow_hyphen_values = true)]
    ppd: f32,

    /// What grows on a mesh file, as for render [default: fur]
    #[arg(long, value_parser = TexelEntry::from_word, help_heading = "Scene")]
    texel: Option<TexelEntry>,

    /// How high it grows, in metres
    #[arg(long, value_parser = positive, allow_hyphen_values = true, help_heading = "Scene")]
    height: Option<f32>,

    /// Voxels a side of the texels, a power of two
    #[arg(long, value_name = "N", allow_hyphen_values = true, help_heading = "Scene")]
    resolution: Option<u32>,

    /// Rays a pixel: adaptive, 1, 4 or 16
    #[arg(long, value_parser = choice::<Rays>, help_heading = "Scene")]
    rays: Option<Rays>,

    /// Level of detail: auto, sharp, smooth or a level from 0 to 12
    #[arg(long, value_parser = choice::<Lod>, allow_hyphen_values = true, help_heading = "Scene")]
    lod: Option<Lod>,

    #[command(flatten)]
    allow: AllowArgs,

    #[command(flatten)]
    run: RunArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LightsArg {
    /// From the side, from near the view and from behind.
    Standard,
    /// All that the scene has.
    Scene,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GoalsArg {
    /// For any texel.
    Standard,
    /// For fur.
    Fur,
}

/// Validates what the arguments name.
pub fn run(args: &ValidateArgs) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"));
        if !named {
            return Err(Failure::Usage(format!("{}: a report is written as .html", path.display())));
        }
        check_place(path)?;
    }
    // All of them, before the first takes its time.
    let scenes = args.scenes.iter().map(|path| scene(args, path)).collect::<Result<Vec<_>, _>>()?;
    interrupt::listen()?;
    pool(args.run.threads)?.install(|| validate(args, scenes))
}

fn validate(args: &ValidateArgs, scenes: Vec<SceneFile>) -> Result<(), Failure> {
    let plan = plan(args);
    let mut studies = Vec::new();
    for (path, scene) in args.scenes.iter().zip(scenes) {
        let study = one(args, path, scene, &plan)?;
        if !args.json {
            // As soon as it is known.
            tell(&(table(&study) + "\n"))?;
        }
        studies.push(study);
    }
    if args.json {
        let list = serde_json::to_string(&studies).map_err(|e| Failure::Stdout(e.into()))?;
        tell(&(list + "\n"))?;
    }
    if let Some(path) = &args.output {
        let page = page(&studies, &about(args)).map_err(|e| Failure::Study(e.to_string()))?;
        replace(path, |file| file.write_all(page.as_bytes()))?;
    }
    let misses: usize = studies.iter().map(|study| study.misses).sum();
    if args.strict && misses > 0 {
        return Err(Failure::Study(format!("{misses} goals missed")));
    }
    Ok(())
}

fn one(args: &ValidateArgs, path: &Path, scene: SceneFile, plan: &Plan) -> Result<Study, Failure> {
    let volume = args.run.volume();
    let name = path.display().to_string();
    if volume > Volume::Quiet {
        say(&name);
    }
    let mut prepared = prepare(scene, volume)?;
    let stage = Stage::begin("validate", volume);
    let result = study(&name, &mut prepared, plan, &|fraction| stage.update(fraction));
    stage.end();
    result.map_err(|error| blame(path, error))
}

fn prepare(scene: SceneFile, volume: Volume) -> Result<Prepared, Failure> {
    let mut stats = Stats::default();
    let loaded = stage("load", volume, &mut stats, |_| Loaded::new(scene))?;
    tell_of_input(&loaded, volume);
    let skins = stage("extrude", volume, &mut stats, |_| loaded.extrude())?;
    tell_of_skins(&skins, &loaded, volume, &mut stats);
    let texels = stage("bake", volume, &mut stats, |stage| loaded.bake(&|f| stage.update(f)))?;
    Ok(stage("compile", volume, &mut stats, |_| loaded.compile(&texels, skins))?)
}

/// The scene of a file, changed as the flags say.
fn scene(args: &ValidateArgs, path: &Path) -> Result<SceneFile, Failure> {
    let mut scene = SceneFile::open(path)?;
    scene.allow_dirs.clone_from(&args.allow.allow_dir);
    if let Some(texel) = &args.texel {
        scene.skin = vec![SkinEntry::of_texel(texel.clone())];
        scene.forget("skin");
    }
    for skin in &mut scene.skin {
        skin.height = args.height.or(skin.height);
        if let Some(resolution) = args.resolution {
            set_resolution(skin, resolution, path).map_err(pelage::Error::from)?;
        }
    }
    scene.render.rays = args.rays.or(scene.render.rays);
    scene.render.lod = args.lod.unwrap_or(scene.render.lod);
    scene.validate().map_err(pelage::Error::from)?;
    Ok(scene)
}

fn plan(args: &ValidateArgs) -> Plan {
    Plan {
        size: args.size,
        samples: args.spp,
        distances: args.distances.clone(),
        lights: match args.lights {
            LightsArg::Standard => Lights::Standard,
            LightsArg::Scene => Lights::Scene,
        },
        ppd: args.ppd,
        goals: args.goals.map(|goals| match goals {
            GoalsArg::Standard => Goals::STANDARD,
            GoalsArg::Fur => Goals::FUR,
        }),
        frames: args.frames,
        ..Plan::default()
    }
}

/// Whose fault it is that a scene could not be validated.
fn blame(path: &Path, error: StudyError) -> Failure {
    match error {
        StudyError::Reference(error) => pelage::Error::from(error).into(),
        StudyError::Render(error) | StudyError::Sight(SightError::Render(error)) => {
            pelage::Error::from(error).into()
        }
        StudyError::Light(error) => pelage::Error::from(error).into(),
        StudyError::Sight(error) => Failure::Usage(format!("{}: {error}", path.display())),
        StudyError::Measure(error) => Failure::Study(format!("{}: {error}", path.display())),
    }
}

fn about(args: &ValidateArgs) -> String {
    let mut about = format!(
        "pelage {}: at most {} pixels a side, {} samples a pixel, {} frames",
        env!("CARGO_PKG_VERSION"),
        args.size,
        args.spp,
        args.frames
    );
    for (flag, value) in [
        ("resolution", args.resolution.map(|n| n.to_string())),
        ("height", args.height.map(|h| h.to_string())),
        (
            "rays",
            args.rays.map(|r| match r {
                Rays::Adaptive => "adaptive".to_string(),
                r => r.count().to_string(),
            }),
        ),
        ("lod", args.lod.map(|l| format!("{l:?}"))),
    ] {
        if let Some(value) = value {
            let _ = write!(about, ", --{flag} {value}");
        }
    }
    about
}

fn tell(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(Failure::Stdout)
}

fn samples(text: &str) -> Result<u32, String> {
    let even = |n: &u32| (4..=65536).contains(n) && n.is_multiple_of(2);
    text.parse().ok().filter(even).ok_or_else(|| "expected an even number from 4 to 65536".into())
}

fn side(text: &str) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|n| (4..=4096).contains(n))
        .ok_or_else(|| "expected a number from 4 to 4096".into())
}

fn frames(text: &str) -> Result<u32, String> {
    let sequence = |n: &u32| *n == 0 || (2..=1000).contains(n);
    text.parse().ok().filter(sequence).ok_or_else(|| "expected 0, or a number from 2 to 1000".into())
}
