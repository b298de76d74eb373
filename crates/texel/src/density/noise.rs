//! Gradient noise that repeats in s and t. [Perlin85, Perlin02]
//!
//! A smooth random function without larger or smaller structure than about its lattice. In each corner of the lattice
//! it is 0 and has one of twelve gradients; between, the eight ramps are blended by quintics. Additions,
//! multiplications and integers only: the same bits everywhere.

use glam::{DVec3, I64Vec3};
use pelage_geom::hash::{STEP, finish};

/// Noise over a lattice of cells of edge 1, which repeats after `period` of them in x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    seed: u64,
    period: i64,
}

impl Noise {
    /// It stays between this and its negative. The largest that eight gradients can sum up to is 1.0364.
    pub(crate) const MOST: f64 = 1.0365;

    /// It never changes by more than this over a distance of 1: the fade's slope, 15/8, times the 2 from −1 to 1 that it
    /// may blend, in the middle of a cell.
    pub(crate) const STEEPEST: f64 = 3.75;

    /// Whatever the `stream`, noise of the same seed has nothing to do with that of another.
    pub(crate) fn new(seed: u64, stream: u64, period: u32) -> Self {
        Self { seed: finish(seed ^ finish(stream)), period: i64::from(period.max(1)) }
    }

    /// The noise at a point.
    pub(crate) fn at(&self, p: DVec3) -> f64 {
        let low = p.floor();
        let d = p - low;
        let [u, v, w] = d.to_array().map(fade);
        let cell = I64Vec3::new(low.x as i64, low.y as i64, low.z as i64);
        let ramp = |x: i64, y: i64, z: i64| {
            let corner = I64Vec3::new(
                (cell.x + x).rem_euclid(self.period),
                (cell.y + y).rem_euclid(self.period),
                cell.z + z,
            );
            let gradient = GRADIENTS[self.hash(corner) as usize & 15];
            gradient.dot(d - DVec3::new(x as f64, y as f64, z as f64))
        };
        let row = |y, z| lerp(ramp(0, y, z), ramp(1, y, z), u);
        let plane = |z| lerp(row(0, z), row(1, z), v);
        lerp(plane(0), plane(1), w)
    }

    fn hash(&self, corner: I64Vec3) -> u64 {
        let [x, y, z] = corner.to_array().map(|c| c as u64);
        finish(
            self.seed
                ^ x.wrapping_mul(STEP)
                ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f).rotate_left(21)
                ^ z.wrapping_mul(0x1656_67b1_9e37_79f9).rotate_left(42),
        )
    }
}

/// The middles of a cube's edges, and four of them again to make sixteen. [Perlin02]
const GRADIENTS: [DVec3; 16] = {
    const fn g(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }
    [
        g(1.0, 1.0, 0.0),
        g(-1.0, 1.0, 0.0),
        g(1.0, -1.0, 0.0),
        g(-1.0, -1.0, 0.0),
        g(1.0, 0.0, 1.0),
        g(-1.0, 0.0, 1.0),
        g(1.0, 0.0, -1.0),
        g(-1.0, 0.0, -1.0),
        g(0.0, 1.0, 1.0),
        g(0.0, -1.0, 1.0),
        g(0.0, 1.0, -1.0),
        g(0.0, -1.0, -1.0),
        g(1.0, 1.0, 0.0),
        g(0.0, -1.0, 1.0),
        g(-1.0, 1.0, 0.0),
        g(0.0, -1.0, -1.0),
    ]
};

