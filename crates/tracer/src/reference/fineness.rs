//! How finely curved content is cut into flat triangles.

use glam::{DVec3, Vec3};

use crate::Camera;

/// How far a flat triangle may be from the curved one that it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fineness {
    /// A part of a pixel, where the box is nearest to the eye.
    Pixels {
        /// Where the eye is, in scene units.
        eye: DVec3,
        /// What is allowed at distance 1, in scene units.
        at_one: f64,
    },
    /// A length in scene units.
    Length(f64),
    /// A part of the height of each box.
    OfHeight(f64),
}

impl Fineness {
    /// `part` of a pixel of a picture of `rows` rows.
    pub(super) fn of_pixel(camera: &Camera, rows: u32, part: f64) -> Self {
        let pixel = 2.0 * (0.5 * f64::from(camera.vertical_fov)).tan() / f64::from(rows);
        Self::Pixels { eye: camera.position.as_dvec3(), at_one: part * pixel }
    }

    /// The length allowed in a box with these bounds and this height, in scene units.
    pub(super) fn tolerance(self, bounds: [Vec3; 2], height: f64) -> f64 {
        match self {
            Self::Pixels { eye, at_one } => {
                let [lo, hi] = bounds.map(|p| p.as_dvec3());
                // At this distance a pixel is narrowest in the middle of the picture, and no narrower anywhere.
                at_one * eye.distance(eye.clamp(lo, hi))
            }
            Self::Length(length) => length,
            Self::OfHeight(part) => part * height,
        }
    }
}
