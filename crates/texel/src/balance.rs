//! Light in context: by how much more light each level sends to the eye than its voxels say.
//!
//! What a voxel's points know of their surroundings ends at their reach and is cut into cells; beyond, the coat's voxels
//! throw their shadows as if they had nothing to do with each other. Each is right to some per cent, and all of them off to
//! the same side. So, as opacity is (`calibrate.rs`), the light of a level is held against the geometry once more: the
//! whole texel, among its copies on a level surface, seen from one direction and lit from another. Of many such pairs
//! follows a factor that varies slowly with both.

use glam::Vec3;

/// How high eye and light stand, the mean of the heights of their unit vectors, where the factor is known.
const HEIGHTS: [f32; 4] = [0.15, 0.4, 0.65, 1.0];

/// How far they are apart, as the length between their unit vectors, where it is known: closest where they are nearly one, since
/// the gaps that both go through are narrow.
const APART: [f32; 8] = [0.0, 0.05, 0.12, 0.25, 0.5, 0.9, 1.4, 2.0];

/// How much of that is to the side, not above or below, where it is known: what is open to the eye between upright strands
/// is open to what is above it.
const ASIDE: [f32; 3] = [0.0, 0.5, 1.0];

/// Where the factor is known.
pub(crate) const NODES: usize = HEIGHTS.len() * APART.len() * ASIDE.len();

/// The factor lies between these.
const RANGE: [f32; 2] = [0.4, 2.5];

/// From this height of a unit vector down to the horizon the factor becomes 1.
const LOW: f32 = 0.1;

/// By how much more light the voxels of a level send, as a function of the directions (texel space) to the eye and to the
/// light: of how high both are, how far apart and how far aside.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// The factor less 1.
    more: Box<[f32; NODES]>,
}

/// What a texel shows from one direction of light from another, on average over its copies on a level surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Unit vectors to the eye and to the light, texel space.
    pub eye: Vec3,
    /// To the light.
    pub light: Vec3,
    /// The radiance of its voxels.
    pub voxels: f32,
    /// That of what it was made from.
    pub source: f32,
}

impl Balance {
    /// The factor for unit vectors to the eye and to the light, texel space. 1 where one is below the horizon.
    #[inline]
    pub fn factor(&self, eye: Vec3, light: Vec3) -> f32 {
        let height = eye.z.min(light.z);
        if height <= 0.0 {
            return 1.0;
        }
        let more: f32 = around(eye, light).iter().map(|(node, weight)| weight * self.more[*node]).sum();
        (1.0 + (height / LOW).min(1.0) * more).clamp(RANGE[0], RANGE[1])
    }

    /// The factor that leaves nothing of the light of `source` on the mean of pairs that are like each other, each counted between
    /// absolute and relative. It varies slowly and, where nothing speaks against it, is 1. `None` where nothing is lit.
    pub fn fit(shown: &[Shown]) -> Option<Self> {
        // The weight, as a part of that of all pairs, of a factor of 1 and of a factor that is linear.
        const PRIOR: f64 = 3e-4;
        const SMOOTH: f64 = 3e-4;
        let mean = shown.iter().map(|s| s.source).sum::<f32>() / shown.len().max(1) as f32;
        if !(mean.is_finite() && mean > 0.0) {
            return None;
        }
        // For each node nothing is left on the mean around it. Least squares would have the voxels in it twice, and take their
        // noise for light that they have too much of.
        let (mut matrix, mut sums) = (vec![vec![0.0_f64; NODES]; NODES], vec![0.0_f64; NODES]);
        for Shown { eye, light, voxels, source } in shown {
            let weight = 1.0 / (source + mean);
            let left = f64::from((source - voxels) * weight);
            let row = around(*eye, *light).map(|(node, x)| (node, f64::from(x)));
            let whole = f64::from(voxels * weight);
            for (i, a) in row {
                sums[i] += a * left;
                row.iter().for_each(|(j, b)| matrix[i][*j] += whole * a * b);
            }
        }
        let all = shown.len() as f64;
        for (node, row) in matrix.iter_mut().enumerate() {
            row[node] += PRIOR * all;
        }
        // Bent as little as may be, along each axis.
        for (stride, count) in
            [(1, ASIDE.len()), (ASIDE.len(), APART.len()), (ASIDE.len() * APART.len(), HEIGHTS.len())]
        {
            for middle in
                (0..NODES).filter(|node| !matches!(node / stride % count, i if i == 0 || i + 1 == count))
            {
                let bend = [(middle - stride, 1.0), (middle, -2.0), (middle + stride, 1.0)];
                for (i, a) in bend {
                    bend.iter().for_each(|(j, b)| matrix[i][*j] += SMOOTH * all * a * b);
                }
            }
        }
        let more = solved(matrix, sums);
        Self::from_nodes(std::array::from_fn(|i| more[i] as f32))
    }

    pub(crate) fn nodes(&self) -> &[f32; NODES] {
        &self.more
    }

    /// `None` unless all are finite.
    pub(crate) fn from_nodes(more: [f32; NODES]) -> Option<Self> {
        more.iter().all(|x| x.is_finite()).then(|| Self { more: Box::new(more) })
    }
}

