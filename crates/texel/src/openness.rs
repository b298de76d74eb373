//! Openness: how much of the light from around reaches a voxel, for ambient light.
//!
//! Walked through the frozen levels, from each voxel's middle in a few directions spread over the upper
//! hemisphere by their cosine. It varies slowly, so fine voxels look through a coarser level.

use core::f32::consts::PI;

use glam::{IVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::{Level, Surfel, Texel};

/// How many directions stand for the hemisphere.
const DIRECTIONS: usize = 6;

/// The level that finer voxels look through.
const COARSE: usize = 5;

/// The level whose openness finer voxels take over.
const FINEST: usize = 5;

/// Sets the openness of every voxel of every level.
pub(crate) fn fill(texel: &mut Texel) {
    let directions = directions();
    let all = (0..texel.levels().len().min(FINEST + 1)).map(|l| {
        let through = &texel.levels()[l.min(COARSE)];
        let level = &texel.levels()[l];
        let cells: Vec<[u32; 3]> = level.cells().collect();
        let scale = 1.0 / level.resolution() as f32;
        let open = cells.par_iter().map(|cell| {
            let middle = (Vec3::from_array(cell.map(|c| c as f32)) + 0.5) * scale;
            directions.iter().map(|&d| unblocked(through, middle, d, Surfel::reach(scale))).sum::<f32>()
                / DIRECTIONS as f32
        });
        open.collect::<Vec<f32>>()
    });
    let mut all: Vec<Vec<f32>> = all.collect();
    for l in FINEST + 1..texel.levels().len() {
        let parents = &texel.levels()[FINEST];
        let parent = |cell: [u32; 3]| IVec3::from_array(cell.map(|c| (c >> (l - FINEST)) as i32));
        let open = texel.levels()[l].cells().map(|cell| parents.find(parent(cell)));
        // Every voxel has an ancestor; 1 would stand for a clear sky.
        let open = open.map(|ancestor| ancestor.map_or(1.0, |voxel| all[FINEST][voxel as usize]));
        all.push(open.collect());
    }
    for (level, open) in texel.levels_mut().iter_mut().zip(all) {
        for (voxel, open) in level.voxels_mut().iter_mut().zip(open) {
            voxel.set_openness(open);
        }
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
    let mut depth = 0.0;
    for step in level.walk(from, from + d) {
        if step.leave < near {
            continue;
        }
        let voxel = level.voxel(step.voxel);
        if let Some([enter, leave]) =
            voxel.clip(from - step.cell.as_vec3(), d, [step.enter.max(near), step.leave])
        {
            depth += voxel.depth_per_step(d) * (leave - enter);
            if depth > OPAQUE {
                return 0.0;
            }
        }
    }
    (-depth).exp()
}
