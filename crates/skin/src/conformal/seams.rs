//! Where a sheet is cut: along short paths where they show least.
//!
//! A closed sheet, or one with holes or handles, is first cut until it is a disk; then from wherever it is stretched
//! the most to the nearest seam or border. A seam joins what would be two charts otherwise: because the texel repeats,
//! what is laid out may overlap itself, and nothing more than such slits is needed. [ShefferHart02]

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::sheet::{NONE, Sheet};

/// What a metre of seam costs where it is not seen at all, against 1 where it is seen best.
const HIDDEN: f64 = 0.15;

/// How much of that a fold that opens inwards at a right angle, where one material meets another, is worth.
const IN_A_FOLD: f64 = 0.7;

/// By half-edge what it costs to cut along it: its length, times how much it is seen, in metres. What faces up is seen
/// best, what faces down or lies in a fold least.
pub(super) fn costs(sheet: &Sheet) -> Vec<f64> {
    let cost = |h: usize| {
        if sheet.vertices[h] == NONE {
            return f64::INFINITY;
        }
        let [a, b] = sheet.ends(h).map(|v| sheet.positions[v]);
        let here = sheet.normals[h / 4];
        let beyond = if sheet.twin[h] == NONE { here } else { sheet.normals[sheet.twin[h] as usize / 4] };
        let up = 0.5 * (here + beyond).normalize_or_zero().y + 0.5;
        // The normals of a fold that opens inwards lean towards each other across the edge.
        let inwards = here.cross(beyond).dot((b - a).normalize_or_zero()).min(0.0).abs();
        (b - a).length() * (HIDDEN + (1.0 - HIDDEN) * up * (1.0 - IN_A_FOLD * inwards))
    };
    (0..sheet.vertices.len()).map(cost).collect()
}

/// Cuts a sheet until it is a disk.
pub(super) fn cut_to_disk(sheet: &mut Sheet, costs: &[f64]) {
    if sheet.opened().characteristic == 1 {
        return;
    }
    grow(sheet);
    prune(sheet);
    if sheet.opened().characteristic == 2 {
        // Nothing is left of the cuts of a sphere: from end to end, then.
        let lengths = lengths(sheet);
        let farthest = |from: usize| {
            let reached = paths(sheet, &lengths, &[from]);
            let far = |v: &usize| Reverse(reached[*v].0.to_bits());
            (0..reached.len()).filter(|&v| reached[v].0.is_finite()).min_by_key(far).unwrap_or(from)
        };
        let one = farthest(0);
        let other = farthest(one);
        let reached = paths(sheet, costs, &[one]);
        cut_back(sheet, &reached, other);
    }
}

/// Cuts from each of some vertices, in their order, to the nearest border or seam.
pub(super) fn cut_from(sheet: &mut Sheet, costs: &[f64], from: &[usize]) {
    for &vertex in from {
        let reached = paths(sheet, costs, &open_vertices(sheet));
        cut_back(sheet, &reached, vertex);
    }
}

/// By vertex how far it is, along edges, from the nearest border or seam, in metres.
pub(super) fn distances(sheet: &Sheet) -> Vec<f64> {
    paths(sheet, &lengths(sheet), &open_vertices(sheet)).into_iter().map(|(distance, _)| distance).collect()
}

fn open_vertices(sheet: &Sheet) -> Vec<usize> {
    let mut open = vec![false; sheet.positions.len()];
    for h in sheet.half_edges().filter(|&h| sheet.is_open(h)) {
        sheet.ends(h).iter().for_each(|&v| open[v] = true);
    }
    (0..open.len()).filter(|&v| open[v]).collect()
}

/// By half-edge, in metres.
fn lengths(sheet: &Sheet) -> Vec<f64> {
    let length = |h: usize| {
        if sheet.vertices[h] == NONE {
            return f64::INFINITY;
        }
        let [a, b] = sheet.ends(h).map(|v| sheet.positions[v]);
        a.distance(b)
    };
    (0..sheet.vertices.len()).map(length).collect()
}

