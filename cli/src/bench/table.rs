//! What was measured, for people.

use std::fmt::Write;

use pelage::expand::Bytes;

use super::report::{Along, Frame, Picture, SceneReport};

/// A scene and its pictures.
pub fn table(report: &SceneReport) -> String {
    let SceneReport { scene, about, boxes, triangles, seconds, threads, .. } = report;
    let mut text = format!("{scene}: {about}\n");
    let _ = writeln!(
        text,
        "  {boxes} boxes, {:.2} M triangles if expanded; texel {}, skin {}, peak {}",
        *triangles as f64 * 1e-6,
        Bytes(report.texel_bytes as u64),
        Bytes(report.skin_bytes as u64),
        report.peak_memory.map_or("unknown".into(), |bytes| Bytes(bytes).to_string()),
    );
    let _ = writeln!(
        text,
        "  load {:.3} s, extrude {:.3} s, compile {:.3} s ({threads} threads)",
        seconds.load, seconds.extrude, seconds.compile
    );
    text.push_str(
        "  view path     thr  render s   cpu s  file→pic    fps  Mray/s  light/px  pass/ray  chord/ray  walk/ray  \
         cell/ray  ns/ray  ns/cell  /straight    eff\n",
    );
    for picture in &report.pictures {
        row(&mut text, picture);
    }
    if let Some(Frame { deform, certify, build, render, total }) = report.frame {
        let _ = writeln!(
            text,
            "  a frame: deform {deform:.4} s, certify {certify:.4} s, build {build:.4} s, render {render:.3} s, in all {total:.3} s"
        );
    }
    text
}

fn row(text: &mut String, picture: &Picture) {
    let Picture { threads, seconds, cpu_seconds, from_file_seconds, pictures_per_second, work, .. } = picture;
    let path = match picture.path {
        Along::Curved => "curved",
        Along::Straight => "straight",
    };
    let of = |ratio: Option<f64>| ratio.map_or("-".into(), |ratio| format!("{ratio:.3}"));
    let _ = writeln!(
        text,
        "  {:4} {path:8} {threads:3}  {seconds:8.3} {cpu_seconds:7.3}  {from_file_seconds:8.3}  {pictures_per_second:5.2}  \
         {:6.2}  {:8.2}  {:8.2}  {:9.2}  {:8.2}  {:8.2}  {:6.0}  {:7.1}  {:>9}  {:>5}",
        picture.distance.name(),
        work.mrays_per_second,
        work.light_cones_per_pixel,
        work.passages_per_ray,
        work.chords_per_ray,
        work.walks_per_ray,
        work.cells_per_ray,
        work.ns_per_ray,
        work.ns_per_cell,
        of(picture.over_straight),
        of(picture.efficiency),
    );
}
