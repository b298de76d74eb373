//! Leaves: small flat diamonds that fill the texel, without twigs.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::domain::{COUNT, Domain, RADIUS, UNIT, at_most_triangles};
use super::scatter::scattered;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

/// Leaves over one tile. Lengths are in texel edges: the tile is 1 wide, the texel 1 high.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Leaves {
    /// Which of the many bushes with these settings.
    pub seed: u64,
    /// Leaves in the tile, 1 to 10⁶.
    pub count: u32,
    /// Length of a leaf from its stalk to its tip, 0 to ½. None reaches out of the texel above or below.
    pub size: f32,
    /// Relative variation of the size, 0 to 1.
    pub size_variation: f32,
    /// Width of a leaf over its length, 0 to 2.
    pub aspect: f32,
    /// How they are turned, 0 to 1: 0 for all level, 1 for every direction alike. The cosine between a leaf's normal
    /// and the upright is evenly spread from 1 − `tilt` to 1.
    pub tilt: f32,
    /// Linear albedo of the leaves at one end of the range of hues.
    pub color: Vec3,
    /// Linear albedo of those at the other end.
    pub other_color: Vec3,
    /// Relative variation of brightness between leaves, 0 to 1.
    pub color_variation: f32,
    /// Specular albedo, 0 to 1.
    pub specular: f32,
    /// Roughness of the highlight, 0 to 1.
    pub roughness: f32,
}

impl Leaves {
    /// A hedge in early summer.
    pub fn green() -> Self {
        Self {
            seed: 1,
            count: 300,
            size: 0.2,
            size_variation: 0.25,
            aspect: 0.55,
            tilt: 0.8,
            color: Vec3::new(0.07, 0.2, 0.035),
            other_color: Vec3::new(0.25, 0.4, 0.07),
            color_variation: 0.2,
            specular: 0.05,
            roughness: 0.4,
        }
    }

    fn leaf(&self, i: u32, geometry: &mut Geometry) {
        let random = &mut Random::new(self.seed, i.into());
        let place = scattered(i, self.count, random);
        let size = (self.size * (1.0 + self.size_variation * random.signed())).min(1.0);
        let z = 1.0 - self.tilt * random.unit();
        let normal = (Vec2::from_angle(TAU * random.unit()) * (1.0 - z * z).max(0.0).sqrt()).extend(z);
        let (right, up) = normal.any_orthonormal_pair();
        let turn = Vec2::from_angle(TAU * random.unit());
        let along = (right * turn.x + up * turn.y) * size;
        let across = normal.cross(along) * (0.5 * self.aspect);
        // From the stalk: the widest place is nearer to it than to the tip.
        let corners = [Vec3::ZERO, 0.4 * along + across, along, 0.4 * along - across];
        let [low, high] = [f32::min, f32::max].map(|pick| corners.iter().map(|p| p.z).fold(0.0, pick));
        let height = -low + (1.0 - (high - low)).max(0.0) * random.unit();
        let stalk = (place - (0.5 * along).truncate()).extend(height);
        let color = self.color.lerp(self.other_color, random.unit());
        let color = color * (1.0 + self.color_variation * random.signed());
        geometry.push_quad(corners.map(|p| stalk + p), color.clamp(Vec3::ZERO, Vec3::ONE));
    }
}

impl Default for Leaves {
    fn default() -> Self {
        Self::green()
    }
}

impl Procedure for Leaves {
    fn name(&self) -> &'static str {
        "leaves"
    }

    fn validate(&self) -> Result<(), BuildError> {
        COUNT.check("count", self.count)?;
        RADIUS.check("size", self.size)?;
        UNIT.check("size_variation", self.size_variation)?;
        Domain::new(0.0, 2.0, "0 to 2").check("aspect", self.aspect)?;
        UNIT.check("tilt", self.tilt)?;
        UNIT.check_each("color", self.color.as_ref())?;
        UNIT.check_each("other_color", self.other_color.as_ref())?;
        UNIT.check("color_variation", self.color_variation)?;
        UNIT.check("specular", self.specular)?;
        UNIT.check("roughness", self.roughness)?;
        at_most_triangles(self.count, 2)
    }

    fn geometry(&self) -> Geometry {
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        for i in 0..self.count {
            self.leaf(i, &mut geometry);
        }
        geometry
    }
}
