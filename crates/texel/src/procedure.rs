//! Geometry to build texels from, and procedures that make it.

use glam::Vec3;

use crate::BuildError;

/// Triangles in texel coordinates (s, t, w): what [`build`](crate::build()) measures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Corners. Of periodic content they may leave `[0, 1]` in s and t, and wrap; outside `0..1` in w they are
    /// clipped. Orientation does not matter: triangles are seen from both sides.
    pub triangles: Vec<[Vec3; 3]>,
    /// One linear albedo a triangle.
    pub colors: Vec<Vec3>,
    /// Specular albedo of the material, 0 to 1.
    pub specular: f32,
    /// Roughness of its highlight, 0 to 1.
    pub roughness: f32,
}

impl Geometry {
    /// How far from the texel a corner may lie, in tiles: an f32 must still place it within a fine voxel.
    pub const REACH: f32 = 16.0;

    /// Adds a triangle.
    pub fn push(&mut self, triangle: [Vec3; 3], color: Vec3) {
        self.triangles.push(triangle);
        self.colors.push(color);
    }

    /// Adds a quad as two triangles; its corners follow each other around it.
    pub fn push_quad(&mut self, quad: [Vec3; 4], color: Vec3) {
        let [a, b, c, d] = quad;
        self.push([a, b, c], color);
        self.push([a, c, d], color);
    }

    /// Checks numbers and lengths.
    ///
    /// # Errors
    /// The first fault found, with its triangle.
    pub fn validate(&self) -> Result<(), BuildError> {
        let [triangles, colors] = [self.triangles.len(), self.colors.len()];
        if triangles != colors {
            return Err(BuildError::ColorCount { triangles, colors });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(corner) = corners.iter().position(|p| !p.is_finite()) {
                return Err(BuildError::NonFinite { triangle, corner });
            }
            if corners.iter().any(|p| p.abs().max_element() > Self::REACH) {
                return Err(BuildError::OutOfReach { triangle, reach: Self::REACH });
            }
        }
        let albedo = |c: &Vec3| c.cmpge(Vec3::ZERO).all() && c.cmple(Vec3::ONE).all();
        if let Some(triangle) = self.colors.iter().position(|c| !albedo(c)) {
            return Err(BuildError::Color { triangle });
        }
        for (field, value) in [("specular", self.specular), ("roughness", self.roughness)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(BuildError::Parameter { field, value: value.into(), domain: "[0, 1]" });
            }
        }
        Ok(())
    }
}

/// Something that makes a texel's content.
pub trait Procedure {
    /// What to call the texel.
    fn name(&self) -> &'static str;

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] for the first that is out of its domain.
    fn validate(&self) -> Result<(), BuildError>;

    /// The content; the same bits every time. What does not [`validate`](Self::validate) gives anything at all.
    fn geometry(&self) -> Geometry;
}
