//! Texture coordinates for surfaces that have none: each connected piece is cut open where it shows least, until it
//! lies flat without being stretched too much.
//!
//! | file | does |
//! |---|---|
//! | `sheet` | the connected pieces, and what they are when they are cut |
//! | `seams` | where they are cut |
//! | `flatten` | lays a disk flat |
//! | `sparse` | solves |
//!
//! The unit of the coordinates is the metre, everywhere as nearly as stretching lets it be.

mod flatten;
mod seams;
mod sheet;
mod sparse;

use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;

use crate::polygon::Surface;
use flatten::{Triangle, flatten, triangles};
use sheet::{NONE, Opened, Sheet, sheets};

/// More faces would take minutes and gigabytes to lay out.
pub(crate) const MOST_FACES: usize = 200_000;

/// A triangle is stretched too much where its longest direction is longer by this factor than it should be, or its
/// shortest shorter.
const MOST_STRETCH: f64 = 1.4;

/// What part of the area may be stretched more than that.
const OVERSTRETCHED: f64 = 0.01;

/// How often cuts are added; each time at most as many as [`CUTS`].
const ROUNDS: usize = 8;

/// How many cuts are made before a sheet is laid flat again.
const CUTS: usize = 4;

/// Two ends of cuts of one round are at least this far apart, as a part of the root of the sheet's area.
const APART: f64 = 0.15;

/// By polygon and corner of `surface` where it lies in the plane, in metres. The same bits on every run.
pub(crate) fn coordinates(surface: &Surface) -> Vec<[Vec2; 4]> {
    let mut coordinates = vec![[Vec2::ZERO; 4]; surface.polygons.len()];
    let laid: Vec<(Sheet, Vec<DVec2>)> = sheets(surface).into_par_iter().map(lay).collect();
    for (sheet, corners) in laid {
        for (&p, corners) in sheet.polygons.iter().zip(corners.chunks(4)) {
            for (to, from) in coordinates[p as usize].iter_mut().zip(corners) {
                *to = from.as_vec2();
            }
        }
    }
    coordinates
}

/// A sheet, cut open, and by corner where it lies.
fn lay(mut sheet: Sheet) -> (Sheet, Vec<DVec2>) {
    let costs = seams::costs(&sheet);
    seams::cut_to_disk(&mut sheet, &costs);
    let mut best: Option<(f64, Vec<DVec2>)> = None;
    for _ in 0..ROUNDS {
        let opened = sheet.opened();
        let triangles = triangles(&sheet, &opened);
        let Some(laid) = flatten(&sheet, &opened, &triangles) else { break };
        let stretches: Vec<f64> = triangles.iter().map(|t| stretch(t, &laid)).collect();
        let share = overstretched(&triangles, &stretches);
        if best.as_ref().is_none_or(|(least, _)| share < *least) {
            best = Some((share, by_corner(&opened, finished(&triangles, &sheet, laid))));
        }
        if share <= OVERSTRETCHED {
            break;
        }
        let ends = worst(&sheet, &opened, &triangles, &stretches);
        if ends.is_empty() {
            break;
        }
        seams::cut_from(&mut sheet, &costs, &ends);
    }
    let corners = match best {
        Some((_, corners)) => corners,
        None => each_flat(&sheet),
    };
    (sheet, corners)
}

fn by_corner(opened: &Opened, laid: Vec<DVec2>) -> Vec<DVec2> {
    opened.vertices.iter().map(|&v| if v == NONE { DVec2::ZERO } else { laid[v as usize] }).collect()
}

/// How much longer a triangle's longest direction is than it should be, or how much shorter its shortest: 1 or more.
fn stretch(triangle: &Triangle, laid: &[DVec2]) -> f64 {
    let jacobian = triangle.jacobian(laid);
    let [longest, shortest] = crate::distortion::singular_values(jacobian);
    if jacobian.determinant() > 0.0 { longest.max(1.0 / shortest) } else { f64::INFINITY }
}

