//! Which levels of the texel a cone reads: the footprint pulled back through the Jacobian. [seed §4.2, Williams83]

use glam::{Mat3, Vec3};
use pelage_geom::{Cone, texel_footprint};

use crate::Lod;

/// How the continuous level λ changes along a stretch of a ray: linearly, from its begin to its end. Half-way between two
/// levels both are read, one more and the other less by and by; elsewhere the nearer one is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// λ at both ends.
    ends: [f32; 2],
    /// The texel's finest level.
    depth: u32,
}

/// Over this much of a level one gives way to the next: wide enough to be no edge in a picture, and narrow, since reading
/// one level costs half of two. [docs/notes/performance.md]
const FADE: f32 = 0.4;

/// A level is read where λ is nearer than this.
const REACH: f32 = 0.5 + 0.5 * FADE;

impl Levels {
    /// From one λ to another, of a texel whose levels are `0..=depth`.
    pub fn new(ends: [f32; 2], depth: u32) -> Self {
        Self { ends, depth }
    }

    /// The part of it between two fractions.
    pub fn part(self, range: [f32; 2]) -> Self {
        let [a, b] = self.ends;
        Self { ends: [a + (b - a) * range[0], a + (b - a) * range[1]], depth: self.depth }
    }

    /// Weight of the even one of the two levels in use at a fraction of the stretch.
    #[inline]
    pub fn even(self, x: f32) -> f32 {
        let [a, b] = self.ends;
        let lambda = (a + (b - a) * x).clamp(0.0, self.depth as f32);
        let coarse = lambda as u32;
        let blend = (0.5 + (lambda - coarse as f32 - 0.5) * FADE.recip()).clamp(0.0, 1.0);
        if coarse.is_multiple_of(2) { 1.0 - blend } else { blend }
    }

    /// The finest level that has any weight.
    pub fn finest(self) -> u32 {
        let [_, finest] = self.first_and_last();
        finest
    }

    /// The one level that is read all along, if it is one.
    #[inline]
    pub fn only(self) -> Option<u32> {
        let [first, last] = self.first_and_last();
        (first == last).then_some(first)
    }

    #[inline]
    fn first_and_last(self) -> [u32; 2] {
        let [low, high] = self.bounds();
        [(low + 1.0 - REACH) as u32, last_below(high + REACH)]
    }

    /// The levels that have any weight, each with the fractions between which it has it, in the order in which the
    /// stretch comes to them.
    pub fn in_use(self) -> impl Iterator<Item = (u32, [f32; 2])> {
        let [first, last] = self.first_and_last();
        let rising = self.ends[0] <= self.ends[1];
        (first..=last)
            .map(move |i| if rising { i } else { last + first - i })
            .map(move |level| (level, self.range(level)))
            .filter(|(_, [begin, end])| begin < end)
    }

    /// The least and the largest level, as far as there are any.
    #[inline]
    fn bounds(self) -> [f32; 2] {
        let [a, b] = self.ends;
        let most = self.depth as f32;
        [a.min(b).clamp(0.0, most), a.max(b).clamp(0.0, most)]
    }

    /// Between which fractions a level has any weight.
    fn range(self, level: u32) -> [f32; 2] {
        let [a, b] = self.ends;
        let low = if level == 0 { f32::NEG_INFINITY } else { level as f32 - REACH };
        let high = if level >= self.depth { f32::INFINITY } else { level as f32 + REACH };
        if a == b {
            return if low < a && a < high { [0.0, 1.0] } else { [0.0; 2] };
        }
        let [x, y] = [(low - a) / (b - a), (high - a) / (b - a)];
        [x.min(y).clamp(0.0, 1.0), x.max(y).clamp(0.0, 1.0)]
    }
}

/// The largest whole number below `x`, or 0.
fn last_below(x: f32) -> u32 {
    (x.ceil() - 1.0).max(0.0) as u32
}

