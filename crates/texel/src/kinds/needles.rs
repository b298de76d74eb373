//! Needles: shoots of conifers, with side shoots and needles around them.

use core::f32::consts::TAU;

use glam::Vec3;

use super::curve::{GOLDEN, arc, around, at, heading, turned};
use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use super::tube::tube;
use super::variant::{elements, seed_of};
use super::within::plant;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Conifer shoots, with side shoots and needles around them.
    pub struct Needles {
        /// Which of the many conifers with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Shoots in a copy.
        shoots: u32 in 1..=10_000 ["shoots"],
        /// Length of a shoot, along it; one that would grow out of the texel is smaller.
        length: f32 in 0..=2 ["texel edges"],
        /// Relative variation of the length.
        length_variation: f32 in 0..=1,
        /// How far shoots lean from the upright where they begin, at most.
        spread: f32 in 0..=90 ["degrees"],
        /// How far shoots bend over on their way; below 0 they bend up.
        bend: f32 in -90..=180 ["degrees"],
        /// Side shoots of a shoot, to its left and right by turns.
        side_shoots: u32 in 0..=32 ["side shoots"],
        /// Angle between side shoots and their shoot.
        side_angle: f32 in 0..=120 ["degrees"],
        /// Radius of a shoot where it begins; it ends half as thick.
        twig_radius: f32 in 0..=0.1 ["texel edges"],
        /// Needles of a shoot; side shoots have as many for their length.
        needles: u32 in 0..=10_000 ["needles"],
        /// Length of a needle.
        needle_length: f32 in 0..=0.5 ["texel edges"],
        /// Relative variation of the needles' length.
        needle_variation: f32 in 0..=1,
        /// Radius of a needle in its middle.
        needle_radius: f32 in 0..=0.1 ["texel edges"],
        /// Angle between needles and shoot; those at the tip are close to it.
        needle_angle: f32 in 0..=120 ["degrees"],
        /// How far needles bend towards the tip of the shoot on their way.
        needle_bend: f32 in -90..=90 ["degrees"],
        /// How far needles are combed to the shoot's left and right: 0 all around as of a spruce, 1 in two rows.
        comb: f32 in 0..=1,
        /// Needles that grow from one place.
        bundle: u32 in 1..=10 ["needles"],
        /// Colour of the needles at the foot of a shoot.
        color: Vec3 in 0..=1,
        /// Colour of the youngest needles, at its tip.
        tip_color: Vec3 in 0..=1,
        /// Relative variation of brightness between needles.
        color_variation: f32 in 0..=1,
        /// Colour of the shoots.
        twig_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
    }
}

/// Straight pieces along a shoot and a needle.
const SHOOT: u32 = 6;
const NEEDLE: u32 = 2;
/// Sides of shoots and needles.
const SIDES: u32 = 3;

impl Needles {
    /// Stiff short needles all around.
    pub fn spruce() -> Self {
        Self {
            seed: 1,
            variant: 0,
            shoots: 26,
            length: 0.8,
            length_variation: 0.2,
            spread: 60.0,
            bend: -10.0,
            side_shoots: 4,
            side_angle: 50.0,
            twig_radius: 0.012,
            needles: 110,
            needle_length: 0.1,
            needle_variation: 0.2,
            needle_radius: 0.006,
            needle_angle: 60.0,
            needle_bend: 15.0,
            comb: 0.2,
            bundle: 1,
            color: Vec3::new(0.025, 0.085, 0.035),
            tip_color: Vec3::new(0.12, 0.24, 0.07),
            color_variation: 0.2,
            twig_color: Vec3::new(0.2, 0.11, 0.05),
            specular: 0.06,
            roughness: 0.4,
        }
    }

    /// Flat needles combed to both sides.
    pub fn fir() -> Self {
        Self {
            shoots: 22,
            side_shoots: 4,
            needles: 90,
            needle_length: 0.13,
            needle_radius: 0.008,
            needle_angle: 75.0,
            comb: 0.85,
            color: Vec3::new(0.03, 0.1, 0.05),
            tip_color: Vec3::new(0.16, 0.3, 0.1),
            ..Self::spruce()
        }
    }

