//! Light in context: by how much more light each level sends to the eye than its voxels say.
//!
//! What a voxel's points know of their surroundings ends at their reach and is cut into cells; beyond, the coat's voxels
//! throw their shadows as if they had nothing to do with each other. Each is right to some per cent, and all of them off to
//! the same side. So, as opacity is (`calibrate.rs`), the light of a level is held against the geometry once more: the
//! whole texel, among its copies on a level surface, seen from one direction and lit from another. Of many such pairs
//! follows a factor that varies slowly with both.

use glam::Vec3;

/// What the factor is a sum of.
pub(crate) const TERMS: usize = APART.len() + 2 * NARROW;

/// Angles between eye and light, as lengths between their unit vectors, at which the factor is known: closest where they are
/// nearly one, since the gaps that both go through are narrow.
const APART: [f32; 8] = [0.0, 0.05, 0.12, 0.25, 0.5, 0.9, 1.4, 2.0];

/// Of these the first are read again: where eye and light are near each other, more is to be known.
const NARROW: usize = 5;

/// The factor lies between these.
const RANGE: [f32; 2] = [0.4, 2.5];

/// From this height of a unit vector down to the horizon the factor becomes 1.
const LOW: f32 = 0.1;

/// By how much more light the voxels of a level send, as a function of the directions (texel space) to the eye and to the
/// light.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    coefficients: [f32; TERMS],
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
        let more: f32 = terms(eye, light).iter().zip(&self.coefficients).map(|(term, c)| term * c).sum();
        (1.0 + (height / LOW).min(1.0) * more).clamp(RANGE[0], RANGE[1])
    }

    /// The factor that comes nearest to all of `shown`: the least squares of what is left, each between absolute and
    /// relative, with some weight for a factor of 1. Only where eye and light are `near` each other, if that is wished.
    /// `None` where nothing is lit.
    pub fn fit(shown: &[Shown], near: bool) -> Option<Self> {
        // The weight of all pairs for each coefficient to be nothing, as a part of theirs.
        const PRIOR: f64 = 5e-3;
        let is_used = |term: usize| !near || IS_NEAR[term];
        let mean = shown.iter().map(|s| s.source).sum::<f32>() / shown.len().max(1) as f32;
        if !(mean.is_finite() && mean > 0.0) {
            return None;
        }
        let mut matrix = [[0.0_f64; TERMS]; TERMS];
        let mut sums = [0.0_f64; TERMS];
        for Shown { eye, light, voxels, source } in shown {
            let weight = 1.0 / (source + mean);
            let mut row = terms(*eye, *light).map(|term| f64::from(term * voxels * weight));
            row.iter_mut().enumerate().filter(|(term, _)| !is_used(*term)).for_each(|(_, x)| *x = 0.0);
            let left = f64::from((source - voxels) * weight);
            for (i, a) in row.iter().enumerate() {
                sums[i] += a * left;
                for (sum, b) in matrix[i].iter_mut().zip(&row) {
                    *sum += a * b;
                }
            }
        }
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] += PRIOR * shown.len() as f64;
        }
        let coefficients = solved(matrix, sums).map(|c| c as f32);
        Self::from_coefficients(coefficients)
    }

    pub(crate) fn coefficients(&self) -> &[f32; TERMS] {
        &self.coefficients
    }

    /// `None` unless all are finite.
    pub(crate) fn from_coefficients(coefficients: [f32; TERMS]) -> Option<Self> {
        coefficients.iter().all(|c| c.is_finite()).then_some(Self { coefficients })
    }
}

/// Which terms vanish where eye and light are far apart.
const IS_NEAR: [bool; TERMS] = {
    let mut is_near = [false; TERMS];
    let mut hat = 0;
    while hat < NARROW {
        is_near[hat] = true;
        is_near[APART.len() + hat] = true;
        is_near[APART.len() + NARROW + hat] = true;
        hat += 1;
    }
    is_near
};

/// A hat around each of [`APART`]; the narrow ones again, by the mean height, and by how far the light is
/// to the side of the eye, not above or below: what is open to the eye between upright strands is open to what is above it.
#[inline]
fn terms(eye: Vec3, light: Vec3) -> [f32; TERMS] {
    const HATS: usize = APART.len();
    let mut terms = [0.0; TERMS];
    let apart = (eye - light).length();
    let mean = 0.5 * (eye.z + light.z);
    let flat = eye.truncate().length() * light.truncate().length();
    let aside = eye.truncate().perp_dot(light.truncate()).powi(2) / (apart * apart * flat).max(1e-4);
    let last = APART.iter().rposition(|known| *known <= apart).unwrap_or(0).min(HATS - 2);
    let part = ((apart - APART[last]) / (APART[last + 1] - APART[last])).min(1.0);
    for (hat, value) in [(last, 1.0 - part), (last + 1, part)] {
        terms[hat] = value;
        if hat < NARROW {
            terms[HATS + hat] = value * (mean - 0.5);
            terms[HATS + NARROW + hat] = value * (0.5 - aside.min(1.0));
        }
    }
    terms
}

/// The solution of `matrix` x = `sums`; the matrix is symmetric and positive.
fn solved(mut matrix: [[f64; TERMS]; TERMS], mut sums: [f64; TERMS]) -> [f64; TERMS] {
    for pivot in 0..TERMS {
        let row = matrix[pivot];
        for other in (0..TERMS).filter(|other| *other != pivot) {
            let factor = matrix[other][pivot] / row[pivot];
            matrix[other].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
            sums[other] -= factor * sums[pivot];
        }
    }
    std::array::from_fn(|i| sums[i] / matrix[i][i])
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
        let balance = Balance::fit(&pairs(300, truth), false).expect("light");
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
        let balance = Balance::fit(&pairs(200, |_, _| 1.0), false).expect("light");
        let light = Vec3::new(0.2, 0.0, 0.96).normalize();
        assert!((balance.factor(Vec3::Z, light) - 1.0).abs() < 1e-6);
        // Nothing is known of what is below the horizon, and nothing asked of what is far from the eye.
        let other = Balance::fit(&pairs(200, |_, _| 1.5), false).expect("light");
        assert!((1.35..1.51).contains(&other.factor(Vec3::Z, light)));
        assert!(other.factor(Vec3::Z, Vec3::new(0.8, 0.0, -0.6)) == 1.0);
        assert!(other.factor(Vec3::X, Vec3::Z) == 1.0);
        let near = Balance::fit(&pairs(200, |_, _| 1.5), true).expect("light");
        assert!(near.factor(Vec3::Z, Vec3::new(0.96, 0.0, 0.28)) == 1.0);
        assert!((1.35..1.51).contains(&near.factor(Vec3::Z, light)));
    }

    #[test]
    fn without_light_there_is_nothing_to_balance() {
        assert!(Balance::fit(&[], false).is_none());
        assert!(Balance::fit(&pairs(50, |_, _| 0.0), false).is_none());
    }
}