/// Cuts all edges but those over which the sheet is reached from its topmost polygon: a tree of polygons is a disk.
fn grow(sheet: &mut Sheet) {
    let centre = |p: usize| {
        sheet.positions[sheet.vertices[4 * p] as usize]
            .midpoint(sheet.positions[sheet.vertices[4 * p + 2] as usize])
    };
    let count = sheet.polygons.len();
    let top = (0..count).max_by(|&a, &b| centre(a).y.total_cmp(&centre(b).y)).unwrap_or(0);
    let mut crossed = vec![false; sheet.vertices.len()];
    let mut distance = vec![f64::INFINITY; count];
    let mut done = vec![false; count];
    distance[top] = 0.0;
    // Distances are not negative, so their bits are in their order.
    let mut queue = BinaryHeap::from([Reverse((0_u64, top, NONE))]);
    while let Some(Reverse((_, p, from))) = queue.pop() {
        if std::mem::replace(&mut done[p], true) {
            continue;
        }
        if from != NONE {
            crossed[from as usize] = true;
            crossed[sheet.twin[from as usize] as usize] = true;
        }
        for h in (4 * p..4 * p + 4).filter(|&h| sheet.twin[h] != NONE) {
            let q = sheet.twin[h] as usize / 4;
            let there = distance[p] + centre(p).distance(centre(q));
            if there < distance[q] {
                distance[q] = there;
                queue.push(Reverse((there.to_bits(), q, h as u32)));
            }
        }
    }
    for (h, crossed) in crossed.into_iter().enumerate() {
        sheet.cut[h] = !crossed && sheet.twin[h] != NONE;
    }
}

/// Closes cuts that end in the middle of the sheet, from their ends.
fn prune(sheet: &mut Sheet) {
    let mut cuts = vec![Vec::new(); sheet.positions.len()];
    let mut at_border = vec![false; sheet.positions.len()];
    for h in sheet.half_edges() {
        for v in sheet.ends(h) {
            at_border[v] |= sheet.twin[h] == NONE;
            if sheet.cut[h] && h < sheet.twin[h] as usize {
                cuts[v].push(h);
            }
        }
    }
    let is_end = |cuts: &[Vec<usize>], v: usize| cuts[v].len() == 1 && !at_border[v];
    let mut ends: Vec<usize> = (0..cuts.len()).filter(|&v| is_end(&cuts, v)).collect();
    while let Some(v) = ends.pop() {
        let &[h] = &cuts[v][..] else { continue };
        (sheet.cut[h], sheet.cut[sheet.twin[h] as usize]) = (false, false);
        for v in sheet.ends(h) {
            cuts[v].retain(|&other| other != h);
            if is_end(&cuts, v) {
                ends.push(v);
            }
        }
    }
}

/// By vertex how far it is from the nearest start, and the half-edge that leads there or away from there.
fn paths(sheet: &Sheet, costs: &[f64], starts: &[usize]) -> Vec<(f64, u32)> {
    let mut around = vec![Vec::new(); sheet.positions.len()];
    for h in sheet.half_edges() {
        // Every edge once, from the side that a border has too.
        if sheet.twin[h] == NONE || h < sheet.twin[h] as usize {
            sheet.ends(h).iter().for_each(|&v| around[v].push(h));
        }
    }
    let mut reached = vec![(f64::INFINITY, NONE); sheet.positions.len()];
    let mut queue = BinaryHeap::new();
    for &v in starts {
        reached[v].0 = 0.0;
        queue.push(Reverse((0_u64, v)));
    }
    while let Some(Reverse((bits, v))) = queue.pop() {
        if bits != reached[v].0.to_bits() {
            continue;
        }
        for &h in &around[v] {
            let [a, b] = sheet.ends(h);
            let other = if a == v { b } else { a };
            let there = reached[v].0 + costs[h];
            if there < reached[other].0 {
                reached[other] = (there, h as u32);
                queue.push(Reverse((there.to_bits(), other)));
            }
        }
    }
    reached
}

/// Cuts along the path that reached a vertex.
fn cut_back(sheet: &mut Sheet, reached: &[(f64, u32)], mut vertex: usize) {
    while reached[vertex].1 != NONE {
        let h = reached[vertex].1 as usize;
        sheet.cut_along(h);
        let [a, b] = sheet.ends(h);
        vertex = if a == vertex { b } else { a };
    }
}