/// The continuous level λ = −log₂(footprint in texel units) for a cone at distance `t`, where `jacobian` maps texel
/// steps to scene steps. Not clamped: negative where one texel is smaller than the footprint.
pub(crate) fn lambda(lod: Lod, jacobian: &Mat3, direction: Vec3, cone: &Cone, t: f64) -> f32 {
    match lod {
        Lod::Level(level) => level as f32,
        Lod::Footprint(rule) => {
            let footprint = texel_footprint(rule, jacobian, direction, cone.width(t) as f32);
            // A cone of no width reads the finest level; a singular Jacobian the coarsest.
            if footprint.is_nan() { 0.0 } else { -footprint.max(f32::MIN_POSITIVE).log2() }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn in_use(ends: [f32; 2]) -> Vec<(u32, [f32; 2])> {
        Levels::new(ends, 7).in_use().collect()
    }

    #[test]
    fn levels_in_use() {
        let whole = [0.0, 1.0];
        assert_eq!(in_use([-3.0, -2.0]), [(0, whole)]);
        assert_eq!(in_use([9.5, 9.5]), [(7, whole)]);
        // Both between 2.3 and 2.7, else the nearer.
        assert_eq!(in_use([2.25, 2.25]), [(2, whole)]);
        assert_eq!(in_use([2.5, 2.5]), [(2, whole), (3, whole)]);
        assert_eq!(in_use([2.75, 2.75]), [(3, whole)]);
        assert_eq!([2.25, 2.5, 2.75, 7.0, 9.0].map(|l| Levels::new([l; 2], 7).finest()), [2, 3, 3, 7, 7]);
        // From 2.5 up to 4.5: level 2 until λ = 2.7, 3 until 3.7, 4 from 3.3 on, 5 from 4.3 on.
        let expected = [(2, [0.0, 0.1]), (3, [0.0, 0.6]), (4, [0.4, 1.0]), (5, [0.9, 1.0])];
        let near = |found: &[(u32, [f32; 2])], expected: &[(u32, [f32; 2])]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for ((l, [a, b]), (m, [c, d])) in found.iter().zip(expected) {
                assert!(l == m && (a - c).abs() + (b - d).abs() < 1e-6, "{found:?}");
            }
        };
        near(&in_use([2.5, 4.5]), &expected);
        let falling: Vec<u32> = in_use([4.5, 2.5]).iter().map(|(l, _)| *l).collect();
        assert_eq!(falling, [5, 4, 3, 2]);
        // Beyond the finest level only that is read: here from λ = 6.7 on.
        near(&in_use([6.5, 8.5]), &[(6, [0.0, 0.1]), (7, whole)]);
        assert_eq!(Levels::new([6.5, 8.5], 7).even(0.6), 0.0);
    }

    #[test]
    fn even_levels_weigh_what_odd_ones_do_not() {
        let even = |lambda: f32| Levels::new([lambda; 2], 7).even(0.5);
        assert_eq!([2.0, 2.25, 2.75, 3.25, 3.75, -1.0, 9.0].map(even), [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
        for (lambda, weight) in [(2.4, 0.75), (2.5, 0.5), (3.6, 0.75)] {
            assert!((even(lambda) - weight).abs() < 1e-5);
        }
    }

    proptest! {
        #[test]
        fn a_level_is_read_where_it_weighs(a in -2.0_f32..10.0, b in -2.0_f32..10.0, x in 0.0_f32..1.0) {
            let levels = Levels::new([a, b], 7);
            let even = levels.even(x);
            // Within rounding of a border a level of next to no weight may be read or not.
            let read = |parity: u32| {
                levels.in_use().any(|(l, [begin, end])| l % 2 == parity && begin - 1e-5 <= x && x <= end + 1e-5)
            };
            prop_assert!(even < 1e-3 || read(0), "{even}");
            prop_assert!(even > 1.0 - 1e-3 || read(1), "{even}");
            prop_assert!(levels.in_use().all(|(l, _)| l <= levels.finest()));
        }
    }

    #[test]
    fn a_cone_as_wide_as_a_voxel_reads_its_level() {
        // A box of side 2, and a cone 1/4 wide: 1/8 of the texel, level 3.
        let cone = Cone { width: 0.25, spread: 0.0 };
        let jacobian = Mat3::from_diagonal(Vec3::splat(2.0));
        let level = lambda(Lod::default(), &jacobian, Vec3::Z, &cone, 7.0);
        assert!((level - 3.0).abs() < 1e-5);
    }
}
