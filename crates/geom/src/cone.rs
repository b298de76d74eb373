//! Rays with an aperture, and how wide they are in a texel's own coordinates. \[Amanatides84\] [seed §4.2]

use glam::{Mat3, Vec3};

/// A ray's aperture: its width grows linearly with the distance `t` along it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// The width at `t` = 0, in scene units.
    pub width: f64,
    /// What the width gains by unit of distance.
    pub spread: f64,
}

impl Cone {
    /// The cone of one pixel of a pinhole camera: 2 tan(θ/2)/H · (D·a) by unit of distance, for a vertical field
    /// of view θ in radians, H `rows`, and `cosine` = D·a between the ray and the camera's axis. [seed §4.2]
    pub fn pixel(vertical_fov: f64, rows: u32, cosine: f64) -> Self {
        Self { width: 0.0, spread: 2.0 * (0.5 * vertical_fov).tan() / f64::from(rows.max(1)) * cosine }
    }

    /// The width across the ray at distance `t`, in scene units; never negative.
    #[inline]
    pub fn width(&self, t: f64) -> f64 {
        (self.width + self.spread * t).max(0.0)
    }
}

/// How a cone's width in the scene becomes a width in the texel, where the box is not a cube. [seed §4.2]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Footprint {
    /// The cone's local cross-section: the side of the square of its area.
    #[default]
    Auto,
    /// By the longest side of the box: crisp, with some aliasing.
    Sharp,
    /// By the shortest side of the box: a slight blur.
    Smooth,
}

/// The width of a cone in texel units, for the `jacobian` (texel to scene) where it has `width` scene units across
/// the unit vector `direction`.
///
/// A length of beam of cross-section A along D has in texel space the volume A/|det J| and the length |J⁻¹D|:
/// [`Footprint::Auto`] is width / √(|det J| |J⁻¹D|) = width / √|adj(J) D|, which takes no inverse. Infinite where
/// the box is flat in the way that counts.
#[inline]
pub fn texel_footprint(rule: Footprint, jacobian: &Mat3, direction: Vec3, width: f32) -> f32 {
    let [u, v, w] = [jacobian.x_axis, jacobian.y_axis, jacobian.z_axis];
    let side = match rule {
        Footprint::Auto => {
            let along =
                Vec3::new(v.cross(w).dot(direction), w.cross(u).dot(direction), u.cross(v).dot(direction));
            along.length().sqrt()
        }
        Footprint::Sharp => u.length_squared().max(v.length_squared()).max(w.length_squared()).sqrt(),
        Footprint::Smooth => u.length_squared().min(v.length_squared()).min(w.length_squared()).sqrt(),
    };
    if side > 0.0 { width / side } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_its_share_of_the_picture() {
        // 90° of view: at depth 1 the picture is 2 tall, so each of 100 rows is 0.02.
        let cone = Cone::pixel(core::f64::consts::FRAC_PI_2, 100, 1.0);
        assert!((cone.width(1.0) - 0.02).abs() < 1e-15 && (cone.width(50.0) - 1.0).abs() < 1e-13);
        // A ray at 60° to the axis is at depth ½ after a distance of 1.
        let aside = Cone::pixel(core::f64::consts::FRAC_PI_2, 100, 0.5);
        assert!((aside.width(1.0) - 0.01).abs() < 1e-15);
        assert_eq!(Cone { width: 1.0, spread: -2.0 }.width(3.0), 0.0);
    }

    #[test]
    fn rules_of_a_box_that_is_not_a_cube() {
        let j = Mat3::from_diagonal(Vec3::new(2.0, 8.0, 1.0));
        assert_eq!(texel_footprint(Footprint::Sharp, &j, Vec3::Z, 4.0), 0.5);
        assert_eq!(texel_footprint(Footprint::Smooth, &j, Vec3::Z, 4.0), 4.0);
        // Along z the cross-section is divided by 2 and by 8: the square root of 1/16.
        assert_eq!(texel_footprint(Footprint::Auto, &j, Vec3::Z, 4.0), 1.0);
        let flat = Mat3::from_diagonal(Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(texel_footprint(Footprint::Auto, &flat, Vec3::Z, 1.0), f32::INFINITY);
    }

    #[test]
    fn auto_is_the_beam_s_cross_section() {
        // A sheared box: the beam's outline in texel space, projected along its own direction there.
        let j =
            Mat3::from_cols(Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.7, 2.0, 0.1), Vec3::new(-0.4, 0.9, 0.5));
        let direction = Vec3::new(0.3, -0.5, 0.8).normalize();
        let (x, y) = direction.any_orthonormal_pair();
        let inverse = j.inverse();
        let along = (inverse * direction).normalize();
        let across = |p: Vec3| inverse * p - along * along.dot(inverse * p);
        let area = across(x).cross(across(y)).length();
        let footprint = texel_footprint(Footprint::Auto, &j, direction, 1.0);
        assert!((footprint - area.sqrt()).abs() < 1e-5 * footprint, "{footprint} {}", area.sqrt());
    }
}
