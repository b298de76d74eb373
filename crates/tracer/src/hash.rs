//! One bijection of 64 bits in which every bit depends on all: what is drawn by place is drawn by it.

/// The finaliser of SplitMix64. [Steele14]
#[inline]
pub(crate) fn finish(z: u64) -> u64 {
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Numbers that depend on the words that they are drawn from, and on nothing else. [Steele14]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn(u64);

impl Drawn {
    /// From some words, in their order.
    #[inline]
    pub fn from<const N: usize>(words: [u64; N]) -> Self {
        Self(words.into_iter().fold(0, |hash: u64, word| {
            // A word of 0 changes the state too.
            finish(hash.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ word)
        }))
    }

    /// 64 new bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
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