/// The part of the area that is stretched more than [`MOST_STRETCH`].
fn overstretched(triangles: &[Triangle], stretches: &[f64]) -> f64 {
    let (mut over, mut all) = (0.0, 0.0);
    for (t, &stretch) in triangles.iter().zip(stretches) {
        all += t.area();
        over += if stretch > MOST_STRETCH { t.area() } else { 0.0 };
    }
    over / all
}

/// The vertices of a sheet around which it is stretched the most, apart from each other and from seams.
fn worst(sheet: &Sheet, opened: &Opened, triangles: &[Triangle], stretches: &[f64]) -> Vec<usize> {
    let mut around = vec![(0.0, 0.0); sheet.positions.len()];
    let mut area = 0.0;
    for (t, &stretch) in triangles.iter().zip(stretches) {
        area += t.area();
        // A folded triangle is bad, but only one.
        let excess = (stretch - 1.0).min(10.0) * t.area();
        for v in t.vertices {
            let (sum, weight) = &mut around[sheet.vertices[opened.corners[v] as usize] as usize];
            *sum += excess;
            *weight += t.area();
        }
    }
    // A long cut relieves more than a short one, and where one ends it is always stretched.
    let away = seams::distances(sheet);
    let mut order: Vec<(f64, usize)> = (around.iter().enumerate())
        .filter(|&(_, &(sum, weight))| weight > 0.0 && sum > 0.5 * (MOST_STRETCH - 1.0) * weight)
        .map(|(v, &(sum, weight))| (sum / weight * away[v], v))
        .filter(|&(score, _)| score > 0.0)
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let apart = APART * area.sqrt();
    let mut chosen: Vec<usize> = Vec::new();
    for (_, v) in order {
        let far = |&other: &usize| sheet.positions[v].distance(sheet.positions[other]) > apart;
        if chosen.len() == CUTS {
            break;
        }
        if chosen.iter().all(far) {
            chosen.push(v);
        }
    }
    chosen
}

/// Scales what is laid to its area on the surface, and turns it so that t grows upwards there.
fn finished(triangles: &[Triangle], sheet: &Sheet, laid: Vec<DVec2>) -> Vec<DVec2> {
    let (mut area, mut laid_area) = (0.0, 0.0);
    for t in triangles {
        area += t.area();
        laid_area += t.area() * t.jacobian(&laid).determinant().abs();
    }
    let scale = if laid_area > 0.0 { (area / laid_area).sqrt() } else { 1.0 };
    // Up the slope; for what is level, away from the eye of one who looks along −Z.
    let upwards = |axis: DVec3| -> DVec2 {
        let ways = sheet.triangles().into_iter().zip(triangles).map(|(corners, t)| {
            let [a, b, c] = corners.map(|c| sheet.positions[sheet.vertices[c] as usize]);
            let side = (b - a).normalize_or_zero();
            let across = side.cross(c - a).cross(side).normalize_or_zero();
            t.area() * (t.jacobian(&laid) * DVec2::new(axis.dot(side), axis.dot(across)))
        });
        ways.sum()
    };
    let up = upwards(DVec3::Y);
    let up = if up.length() > 0.05 * area { up } else { up + upwards(DVec3::NEG_Z) };
    // The rotation that takes `up` to (0, 1).
    let turn = up.try_normalize().map_or(DVec2::X, |up| DVec2::new(up.y, up.x));
    laid.into_iter().map(|p| scale * turn.rotate(p)).collect()
}

/// Every polygon laid flat by itself: what is left where numbers run out.
fn each_flat(sheet: &Sheet) -> Vec<DVec2> {
    let at = |h: usize| sheet.positions[sheet.vertices[h] as usize];
    (0..sheet.vertices.len())
        .map(|h| {
            if sheet.vertices[h] == NONE {
                return DVec2::ZERO;
            }
            let first = h & !3;
            let side = (at(first + 1) - at(first)).normalize_or_zero();
            let arm = at(h) - at(first);
            DVec2::new(arm.dot(side), sheet.normals[h / 4].cross(side).dot(arm))
        })
        .collect()
}
