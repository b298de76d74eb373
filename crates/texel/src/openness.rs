//! Openness: how much of the light from around reaches a voxel, for ambient light.
//!
//! Walked through the frozen levels, from each voxel's middle in a few directions spread over the upper
//! hemisphere by their cosine. It varies slowly, so fine voxels have that of an ancestor.

use core::f32::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::{Level, Line, Texel};

/// How many directions stand for the hemisphere.
const DIRECTIONS: usize = 6;

/// Sets the openness of the voxels of the levels up to `finest`, from what is further than `reach` of a level: what is
/// nearer is known there.
pub(crate) fn fill(texel: &mut Texel, finest: u32, reach: impl Fn(u32) -> f32 + Sync) {
    let directions = directions();
    for (l, level) in (0..=finest).zip(texel.levels_mut()) {
        let near = reach(l);
        let cells: Vec<[u32; 3]> = level.cells().collect();
        let scale = 1.0 / level.resolution() as f32;
        let open = cells.par_iter().map(|cell| {
            let middle = (Vec3::from_array(cell.map(|c| c as f32)) + 0.5) * scale;
            let open = directions.iter().map(|&d| unblocked(level, middle, d, near));
            (255.0 * open.sum::<f32>() / DIRECTIONS as f32).round() as u8
        });
        let open = open.collect();
        level.set_openness(open);
    }
}

/// Directions of equal weight under the cosine: stratified in sin²θ, turned by the golden angle.
fn directions() -> [Vec3; DIRECTIONS] {
    core::array::from_fn(|i| {
        let sin2 = (i as f32 + 0.5) / DIRECTIONS as f32;
        let around = Vec2::from_angle(i as f32 * PI * (3.0 - 5.0_f32.sqrt()));
        (around * sin2.sqrt()).extend((1.0 - sin2).sqrt())
    })
}

/// Transmittance from a point (texel coordinates) out of the texel's top, without what is nearer than `near`: that is in
/// the masks of the surfels.
fn unblocked(level: &Level, from: Vec3, direction: Vec3, near: f32) -> f32 {
    // Deeper than this less than 1 % passes.
    const OPAQUE: f32 = 4.6;
    let scale = level.resolution() as f32;
    let from = from * scale;
    let d = direction * ((scale - from.z) / direction.z);
    let near = near * scale / d.length();
    let line = Line::new(from, d);
    let mut depth = 0.0;
    for step in level.walk_along(&line, [near, 1.0]) {
        depth += level.cross(&line, &step).map_or(0.0, |met| met.depth);
        if depth > OPAQUE {
            return 0.0;
        }
    }
    (-depth).exp()
}
