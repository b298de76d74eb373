//! Grass: flat tapered blades that stand on the surface and bend over.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::domain::{COUNT, Domain, RADIUS, SEGMENTS, UNIT, at_most_triangles};
use super::scatter::scattered;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

/// Grass over one tile. Lengths are in texel edges: the tile is 1 wide, the texel 1 high.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Grass {
    /// Which of the many lawns with these settings.
    pub seed: u64,
    /// Blades in the tile, 1 to 10⁶.
    pub count: u32,
    /// Length of a blade, along it, 0 to 1; tips stay below the texel's top.
    pub length: f32,
    /// Relative variation of the length, 0 to 1.
    pub length_variation: f32,
    /// Width at the root, 0 to ½.
    pub width: f32,
    /// Part of the width that is lost at the tip, 0 to 1; narrowing begins slowly.
    pub taper: f32,
    /// Mean angle between a blade's tip and the upright in radians, 0 to 1.5; blades bend from none to twice that.
    pub bend: f32,
    /// Linear albedo at the root.
    pub root_color: Vec3,
    /// Linear albedo at the tip.
    pub tip_color: Vec3,
    /// Relative variation of brightness between blades, 0 to 1.
    pub color_variation: f32,
    /// Fraction of the blades that are dry, 0 to 1.
    pub dry: f32,
    /// Linear albedo of a dry blade, all along it.
    pub dry_color: Vec3,
    /// Specular albedo, 0 to 1.
    pub specular: f32,
    /// Roughness of the highlight, 0 to 1.
    pub roughness: f32,
    /// Straight pieces a blade, 1 to 32, of two triangles each.
    pub segments: u32,
}

impl Grass {
    /// Tall and loose, some of it dry.
    pub fn meadow() -> Self {
        Self {
            seed: 1,
            count: 200,
            length: 0.88,
            length_variation: 0.25,
            width: 0.035,
            taper: 0.9,
            bend: 0.45,
            root_color: Vec3::new(0.06, 0.1, 0.02),
            tip_color: Vec3::new(0.28, 0.42, 0.09),
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
            taper: 0.75,
            bend: 0.35,
            root_color: Vec3::new(0.05, 0.11, 0.02),
            tip_color: Vec3::new(0.2, 0.4, 0.07),
            color_variation: 0.2,
            dry: 0.02,
            ..Self::meadow()
        }
    }

    fn blade(&self, i: u32, geometry: &mut Geometry) {
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.count, random).extend(0.0);
        let length = self.length * (1.0 + self.length_variation * random.signed());
        let length = length.clamp(0.0, 0.98);
        // It bends over its flat side.
        let ahead = Vec2::from_angle(TAU * random.unit());
        let across = ahead.perp().extend(0.0) * (0.5 * self.width);
        let bend = 2.0 * self.bend * random.unit();
        let dry = random.unit() < self.dry;
        let shade = 1.0 + self.color_variation * random.signed();
        let segments = self.segments as f32;
        let half_width = |x: f32| across * (1.0 - self.taper * x * x);
        let mut below = root;
        for k in 0..self.segments {
            let [from, middle, to] = [0.0, 0.5, 1.0].map(|part| (k as f32 + part) / segments);
            // An arc: the angle grows evenly along it.
            let (sine, cosine) = (bend * middle).sin_cos();
            let above = below + (ahead * sine).extend(cosine) * (length / segments);
            let color =
                if dry { self.dry_color } else { self.root_color.lerp(self.tip_color, middle) } * shade;
            let [wide, narrow] = [half_width(from), half_width(to)];
            let quad = [below - wide, below + wide, above + narrow, above - narrow];
            geometry.push_quad(quad, color.clamp(Vec3::ZERO, Vec3::ONE));
            below = above;
        }
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
        COUNT.check("count", self.count)?;
        UNIT.check("length", self.length)?;
        UNIT.check("length_variation", self.length_variation)?;
        RADIUS.check("width", self.width)?;
        UNIT.check("taper", self.taper)?;
        Domain::new(0.0, 1.5, "0 to 1.5").check("bend", self.bend)?;
        UNIT.check_each("root_color", self.root_color.as_ref())?;
        UNIT.check_each("tip_color", self.tip_color.as_ref())?;
        UNIT.check("color_variation", self.color_variation)?;
        UNIT.check("dry", self.dry)?;
        UNIT.check_each("dry_color", self.dry_color.as_ref())?;
        UNIT.check("specular", self.specular)?;
        UNIT.check("roughness", self.roughness)?;
        SEGMENTS.check("segments", self.segments)?;
        at_most_triangles(self.count, 2 * self.segments)
    }

    fn geometry(&self) -> Geometry {
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        for i in 0..self.count {
            self.blade(i, &mut geometry);
        }
        geometry
    }
}
