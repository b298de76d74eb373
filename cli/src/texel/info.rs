//! `pelage texel info`: what a texel file holds.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use pelage::texel::file::{PartKind, TexelFile};
use pelage::texel::{Procedure, Source};
use pelage::texel_file::read_texel;
use serde::Serialize;

use crate::failure::Failure;

#[derive(Args)]
pub struct InfoArgs {
    /// The texel: .texel
    file: PathBuf,

    /// As JSON
    #[arg(long)]
    json: bool,
}

/// Tells what the file holds, on stdout.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let info = Info::new(&read_texel(&args.file)?);
    let text = if args.json {
        serde_json::to_string_pretty(&info).map_err(|error| Failure::Stdout(error.into()))? + "\n"
    } else {
        info.text()
    };
    std::io::stdout().write_all(text.as_bytes()).map_err(Failure::Stdout)
}

#[derive(Serialize)]
struct Info {
    name: String,
    licence: String,
    origin: String,
    parameters: std::collections::BTreeMap<String, String>,
    source: String,
    periodic: bool,
    specular: f32,
    roughness: f32,
    depth: u32,
    resolution: u64,
    levels: Vec<LevelInfo>,
    /// Of the whole file.
    bytes: u64,
    /// Of all levels, in memory.
    memory: usize,
    /// By an occupied voxel of the finest level, all levels together.
    bytes_per_finest_voxel: f64,
    memory_per_finest_voxel: f64,
    /// Along s, t and w, of the finest level.
    opacity: [f32; 3],
    checksum: String,
}

#[derive(Serialize)]
struct LevelInfo {
    level: u32,
    voxels: usize,
    stored: u64,
    memory: usize,
}

impl Info {
    fn new(file: &TexelFile) -> Self {
        let texel = &file.texel;
        let stored = |l| file.parts.iter().filter(|p| p.kind == PartKind::Level(l)).map(|p| p.stored).sum();
        let levels: Vec<LevelInfo> = (0..)
            .zip(texel.levels())
            .map(|(l, level)| LevelInfo {
                level: l,
                voxels: level.len(),
                stored: stored(l),
                memory: level.memory(),
            })
            .collect();
        let finest = levels.last().map_or(1, |level| level.voxels).max(1) as f64;
        let on_disk: u64 = levels.iter().map(|level| level.stored).sum();
        let source = match texel.source() {
            Source::Unknown => "not kept".into(),
            Source::Geometry(geometry) => format!("{} triangles", geometry.triangles.len()),
            Source::Grown(kind) => format!("grown: {}", kind.name()),
        };
        Self {
            name: texel.name.clone(),
            licence: file.metadata.licence.clone(),
            origin: file.metadata.origin.clone(),
            parameters: file.metadata.parameters.clone(),
            source,
            periodic: texel.periodic,
            specular: texel.specular,
            roughness: texel.roughness,
            depth: texel.depth(),
            resolution: 1 << texel.depth(),
            bytes: file.length,
            memory: texel.memory(),
            bytes_per_finest_voxel: on_disk as f64 / finest,
            memory_per_finest_voxel: texel.memory() as f64 / finest,
            opacity: [0, 1, 2].map(|axis| texel.opacity(texel.depth(), axis)),
            checksum: format!("{:08x}", file.checksum),
            levels,
        }
    }

    fn text(&self) -> String {
        // What a stranger wrote must not steer the terminal.
        let plain = |text: &str| text.chars().filter(|c| !c.is_control()).collect::<String>();
        let or_none = |text: &str| if text.is_empty() { "not given".into() } else { plain(text) };
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<12} {value}");
        };
        line("name", or_none(&self.name));
        line("source", self.source.clone());
        line("origin", or_none(&self.origin));
        line("licence", or_none(&self.licence));
        for (name, value) in &self.parameters {
            line("parameter", format!("{} = {}", plain(name), plain(value)));
        }
        line("resolution", format!("{0}³, levels 0 to {1}", self.resolution, self.depth));
        line("repeats", if self.periodic { "in s and t".into() } else { "no".into() });
        line("material", format!("specular {}, roughness {}", self.specular, self.roughness));
        let [s, t, w] = self.opacity;
        line("opacity", format!("{s:.3} along s, {t:.3} along t, {w:.3} along w"));
        line("checksum", self.checksum.clone());
        let _ = writeln!(text, "\n{:>5} {:>10} {:>12} {:>12}", "level", "voxels", "file bytes", "memory");
        for LevelInfo { level, voxels, stored, memory } in &self.levels {
            let _ = writeln!(text, "{level:>5} {voxels:>10} {stored:>12} {memory:>12}");
        }
        let _ = writeln!(text, "{:>5} {:>10} {:>12} {:>12}", "all", "", self.bytes, self.memory);
        let _ = writeln!(
            text,
            "a finest voxel, all levels together: {:.1} bytes in the file, {:.1} in memory",
            self.bytes_per_finest_voxel, self.memory_per_finest_voxel
        );
        text
    }
}
