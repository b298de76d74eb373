//! What was found out about a scene, as a table to read.

use std::fmt::Write;

use crate::goals::Miss;
use crate::noise::Worth;
use crate::study::{Cell, Found, Study};

/// A table of `study`: a line for each distance and light, the goals missed at its end.
pub fn table(study: &Study) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {} samples, {:.0} s, {}",
        study.scene,
        study.samples,
        study.seconds,
        match study.misses {
            0 => "every goal reached".to_owned(),
            n => format!("{n} goals missed"),
        }
    );
    let _ = writeln!(
        text,
        "{:>8} {:>7} {:>6} {:>8}  {:<9} {:>8} {:>7} {:>6} {:>7} {:>8} {:>8}",
        "distance", "box px", "level", "alpha", "light", "energy", "RMSE", "FLIP", "N", "flicker", "of 16"
    );
    for found in &study.distances {
        for (i, cell) in found.lights.iter().enumerate() {
            // What all lights share is told once.
            let shared = if i == 0 { distance(found) } else { " ".repeat(32) };
            let misses = found.misses.iter().filter(|_| i == 0).chain(&cell.misses);
            let verdict: Vec<String> = misses.map(missed).collect();
            let verdict = if verdict.is_empty() { "ok".into() } else { verdict.join(", ") };
            let _ = writeln!(text, "{shared}  {}  {verdict}", line(cell));
        }
    }
    text
}

fn distance(found: &Found) -> String {
    let Found { distance, box_pixels, level, alpha_bias, .. } = found;
    format!("{distance:>8} {box_pixels:>7.1} {level:>6.2} {:>8}", percent(*alpha_bias))
}

fn line(cell: &Cell) -> String {
    format!(
        "{:<9} {:>8} {:>7.4} {:>6.3} {:>7} {:>8} {:>8}",
        cell.light,
        percent(cell.energy_error),
        cell.rmse,
        cell.flip,
        worth(cell.worth),
        number(cell.flicker),
        number(cell.flicker_of_16)
    )
}

/// A miss in words: by how much, and what it should be.
pub(crate) fn missed(miss: &Miss) -> String {
    let Miss { measure, value, goal } = miss;
    match *measure {
        "alpha" | "energy" => format!("{measure} {:.1} % over {:.1} %", 100.0 * value, 100.0 * goal),
        "samples" => format!("N {value:.1} under {goal:.0}"),
        "flicker" => format!("{measure} {value:.4} over {goal:.4}"),
        _ => format!("{measure} {value:.3} over {goal:.3}"),
    }
}

pub(crate) fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |x| format!("{:+.2} %", 100.0 * x))
}

pub(crate) fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |x| format!("{x:.4}"))
}

/// The samples that a picture is worth; `≥` where no more can be told.
pub(crate) fn worth(worth: Option<Worth>) -> String {
    worth.map_or_else(
        || "-".into(),
        |w| {
            let sign = if w.at_least { "≥" } else { "" };
            if w.samples < 9.95 {
                format!("{sign}{:.1}", w.samples)
            } else {
                format!("{sign}{:.0}", w.samples)
            }
        },
    )
}
