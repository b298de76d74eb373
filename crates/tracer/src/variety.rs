//! What stands in the copies of a coat: one of several texels, turned, mirrored, lower and of another tone from copy to
//! copy, so that repetition does not show.
//!
//! Everything is drawn by the number of the copy, so it needs no memory, and all patches that a copy reaches into have
//! the same in it. A copy is its texel under an affine map, which the ray takes into account as it does the deformation
//! of its box: a copy that is lower shows exactly what content that is lower shows, and has as sharp a level of detail.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3, Vec3Swizzles};
use pelage_skin::Anchor;
use pelage_texel::Texel;

use crate::hash::Drawn;

/// What stands in the copies of a coat. By `From`, one texel that is the same in all of them: it goes on from copy to
/// copy if it is periodic. With any variety, each copy holds one whole texel, which ends where the copy does.
#[derive(Clone, Debug)]
pub struct Variety {
    /// The texels, each with its weight: it is chosen for as many copies as its weight is of the sum of all. Their
    /// depths, materials and kinds of source may differ.
    pub texels: Vec<(Arc<Texel>, f32)>,
    /// Whether copies are turned, by any number of quarter turns.
    pub turns: bool,
    /// Whether copies are mirrored in s and in t.
    pub mirrors: bool,
    /// By which part of its height a copy is lower at most, 0 to 0.9.
    pub height: f32,
    /// By which part the tone of a copy is off at most, 0 to 1: up or down in value, and half as much in warmth, red
    /// against blue.
    pub color: f32,
    /// Which of many choices.
    pub seed: u32,
}

impl From<Arc<Texel>> for Variety {
    fn from(texel: Arc<Texel>) -> Self {
        Self { texels: vec![(texel, 1.0)], turns: false, mirrors: false, height: 0.0, color: 0.0, seed: 0 }
    }
}

impl From<Texel> for Variety {
    fn from(texel: Texel) -> Self {
        Arc::new(texel).into()
    }
}

impl Variety {
    /// The one texel that stands alike in all copies, if there is no variety.
    #[inline]
    pub fn plain(&self) -> Option<&Arc<Texel>> {
        match self.texels.as_slice() {
            [(texel, _)] => {
                let alike = !self.turns && !self.mirrors && self.height == 0.0 && self.color == 0.0;
                alike.then_some(texel)
            }
            _ => None,
        }
    }

    /// The texel that stands in a copy.
    #[inline]
    pub(crate) fn of(&self, tile: &Tile) -> &Texel {
        &self.texels[tile.texel].0
    }

    /// The number of the finest level of all texels.
    pub fn depth(&self) -> u32 {
        self.texels.iter().map(|(texel, _)| texel.depth()).max().unwrap_or(0)
    }

    /// What keeps it from being used, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let sum: f32 = self.texels.iter().map(|(_, weight)| weight).sum();
        let weighs = self.texels.iter().all(|(_, w)| *w >= 0.0) && sum > 0.0 && sum.is_finite();
        if self.texels.is_empty() {
            Some("there is no texel")
        } else if !weighs {
            Some("the weights of its texels must not be negative, and some of them positive")
        } else if !(0.0..=0.9).contains(&self.height) {
            Some("its copies may be lower by a part from 0 to 0.9")
        } else if !(0.0..=1.0).contains(&self.color) {
            Some("the tone of its copies may be off by a part from 0 to 1")
        } else {
            None
        }
    }

    /// What stands in a copy (a number of a patch's lattice), which ends where the copy does.
    pub(crate) fn tile(&self, anchor: &Anchor, copy: [i32; 2]) -> Tile {
        let [s, t] = anchor.number(copy).map(|n| u64::from(n as u32));
        let mut drawn = Drawn::from([self.seed.into(), anchor.island.into(), s << 32 | t]);
        let texel = self.choose(drawn.unit());
        let bits = drawn.bits();
        let [swapped, across, along] = [0, 1, 2].map(|i| bits >> (63 - i) & 1 == 1);
        let (swapped, mirrored) = match (self.turns, self.mirrors) {
            (false, false) => (false, [false; 2]),
            (false, true) => (false, [across, along]),
            // A turn is made of two mirrorings: an even number of the three.
            (true, false) => (swapped, [across, across ^ swapped]),
            (true, true) => (swapped, [across, along]),
        };
        let height = 1.0 - self.height * drawn.unit();
        let [value, warmth] = [1.0 + self.color * drawn.signed(), 0.5 * self.color * drawn.signed()];
        let tint = value * Vec3::new(1.0 + warmth, 1.0, 1.0 - warmth);
        Tile { texel, copy, swapped, mirrored, height, tint }
    }

    /// The number of the texel that `at`, from 0 to 1 of all weight, falls to.
    fn choose(&self, at: f32) -> usize {
        let sum: f32 = self.texels.iter().map(|(_, weight)| weight).sum();
        let mut left = at * sum;
        let chosen = self.texels.iter().position(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        // Rounding may leave a little beyond the last that has any weight.
        chosen.or_else(|| self.texels.iter().rposition(|(_, weight)| *weight > 0.0)).unwrap_or(0)
    }
}

