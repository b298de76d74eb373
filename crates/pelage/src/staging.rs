//! Camera, light and exposure where a scene does not bring its own.

use std::f32::consts::PI;

use glam::{Vec3, vec3};
use pelage_tracer::{Camera, Environment, Light};

/// From where a scene is looked at when it has no camera.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct View {
    /// Degrees around the vertical: 0 from the front (+Z), 90 from the right (+X).
    pub azimuth: f32,
    /// Degrees above the horizon, within ±90.
    #[schemars(range(min = -90, max = 90))]
    pub elevation: f32,
    /// 1 fits everything in; 2 shows it twice as large.
    #[schemars(range(min = 0.001, max = 1e6))]
    pub zoom: f32,
    /// Vertical angle of view in degrees, within (0, 180).
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov: f32,
}

impl Default for View {
    /// Three quarters from the front, slightly from above.
    fn default() -> Self {
        Self { azimuth: 30.0, elevation: 18.0, zoom: 1.0, fov: 30.0 }
    }
}

/// A camera that sees the box `bounds` as `view` says, in a picture whose width is `aspect` times its height.
///
/// It stands as near as it can with every corner of the box in the picture, a margin around.
pub fn camera(bounds: [Vec3; 2], view: &View, aspect: f32) -> Camera {
    const MARGIN: f32 = 1.06;
    let [lo, hi] = bounds;
    let centre = 0.5 * (lo + hi);
    let (azimuth, elevation) = (view.azimuth.to_radians(), view.elevation.clamp(-89.9, 89.9).to_radians());
    let back = vec3(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
    let vertical_fov = view.fov.to_radians();
    let [tan_x, tan_y] = [aspect, 1.0].map(|side| side * (0.5 * vertical_fov).tan() / MARGIN);
    let axes = Camera::look_at(centre + back, centre, Vec3::Y, vertical_fov).orientation;
    let corners = (0..8).map(|i| {
        let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 0 { lo } else { hi };
        axes.transpose() * (vec3(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z)) - centre)
    });
    // A corner at (x, y, z) is in the picture from the distance z + max(|x| / tan_x, |y| / tan_y) on.
    let distance = corners
        .map(|c| c.z + (c.x.abs() / tan_x).max(c.y.abs() / tan_y))
        .fold(0.0, f32::max)
        .max(1e-3 * (hi - lo).length())
        .max(f32::MIN_POSITIVE);
    // Zooming narrows the view rather than walking into the fur.
    let narrowed = 2.0 * ((0.5 * vertical_fov).tan() / view.zoom.max(1e-3)).atan();
    Camera::look_at(centre + distance * back, centre, Vec3::Y, narrowed)
}

/// A warm afternoon sun from the upper front left, π lux or so: a matt white surface facing it has radiance 1.
pub fn sun() -> Light {
    Light::Directional {
        direction: vec3(0.55, -0.8, -0.5),
        illuminance: PI * vec3(1.0, 0.95, 0.85),
        angle: 0.53_f32.to_radians(),
    }
}

/// A pale blue sky over brown ground, bright enough to show fur in its own shadow.
pub fn sky() -> Environment {
    Environment { sky: vec3(0.6, 0.75, 0.95), ground: vec3(0.35, 0.3, 0.24) }
}

/// What a matt white surface in full light is exposed to: over 1, because a coat lies half in its own shadow; the
/// filmic curve brings it back to 92 % of a screen's white.
pub(crate) const WHITE: f32 = 1.6;

/// The exposure at which a matt white surface at `centre`, turned to each light in turn and to the sky, comes to 1.6.
///
/// Only the lights decide, never the pixels: a crop is exposed as the whole is. Without any light it is 1.
pub fn exposure(lights: &[Light], environment: &Environment, centre: Vec3) -> f32 {
    let luminance = |color: Vec3| color.dot(vec3(0.2126, 0.7152, 0.0722));
    let direct: f32 = lights
        .iter()
        .filter_map(|light| light.incoming(centre))
        .map(|incoming| luminance(incoming.irradiance) / PI)
        .sum();
    let white = direct + luminance(environment.mean_radiance(Vec3::Y));
    let exposure = WHITE / white;
    if white > 0.0 && exposure.is_finite() { exposure } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn everything_is_in_the_picture_and_something_near_its_edge() {
        let bounds = [vec3(-3.0, 0.0, -1.0), vec3(2.0, 1.5, 4.0)];
        for (azimuth, elevation, aspect) in [(30.0, 18.0, 1.78), (-120.0, 60.0, 0.5), (0.0, 90.0, 1.0)] {
            let view = View { azimuth, elevation, ..View::default() };
            let camera = camera(bounds, &view, aspect);
            let tan = (0.5 * camera.vertical_fov).tan();
            let mut extreme = Vec2::ZERO;
            for i in 0..8 {
                let corner = vec3(bounds[i & 1].x, bounds[i >> 1 & 1].y, bounds[i >> 2].z);
                let p = camera.orientation.transpose() * (corner - camera.position);
                assert!(p.z < 0.0);
                extreme = extreme.max(Vec2::new(p.x / (aspect * tan), p.y / tan).abs() / -p.z);
            }
            // The tightest corner lies at the margin: 1 / 1.06 = 0.943 of half the picture.
            assert!((extreme.max_element() - 1.0 / 1.06).abs() < 1e-3, "{extreme}");
        }
    }

    #[test]
    fn a_white_surface_in_full_light_is_exposed_to_white() {
        // A lamp of 4π cd at 2 m gives π lux: radiance 1 from white. The sky adds 1.
        let lamp =
            Light::Point { position: vec3(0.0, 2.0, 0.0), intensity: Vec3::splat(4.0 * PI), radius: 0.0 };
        let exposure_of = |lights: &[Light], sky: f32| {
            exposure(lights, &Environment::uniform(Vec3::splat(sky)), Vec3::ZERO)
        };
        assert!((exposure_of(&[lamp], 0.0) - WHITE).abs() < 1e-6);
        assert!((exposure_of(&[lamp], 1.0) - 0.5 * WHITE).abs() < 1e-6);
        assert_eq!(exposure_of(&[], 0.0), 1.0);
    }
}