/// 6t⁵ − 15t⁴ + 10t³: from 0 to 1, its first two derivatives 0 at both ends. [Perlin02]
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn somewhere(random: &mut Random) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| f64::from(random.unit())))
    }

    #[test]
    fn it_is_zero_in_the_corners_and_repeats() {
        let noise = Noise::new(3, 0, 5);
        let random = &mut Random::new(1, 0);
        for _ in 0..1000 {
            let p = 20.0 * somewhere(random) - 10.0;
            assert_eq!(noise.at(p.round()), 0.0);
            for shift in [DVec3::X, DVec3::Y, DVec3::new(-2.0, 1.0, 0.0)] {
                // A point of the order of 10, moved, is rounded by 1e-15 of it.
                assert!((noise.at(p + 5.0 * shift) - noise.at(p)).abs() < 1e-13);
            }
        }
        assert_ne!(noise.at(DVec3::splat(0.4)), Noise::new(4, 0, 5).at(DVec3::splat(0.4)));
        assert_ne!(noise.at(DVec3::splat(0.4)), Noise::new(3, 1, 5).at(DVec3::splat(0.4)));
    }

    #[test]
    fn the_bounds_hold_for_any_gradients() {
        // At a point both the noise and its slope in a direction e are sums over the corners of something linear in
        // the corner's gradient: the largest over all gradients is the sum of each corner's largest. So the search is
        // one over points (and e) alone. With f = fade and f' its derivative, the slope of w (g·d) is
        // w (g·e) + (∇w·e)(g·d).
        let largest = |p: DVec3, e: DVec3| {
            let slope = |t: f64| 30.0 * t * t * (t - 1.0) * (t - 1.0);
            let [mut value, mut steep] = [0.0, 0.0];
            for corner in 0..8 {
                let c = DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1)));
                let weight = |axis: usize| {
                    if c[axis] > 0.5 { fade(p[axis]) } else { 1.0 - fade(p[axis]) }
                };
                let [x, y, z] = [0, 1, 2].map(weight);
                let s = DVec3::from_array([0, 1, 2].map(|a| (2.0 * c[a] - 1.0) * slope(p[a])));
                let change = (DVec3::new(y * z, x * z, x * y) * s).dot(e);
                let d = p - c;
                let most = |v: DVec3| GRADIENTS.iter().map(|g| g.dot(v)).fold(f64::MIN, f64::max);
                value += x * y * z * most(d);
                steep += most(x * y * z * e + change * d);
            }
            [value, steep]
        };
        let random = &mut Random::new(2, 0);
        let mut found = [0.0_f64; 2];
        for (which, found) in found.iter_mut().enumerate() {
            let mut best = (DVec3::splat(0.5), DVec3::X);
            for i in 0..60_000 {
                // First anywhere, then ever nearer to the best so far.
                let near = if i < 20_000 { 1.0 } else { 0.3 * 0.9998_f64.powi(i - 20_000) };
                let p = best.0.lerp(somewhere(random), near);
                let e = best.1.lerp(2.0 * somewhere(random) - 1.0, near).normalize_or(DVec3::X);
                let value = largest(p, e)[which];
                if value > *found {
                    (*found, best) = (value, (p, e));
                }
            }
        }
        println!("largest {:.4}, steepest {:.4}", found[0], found[1]);
        assert!(found[0] <= Noise::MOST && found[0] > 0.99 * Noise::MOST);
        assert!(found[1] <= Noise::STEEPEST + 1e-9 && found[1] > 0.95 * Noise::STEEPEST);
    }

    #[test]
    fn its_mean_is_zero_and_its_variance_is_known() {
        // The corners' gradients are independent, of mean 0, and the sixteen have the second moments (⅝, ¾, ⅝). So the
        // mean over everything is 0, and the variance Σ over the corners of ∫ w² (⅝ x² + ¾ y² + ⅝ z²). With A = ∫ f² and
        // B = ∫ (1 − f)² t², the far part of a ramp, ∫ w² x² is A²B, and the whole 8 (⅝ + ¾ + ⅝) A²B.
        let noise = Noise::new(7, 0, 1 << 20);
        let random = &mut Random::new(3, 0);
        let n = 200_000;
        let [mut mean, mut square] = [0.0, 0.0];
        for _ in 0..n {
            let value = noise.at(1e4 * somewhere(random));
            mean += value / f64::from(n);
            square += value * value / f64::from(n);
        }
        let steps = 10_000;
        let integral = |f: &dyn Fn(f64) -> f64| {
            (0..steps).map(|i| f((f64::from(i) + 0.5) / f64::from(steps))).sum::<f64>() / f64::from(steps)
        };
        let a = integral(&|t| fade(t).powi(2));
        let b = integral(&|t| ((1.0 - fade(t)) * t).powi(2));
        let expected = 16.0 * a * a * b;
        println!("mean {mean:.5}, variance {square:.5}, expected {expected:.5}");
        // Four standard errors.
        assert!(mean.abs() < 4.0 * (expected / f64::from(n)).sqrt());
        assert!((square / expected - 1.0).abs() < 0.015);
    }
}
