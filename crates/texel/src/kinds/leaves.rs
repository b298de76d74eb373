//! Leaves: small flat diamonds that fill the texel, without twigs.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Small flat leaves in mid-air, without twigs.
    pub struct Leaves {
        /// Which of the many bushes with these settings.
        seed: u64,
        /// Leaves in a copy.
        count: u32 in 1..=1_000_000 ["leaves"],
        /// Length of a leaf from its stalk to its tip. None reaches out of the texel above or below.
        size: f32 in 0..=0.5 ["texel edges"],
        /// Relative variation of the size.
        size_variation: f32 in 0..=1,
        /// Width of a leaf over its length.
        aspect: f32 in 0..=2,
        /// How they are turned: 0 for all level, 1 for every direction alike. The cosine between a leaf's normal and
        /// the upright is evenly spread from 1 − `tilt` to 1.
        tilt: f32 in 0..=1,
        /// Colour of the leaves at one end of the range.
        color: Vec3 in 0..=1,
        /// Colour of those at the other end.
        other_color: Vec3 in 0..=1,
        /// Relative variation of brightness between leaves.
        color_variation: f32 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
    }
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
        let place = scattered(i, self.count, LOOSELY, random);
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
        check(&self.parameters())?;
        at_most_triangles(2 * u64::from(self.count))
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
