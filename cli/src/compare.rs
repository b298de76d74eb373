//! `pelage compare`: how far a picture is from its reference.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use pelage::output::{Display, Format, Tone, check_output, write_png};
use pelage::tracer::{Film, Rect};
use pelage_validate::{
    AS_IT_IS, Encoding, MeasureError, Measures, NORMAL_PPD, Picture, exposure_of, flip, panels, part,
};
use serde::Serialize;

use crate::args::{list, positive};
use crate::failure::Failure;

const NOTES: &str = "\
A is the test and B the reference: ratios are A over B. Both are .png (what a screen shows) or both .exr (linear
radiance). Colours are compared linear and premultiplied, as over black. PSNR and FLIP compare what a screen shows:
PNGs as they are, radiance exposed so that 95 % of the lit pixels of B stay below 0.8, with the filmic curve of
`pelage render`.

Examples:
  pelage compare cone.exr reference.exr
      A table of all measures.
  pelage compare new.png old.png --json --diff difference.png
      The same for programs, and a picture of A, B and their FLIP map (black: equal; pale yellow: as unlike as can be).";

#[derive(Args)]
#[command(after_help = NOTES)]
pub struct CompareArgs {
    /// The test: .png or .exr
    #[arg(value_name = "A")]
    test: PathBuf,

    /// The reference that it is measured against: a file of the same kind and size
    #[arg(value_name = "B")]
    reference: PathBuf,

    /// Tell in one line of JSON
    #[arg(long)]
    json: bool,

    /// Write A, B and their FLIP map side by side
    #[arg(long, value_name = "PNG")]
    diff: Option<PathBuf>,

    /// Compare only this part, in pixels, the ends not included
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = list::<4, u32>, allow_hyphen_values = true)]
    crop: Option<[u32; 4]>,

    /// Stops added to the automatic exposure (EXR)
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    exposure: Option<f32>,

    /// Pixels a degree of the eye, for FLIP
    #[arg(long, default_value_t = NORMAL_PPD, value_parser = ppd, allow_hyphen_values = true)]
    ppd: f32,
}

/// What `--json` tells; the keys are kept.
#[derive(Serialize)]
struct Comparison {
    test: String,
    reference: String,
    /// The part compared.
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    /// What radiance was multiplied by to be shown; 1 for PNGs.
    exposure: f32,
    ppd: f32,
    /// Mean FLIP.
    flip: f64,
    #[serde(flatten)]
    measures: Measures,
}

/// Compares what the arguments name.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    if let Some(path) = &args.diff
        && check_output(path)? != Format::Png
    {
        return Err(Failure::Usage(format!("{}: a difference is written as .png", path.display())));
    }
    let (test, reference) = (Picture::open(&args.test)?, Picture::open(&args.reference)?);
    let [a, b] = [&args.test, &args.reference].map(|path| path.display());
    if test.encoding != reference.encoding {
        return Err(Failure::Usage(format!(
            "{a}: a PNG holds what a screen shows, an EXR radiance: compare it with a file of its own kind, not {b}"
        )));
    }
    let unlike = |error: MeasureError| {
        let hint =
            if matches!(error, MeasureError::Window { .. }) { "; --crop names a part of both" } else { "" };
        Failure::Usage(format!("{a}: {error} {b}{hint}"))
    };
    if test.film.size != reference.film.size {
        let (test, reference) = (test.film.size, reference.film.size);
        return Err(unlike(MeasureError::Size { test, reference }));
    }
    let (test_film, reference_film) = match args.crop {
        Some(crop) => (cut(&test.film, crop, &args.test)?, cut(&reference.film, crop, &args.reference)?),
        None => (test.film, reference.film),
    };
    let display = display(args, reference.encoding, &reference_film)?;
    let measures = Measures::of(&test_film, &reference_film, &display).map_err(unlike)?;
    let map = flip(&test_film, &reference_film, &display, args.ppd).map_err(unlike)?;
    if let Some(path) = &args.diff {
        write_png(&panels(&test_film, &reference_film, &map, &display), path, &AS_IT_IS)?;
    }
    let Rect { x, y, width, height } = reference_film.window;
    let comparison = Comparison {
        test: a.to_string(),
        reference: b.to_string(),
        x,
        y,
        width,
        height,
        exposure: display.exposure,
        ppd: args.ppd,
        flip: map.mean(),
        measures,
    };
    let told = if args.json { json(&comparison)? } else { text(&comparison) };
    std::io::stdout().write_all(told.as_bytes()).map_err(Failure::Stdout)
}

