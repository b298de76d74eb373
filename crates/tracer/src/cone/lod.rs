//! Which levels of the texel a cone reads: the footprint pulled back through the Jacobian. [seed §4.2, Williams83]

use glam::{Mat3, Vec3};
use pelage_geom::{Cone, texel_footprint};

use crate::Lod;

/// How the continuous level λ changes along a stretch of a ray: linearly, from its begin to its end. Between two
/// levels both are read, and weigh as much as λ is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// λ at both ends.
    ends: [f32; 2],
    /// The texel's finest level.
    depth: u32,
}

/// Weights below this show in no picture, and reading one level costs half of two.
const FAINT: f32 = 1.0 / 256.0;

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
        let blend = match lambda - coarse as f32 {
            // A level that is not read has no weight either.
            blend if blend <= FAINT => 0.0,
            blend if blend >= 1.0 - FAINT => 1.0,
            blend => blend,
        };
        if coarse % 2 == 0 { 1.0 - blend } else { blend }
    }

    /// The finest level that has any weight.
    pub fn finest(self) -> u32 {
        let [_, high] = self.bounds();
        (high - FAINT).ceil().max(0.0) as u32
    }

    /// The levels that have any weight, each with the fractions between which it has it, in the order in which the
    /// stretch comes to them.
    pub fn in_use(self) -> impl Iterator<Item = (u32, [f32; 2])> {
        let [low, high] = self.bounds();
        let (first, last) = ((low + FAINT).floor() as u32, (high - FAINT).ceil().max(0.0) as u32);
        let rising = self.ends[0] <= self.ends[1];
        (first..=last.max(first))
            .map(move |i| if rising { i } else { last.max(first) + first - i })
            .map(move |level| (level, self.range(level)))
            .filter(|(_, [begin, end])| begin < end)
    }

    /// The least and the largest level, as far as there are any.
    fn bounds(self) -> [f32; 2] {
        let [a, b] = self.ends;
        let most = self.depth as f32;
        [a.min(b).clamp(0.0, most), a.max(b).clamp(0.0, most)]
    }

    /// Between which fractions a level weighs more than [`FAINT`].
    fn range(self, level: u32) -> [f32; 2] {
        const REACH: f32 = 1.0 - FAINT;
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
    use super::*;

    fn in_use(ends: [f32; 2]) -> Vec<(u32, [f32; 2])> {
        Levels::new(ends, 7).in_use().collect()
    }

    #[test]
    fn levels_in_use() {
        let whole = [0.0, 1.0];
        assert_eq!(in_use([-3.0, -2.0]), [(0, whole)]);
        assert_eq!(in_use([9.5, 9.5]), [(7, whole)]);
        assert_eq!(in_use([2.25, 2.25]), [(2, whole), (3, whole)]);
        // What weighs less than 1/256 is not read.
        assert_eq!(in_use([2.001, 2.001]), [(2, whole)]);
        assert_eq!(in_use([2.999, 2.999]), [(3, whole)]);
        assert_eq!([2.001, 2.25, 2.999].map(|l| Levels::new([l; 2], 7).finest()), [2, 3, 3]);
        // From 2.5 up to 4.5: level 2 until λ = 3, 3 until 4, 4 from 3 on, 5 from 4 on; all but 1/256 of a level.
        let faint = FAINT / 2.0;
        let rising = [(2, [0.0, 0.25 - faint]), (3, [0.0, 0.75 - faint]), (4, [0.25 + faint, 1.0])];
        assert_eq!(in_use([2.5, 4.5])[..3], rising);
        assert_eq!(in_use([2.5, 4.5])[3], (5, [0.75 + faint, 1.0]));
        let falling: Vec<u32> = in_use([4.5, 2.5]).iter().map(|(l, _)| *l).collect();
        assert_eq!(falling, [5, 4, 3, 2]);
        // Beyond the finest level only that is read, and from where it is reached on with all its weight.
        assert_eq!(in_use([6.5, 8.5]), [(6, [0.0, 0.25 - faint]), (7, whole)]);
        assert_eq!(Levels::new([6.5, 8.5], 7).even(0.6), 0.0);
    }

    #[test]
    fn even_levels_weigh_what_odd_ones_do_not() {
        let even = |lambda: f32| Levels::new([lambda; 2], 7).even(0.5);
        assert_eq!([2.0, 2.25, 3.0, 3.25, 4.0, -1.0, 9.0].map(even), [1.0, 0.75, 0.0, 0.25, 1.0, 1.0, 0.0]);
        // One level alone has all of the weight.
        assert_eq!([2.001, 2.999, 3.001].map(even), [1.0, 0.0, 0.0]);
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
