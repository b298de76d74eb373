//! What noise in the reference does to a measure, and how many of its samples a picture is worth.

use pelage::tracer::{Film, Pixel};
use serde::Serialize;

/// A reference of two halves: rendered from independent seeds with as many samples each.
pub(crate) struct Halves {
    first: Film,
    second: Film,
    /// The mean of both.
    pub mean: Film,
}

impl Halves {
    /// Both halves; films of the same window.
    pub fn new(first: Film, second: Film) -> Self {
        let pixels = first.pixels.iter().zip(&second.pixels).map(|(a, b)| Pixel {
            color: 0.5 * (a.color + b.color),
            alpha: 0.5 * (a.alpha + b.alpha),
            depth: 0.5 * (a.depth + b.depth),
        });
        let mean = Film { size: first.size, window: first.window, pixels: pixels.collect() };
        Self { first, second, mean }
    }

    /// The expected square error of the mean, per pixel and channel.
    ///
    /// The halves h₁, h₂ are independent with one variance v, so E(h₁ − h₂)² = 2v, and their mean has v/2: a quarter
    /// of the square difference.
    pub fn variance(&self) -> f64 {
        0.25 * mean_square(&self.first, &self.second)
    }

    /// The square error of `film` against what the mean would be without noise; `film` being independent of it,
    /// E(a − m)² = E(a − r)² + v/2. May come out negative where both are small.
    pub fn square_error(&self, film: &Film) -> f64 {
        mean_square(film, &self.mean) - self.variance()
    }
}

/// Mean (a − b)² over pixels and channels.
pub(crate) fn mean_square(a: &Film, b: &Film) -> f64 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let sum: f64 = pairs.map(|(a, b)| (a.color.as_dvec3() - b.color.as_dvec3()).length_squared()).sum();
    sum / (3 * a.pixels.len().max(1)) as f64
}

/// The samples a pixel at which the reference renderer errs as much as a picture does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Worth {
    /// How many; not whole in general.
    pub samples: f64,
    /// The picture errs less than can be told from the reference's own noise: this many are the least.
    pub at_least: bool,
}

impl Worth {
    /// The worth of a picture of square error `error`, where the reference renderer with `n` samples has the square
    /// error `e` for each `(n, e)` of `ladder`, n increasing. `floor` is what can be told from noise.
    ///
    /// Between rungs log e is linear in log n; outside of them e falls as 1/n, as the variance of a mean does. `None`
    /// where the ladder has no rung above `floor`: nothing varies there, and no number of samples is worse than another.
    pub fn of(error: f64, ladder: &[(u32, f64)], floor: f64) -> Option<Self> {
        let rungs: Vec<(f64, f64)> =
            ladder.iter().filter(|&&(_, e)| e > floor && e > 0.0).map(|&(n, e)| (f64::from(n), e)).collect();
        let (&(first, largest), &(last, smallest)) = rungs.first().zip(rungs.last())?;
        let told = error.max(floor);
        let samples = if told >= largest {
            first * largest / told
        } else if told <= smallest {
            if told <= 0.0 {
                return Some(Self { samples: last, at_least: true });
            }
            last * smallest / told
        } else {
            // The first pair of rungs that holds it: with noise, rungs need not fall one by one.
            rungs.windows(2).find(|pair| pair[0].1 >= told && told >= pair[1].1).map_or(last, |pair| {
                let [(n0, e0), (n1, e1)] = [pair[0], pair[1]];
                let place = if e0 > e1 { (e0 / told).ln() / (e0 / e1).ln() } else { 0.0 };
                n0 * (n1 / n0).powf(place)
            })
        };
        Some(Self { samples, at_least: error < floor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pelage::tracer::Rect;
    use proptest::prelude::*;

    /// Uniform noise of variance 1/n around a ramp: a mean of n numbers is not needed to know its variance.
    fn noisy(n: u32, seed: u64) -> Film {
        let size = [100, 100];
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 40) as f32 / (1 << 24) as f32
        };
        // Uniform over a width w has the variance w²/12.
        let width = (12.0 / n as f32).sqrt();
        let pixels = (0..10_000).map(|i| {
            let noise = Vec3::from_array([0; 3].map(|_| width * (uniform() - 0.5)));
            Pixel { color: Vec3::splat(i as f32 * 1e-3) + noise, alpha: 1.0, depth: 1.0 }
        });
        Film { size, window: Rect::whole(size), pixels: pixels.collect() }
    }

    #[test]
    fn noise_of_known_variance_is_worth_its_samples() {
        let halves = Halves::new(noisy(128, 1), noisy(128, 2));
        // 30 000 numbers: the estimate of a variance is good to about 1 %.
        println!("variance × 256: {}", 256.0 * halves.variance());
        assert!((256.0 * halves.variance() - 1.0).abs() < 0.03);
        let ladder: Vec<(u32, f64)> =
            [1, 4, 16, 64].map(|n| (n, halves.square_error(&noisy(n, 10 + u64::from(n))))).to_vec();
        for n in [2, 8, 23, 100, 200] {
            let error = halves.square_error(&noisy(n, 99));
            let worth = Worth::of(error, &ladder, 0.02 * halves.variance()).expect("noise");
            println!("{n} samples: worth {:.1}", worth.samples);
            // The noise left in the reference adds what 256 samples have to what n have; 3 % of that sum.
            let slack = 0.03 * (1.0 + f64::from(n) / 256.0) + 0.02;
            assert!((worth.samples / f64::from(n) - 1.0).abs() < slack && !worth.at_least);
        }
    }

    #[test]
    fn by_hand() {
        // Errors that fall as 1/√n between the rungs, and as 1/n outside.
        let ladder = [(1, 1.0), (4, 0.5), (16, 0.25)];
        let samples = |e: f64| Worth::of(e, &ladder, 0.01).expect("a ladder");
        assert!((samples(2.0).samples - 0.5).abs() < 1e-12);
        assert!((samples(0.5_f64.sqrt()).samples - 2.0).abs() < 1e-12);
        assert!((samples(0.125).samples - 32.0).abs() < 1e-12);
        assert_eq!(samples(-1.0), Worth { samples: 400.0, at_least: true });
        assert_eq!(Worth::of(0.1, &[(1, 0.0), (4, 0.0)], 0.0), None);
        assert_eq!(Worth::of(0.0, &ladder, 0.0), Some(Worth { samples: 16.0, at_least: true }));
    }

    proptest! {
        #[test]
        fn less_error_is_worth_no_fewer_samples(a in 1e-6_f64..10.0, b in 1e-6_f64..10.0) {
            let ladder = [(1, 1.0), (4, 0.3), (16, 0.04), (64, 0.01)];
            let [less, more] = [a.min(b), a.max(b)].map(|e| Worth::of(e, &ladder, 1e-4).expect("a ladder").samples);
            prop_assert!(less >= more && more > 0.0, "{less} {more}");
        }
    }
}