/// What stands in one copy, and how: the map between the lattice of the patch and the texel's own unit cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Which texel of the [`Variety`].
    pub texel: usize,
    /// Which copy of the lattice it is.
    pub copy: [i32; 2],
    /// Whether s and t change places, before they are mirrored.
    swapped: bool,
    mirrored: [bool; 2],
    /// Height of the texel's top, in w.
    pub height: f32,
    /// Multiplies its colours.
    pub tint: Vec3,
}

impl Tile {
    /// The first texel, as it is.
    pub fn upright(copy: [i32; 2]) -> Self {
        Self { texel: 0, copy, swapped: false, mirrored: [false; 2], height: 1.0, tint: Vec3::ONE }
    }

    fn corner(&self) -> DVec3 {
        DVec3::new(self.copy[0].into(), self.copy[1].into(), 0.0)
    }

    /// The texel's own coordinates of a point of the lattice.
    #[inline]
    pub fn inside(&self, p: DVec3) -> DVec3 {
        let mut q = p - self.corner();
        if self.swapped {
            q = q.yxz();
        }
        for (axis, mirrored) in self.mirrored.into_iter().enumerate() {
            if mirrored {
                q[axis] = 1.0 - q[axis];
            }
        }
        q.z /= f64::from(self.height);
        q
    }

    /// The same for what lies in the copy, in single precision; kept in it, so that rounding puts nothing beyond it.
    #[inline]
    pub fn within(&self, p: Vec3) -> Vec3 {
        const LAST: f32 = 1.0 - 0.5 * f32::EPSILON;
        let q = self.inside(p.as_dvec3()).as_vec3();
        q.truncate().clamp(Vec2::ZERO, Vec2::splat(LAST)).extend(q.z)
    }

    /// The point of the lattice at the texel's own coordinates.
    #[inline]
    pub fn outside(&self, mut q: DVec3) -> DVec3 {
        for (axis, mirrored) in self.mirrored.into_iter().enumerate() {
            if mirrored {
                q[axis] = 1.0 - q[axis];
            }
        }
        if self.swapped {
            q = q.yxz();
        }
        q.z *= f64::from(self.height);
        q + self.corner()
    }

    /// What a step along each axis of the texel moves, of what steps along those of the lattice do.
    pub fn carried(&self, tangents: DMat3) -> DMat3 {
        let DMat3 { x_axis: s, y_axis: t, z_axis: w } = tangents;
        let [along_s, along_t] = if self.swapped { [t, s] } else { [s, t] };
        let [s, t] = self.mirrored.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        DMat3::from_cols(s * along_s, t * along_t, f64::from(self.height) * w)
    }

    /// The matrix from steps in the lattice to steps in the texel.
    pub fn steps(&self) -> DMat3 {
        let [s, t] = self.mirrored.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        let [along_s, along_t] = [s * DVec3::X, t * DVec3::Y];
        let (first, second) = if self.swapped { (along_t, along_s) } else { (along_s, along_t) };
        DMat3::from_cols(first, second, DVec3::Z / f64::from(self.height))
    }
}

#[cfg(test)]
mod tests {
    use pelage_texel::{Procedure, Spheres, Texel};

    use super::*;

    fn variety(weights: &[f32]) -> Variety {
        let texel = Arc::new(Texel::unbaked("balls", Spheres::default().geometry()).expect("a source"));
        let texels = weights.iter().map(|&weight| (texel.clone(), weight)).collect();
        Variety { texels, turns: true, mirrors: true, height: 0.4, color: 0.2, seed: 3 }
    }

    /// The tiles of 90 × 90 copies about (0, 0).
    fn tiles(variety: &Variety, island: u32) -> Vec<Tile> {
        let anchor = Anchor { island, first: [0; 2] };
        (0..8100).map(|i| variety.tile(&anchor, [i % 90 - 45, i / 90 - 45])).collect()
    }

    /// Σ (observed − expected)² / expected, over classes of which each is expected for its part.
    fn chi_square(classes: impl Iterator<Item = usize>, parts: &[f64]) -> f64 {
        let mut observed = vec![0.0; parts.len()];
        classes.for_each(|class| observed[class] += 1.0);
        let count: f64 = observed.iter().sum();
        observed.iter().zip(parts).map(|(o, part)| (o - count * part).powi(2) / (count * part)).sum()
    }

    fn symmetry(tile: &Tile) -> usize {
        usize::from(tile.swapped) + 2 * usize::from(tile.mirrored[0]) + 4 * usize::from(tile.mirrored[1])
    }

