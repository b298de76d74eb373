//! `pelage bench`: whole scenes, measured.
//!
//! | | |
//! |---|---|
//! | [`scenes`] | what is measured |
//! | [`measure`], [`moving`] | how |
//! | [`report`], [`table`] | what is told, for programs and for people |

mod measure;
mod moving;
mod report;
mod scenes;
mod table;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;
use pelage::output::{check_place, replace};
use serde::Serialize;

use crate::args::{size, threads};
use crate::failure::Failure;
use crate::progress::say;
use crate::render::pool;
use measure::Plan;
use report::{Report, SceneReport};
use scenes::{BenchScene, Distance, SCENES, scene};
use table::table;

const NOTES: &str = "\
Texels are baked once and kept in the cache, with the scene files (NAME-DISTANCE.toml, for pelage render and expand): what
is measured goes from a scene file to a picture. Delete the cache when texels are built in another way than they were.
Every scene is measured in a process of its own, its pictures along the curved and the straight path by turns. Times are
medians. A ray or cone is one from the camera or to a light; ns a ray and a cell are of the CPU time of all threads.

Examples:
  pelage bench --scene blades-4096,hairs --threads 1,2 --json bench.json
  pelage bench --list";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct BenchArgs {
    /// Only these, with commas between [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = scene)]
    scene: Vec<&'static BenchScene>,

    /// Tell which scenes there are, and measure nothing
    #[arg(long)]
    list: bool,

    /// From how far, with commas between
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Distance::Mid, Distance::Far])]
    distance: Vec<Distance>,

    /// Numbers of threads, with commas between; 0 for one a core
    #[arg(short, long, value_name = "N,N,…", value_delimiter = ',', default_values_t = [0], value_parser = threads)]
    threads: Vec<usize>,

    /// How often each time is taken
    #[arg(long, default_value_t = 5, value_parser = runs)]
    runs: usize,

    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [u32; 2],

    /// Voxels a side of the texels
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = resolution)]
    resolution: u32,

    /// The folder where texels and scenes are kept [default: pelage-bench among the system's temporary files]
    #[arg(long, value_name = "FOLDER")]
    cache: Option<PathBuf>,

    /// Also write what was measured: .json
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Measure one scene in this process and tell its part of the JSON
    #[arg(long, hide = true)]
    here: bool,
}

/// Measures what the arguments name.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    if args.list {
        let list: String = SCENES.iter().map(|s| format!("{:16} {}\n", s.name, s.about)).collect();
        return out.write_all(list.as_bytes()).map_err(Failure::Stdout);
    }
    let plan = args.plan()?;
    if let ([scene], true) = (&args.scene[..], args.here) {
        let told = to_json(&plan.measure(scene)?)?;
        return writeln!(out, "{told}").map_err(Failure::Stdout);
    }
    if let Some(path) = &args.json {
        check_place(path)?;
    }
    let mut scenes = Vec::new();
    for scene in if args.scene.is_empty() { SCENES.iter().collect() } else { args.scene.clone() } {
        say(format_args!("{} …", scene.name));
        plan.write(scene)?;
        let report = args.measured_apart(scene, &plan)?;
        out.write_all(table(&report).as_bytes()).map_err(Failure::Stdout)?;
        scenes.push(report);
    }
    if let Some(path) = &args.json {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let BenchArgs { size, runs, resolution, .. } = *args;
        let told = to_json(&Report { version, size, runs, resolution, scenes })?;
        replace(path, |file| writeln!(file, "{told}"))?;
    }
    Ok(())
}

fn to_json(report: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(report).map_err(|error| Failure::Study(error.to_string()))
}

impl BenchArgs {
    /// Measures a scene in a process of its own, so that its memory is its own.
    fn measured_apart(&self, scene: &BenchScene, plan: &Plan) -> Result<SceneReport, Failure> {
        let fault = |what: String| Failure::Study(format!("{}: {what}", scene.name));
        let listed = |list: Vec<String>| list.join(",");
        let program = std::env::current_exe().map_err(|error| fault(error.to_string()))?;
        let output = Command::new(program)
            .args(["bench", "--here", "--scene", scene.name])
            .args(["--distance", &listed(self.distance.iter().map(|d| d.name().to_owned()).collect())])
            .args(["--threads", &listed(self.threads.iter().map(usize::to_string).collect())])
            .args(["--runs", &self.runs.to_string()])
            .args(["--size", &format!("{}x{}", self.size[0], self.size[1])])
            .args(["--resolution", &self.resolution.to_string()])
            .arg("--cache")
            .arg(&plan.cache)
            .stderr(Stdio::inherit())
            .output()
            .map_err(|error| fault(error.to_string()))?;
        if !output.status.success() {
            return Err(fault(output.status.to_string()));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| fault(error.to_string()))
    }

    fn plan(&self) -> Result<Plan, Failure> {
        let cache = self.cache.clone().unwrap_or_else(|| std::env::temp_dir().join("pelage-bench"));
        std::fs::create_dir_all(&cache)
            .map_err(|error| Failure::Usage(format!("--cache {}: {error}", cache.display())))?;
        let pools = self.threads.iter().map(|&n| pool(n).map(|pool| (pool.current_num_threads(), pool)));
        Ok(Plan {
            distances: self.distance.clone(),
            pools: pools.collect::<Result<_, _>>()?,
            runs: self.runs,
            size: self.size,
            cache,
            resolution: self.resolution,
        })
    }
}

fn runs(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|n| (1..=1000).contains(n));
    count.ok_or_else(|| "expected a whole number from 1 to 1000".into())
}

fn resolution(text: &str) -> Result<u32, String> {
    let side = text.parse().ok().filter(|n: &u32| n.is_power_of_two() && (2..=512).contains(n));
    side.ok_or_else(|| "expected a power of two from 2 to 512".into())
}
