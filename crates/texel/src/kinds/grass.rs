//! Grass: blades that stand on the surface and bend over.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::blade::Blade;
use super::clumps::Clumps;
use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use super::variant::{elements, seed_of};
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Blades that stand on the surface and bend over.
    pub struct Grass {
        /// Which of the many lawns with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Blades in a copy.
        count: u32 in 1..=1_000_000 ["blades"],
        /// Length of a blade, along it; tips stay below the texel's top.
        length: f32 in 0..=1 ["texel edges"],
        /// Relative variation of the length.
        length_variation: f32 in 0..=1,
        /// Width of a blade at its root.
        width: f32 in 0..=0.5 ["texel edges"],
        /// Relative variation of the width.
        width_variation: f32 in 0..=1,
        /// Part of the width that is lost at the tip; narrowing begins slowly.
        taper: f32 in 0..=1,
        /// Mean angle between a blade's tip and the upright; blades bend from none to twice that.
        bend: f32 in 0..=85 ["degrees"],
        /// How far each half of a blade is folded up along its middle; 0 for flat blades, of half as many triangles.
        fold: f32 in 0..=80 ["degrees"],
        /// How far blades gather in tufts: at 1 all of a tuft grow from one place.
        clump: f32 in 0..=1,
        /// Blades in a tuft.
        clump_size: u32 in 1..=10_000 ["blades"],
        /// Colour at the root.
        root_color: Vec3 in 0..=1,
        /// Colour at the tip.
        tip_color: Vec3 in 0..=1,
        /// Another colour at the tip: those of the blades are spread between the two.
        other_tip_color: Vec3 in 0..=1,
        /// Relative variation of brightness between blades.
        color_variation: f32 in 0..=1,
        /// Fraction of the blades that are dry.
        dry: f32 in 0..=1,
        /// Colour of a dry blade, all along it.
        dry_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
        /// Straight pieces of a blade.
        segments: u32 in 1..=32 ["pieces"],
    }
}

impl Grass {
    /// Tall and loose, some of it dry.
    pub fn meadow() -> Self {
        Self {
            seed: 1,
            variant: 0,
            count: 200,
            length: 0.88,
            length_variation: 0.25,
            width: 0.035,
            width_variation: 0.0,
            taper: 0.9,
            bend: 26.0,
            fold: 0.0,
            clump: 0.0,
            clump_size: 12,
            root_color: Vec3::new(0.06, 0.1, 0.02),
            tip_color: Vec3::new(0.28, 0.42, 0.09),
            other_tip_color: Vec3::new(0.28, 0.42, 0.09),
            color_variation: 0.3,
            dry: 0.1,
            dry_color: Vec3::new(0.5, 0.4, 0.18),
            specular: 0.04,
            roughness: 0.5,
            segments: 4,
        }
    }

    /// Dense, even and green: as mown a while ago.
    pub fn lawn() -> Self {
        Self {
            count: 450,
            length: 0.7,
            length_variation: 0.15,
            width: 0.03,
            width_variation: 0.2,
            taper: 0.75,
            bend: 20.0,
            fold: 15.0,
            clump: 0.1,
            root_color: Vec3::new(0.05, 0.11, 0.02),
            tip_color: Vec3::new(0.2, 0.4, 0.07),
            other_tip_color: Vec3::new(0.26, 0.42, 0.06),
            color_variation: 0.2,
            dry: 0.02,
            ..Self::meadow()
        }
    }

    /// Long narrow blades in tufts that bend far over, with much dry grass between the green.
    pub fn tussock() -> Self {
        Self {
            count: 420,
            length: 0.98,
            length_variation: 0.3,
            width: 0.022,
            width_variation: 0.4,
            taper: 1.0,
            bend: 38.0,
            fold: 25.0,
            clump: 0.5,
            clump_size: 24,
            root_color: Vec3::new(0.09, 0.11, 0.025),
            tip_color: Vec3::new(0.22, 0.36, 0.07),
            other_tip_color: Vec3::new(0.42, 0.44, 0.11),
            color_variation: 0.25,
            dry: 0.22,
            dry_color: Vec3::new(0.58, 0.46, 0.22),
            segments: 6,
            ..Self::meadow()
        }
    }

    /// Grows blade after blade.
    fn blades(&self) -> impl Fn(u32, &mut Geometry) + '_ {
        let tufts = Clumps::new(self.count / self.clump_size.max(1), self.seed ^ 0x7af7);
        move |i, geometry| self.blade(i, &tufts, geometry)
    }

    fn blade(&self, i: u32, tufts: &Clumps, geometry: &mut Geometry) {
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.count, LOOSELY, random);
        let root = root.lerp(tufts.nearest(root).middle, self.clump).extend(0.0);
        let length = self.length * (1.0 + self.length_variation * random.signed());
        let ahead = Vec2::from_angle(TAU * random.unit());
        let bend = 2.0 * self.bend.to_radians() * random.unit();
        let dry = random.unit() < self.dry;
        let shade = 1.0 + self.color_variation * random.signed();
        let width = self.width * (1.0 + self.width_variation * random.signed());
        let tip_color = self.tip_color.lerp(self.other_tip_color, random.unit());
        let blade = Blade {
            base: root,
            along: Vec3::Z,
            // It bends over its flat side.
            normal: -ahead.extend(0.0),
            length: length.clamp(0.0, 0.98),
            droop: bend,
            fold: self.fold.to_radians(),
            segments: self.segments,
        };
        let half_width = |x: f32| 0.5 * width * (1.0 - self.taper * x * x);
        let color = |x: f32| if dry { self.dry_color } else { self.root_color.lerp(tip_color, x) } * shade;
        blade.grow(geometry, half_width, color);
    }
}

impl Default for Grass {
    fn default() -> Self {
        Self::meadow()
    }
}

impl Procedure for Grass {
    fn name(&self) -> &'static str {
        "grass"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        let triangles = Blade::triangles(self.segments, self.fold > 0.0, false, self.taper == 1.0);
        at_most_triangles(u64::from(self.count) * u64::from(triangles))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        elements(geometry, self.count, self.variant, self.blades(), own.blades())
    }
}
