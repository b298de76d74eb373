//! One bijection of 64 bits in which every bit depends on all: what is drawn by place or number is drawn by it.

/// What SplitMix64 adds to its state for each number: 2⁶⁴ over the golden ratio, odd. \[Steele14\]
pub const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64. \[Steele14\]
#[inline]
pub fn finish(z: u64) -> u64 {
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_splitmix64() {
        // The first three of the seed 1234567, as the public-domain code of its authors prints them.
        let numbers = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        for (i, number) in (1_u64..).zip(numbers) {
            assert_eq!(finish(1_234_567_u64.wrapping_add(i.wrapping_mul(STEP))), number);
        }
    }
}
