//! `pelage skin mesh-table`: one surface by more and more patches. [seed §7]

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use pelage::geom::glam::Vec3;
use pelage::skin::tessellate::{Deviation, Parametric, uniform};
use pelage::skin::{Skin, SkinOptions, extrude};

use crate::failure::Failure;

/// How often each row is made; the median time is told.
const REPEATS: usize = 9;

const NOTES: &str = "\
Arc error: by how much the worst edge is shorter than the curve on the surface between its ends. Area error: by how much
the worst patch's area is off that of the surface over it; total: all of them together. Time: for the mesh, its measure, its
boxes and their certificates, the median of 9. Memory: of the boxes.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct MeshTableArgs {
    /// Which surface
    #[arg(long, value_enum, default_value_t = Surface::Bezier)]
    surface: Surface,

    /// Patches along each side, row by row
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', default_values_t = [4, 8, 16])]
    sides: Vec<u32>,
}

/// Surfaces with numbers of their own.
#[derive(Clone, Copy, ValueEnum)]
enum Surface {
    /// A strongly bent bicubic patch
    Bezier,
    /// A sphere, twice as many patches around as up
    Sphere,
    /// A torus of radii 1 and 0.4
    Torus,
}

impl Surface {
    fn parametric(self) -> Parametric {
        match self {
            Self::Sphere => Parametric::Sphere { radius: 1.0 },
            Self::Torus => Parametric::Torus { major: 1.0, minor: 0.4 },
            Self::Bezier => {
                const HEIGHTS: [f32; 16] =
                    [0.0, 2.6, -2.6, 0.0, 2.6, 6.0, -6.0, -2.6, -2.6, -6.0, 6.0, 2.6, 0.0, -2.6, 2.6, 0.0];
                let at =
                    |(k, height): (usize, f32)| Vec3::new((k % 4) as f32 - 1.5, height, 1.5 - (k / 4) as f32);
                Parametric::Bezier { points: HEIGHTS.into_iter().enumerate().map(at).collect() }
            }
        }
    }
}

struct Row {
    patches: usize,
    vertices: usize,
    deviation: Deviation,
    time: Duration,
    bytes: usize,
}

/// Prints the table.
pub fn run(args: &MeshTableArgs) -> Result<(), Failure> {
    if let Some(side) = args.sides.iter().find(|n| !(1..=2048).contains(*n)) {
        return Err(Failure::Usage(format!("--sides: {side}: from 1 to 2048 patches a side are possible")));
    }
    let surface = args.surface.parametric();
    let around = if matches!(args.surface, Surface::Sphere) { 2 } else { 1 };
    let mut table = String::from(
        "patches  vertices   arc error            area error                      time      memory\n",
    );
    for &n in &args.sides {
        let Row { patches, vertices, deviation: d, time, bytes } =
            row(&surface, around * n as usize, n as usize)?;
        let _ = writeln!(
            table,
            "{patches:7}  {vertices:8}   {:6.2} %  {:7.4} m   {:6.2} %  {:7.4} m²  {:6.2} % total   {:6.2} ms  {:7.2} KB",
            100.0 * d.arc,
            d.arc_metres,
            100.0 * d.area,
            d.area_square_metres,
            100.0 * d.total_area,
            1e3 * time.as_secs_f64(),
            bytes as f64 / 1e3
        );
    }
    std::io::stdout().write_all(table.as_bytes()).map_err(Failure::Stdout)
}

fn row(surface: &Parametric, nu: usize, nv: usize) -> Result<Row, Failure> {
    let fault = |e: pelage::skin::SkinError| Failure::Usage(e.to_string());
    let mut times = Vec::new();
    let mut made = None;
    for _ in 0..REPEATS {
        let begin = Instant::now();
        let tessellation = uniform(surface, nu, nv).map_err(fault)?;
        let skin: Skin = extrude(&tessellation.mesh, &|_| true, &SkinOptions::new(0.05)).map_err(fault)?;
        times.push(begin.elapsed());
        made = Some((tessellation, skin));
    }
    times.sort_unstable();
    let (tessellation, skin) = made.ok_or_else(|| Failure::Usage("nothing was made".into()))?;
    Ok(Row {
        patches: tessellation.mesh.faces.len(),
        vertices: tessellation.mesh.positions.len(),
        deviation: tessellation.deviation(),
        time: times[REPEATS / 2],
        bytes: skin.bytes(),
    })
}
