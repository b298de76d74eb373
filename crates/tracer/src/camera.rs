//! A pinhole camera, and the cone of each of its pixels. [seed §4.2]

use glam::{Mat3, Vec2, Vec3};
use pelage_geom::{Cone, Ray};

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is, in scene units.
    pub position: Vec3,
    /// Columns: right, up, and backwards (the camera looks along the negative third axis, as in glTF).
    pub orientation: Mat3,
    /// Full vertical angle of view, in radians, in (0, π).
    pub vertical_fov: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, `up` upwards in the picture as far as possible.
    ///
    /// Where `eye` is `target`, it looks along −Z; where `up` is along the view, another axis stands in for it.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, vertical_fov: f32) -> Self {
        let back = (eye - target).normalize_or(Vec3::Z);
        let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
        Self { position: eye, orientation: Mat3::from_cols(right, back.cross(right), back), vertical_fov }
    }

    /// A camera that sees the whole of the box `[lo, hi]`, looking along `direction`, in a picture whose width is
    /// `aspect` times its height.
    pub fn framing([lo, hi]: [Vec3; 2], direction: Vec3, vertical_fov: f32, aspect: f32) -> Self {
        let centre = 0.5 * (lo + hi);
        let radius = (0.5 * (hi - lo).length()).max(f32::MIN_POSITIVE);
        let narrow = (0.5 * vertical_fov).tan() * aspect.min(1.0);
        // The sphere around the box touches the pyramid of view: its sine, not its tangent.
        let distance = radius / (narrow / (1.0 + narrow * narrow).sqrt());
        let back = -direction.normalize_or(-Vec3::Z);
        Self::look_at(centre + distance * back, centre, Vec3::Y, vertical_fov)
    }

    /// The direction in which the camera looks.
    pub fn forward(&self) -> Vec3 {
        -self.orientation.z_axis
    }

    /// The ray through the point `pixel` of a picture of `size` pixels (x to the right, y downwards, pixel centres
    /// at half integers), and the cone of one pixel around it.
    pub fn cone(&self, pixel: Vec2, size: [u32; 2]) -> (Ray, Cone) {
        let rows = size[1] as f32;
        let scale = 2.0 * (0.5 * self.vertical_fov).tan() / rows;
        let x = (pixel.x - 0.5 * size[0] as f32) * scale;
        let y = (0.5 * rows - pixel.y) * scale;
        let direction = (self.orientation * Vec3::new(x, y, -1.0)).as_dvec3().normalize();
        let cosine = direction.dot(self.forward().as_dvec3());
        // A pixel is `scale` wide at depth 1, and the point at distance d lies at depth d cos.
        (
            Ray { origin: self.position.as_dvec3(), direction },
            Cone { width: 0.0, spread: f64::from(scale) * cosine },
        )
    }
}
