//! Foliage: twigs with leaves that have a real outline.

use core::f32::consts::TAU;

use glam::Vec3;

use super::blade::Blade;
use super::curve::{arc, around, at, heading, turned};
use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use super::tube::tube;
use super::variant::{elements, seed_of};
use super::within::plant;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Twigs with leaves of a real outline, folded along the middle and bent.
    pub struct Foliage {
        /// Which of the many bushes with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Twigs in a copy.
        twigs: u32 in 1..=10_000 ["twigs"],
        /// Length of a twig, along it; one that would grow out of the texel is smaller.
        length: f32 in 0..=2 ["texel edges"],
        /// Relative variation of the length.
        length_variation: f32 in 0..=1,
        /// How far twigs lean from the upright where they begin, at most.
        spread: f32 in 0..=90 ["degrees"],
        /// How far twigs bend over on their way; below 0 they bend up.
        bend: f32 in -90..=180 ["degrees"],
        /// Radius of a twig where it begins; it ends half as thick.
        twig_radius: f32 in 0..=0.1 ["texel edges"],
        /// Leaves of a twig.
        leaves: u32 in 0..=1000 ["leaves"],
        /// Part of the twig, from where it begins, that bears no leaves.
        bare: f32 in 0..=1,
        /// Angle around the twig from a leaf to the next: 180 for two rows, 137.5 for leaves all around.
        divergence: f32 in 0..=180 ["degrees"],
        /// Angle between a leaf and its twig.
        leaf_angle: f32 in 0..=150 ["degrees"],
        /// How far leaves turn their upper sides up, to the light.
        facing: f32 in 0..=1,
        /// Length of a leaf's stalk.
        stalk: f32 in 0..=0.5 ["texel edges"],
        /// Length of a leaf.
        leaf_length: f32 in 0..=0.5 ["texel edges"],
        /// Relative variation of a leaf's length.
        leaf_variation: f32 in 0..=1,
        /// Width of a leaf over its length.
        leaf_width: f32 in 0..=2,
        /// Where a leaf is widest, from its base to its tip.
        widest: f32 in 0.1..=0.9,
        /// How pointed a leaf's tip is: 0 for round, 1 for drawn out to a point.
        pointed: f32 in 0..=1,
        /// How far each half of a leaf is folded up along its middle.
        fold: f32 in 0..=80 ["degrees"],
        /// How far leaves bend back towards their tips.
        droop: f32 in -180..=180 ["degrees"],
        /// Colour of the leaves at one end of the range.
        color: Vec3 in 0..=1,
        /// Colour of those at the other end. Leaves of a twig are alike.
        other_color: Vec3 in 0..=1,
        /// Relative variation of brightness between leaves.
        color_variation: f32 in 0..=1,
        /// Fraction of the leaves that have turned.
        turned: f32 in 0..=1,
        /// Their colour.
        turned_color: Vec3 in 0..=1,
        /// Colour of twigs and stalks.
        twig_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
        /// Straight pieces along a leaf.
        segments: u32 in 2..=32 ["pieces"],
    }
}

/// Straight pieces along a twig.
const TWIG: u32 = 8;
/// Sides of twigs and stalks.
const SIDES: u32 = 3;

impl Foliage {
    /// A dense shrub with oval leaves: a hedge.
    pub fn shrub() -> Self {
        Self {
            seed: 1,
            variant: 0,
            twigs: 26,
            length: 0.85,
            length_variation: 0.25,
            spread: 55.0,
            bend: -15.0,
            twig_radius: 0.01,
            leaves: 13,
            bare: 0.2,
            divergence: 137.5,
            leaf_angle: 60.0,
            facing: 0.5,
            stalk: 0.02,
            leaf_length: 0.17,
            leaf_variation: 0.25,
            leaf_width: 0.55,
            widest: 0.45,
            pointed: 0.45,
            fold: 18.0,
            droop: 30.0,
            color: Vec3::new(0.06, 0.17, 0.03),
            other_color: Vec3::new(0.24, 0.4, 0.07),
            color_variation: 0.2,
            turned: 0.01,
            turned_color: Vec3::new(0.45, 0.33, 0.06),
            twig_color: Vec3::new(0.16, 0.1, 0.06),
            specular: 0.06,
            roughness: 0.35,
            segments: 5,
        }
    }

    /// Broad heart-shaped leaves on creeping twigs: a wall of ivy.
    pub fn ivy() -> Self {
        Self {
            twigs: 16,
            length: 0.9,
            spread: 80.0,
            bend: 10.0,
            leaves: 12,
            divergence: 180.0,
            leaf_angle: 70.0,
            facing: 0.85,
            stalk: 0.1,
            leaf_length: 0.2,
            leaf_width: 0.95,
            widest: 0.28,
            pointed: 0.6,
            fold: 12.0,
            droop: 40.0,
            color: Vec3::new(0.025, 0.09, 0.025),
            other_color: Vec3::new(0.1, 0.22, 0.045),
            specular: 0.09,
            roughness: 0.3,
            ..Self::shrub()
        }
    }