    #[test]
    fn everything_is_drawn_as_often_as_it_should_be() {
        // χ² of k classes that are drawn independently has the mean k − 1 and the variance 2 (k − 1); by Wilson and
        // Hilferty, (χ²/n)^⅓ of n = k − 1 is normal with the mean 1 − 2/9n and the variance 2/9n: four deviations.
        let bound = |classes: usize| {
            let n = (classes - 1) as f64;
            n * (1.0 - 2.0 / (9.0 * n) + 4.0 * (2.0 / (9.0 * n)).sqrt()).powi(3)
        };
        let check = |what: &str, chi: f64, classes: usize| {
            println!("{what}: χ² {chi:.1} of {classes}, at most {:.1}", bound(classes));
            assert!(chi < bound(classes), "{what}");
        };
        let variety = variety(&[1.0, 0.0, 2.0, 5.0]);
        let drawn = tiles(&variety, 7);
        assert!(drawn.iter().all(|tile| tile.texel != 1));
        check(
            "texels",
            chi_square(drawn.iter().map(|t| t.texel - usize::from(t.texel > 1)), &[0.125, 0.25, 0.625]),
            3,
        );
        check("symmetries", chi_square(drawn.iter().map(symmetry), &[0.125; 8]), 8);
        let class = |x: f32| ((8.0 * x) as usize).min(7);
        check("heights", chi_square(drawn.iter().map(|t| class((1.0 - t.height) / 0.4)), &[0.125; 8]), 8);
        check("tones", chi_square(drawn.iter().map(|t| class((t.tint.y - 0.8) / 0.4)), &[0.125; 8]), 8);
        // Neighbours along either axis, the same copy of another island, and under another seed, have nothing in common.
        let reseeded = tiles(&Variety { seed: 4, ..variety.clone() }, 7);
        let elsewhere = tiles(&variety, 8);
        let pairs = |others: &[Tile]| {
            let both = drawn.iter().zip(others).map(|(a, b)| symmetry(a) + 8 * symmetry(b));
            chi_square(both, &[1.0 / 64.0; 64])
        };
        for (what, others) in [
            ("along s", &drawn[1..]),
            ("along t", &drawn[90..]),
            ("islands", &elsewhere),
            ("seeds", &reseeded),
        ] {
            check(what, pairs(others), 64);
        }
    }

    #[test]
    fn every_tile_is_a_bijection_of_the_cube() {
        let all = variety(&[1.0]);
        let mut seen = [false; 8];
        for tile in tiles(&all, 0).iter().take(300) {
            seen[symmetry(tile)] = true;
            let height = f64::from(tile.height);
            assert!((0.6..=1.0).contains(&height));
            for i in 0..64 {
                let p = DVec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)) / 3.0;
                let out = tile.outside(p);
                assert!(tile.inside(out).distance(p) < 1e-12);
                // Corners of the texel are corners of the copy, its top where the height says.
                let within = out - tile.corner();
                assert!(within.min_element() > -1e-12 && within.truncate().max_element() < 1.0 + 1e-12);
                assert!((within.z - height * p.z).abs() < 1e-12);
                // Steps are what differences of points are.
                let d = DVec3::new(0.3, -0.2, 0.7);
                assert!((tile.inside(out + d) - p).distance(tile.steps() * d) < 1e-12);
                let carried = tile.carried(DMat3::IDENTITY);
                assert!((carried * tile.steps()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
            }
        }
        assert_eq!(seen, [true; 8]);
    }

    #[test]
    fn turns_and_mirrors_are_what_they_are_called() {
        let of = |turns: bool, mirrors: bool| {
            let mut found = [false; 8];
            let tiles = tiles(&Variety { turns, mirrors, ..variety(&[1.0]) }, 1);
            for tile in &tiles {
                found[symmetry(tile)] = true;
                // A turn does not mirror, and without turns s stays s.
                assert!(mirrors || tile.steps().determinant() > 0.0);
                assert!(turns || !tile.swapped);
            }
            found.iter().filter(|found| **found).count()
        };
        assert_eq!([of(false, false), of(true, false), of(false, true), of(true, true)], [1, 4, 4, 8]);
    }

    #[test]
    fn what_cannot_be_chosen_from_is_refused() {
        let good = variety(&[1.0]);
        assert_eq!(good.fault(), None);
        for bad in [
            variety(&[]),
            variety(&[0.0, 0.0]),
            variety(&[1.0, -0.5]),
            variety(&[f32::NAN]),
            variety(&[f32::INFINITY]),
            Variety { height: 1.0, ..good.clone() },
            Variety { height: f32::NAN, ..good.clone() },
            Variety { color: -0.1, ..good.clone() },
        ] {
            assert!(bad.fault().is_some(), "{bad:?}");
        }
    }
}
