//! A sheet: one plane across the texel, the simplest solid content, whose coverage and normal are known.

use glam::{Vec2, Vec3};

use super::parameter::{check, parameters};
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// A plane at w = `height` + `slope` · (s − ½, t − ½). What lies above or below the texel is cut off; a sloping sheet
    /// has a step between one tile and the next.
    pub struct Sheet {
        /// w in the middle of the tile.
        height: f32 in 0..=1 ["texel edges"],
        /// Change of w per unit of s and of t.
        slope: Vec2 in -10..=10 ["texel edges a texel edge"],
        /// Its colour.
        color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
    }
}

impl Sheet {
    /// Rising along s like the slates of a roof.
    pub fn tilted() -> Self {
        Self {
            height: 0.5,
            slope: Vec2::new(0.35, 0.0),
            color: Vec3::new(0.5, 0.42, 0.36),
            specular: 0.0,
            roughness: 1.0,
        }
    }
}

impl Default for Sheet {
    fn default() -> Self {
        Self::tilted()
    }
}

impl Procedure for Sheet {
    fn name(&self) -> &'static str {
        "sheet"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())
    }

    fn geometry(&self) -> Geometry {
        let corner = |p: Vec2| p.extend(self.height + self.slope.dot(p - 0.5));
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        geometry.push_quad([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(corner), self.color);
        geometry
    }
}
