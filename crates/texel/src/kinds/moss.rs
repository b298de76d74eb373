//! Moss: cushions of small shoots, each a stem with tiny pointed leaves around it.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::blade::Blade;
use super::clumps::Clumps;
use super::curve::{GOLDEN, arc, around, at, heading, turned};
use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use super::tube::tube;
use super::variant::{elements, seed_of};
use super::within::plant;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Cushions of small shoots, each a stem with tiny pointed leaves around it.
    pub struct Moss {
        /// Which of the many mosses with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Shoots in a copy.
        shoots: u32 in 1..=100_000 ["shoots"],
        /// Length of a shoot in the middle of its cushion, along its stem.
        length: f32 in 0..=1 ["texel edges"],
        /// Relative variation of the length.
        length_variation: f32 in 0..=1,
        /// Cushions in a copy.
        cushions: u32 in 1..=1000 ["cushions"],
        /// How domed cushions are: part of the length that shoots between them lack.
        dome: f32 in 0..=1,
        /// How far shoots between cushions lean outwards; those in the middle of one are upright.
        splay: f32 in 0..=85 ["degrees"],
        /// Radius of a stem.
        stem_radius: f32 in 0..=0.1 ["texel edges"],
        /// Leaves of a shoot.
        leaves: u32 in 0..=500 ["leaves"],
        /// Part of the stem, from its root, that bears no leaves.
        bare: f32 in 0..=1,
        /// Length of a leaf; the youngest at the tip are half as long.
        leaf_length: f32 in 0..=0.5 ["texel edges"],
        /// Width of a leaf over its length.
        leaf_width: f32 in 0..=2,
        /// Angle between the lowest leaves and the stem; the youngest at the tip are close to it.
        leaf_angle: f32 in 0..=120 ["degrees"],
        /// How far leaves bend back towards their tips.
        leaf_droop: f32 in -180..=180 ["degrees"],
        /// Colour of the stems and of the leaves at the foot of a shoot.
        base_color: Vec3 in 0..=1,
        /// Colour of the leaves at the tip of a shoot.
        tip_color: Vec3 in 0..=1,
        /// Relative variation of brightness between shoots.
        color_variation: f32 in 0..=1,
        /// Fraction of the shoots that bear a capsule on a thin stalk, up to the texel's top.
        capsules: f32 in 0..=1,
        /// Colour of the capsules and their stalks.
        capsule_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
    }
}

/// Straight pieces along a stem, a leaf, and a capsule with its stalk.
const STEM: u32 = 3;
const LEAF: u32 = 3;
const CAPSULE: u32 = 10;
/// Sides of stems and stalks.
const SIDES: u32 = 3;

impl Moss {
    /// Soft rounded cushions, as on a boulder or a roof.
    pub fn cushion() -> Self {
        Self {
            seed: 1,
            variant: 0,
            shoots: 260,
            length: 0.75,
            length_variation: 0.08,
            cushions: 3,
            dome: 0.45,
            splay: 35.0,
            stem_radius: 0.008,
            leaves: 30,
            bare: 0.35,
            leaf_length: 0.1,
            leaf_width: 0.3,
            leaf_angle: 75.0,
            leaf_droop: 25.0,
            base_color: Vec3::new(0.07, 0.065, 0.015),
            tip_color: Vec3::new(0.3, 0.42, 0.05),
            color_variation: 0.2,
            capsules: 0.03,
            capsule_color: Vec3::new(0.42, 0.13, 0.04),
            specular: 0.03,
            roughness: 0.5,
        }
    }

    /// Large separate shoots that look like green stars from above.
    pub fn star() -> Self {
        Self {
            shoots: 70,
            length: 0.8,
            length_variation: 0.15,
            cushions: 1,
            dome: 0.15,
            splay: 15.0,
            stem_radius: 0.01,
            leaves: 46,
            bare: 0.3,
            leaf_length: 0.22,
            leaf_width: 0.13,
            leaf_angle: 85.0,
            leaf_droop: 15.0,
            base_color: Vec3::new(0.09, 0.06, 0.02),
            tip_color: Vec3::new(0.16, 0.34, 0.06),
            capsules: 0.08,
            ..Self::cushion()
        }
    }