    /// Long needles in pairs.
    pub fn pine() -> Self {
        Self {
            shoots: 24,
            length: 0.7,
            spread: 45.0,
            bend: -25.0,
            side_shoots: 0,
            needles: 150,
            needle_length: 0.32,
            needle_variation: 0.25,
            needle_radius: 0.005,
            needle_angle: 55.0,
            needle_bend: -12.0,
            comb: 0.0,
            bundle: 2,
            color: Vec3::new(0.05, 0.12, 0.045),
            tip_color: Vec3::new(0.15, 0.26, 0.08),
            ..Self::spruce()
        }
    }

    fn shoot(&self, i: u32, geometry: &mut Geometry) {
        let mut shoot = Geometry::default();
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.shoots, LOOSELY, random).extend(0.0);
        let length = self.length * (1.0 + self.length_variation * random.signed());
        let along = heading(TAU * random.unit(), self.spread.to_radians() * random.unit().sqrt());
        let bend = self.bend.to_radians() * (1.0 + 0.3 * random.signed());
        let over = along.truncate().normalize_or_zero().extend(-1.0);
        let curve = arc(root, along, over, bend, length, SHOOT);
        self.dress(&curve, 1.0, random, &mut shoot);
        for k in 0..self.side_shoots {
            let place = 0.25 + 0.6 * (k as f32 + 0.5) / self.side_shoots as f32;
            let (base, axis) = at(&curve, place);
            let side = if k % 2 == 0 { 0.25 } else { -0.25 } * TAU;
            let out = around(axis, side + 0.4 * random.signed());
            let along = turned(axis, out, self.side_angle.to_radians() * (1.0 + 0.15 * random.signed()));
            // The further up, the younger.
            let part = 0.75 * (1.1 - place) * (1.0 + 0.15 * random.signed());
            let twig = arc(base, along, axis, 0.3, length * part, SHOOT);
            self.dress(&twig, part, random, &mut shoot);
        }
        plant(geometry, shoot, root);
    }

    /// The twig along `curve` and its needles: those of a `part` of a shoot.
    fn dress(&self, curve: &[Vec3], part: f32, random: &mut Random, shoot: &mut Geometry) {
        let turn = TAU * random.unit();
        let thick = self.twig_radius * part.sqrt();
        tube(shoot, curve, SIDES, turn, |x| thick * (1.0 - 0.5 * x), |_| self.twig_color);
        let count = (self.needles as f32 * part).round() as u32;
        for k in 0..count {
            let bundle = k / self.bundle.max(1);
            let age = (bundle as f32 + 0.5) / count.div_ceil(self.bundle.max(1)) as f32;
            let (base, axis) = at(curve, 0.04 + 0.96 * age);
            let out = around(axis, turn + GOLDEN * bundle as f32 + 0.35 * random.signed());
            // Left and right of a shoot are across it and level.
            let side = around(axis, 0.25 * TAU);
            let level = side * side.dot(out).signum();
            let out = out.lerp(level, self.comb).normalize_or(level);
            let tip = age.powi(8);
            let angle = self.needle_angle.to_radians() * (1.0 - 0.7 * tip) * (1.0 + 0.15 * random.signed());
            let size =
                self.needle_length * (1.0 - 0.35 * tip) * (1.0 + self.needle_variation * random.signed());
            let bend = self.needle_bend.to_radians();
            let needle = arc(base, turned(axis, out, angle), axis, bend, size, NEEDLE);
            let color =
                self.color.lerp(self.tip_color, age.powi(3)) * (1.0 + self.color_variation * random.signed());
            let radius = |x: f32| self.needle_radius * (1.0 - x * x * x);
            tube(shoot, &needle, SIDES, TAU * random.unit(), radius, |x| color * (0.85 + 0.3 * x));
        }
    }
}

impl Default for Needles {
    fn default() -> Self {
        Self::spruce()
    }
}

impl Procedure for Needles {
    fn name(&self) -> &'static str {
        "needles"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        // A side shoot is at most 1.1 · ¾ · 1.15 of a shoot.
        let twigs = u64::from(1 + self.side_shoots);
        let twig = 2 * SHOOT * SIDES + self.needles * 2 * NEEDLE * SIDES;
        at_most_triangles(u64::from(self.shoots) * twigs * u64::from(twig))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        let grow = |i: u32, geometry: &mut Geometry| self.shoot(i, geometry);
        elements(geometry, self.shoots, self.variant, grow, |i, geometry| own.shoot(i, geometry))
    }
}
