//! What is drawn by place: numbers that depend on it and on nothing else.

use pelage_geom::hash::{STEP, finish};

/// Numbers that depend on the words that they are drawn from, and on nothing else. [Steele14]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn(u64);

impl Drawn {
    /// From some words, in their order.
    #[inline]
    pub fn from<const N: usize>(words: [u64; N]) -> Self {
        Self(words.into_iter().fold(0, |hash: u64, word| {
            // A word of 0 changes the state too.
            finish(hash.wrapping_add(STEP) ^ word)
        }))
    }

    /// 64 new bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        finish(self.0)
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in [−1, 1).
    #[inline]
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
}
