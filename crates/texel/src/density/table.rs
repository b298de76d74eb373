//! The heights of a density on a lattice, fine enough for its noise: what everything built from it is measured in.
//!
//! Tabulated is the height under the boundary, not the extinction: a height is smooth where extinction has the corners
//! of its ramp, so between lattice points it is interpolated.

use glam::{DVec3, UVec3, Vec3};
use rayon::prelude::*;

use super::Density;
use crate::grid::{floor, larger, smaller};

/// Heights at (R + 1)³ points of the cube.
pub(crate) struct Table<'a> {
    pub(crate) density: &'a Density,
    /// R: lattice cells along an edge, a power of two.
    pub(crate) resolution: u32,
    /// Samples of extinction that a texel edge takes.
    pub(crate) samples: f32,
    heights: Vec<f32>,
    periodic: bool,
}

/// What stands for heights where nothing is near, in texel edges: below the boundary of any shape.
const FAR: f32 = -2.0;

impl<'a> Table<'a> {
    /// Lattice cells along an edge of whole blocks that are left out where a bound says that nothing is in them.
    const BLOCK: u32 = 8;

    /// Four lattice cells to each of the finest noise, at least 32.
    pub(crate) fn new(density: &'a Density, periodic: bool) -> Self {
        let resolution = ((4.0 * density.finest()) as u32).clamp(32, 256).next_power_of_two();
        let n = resolution as usize + 1;
        let blocks = resolution.div_ceil(Self::BLOCK) + 1;
        let scale = 1.0 / f64::from(resolution);
        let block_at = |x: u32, y: u32, z: u32| (x + blocks * (y + blocks * z)) as usize;
        let empty: Vec<bool> = (0..blocks.pow(3))
            .into_par_iter()
            .map(|i| {
                let block = UVec3::new(i % blocks, i / blocks % blocks, i / blocks / blocks);
                // A lattice cell more on every side: those that touch the block are empty to their other ends.
                let middle = (block.as_dvec3() + 0.5) * f64::from(Self::BLOCK) * scale;
                let half = (0.5 * f64::from(Self::BLOCK) + 1.0) * scale;
                density.most(middle, half * 3_f64.sqrt()) == 0.0
            })
            .collect();
        let mut heights = vec![FAR; n * n * n];
        heights.par_chunks_mut(n * n).enumerate().for_each(|(z, plane)| {
            for (i, height) in plane.iter_mut().enumerate() {
                let p = UVec3::new((i % n) as u32, (i / n) as u32, z as u32);
                let block = p / Self::BLOCK;
                if !empty[block_at(block.x, block.y, block.z)] {
                    *height = density.height(p.as_dvec3() * scale) as f32;
                }
            }
        });
        // Two to each cell of the finest noise, and some across the boundary.
        let samples = (2.0 * density.finest()).max(3.0 / density.softness()) as f32;
        Self { density, resolution, samples, heights, periodic }
    }

    /// The height at a point, s and t wrapped or not as the content is; far outside it nothing is.
    pub(crate) fn height(&self, p: Vec3) -> f32 {
        let p = if self.periodic { Vec3::new(fract(p.x), fract(p.y), p.z) } else { p };
        if !(p.cmpge(Vec3::ZERO).all() && p.cmple(Vec3::ONE).all()) {
            return FAR;
        }
        self.interpolated(p)
    }

    /// The height at a point of the cube.
    fn interpolated(&self, p: Vec3) -> f32 {
        let n = self.resolution as usize + 1;
        let p = p * self.resolution as f32;
        let last = self.resolution as i32 - 1;
        let [x, y, z] = p.to_array().map(|c| floor(c).min(last));
        let f = p - Vec3::new(x as f32, y as f32, z as f32);
        let at = x as usize + n * (y as usize + n * z as usize);
        let Some(around) = self.heights.get(at..at + n * n + n + 2) else { return FAR };
        let along = |at: usize| around[at] + f.x * (around[at + 1] - around[at]);
        let (a, b, c, d) = (along(0), along(n), along(n * n), along(n * n + n));
        let (below, above) = (a + f.y * (b - a), c + f.y * (d - c));
        below + f.z * (above - below)
    }