    /// Long narrow leaves on twigs that hang over.
    pub fn willow() -> Self {
        Self {
            twigs: 24,
            length: 1.3,
            spread: 35.0,
            bend: 110.0,
            leaves: 22,
            leaf_angle: 40.0,
            facing: 0.15,
            leaf_length: 0.24,
            leaf_width: 0.17,
            pointed: 0.8,
            droop: 45.0,
            color: Vec3::new(0.12, 0.22, 0.07),
            other_color: Vec3::new(0.3, 0.4, 0.14),
            ..Self::shrub()
        }
    }

    /// A beech in October.
    pub fn autumn() -> Self {
        Self {
            leaf_width: 0.6,
            color: Vec3::new(0.5, 0.14, 0.02),
            other_color: Vec3::new(0.62, 0.38, 0.04),
            color_variation: 0.25,
            turned: 0.25,
            turned_color: Vec3::new(0.28, 0.05, 0.02),
            twig_color: Vec3::new(0.12, 0.09, 0.07),
            specular: 0.03,
            roughness: 0.5,
            ..Self::shrub()
        }
    }

    fn twig(&self, i: u32, geometry: &mut Geometry) {
        let mut twig = Geometry::default();
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.twigs, LOOSELY, random).extend(0.0);
        let length = self.length * (1.0 + self.length_variation * random.signed());
        let along = heading(TAU * random.unit(), self.spread.to_radians() * random.unit().sqrt());
        let bend = self.bend.to_radians() * (1.0 + 0.3 * random.signed());
        // Over: away from the upright; back: towards it.
        let over = along.truncate().normalize_or_zero().extend(-1.0);
        let curve = arc(root, along, over, bend, length, TWIG);
        let turn = TAU * random.unit();
        tube(&mut twig, &curve, SIDES, turn, |x| self.twig_radius * (1.0 - 0.5 * x), |_| self.twig_color);
        let hue = random.unit();
        for k in 0..self.leaves {
            // 0 for the lowest, 1 for the one at the tip.
            let age = if self.leaves > 1 { k as f32 / (self.leaves - 1) as f32 } else { 1.0 };
            let place = self.bare + (1.0 - self.bare) * age;
            let (base, axis) = at(&curve, place);
            let out = around(axis, turn + self.divergence.to_radians() * k as f32 + 0.25 * random.signed());
            // The last goes on where the twig ends.
            let angle = self.leaf_angle.to_radians() * (1.0 - age.powi(6)) * (1.0 + 0.2 * random.signed());
            let along = turned(axis, out, angle);
            let size =
                self.leaf_length * (1.0 - 0.3 * age * age) * (1.0 + self.leaf_variation * random.signed());
            let inner = turned(along, axis, 0.25 * TAU);
            let up = turned(along, Vec3::Z, 0.25 * TAU);
            // Across the leaf whatever the blend: both are.
            let normal = inner.lerp(up, self.facing).normalize_or(inner);
            let stalk = [base, base + along * self.stalk];
            let thin = 0.35 * self.twig_radius;
            tube(&mut twig, &stalk, SIDES, 0.0, |_| thin, |_| self.twig_color.lerp(self.color, 0.5));
            let leaf = Blade {
                base: stalk[1],
                along,
                normal,
                length: size,
                droop: self.droop.to_radians() * (1.0 + 0.4 * random.signed()),
                fold: self.fold.to_radians(),
                segments: self.segments,
            };
            let has_turned = random.unit() < self.turned;
            let own = (0.6 * hue + 0.4 * random.unit()).clamp(0.0, 1.0);
            let color = if has_turned { self.turned_color } else { self.color.lerp(self.other_color, own) };
            let color = color * (1.0 + self.color_variation * random.signed());
            leaf.grow(&mut twig, |x| 0.5 * size * self.leaf_width * self.outline(x), |_| color);
        }
        plant(geometry, twig, root);
    }

    /// Half-width over half the width at a fraction of a leaf's length: 1 where it is widest, 0 at its ends.
    fn outline(&self, x: f32) -> f32 {
        // x^a (1 − x)^b is greatest at a/(a + b). Half a power is as round as a circle, one is a straight edge, more is
        // drawn out.
        let b = 0.5 + self.pointed;
        let a = b * self.widest / (1.0 - self.widest);
        let shape = |x: f32| x.max(0.0).powf(a) * (1.0 - x).max(0.0).powf(b);
        shape(x) / shape(self.widest)
    }
}

impl Default for Foliage {
    fn default() -> Self {
        Self::shrub()
    }
}

impl Procedure for Foliage {
    fn name(&self) -> &'static str {
        "foliage"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        let leaf = Blade::triangles(self.segments, self.fold > 0.0, true, true) + 2 * SIDES;
        let twig = 2 * TWIG * SIDES + self.leaves * leaf;
        at_most_triangles(u64::from(self.twigs) * u64::from(twig))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        let grow = |i: u32, geometry: &mut Geometry| self.twig(i, geometry);
        elements(geometry, self.twigs, self.variant, grow, |i, geometry| own.twig(i, geometry))
    }
}