/// The eight nodes around unit vectors to the eye and to the light, and their weights, whose sum is 1.
#[inline]
fn around(eye: Vec3, light: Vec3) -> [(usize, f32); 8] {
    let square = (eye - light).length_squared();
    // The squares of the way up and of the two ways around add up, that along being what is left.
    let flat = eye.truncate().length() * light.truncate().length();
    let aside = 2.0 * (flat - eye.truncate().dot(light.truncate())) / square.max(1e-6);
    let [height, apart, aside] =
        [between(&HEIGHTS, 0.5 * (eye.z + light.z)), between(&APART, square.sqrt()), between(&ASIDE, aside)];
    std::array::from_fn(|i| {
        let [(h, x), (a, y), (s, z)] = [height[i >> 2], apart[i >> 1 & 1], aside[i & 1]];
        ((h * APART.len() + a) * ASIDE.len() + s, x * y * z)
    })
}

/// The two values among `known` (ascending) around one, by their numbers, and their weights.
#[inline]
fn between(known: &[f32], value: f32) -> [(usize, f32); 2] {
    let first = known.iter().rposition(|known| *known <= value).unwrap_or(0).min(known.len() - 2);
    let part = ((value - known[first]) / (known[first + 1] - known[first])).clamp(0.0, 1.0);
    [(first, 1.0 - part), (first + 1, part)]
}

/// The solution of `matrix` x = `sums`; the matrix is symmetric and positive.
fn solved(mut matrix: Vec<Vec<f64>>, mut sums: Vec<f64>) -> Vec<f64> {
    for pivot in 0..sums.len() {
        let row = matrix[pivot].clone();
        for other in pivot + 1..sums.len() {
            let factor = matrix[other][pivot] / row[pivot];
            matrix[other].iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
            sums[other] -= factor * sums[pivot];
        }
    }
    for pivot in (0..sums.len()).rev() {
        let known: f64 = (pivot + 1..sums.len()).map(|i| matrix[pivot][i] * sums[i]).sum();
        sums[pivot] = (sums[pivot] - known) / matrix[pivot][pivot];
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A unit vector above the surface.
    fn upwards(random: &mut Random) -> Vec3 {
        let d = random.direction();
        Vec3 { z: d.z.abs(), ..d }
    }

    fn pairs(count: usize, source: impl Fn(Vec3, Vec3) -> f32) -> Vec<Shown> {
        let random = &mut Random::new(3, 0);
        // Every second light is near the eye.
        let one = |i| {
            let [eye, light] = [(); 2].map(|()| upwards(random));
            let light = if i % 2 == 0 { light } else { (eye + 0.3 * random.unit() * light).normalize() };
            Shown { eye, light, voxels: 0.5 * light.z, source: 0.5 * light.z * source(eye, light) }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn a_factor_that_varies_slowly_is_found() {
        let truth = |eye: Vec3, light: Vec3| 1.3 - 0.2 * (eye - light).length();
        let balance = Balance::fit(&pairs(300, truth)).expect("light");
        // Of other pairs, less than a quarter of the error is left: what speaks for 1, and the hats' corners.
        let [mut before, mut after] = [0.0; 2];
        for Shown { eye, light, voxels, source } in pairs(400, truth).split_off(300) {
            before += (voxels - source).powi(2);
            after += (balance.factor(eye, light) * voxels - source).powi(2);
        }
        assert!(after.sqrt() < 0.25 * before.sqrt(), "{before} {after}");
    }

    #[test]
    fn what_is_right_stays() {
        let balance = Balance::fit(&pairs(200, |_, _| 1.0)).expect("light");
        let light = Vec3::new(0.2, 0.0, 0.96).normalize();
        assert!((balance.factor(Vec3::Z, light) - 1.0).abs() < 1e-6);
        // Nothing is known of what is below the horizon.
        let other = Balance::fit(&pairs(200, |_, _| 1.5)).expect("light");
        assert!((1.35..1.51).contains(&other.factor(Vec3::Z, light)));
        assert!(other.factor(Vec3::Z, Vec3::new(0.8, 0.0, -0.6)) == 1.0);
        assert!(other.factor(Vec3::X, Vec3::Z) == 1.0);
    }

    #[test]
    fn noise_makes_nothing_darker() {
        // Light that is known to a third more or less: were the factor fitted to what is seen, it would be a tenth too low,
        // as 1 / (1 + 1/9) is.
        let random = &mut Random::new(5, 0);
        let noisy = pairs(4000, |_, _| 1.0).into_iter().map(|shown| {
            let noise = if random.unit() < 0.5 { 2.0 / 3.0 } else { 4.0 / 3.0 };
            Shown { voxels: noise * shown.voxels, ..shown }
        });
        let balance = Balance::fit(&noisy.collect::<Vec<_>>()).expect("light");
        let light = Vec3::new(0.2, 0.3, 0.7).normalize();
        let factor = balance.factor(Vec3::new(0.5, -0.2, 0.8).normalize(), light);
        assert!((factor - 1.0).abs() < 0.04, "{factor}");
    }

    #[test]
    fn without_light_there_is_nothing_to_balance() {
        assert!(Balance::fit(&[]).is_none());
        assert!(Balance::fit(&pairs(50, |_, _| 0.0)).is_none());
    }
}