    /// Extinction at a point, per texel edge.
    pub(crate) fn extinction(&self, p: Vec3) -> f32 {
        self.density.extinction_at(f64::from(self.height(p))) as f32
    }

    /// The greatest height in a box of the cube: trilinear functions are greatest in corners, of lattice cells or of the
    /// box.
    pub(crate) fn highest(&self, lo: Vec3, hi: Vec3) -> f32 {
        let cells = |p: Vec3| p * self.resolution as f32;
        let [first, last] = [cells(lo).floor().as_uvec3(), cells(hi).ceil().as_uvec3()];
        let knots = |axis: usize| {
            let inner = (first[axis] + 1..last[axis]).map(|i| i as f32 / self.resolution as f32);
            [lo[axis], hi[axis]].into_iter().chain(inner)
        };
        let mut highest = FAR;
        for z in knots(2) {
            for y in knots(1) {
                for x in knots(0) {
                    highest = larger(self.interpolated(Vec3::new(x, y, z)), highest);
                }
            }
        }
        highest
    }

    /// The part of a step `d` (texel edges) from `from` that lies in the cube; of periodic content only its bottom and
    /// top bound it. Empty as a reversed range.
    fn inside(&self, from: Vec3, d: Vec3) -> [f32; 2] {
        let first = if self.periodic { 2 } else { 0 };
        (first..3).fold([0.0, 1.0], |[enter, leave], axis| {
            // Slower than this it stays where it is: 1e-12 of an edge.
            if d[axis].abs() < 1e-12 {
                let inside = (0.0..=1.0).contains(&from[axis]);
                return if inside { [enter, leave] } else { [1.0, 0.0] };
            }
            let [a, b] = [-from[axis] / d[axis], (1.0 - from[axis]) / d[axis]];
            [larger(smaller(a, b), enter), smaller(larger(a, b), leave)]
        })
    }

    /// The optical depth of a step `d` (texel edges) from a point; no further than a depth of `limit`. Where it is
    /// reached is passed on as a part of the step.
    fn march(&self, from: Vec3, d: Vec3, limit: f32) -> (f32, Option<f32>) {
        let [enter, leave] = self.inside(from, d);
        let length = d.length() * (leave - enter);
        if length.is_nan() || length <= 0.0 {
            return (0.0, None);
        }
        let count = (length * self.samples).ceil().max(1.0);
        let part = (leave - enter) / count;
        let mut depth = 0.0;
        for i in 0..count as u32 {
            let at = enter + part * (i as f32 + 0.5);
            let step = self.extinction(from + at * d) * part * d.length();
            if depth + step >= limit {
                let rest = (limit - depth) / step;
                return (limit, Some(at + part * (rest - 0.5)));
            }
            depth += step;
        }
        (depth, None)
    }

    /// The part of the light that passes a step `d` (texel edges) from a point.
    pub(crate) fn transmittance(&self, from: Vec3, d: Vec3) -> f32 {
        // Less than 1/1000 would not be kept.
        let (depth, stopped) = self.march(from, d, 7.0);
        if stopped.is_some() { 0.0 } else { (-depth).exp() }
    }

    /// Where light that may go the optical depth `free` from `from` to `to` is stopped, as a part of the way; infinite
    /// if it arrives.
    pub(crate) fn first_hit(&self, from: Vec3, to: Vec3, free: f32) -> f32 {
        self.march(from, to - from, free).1.unwrap_or(f32::INFINITY)
    }

    /// Linear albedo at a point.
    pub(crate) fn color(&self, p: Vec3) -> Vec3 {
        let wrapped = Vec3::new(fract(p.x), fract(p.y), p.z);
        self.density.color(if self.periodic { wrapped } else { p }.as_dvec3())
    }

    /// Unit vector out of the density at a point.
    pub(crate) fn normal(&self, p: DVec3) -> Vec3 {
        self.density.normal(p).as_vec3()
    }
}

/// What is left of a number within ±2²² when it is rounded down.
fn fract(x: f32) -> f32 {
    x - floor(x) as f32
}
