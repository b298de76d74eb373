//! A sheet: one plane across the texel, the simplest solid content, whose coverage and normal are known.

use glam::{Vec2, Vec3};

use super::domain::{SLOPE, UNIT};
use crate::{BuildError, Geometry, Procedure};

/// A plane at w = `height` + `slope` · (s − ½, t − ½). What lies above or below the texel is cut off; a sloping sheet
/// has a step between one tile and the next.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Sheet {
    /// w in the middle of the tile, 0 to 1.
    pub height: f32,
    /// Change of w per unit of s and of t, each −10 to 10.
    pub slope: Vec2,
    /// Linear albedo.
    pub color: Vec3,
    /// Specular albedo, 0 to 1.
    pub specular: f32,
    /// Roughness of the highlight, 0 to 1.
    pub roughness: f32,
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
        UNIT.check("height", self.height)?;
        SLOPE.check_each("slope", self.slope.as_ref())?;
        UNIT.check_each("color", self.color.as_ref())?;
        UNIT.check("specular", self.specular)?;
        UNIT.check("roughness", self.roughness)
    }

    fn geometry(&self) -> Geometry {
        let corner = |p: Vec2| p.extend(self.height + self.slope.dot(p - 0.5));
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        geometry.push_quad([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(corner), self.color);
        geometry
    }
}
