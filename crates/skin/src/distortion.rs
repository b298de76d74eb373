//! How much the texel is stretched where it is laid out, and along which seams it does not continue.

use core::fmt;

use glam::{DMat2, DVec2, Vec2};
use rayon::prelude::*;

use crate::Skin;
use crate::disjoint::DisjointSets;

/// Texel coordinates that differ by less than this from a whole number continue, in copies of the texel: a quarter
/// of a voxel of a texel of 64³.
const CONTINUES: f32 = 1.0 / 256.0;

/// How the texel is laid out on a skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distortion {
    /// By chart, the largest first: patches over whose common edges the texel continues.
    pub charts: Vec<Chart>,
    /// Edges between two patches over which it does not.
    pub seam_edges: usize,
    /// How long those are together, in metres.
    pub seam_length: f64,
    /// Mean stretch by area, all over.
    pub mean: f64,
    /// The stretch that one hundredth of the area exceeds.
    pub hundredth: f64,
    /// The largest.
    pub worst: f64,
}

/// A part of a skin on which the texel is not interrupted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// The first of its patches.
    pub first: u32,
    /// How many there are.
    pub patches: usize,
    /// Of the surface, in square metres.
    pub area: f64,
    /// Mean stretch, by area.
    pub mean: f64,
    /// The largest.
    pub worst: f64,
}

impl Skin {
    /// By how much a copy of the texel is longer (or, inverted, shorter) on a patch than copies are all over the skin
    /// ([`Report::copy_width`](crate::Report::copy_width)), in the direction in which that is the most; at the middle of the
    /// patch, an index below [`Skin::len`]. 1 where nothing is stretched; infinite for a patch without area. \[SanderEtAl01\]
    pub fn stretch(&self, patch: usize) -> f32 {
        stretch_and_area(self, patch)[0] as f32
    }

    /// The charts and seams of the layout, and how much it stretches the texel.
    pub fn distortion(&self) -> Distortion {
        let each: Vec<[f64; 2]> =
            (0..self.len()).into_par_iter().map(|i| stretch_and_area(self, i)).collect();
        let mut edges: Vec<([u32; 2], u32, [Vec2; 2])> = Vec::with_capacity(4 * self.len());
        for (i, patch) in self.patches.iter().enumerate() {
            let (outline, n) = (patch.outline(), patch.corners().len());
            let around = [Vec2::ZERO, Vec2::X, if n == 3 { Vec2::Y } else { Vec2::ONE }, Vec2::Y];
            for k in 0..n {
                let ends = [k, (k + 1) % n].map(|k| (outline[k], patch.lattice.point(around[k])));
                let [(a, at_a), (b, at_b)] = if ends[0].0 < ends[1].0 { ends } else { [ends[1], ends[0]] };
                edges.push(([a, b], i as u32, [at_a, at_b]));
            }
        }
        edges.par_sort_by_key(|&(ends, patch, _)| (ends, patch));
        let mut sets = DisjointSets::new(self.len());
        let (mut seam_edges, mut seam_length) = (0, 0.0);
        for beside in edges.chunk_by(|a, b| a.0 == b.0) {
            for (one, other) in beside.iter().zip(beside.iter().skip(1)) {
                // The same whole number at both ends.
                let shift = (other.2[0] - one.2[0]).round();
                let apart = [0, 1].map(|k| (other.2[k] - one.2[k] - shift).abs().max_element());
                if apart[0].max(apart[1]) < CONTINUES {
                    sets.join(one.1, other.1);
                } else {
                    let [a, b] = one.0.map(|v| self.base[v as usize].as_dvec3());
                    (seam_edges, seam_length) = (seam_edges + 1, seam_length + a.distance(b));
                }
            }
        }
        let mut number = vec![usize::MAX; self.len()];
        let mut charts: Vec<Chart> = Vec::new();
        for (i, &[stretch, area]) in each.iter().enumerate() {
            let first = sets.root(i as u32) as usize;
            if first == i {
                number[i] = charts.len();
                charts.push(Chart { first: i as u32, patches: 0, area: 0.0, mean: 0.0, worst: 1.0 });
            }
            let chart = &mut charts[number[first]];
            chart.patches += 1;
            chart.area += area;
            chart.mean += if area > 0.0 { stretch * area } else { 0.0 };
            chart.worst = chart.worst.max(stretch);
        }
        let total: f64 = charts.iter().map(|chart| chart.area).sum();
        let mean = charts.iter().map(|chart| chart.mean).sum::<f64>() / total;
        let worst = charts.iter().map(|chart| chart.worst).fold(1.0, f64::max);
        charts.iter_mut().for_each(|chart| chart.mean /= chart.area);
        charts.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.first.cmp(&b.first)));
        Distortion {
            charts,
            seam_edges,
            seam_length,
            mean,
            hundredth: exceeded_by_a_hundredth(each, total),
            worst,
        }
    }
}

impl fmt::Display for Distortion {
    /// One line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { charts, seam_edges, seam_length, mean, hundredth, worst } = self;
        let charts = charts.len();
        write!(
            f,
            "{charts} charts, {seam_edges} seam edges ({seam_length:.3} m); stretch {mean:.3} in the mean, "
        )?;
        write!(f, "{hundredth:.3} or more on a hundredth of the area, {worst:.3} at worst")
    }
}

fn exceeded_by_a_hundredth(mut each: Vec<[f64; 2]>, total: f64) -> f64 {
    each.sort_by(|a, b| b[0].total_cmp(&a[0]));
    let mut above = 0.0;
    for [stretch, area] in each {
        above += area;
        if above > 0.01 * total {
            return stretch;
        }
    }
    1.0
}

/// The stretch of a patch, and its area in square metres.
fn stretch_and_area(skin: &Skin, patch: usize) -> [f64; 2] {
    let patch = &skin.patches[patch];
    let [a, b, c] = [0, 1, 2].map(|k| skin.base[patch.vertices[k] as usize].as_dvec3());
    let (mut u, mut v) = (b - a, c - a);
    if !patch.is_prism() {
        let d = skin.base[patch.vertices[3] as usize].as_dvec3();
        (u, v) = (0.5 * (b - a + d - c), 0.5 * (c - a + d - b));
    }
    let area = u.cross(v).length() * if patch.is_prism() { 0.5 } else { 1.0 };
    let along = u.length();
    let s = if along > 0.0 { u.dot(v) / along } else { 0.0 };
    let flat =
        DMat2::from_cols(DVec2::new(along, 0.0), DVec2::new(s, (v.length_squared() - s * s).max(0.0).sqrt()));
    let laid = DMat2::from_cols(patch.lattice.u.as_dvec2(), patch.lattice.v.as_dvec2());
    if flat.determinant() <= 0.0 {
        return [f64::INFINITY, 0.0];
    }
    let [most, least] = singular_values(laid * flat.inverse());
    let width = f64::from(skin.report.copy_width);
    [(most * width).max(1.0 / (least * width)).max(1.0), area]
}

/// The largest and the smallest factor by which a map changes lengths.
pub(crate) fn singular_values(m: DMat2) -> [f64; 2] {
    // The half sum and half difference of the two are lengths of the conformal and the anticonformal part.
    let conformal = 0.5 * DVec2::new(m.x_axis.x + m.y_axis.y, m.x_axis.y - m.y_axis.x).length();
    let rest = 0.5 * DVec2::new(m.x_axis.x - m.y_axis.y, m.x_axis.y + m.y_axis.x).length();
    [conformal + rest, (conformal - rest).abs()]
}
