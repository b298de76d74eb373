//! What was found out about scenes, as one page with all its pictures in it.

use std::io;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use pelage::output::encode_png;

use crate::goals::{Goals, Miss};
use crate::panels::{AS_IT_IS, panels};
use crate::study::{Cell, Found, Pictures, Study};
use crate::table::{missed, number, percent, worth};

const STYLE: &str = "\
body { font: 14px/1.4 system-ui, sans-serif; margin: 2em; color: #222; background: #fff }
table { border-collapse: collapse; margin: 1em 0 }
th, td { padding: .15em .6em; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th, td.word { text-align: left }
td.missed { background: #fbdcd4 }
figure { display: inline-block; margin: 0 1em 1em 0 }
figcaption { font-size: 12px; color: #555 }
img { image-rendering: pixelated; height: 192px; background: #000 }
.note { color: #555; max-width: 60em }";

/// A self-contained HTML page of `studies`; `about` says how they were made.
///
/// # Errors
/// A picture that cannot be encoded.
pub fn page(studies: &[Study], about: &str) -> io::Result<String> {
    let sections =
        studies.iter().enumerate().map(|(i, study)| section(i, study)).collect::<io::Result<Vec<_>>>()?;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { "pelage validate" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Cone pictures against the geometry" }
                p.note { (about) }
                (summary(studies))
                @for section in &sections { (section) }
                (notes())
            }
        }
    };
    Ok(markup.into_string())
}

fn summary(studies: &[Study]) -> Markup {
    html! {
        table {
            tr { th { "scene" } th { "goals missed" } th { "worst |alpha|" } th { "worst |energy|" } th { "worst FLIP" } th { "least N" } th { "seconds" } }
            @for (i, study) in studies.iter().enumerate() {
                @let cells = || study.distances.iter().flat_map(|found| &found.lights);
                @let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
                @let least = cells().filter_map(|c| c.worth).min_by(|a, b| a.samples.total_cmp(&b.samples));
                tr {
                    td.word { a href=(format!("#scene{i}")) { (study.scene) } }
                    td.missed[study.misses > 0] { (study.misses) }
                    td { (percent(Some(most(&mut study.distances.iter().filter_map(|f| f.alpha_bias).map(f64::abs))))) }
                    td { (percent(Some(most(&mut cells().filter_map(|c| c.energy_error).map(f64::abs))))) }
                    td { (number(Some(most(&mut cells().map(|c| c.flip))))) }
                    td { (worth(least)) }
                    td { (format!("{:.0}", study.seconds)) }
                }
            }
        }
    }
}

fn section(i: usize, study: &Study) -> io::Result<Markup> {
    let rows = study.distances.iter().map(pictures).collect::<io::Result<Vec<_>>>()?;
    Ok(html! {
        h2 id=(format!("scene{i}")) { (study.scene) }
        p.note {
            "Reference: " (study.samples) " samples a pixel. Exposure " (study.exposure) ". FLIP at " (study.ppd)
            " pixels a degree. " (goals(&study.goals))
        }
        table {
            tr {
                th { "distance" } th { "box, pixels" } th { "level" } th { "window" } th { "alpha" } th { "light" }
                th { "energy" } th { "RMSE" } th { "FLIP" } th { "as good as N samples" } th { "flicker" }
                th { "flicker of 16" } th { "verdict" }
            }
            @for found in &study.distances {
                @for (k, cell) in found.lights.iter().enumerate() { (row(found, k, cell)) }
            }
        }
        @for row in &rows { (row) }
    })
}

fn row(found: &Found, k: usize, cell: &Cell) -> Markup {
    let over = |measure: &str| cell.misses.iter().any(|miss| miss.measure == measure);
    let misses: Vec<&Miss> = found.misses.iter().filter(|_| k == 0).chain(&cell.misses).collect();
    html! {
        tr {
            @if k == 0 {
                @let span = found.lights.len();
                td rowspan=(span) { (found.distance) }
                td rowspan=(span) { (format!("{:.1}", found.box_pixels)) }
                td rowspan=(span) { (format!("{:.2}", found.level)) }
                td rowspan=(span) { (found.window[0]) "×" (found.window[1]) @if found.looks > 1 { ", " (found.looks) " times" } }
                td.missed[!found.misses.is_empty()] rowspan=(span) { (percent(found.alpha_bias)) }
            }
            td.word { (cell.light) }
            td.missed[over("energy")] { (percent(cell.energy_error)) }
            td { (format!("{:.4}", cell.rmse)) }
            td.missed[over("flip")] { (format!("{:.3}", cell.flip)) }
            td.missed[over("samples")] { (worth(cell.worth)) }
            td.missed[over("flicker")] { (number(cell.flicker)) }
            td { (number(cell.flicker_of_16)) }
            td.word {
                @if misses.is_empty() { "ok" }
                @for (i, miss) in misses.iter().enumerate() { @if i > 0 { ", " } (missed(miss)) }
            }
        }
    }
}

fn pictures(found: &Found) -> io::Result<Markup> {
    let sources = found.lights.iter().map(|cell| source(&cell.pictures)).collect::<io::Result<Vec<_>>>()?;
    Ok(html! {
        div {
            @for (cell, source) in found.lights.iter().zip(&sources) {
                figure {
                    img src=(source) alt="cone picture, reference and FLIP map";
                    figcaption { (found.distance) ", " (cell.light) ": cone | reference | FLIP" }
                }
            }
        }
    })
}

/// The three panels of a cell, as an address that holds the picture itself.
fn source(pictures: &Pictures) -> io::Result<String> {
    let Pictures { cone, reference, map, display } = pictures;
    let mut png = Vec::new();
    encode_png(&panels(cone, reference, map, display), &AS_IT_IS, &mut png)?;
    Ok(format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png)))
}

fn goals(goals: &Goals) -> String {
    let Goals { alpha_bias, energy_wide, energy_narrow, flip, samples_near, samples_far, flicker, wide } =
        goals;
    format!(
        "Goals: alpha within {} %; energy within {} % where a box is {wide} pixels or wider and {} % beyond; FLIP at \
         most {flip}; as good as {samples_near} samples near and {samples_far} from {wide} pixels outwards; flicker at \
         most {flicker} of that of 16 samples.",
        100.0 * alpha_bias,
        100.0 * energy_wide,
        100.0 * energy_narrow
    )
}

fn notes() -> Markup {
    html! {
        p.note {
            "Energy under light from behind is judged against the energy under light from the side. RMSE is in linear \
             radiance, the noise of the reference subtracted. N is the number of samples a pixel at which the reference \
             renderer errs as much; ≥ where the reference's own noise hides more. Flicker is the root mean square of \
             (the picture's change from frame to frame − the reference's) over a zoom of a quarter of a level. In FLIP \
             maps black is equal and pale yellow as unlike as can be."
        }
    }
}