fn cut(film: &Film, [x0, x1, y0, y1]: [u32; 4], path: &Path) -> Result<Film, Failure> {
    let window = x1.checked_sub(x0).zip(y1.checked_sub(y0));
    let window = window.map(|(width, height)| Rect { x: x0, y: y0, width, height });
    window.and_then(|window| part(film, window)).ok_or_else(|| {
        let Rect { x, y, width, height } = film.window;
        let held = format!("columns {x} to {} and rows {y} to {}", x + width, y + height);
        Failure::Usage(format!("{}: --crop {x0},{x1},{y0},{y1} is not within its {held}", path.display()))
    })
}

fn display(args: &CompareArgs, encoding: Encoding, reference: &Film) -> Result<Display, Failure> {
    match (encoding, args.exposure) {
        (Encoding::Display, None) => Ok(AS_IT_IS),
        (Encoding::Display, Some(_)) => {
            Err(Failure::Usage(format!("{}: --exposure: a PNG is exposed already", args.reference.display())))
        }
        (Encoding::Radiance, stops) => {
            let stops = stops.unwrap_or(0.0);
            let exposure = exposure_of(reference) * stops.exp2();
            if !(exposure > 0.0 && exposure.is_finite()) {
                return Err(Failure::Usage(format!("--exposure {stops}: beyond what can be shown")));
            }
            Ok(Display { exposure, tone: Tone::Filmic })
        }
    }
}

fn json(comparison: &Comparison) -> Result<String, Failure> {
    let line = serde_json::to_string(comparison).map_err(|e| Failure::Stdout(e.into()))?;
    Ok(line + "\n")
}

fn text(comparison: &Comparison) -> String {
    let m = &comparison.measures;
    let or = |value: Option<f64>, digits: usize, none: &str| {
        value.map_or_else(|| none.to_owned(), |x| format!("{x:.digits$}"))
    };
    let percent =
        m.alpha_bias.map_or_else(|| "the reference is empty".into(), |x| format!("{:+.3} %", 100.0 * x));
    let most = m.max_difference;
    let rows = [
        ("RMSE", format!("{:.6}", m.rmse), ""),
        ("relMSE", format!("{:.6}", m.rel_mse), ""),
        ("PSNR", or(m.psnr, 2, "no difference"), if m.psnr.is_some() { "dB" } else { "" }),
        ("mean FLIP", format!("{:.5}", comparison.flip), ""),
        ("energy ratio", or(m.energy_ratio, 5, "the reference is black"), ""),
        ("alpha bias", percent, ""),
        ("alpha difference", format!("{:+.6}", m.alpha_difference), ""),
        ("max difference", format!("{:.6} at column {}, row {}", most.value, most.x, most.y), ""),
    ];
    let mut text = String::new();
    for (name, value, unit) in rows {
        let _ = writeln!(text, "{}", format!("{name:>16}  {value} {unit}").trim_end());
    }
    text
}

/// Pixels a degree: outside of this a filter is wider than any picture, or narrower than a pixel.
pub fn ppd(text: &str) -> Result<f32, String> {
    positive(text)
        .ok()
        .filter(|x| (1.0..=1000.0).contains(x))
        .ok_or_else(|| "expected a number from 1 to 1000".into())
}
