//! Opacity in context: what a level hides, and how deep it is seen into.
//!
//! Coverage measured voxel by voxel multiplies up to the coverage of the whole only where voxels have nothing to do
//! with each other. They have: a strand goes from voxel to voxel, and a ray that got past it in one gets past it in the
//! next. So each level is held against the geometry once more, along sightlines from above through the whole texel: at
//! each height, the level must stop as many of them as the geometry does. Of sightlines that reach a height with
//! transmittance T, and meet the depth τ in it, it stops
//!
//! ```text
//! Σ T (1 − e^−sτ)
//! ```
//!
//! which gives the factor s for the depths there, height after height, for each class of slopes. Then the whole hides
//! what the geometry hides, and what is seen of it lies as deep.

use core::f32::consts::PI;

use glam::Vec3;
use pelage_geom::Symmetric3;
use rayon::prelude::*;

use crate::coverage::{SIXTEEN, Sight, fit};
use crate::packed::Packed;
use crate::sightline::Sightline;
use crate::{Level, Voxel};

/// Classes of heights at most.
const HEIGHTS: usize = 8;

/// Slopes (angles to the surface) and heights are sorted into classes.
#[derive(Clone, Copy)]
struct Classes {
    slopes: usize,
    heights: usize,
    resolution: u32,
}

impl Classes {
    fn of(level: &Level) -> Self {
        Self {
            slopes: 6,
            heights: level.resolution().min(HEIGHTS as u32) as usize,
            resolution: level.resolution(),
        }
    }

    fn height(self, z: i32) -> usize {
        (z.max(0) as usize * self.heights / self.resolution as usize).min(self.heights - 1)
    }

    /// The slope of a direction of this z, in classes.
    fn angle(self, z: f32) -> f32 {
        z.abs().min(1.0).asin() / (0.5 * PI) * self.slopes as f32
    }

    fn slope(self, z: f32) -> usize {
        (self.angle(z) as usize).min(self.slopes - 1)
    }

    /// The factor for a slope, between those of the two nearest classes.
    fn factor(self, factors: &[f32], height: usize, z: f32) -> f32 {
        let at = (self.angle(z) - 0.5).clamp(0.0, (self.slopes - 1) as f32);
        let low = (at as usize).min(self.slopes - 2);
        let row = &factors[height * self.slopes..];
        row[low] + (at - low as f32) * (row[low + 1] - row[low])
    }
}

/// Multiplies the depths of a level's voxels so that sightlines end where they do in the geometry.
pub(crate) fn calibrate(level: &mut Level, sightlines: &[Sightline]) {
    // Each refits Σ, which then says not quite what it was asked to: again, for what is left.
    const ROUNDS: usize = 2;
    let classes = Classes::of(level);
    let cells: Vec<[u32; 3]> = level.cells().collect();
    for _ in 0..ROUNDS {
        let paths = paths(level, sightlines, classes);
        let by_slope = |slope| factors(paths.iter().filter(|path| path.slope == slope), classes.heights);
        let by_slope: Vec<Vec<f32>> = (0..classes.slopes).into_par_iter().map(by_slope).collect();
        let factors: Vec<f32> =
            (0..classes.heights).flat_map(|height| by_slope.iter().map(move |s| s[height])).collect();
        let repeats = level.is_periodic();
        level.voxels_mut().par_iter_mut().zip(&cells).for_each(|(packed, cell)| {
            let mut voxel = packed.unpack();
            // Where the texel ends, sightlines pass beside a sheet and through its slab: that makes no holes in it.
            if !repeats && is_solid(&voxel) {
                return;
            }
            let height = classes.height(cell[2] as i32);
            voxel.sigma = scaled(voxel.sigma, |d| classes.factor(&factors, height, d.z));
            *packed = Packed::new(&voxel);
        });
    }
}

/// Whether next to nothing gets through the slab of a voxel, however it crosses it.
pub(crate) fn is_solid(voxel: &Voxel) -> bool {
    /// The depth of a slab that lets a thousandth through.
    const SOLID: f32 = 7.0;
    voxel.depth_per_step(voxel.slab_normal) * (voxel.slab[1] - voxel.slab[0]) > SOLID
}

/// What a sightline meets in a level.
struct Path {
    slope: usize,
    /// Depth in each class of heights.
    depths: [f32; HEIGHTS],
    /// The class of heights in which the geometry stops it.
    stopped: Option<usize>,
}

fn paths(level: &Level, sightlines: &[Sightline], classes: Classes) -> Vec<Path> {
    let path = |line: &Sightline| {
        let d = line.direction();
        let mut depths = [0.0; HEIGHTS];
        let mut stopped = None;
        line.meet(level, |_, z, depth, is_stopped| {
            let height = classes.height(z);
            depths[height] += depth;
            if stopped.is_none() && is_stopped {
                stopped = Some(height);
            }
        });
        Path { slope: classes.slope(d.z / d.length()), depths, stopped }
    };
    sightlines.par_iter().map(path).collect()
}

/// The factor of each height, from the top down, with the weight of a few sightlines for a factor of 1.
fn factors<'a>(paths: impl Iterator<Item = &'a Path>, heights: usize) -> Vec<f32> {
    const PRIOR: f32 = 4.0;
    const RANGE: [f32; 2] = [0.1, 10.0];
    let mut reached: Vec<(f32, &Path)> = paths.map(|path| (1.0, path)).collect();
    let mut factors = vec![1.0; heights];
    for height in (0..heights).rev() {
        let stopped = reached.iter().filter(|(_, path)| path.stopped == Some(height)).count() as f32;
        let excess = |s: f32| {
            let hidden = |(t, path): &(f32, &Path)| t * -(-s * path.depths[height]).exp_m1();
            reached.iter().map(hidden).sum::<f32>() - stopped + PRIOR * (s - 1.0) / (s + 1.0)
        };
        let [mut low, mut high] = RANGE.map(f32::ln);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if excess(middle.exp()) < 0.0 { low = middle } else { high = middle }
        }
        factors[height] = (0.5 * (low + high)).exp();
        for (t, path) in &mut reached {
            *t *= (-factors[height] * path.depths[height]).exp();
        }
    }
    factors
}

/// Σ with the depth along each direction multiplied.
fn scaled(sigma: Symmetric3, factor: impl Fn(Vec3) -> f32) -> Symmetric3 {
    let sights = SIXTEEN.map(|direction| {
        let sigma = factor(direction) * sigma.quadratic(direction).max(0.0).sqrt();
        Sight { direction, sigma, ..Sight::default() }
    });
    fit(&sights)
}
