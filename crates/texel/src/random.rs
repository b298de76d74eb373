//! A small deterministic generator of random numbers: SplitMix64 [Steele14].

use pelage_geom::hash::{STEP, finish};

/// The state; the same seed gives the same numbers everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// The `stream`-th of the sequences that belong to a seed: strands, directions, … draw from their own, so
    /// that changing one leaves the others as they were.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut random = Self(seed ^ stream.wrapping_mul(0xd6e8_feb8_6659_fd93));
        random.bits();
        random
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        finish(self.0)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in [−1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform among unit vectors.
    #[cfg(test)]
    pub(crate) fn direction(&mut self) -> glam::Vec3 {
        loop {
            let d = glam::Vec3::new(self.signed(), self.signed(), self.signed());
            if (0.01..1.0).contains(&d.length_squared()) {
                return d.normalize();
            }
        }
    }
}
