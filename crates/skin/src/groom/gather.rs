//! Operations that look at a vertex together with others: locks, and smoothing.

use std::collections::HashMap;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::operation::{Clump, Smooth};
use super::surface::Ground;
use crate::Skin;

/// Draws the tips of each lock towards their middle.
pub(super) fn clump(
    skin: &Skin,
    ground: &Ground,
    vectors: &[Vec3],
    weights: &[f32],
    by: &Clump,
) -> Vec<Vec3> {
    let tip = |i: usize| skin.base[i] + vectors[i];
    // Asked a lock's width above the surface, so that the two sides of something thin do not share locks.
    let cells: Vec<IVec3> = (0..vectors.len())
        .into_par_iter()
        .map(|i| nearest_seed((skin.base[i] + by.size * ground.normal[i]) / by.size, by.seed))
        .collect();
    let mut locks: HashMap<[i32; 3], (Vec3, f32)> = HashMap::new();
    for (i, cell) in cells.iter().enumerate().filter(|&(i, _)| ground.normal[i] != Vec3::ZERO) {
        let (sum, count) = locks.entry(cell.to_array()).or_default();
        // Relative to the cell, so that far from the origin no digits are lost.
        *sum += tip(i) - by.size * cell.as_vec3();
        *count += 1.0;
    }
    (0..vectors.len())
        .into_par_iter()
        .map(|i| match locks.get(&cells[i].to_array()) {
            Some((sum, count)) if weights[i] > 0.0 => {
                let middle = by.size * cells[i].as_vec3() + *sum / *count;
                vectors[i] + weights[i] * by.amount * (middle - tip(i))
            }
            _ => vectors[i],
        })
        .collect()
}

/// The cell of the unit grid whose random point is nearest. \[Worley96\]
fn nearest_seed(at: Vec3, seed: u32) -> IVec3 {
    // Beyond, cells could not be told apart.
    let home = at.clamp(Vec3::splat(-1e9), Vec3::splat(1e9)).floor().as_ivec3();
    let mut nearest = (f32::INFINITY, home);
    for k in 0..27 {
        let cell = home + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        let distance = at.distance_squared(cell.as_vec3() + random(cell, seed));
        if distance < nearest.0 {
            nearest = (distance, cell);
        }
    }
    nearest.1
}

/// A point of the unit cube that depends on nothing but the cell and the seed: pcg3d. \[JarzynskiOlano20\]
fn random(cell: IVec3, seed: u32) -> Vec3 {
    let [mut x, mut y, mut z] =
        cell.to_array().map(|c| (c as u32 ^ seed).wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mut mix = || {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
    };
    mix();
    mix();
    [x, y, z] = [x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16)];
    Vec3::from([x, y, z].map(|bits| (bits >> 8) as f32 / (1 << 24) as f32))
}

/// Evens out directions and lengths, each towards the mean over the edges of the patches.
pub(super) fn smooth(skin: &Skin, vectors: &[Vec3], weights: &[f32], by: &Smooth) -> Vec<Vec3> {
    let mut vectors = vectors.to_vec();
    for _ in 0..by.steps {
        let parts: Vec<(Vec3, f32)> =
            vectors.par_iter().map(|v| (v.normalize_or_zero(), v.length())).collect();
        let mut sums = vec![(Vec3::ZERO, 0.0_f32, 0.0_f32); vectors.len()];
        for patch in &skin.patches {
            let (outline, n) = (patch.outline(), patch.corners().len());
            for k in 0..n {
                let (a, b) = (outline[k] as usize, outline[(k + 1) % n] as usize);
                for (at, other) in [(a, parts[b]), (b, parts[a])] {
                    let (direction, length, count) = &mut sums[at];
                    *direction += other.0;
                    *length += other.1;
                    *count += 1.0;
                }
            }
        }
        vectors = (0..vectors.len())
            .into_par_iter()
            .map(|i| {
                let ((direction, length), (sum, lengths, count)) = (parts[i], sums[i]);
                let part = weights[i] * by.amount;
                if part == 0.0 || count == 0.0 {
                    return vectors[i];
                }
                let mean = sum.normalize_or(direction);
                let new_length = length + part * (lengths / count - length);
                new_length * direction.lerp(mean, part).normalize_or(direction)
            })
            .collect();
    }
    vectors
}