    /// Grows shoot after shoot.
    fn shoots(&self) -> impl Fn(u32, &mut Geometry) + '_ {
        let cushions = Clumps::new(self.cushions, self.seed ^ 0xc054);
        move |i, geometry| self.shoot(i, &cushions, geometry)
    }

    fn shoot(&self, i: u32, cushions: &Clumps, geometry: &mut Geometry) {
        let mut shoot = Geometry::default();
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.shoots, LOOSELY, random);
        let outwards = root - cushions.nearest(root).middle;
        // Half the distance between neighbours of an even lattice.
        let reach = 0.5 / (self.cushions as f32).sqrt();
        let rim = (outwards.length() / reach).min(1.0);
        let length =
            self.length * (1.0 - self.dome * rim * rim) * (1.0 + self.length_variation * random.signed());
        let lean = self.splay.to_radians() * rim;
        let azimuth = outwards.y.atan2(outwards.x) + 0.5 * random.signed();
        let wander = 0.15 * random.signed();
        let shade = 1.0 + self.color_variation * random.signed();
        // It leaves the ground leaning and straightens up a little.
        let along = heading(azimuth, (lean + wander).abs());
        let root = root.extend(0.0);
        let stem = arc(root, along, Vec3::Z, 0.5 * lean, length, STEM);
        let turn = TAU * random.unit();
        let color = |x: f32| self.base_color.lerp(self.tip_color, x) * shade;
        tube(&mut shoot, &stem, SIDES, turn, |x| self.stem_radius * (1.0 - 0.6 * x), |x| color(0.3 * x));
        for k in 0..self.leaves {
            // 0 for the lowest leaf, 1 for the one at the tip. They crowd towards the tip.
            let age = (k as f32 + 0.5) / self.leaves as f32;
            let place = self.bare + (1.0 - self.bare) * (1.0 - (1.0 - age).powf(1.5));
            let (base, axis) = at(&stem, place);
            let out = around(axis, turn + GOLDEN * k as f32 + 0.3 * random.signed());
            let angle =
                self.leaf_angle.to_radians() * (1.0 - 0.75 * age * age) * (1.0 + 0.12 * random.signed());
            let along = turned(axis, out, angle);
            let size = self.leaf_length * (1.0 - 0.5 * age.powi(4)) * (1.0 + 0.2 * random.signed());
            let leaf = Blade {
                base,
                along,
                normal: turned(along, axis, TAU / 4.0),
                length: size,
                droop: self.leaf_droop.to_radians(),
                fold: 0.35,
                segments: LEAF,
            };
            // Broadest near its base, then drawn out to a point.
            let half_width = |x: f32| size * self.leaf_width * 0.5 * outline(x);
            leaf.grow(&mut shoot, half_width, |x| color(age * (0.75 + 0.25 * x)));
        }
        if random.unit() < self.capsules {
            self.capsule(at(&stem, 1.0).0, random, &mut shoot);
        }
        plant(geometry, shoot, root);
    }

    /// A stalk from the tip of a shoot almost to the texel's top, its nodding end swollen.
    fn capsule(&self, tip: Vec3, random: &mut Random, geometry: &mut Geometry) {
        let length = (0.97 - tip.z) * (0.75 + 0.25 * random.unit());
        let along = heading(TAU * random.unit(), 0.12 * random.unit());
        let mut stalk = arc(tip, along, Vec3::Z, 0.0, 0.8 * length, CAPSULE / 2);
        let (end, _) = at(&stalk, 1.0);
        let over = Vec2::from_angle(TAU * random.unit()).extend(-0.3);
        stalk.extend(arc(end, along, over, 1.3, 0.22 * length, CAPSULE / 2).into_iter().skip(1));
        let thin = 0.6 * self.stem_radius;
        let radius = move |x: f32| {
            let inside = ((x - 0.6) / 0.4).clamp(0.0, 1.0);
            thin + 3.2 * thin * (inside * (1.0 - inside) * 4.0).sqrt() * (1.0 - 0.3 * inside)
        };
        tube(geometry, &stalk, SIDES + 1, TAU * random.unit(), radius, |x| {
            self.capsule_color * (0.6 + 0.6 * x)
        });
    }
}

/// Half-width over half the width of a leaf that is broadest at a third of its length; none at its ends.
fn outline(x: f32) -> f32 {
    // √x (1 − x) is greatest, 2/√27, at ⅓.
    2.598_076 * x.max(0.0).sqrt() * (1.0 - x).max(0.0)
}

impl Default for Moss {
    fn default() -> Self {
        Self::cushion()
    }
}

impl Procedure for Moss {
    fn name(&self) -> &'static str {
        "moss"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        let leaf = Blade::triangles(LEAF, true, true, true);
        let shoot = 2 * STEM * SIDES + self.leaves * leaf + 2 * CAPSULE * (SIDES + 1);
        at_most_triangles(u64::from(self.shoots) * u64::from(shoot))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        elements(geometry, self.shoots, self.variant, self.shoots(), own.shoots())
    }
}
