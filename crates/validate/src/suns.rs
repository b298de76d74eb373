//! The light that a scene is validated under.

use std::f32::consts::PI;

use glam::{Quat, Vec3};
use pelage::output::Display;
use pelage::staging;
use pelage::tracer::reference::Lighting;
use pelage::tracer::{Environment, Light, Scene};

use crate::sight::Sight;

/// Which light a scene is validated under.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Lights {
    /// A sun from the side, one from near the view and one from behind, one at a time, with hard shadows and no sky.
    #[default]
    Standard,
    /// The scene's own.
    Scene,
}

/// One light situation.
#[derive(Clone, Debug)]
pub(crate) struct Situation {
    pub name: &'static str,
    pub lighting: Lighting,
    /// The place of another situation, whose energy the error is measured in if its own is smaller.
    pub judged_by: Option<usize>,
}

/// Height of the suns at the side and behind, above the surface.
const ELEVATION: f32 = 30.0 / 180.0 * PI;

/// Angle between the sun near the view and the view.
const NEAR_VIEW: f32 = 13.0 / 180.0 * PI;

impl Lights {
    /// The situations, in the order of the tables.
    pub(crate) fn situations(self, scene: &Scene, sight: &Sight, up: Vec3) -> Vec<Situation> {
        if self == Self::Scene {
            return vec![Situation { name: "scene", lighting: scene.lighting(), judged_by: None }];
        }
        let [side, near, behind] = suns(sight.normal, -sight.direction, up);
        vec![
            Situation { name: "side", lighting: sun(side), judged_by: None },
            Situation { name: "near view", lighting: sun(near), judged_by: None },
            // Its own energy is tiny where what grows is dense.
            Situation { name: "behind", lighting: sun(behind), judged_by: Some(0) },
        ]
    }

    /// How the pictures are shown: as the command line shows them, by their light.
    pub(crate) fn display(self, own: &Display, situations: &[Situation], target: Vec3) -> Display {
        match (self, situations) {
            (Self::Standard, [first, ..]) => {
                let Lighting { lights, environment } = &first.lighting;
                Display { exposure: staging::exposure(lights, environment, target), ..*own }
            }
            _ => *own,
        }
    }
}

/// π lux: a white surface that faces it has radiance 1.
fn sun(towards: Vec3) -> Lighting {
    let light = Light::Directional { direction: -towards, illuminance: Vec3::splat(PI), angle: 0.0 };
    Lighting { lights: vec![light], environment: Environment::BLACK }
}

/// Unit vectors to the suns at the side, near the view and behind, for a surface with the unit vectors `normal` out of
/// it and `view` to the eye.
///
/// Behind means across the surface from the eye, and above the surface: under it would be no light.
fn suns(normal: Vec3, view: Vec3, up: Vec3) -> [Vec3; 3] {
    let flat = (view - view.dot(normal) * normal)
        .try_normalize()
        .filter(|_| view.dot(normal).abs() < 0.9999)
        .or_else(|| (-(up - up.dot(normal) * normal)).try_normalize())
        .unwrap_or_else(|| normal.any_orthonormal_vector());
    let raised = |horizontal: Vec3| ELEVATION.cos() * horizontal + ELEVATION.sin() * normal;
    let about = normal.cross(flat);
    // Turned up from the view, so that it stays above the surface; past the top it goes on to the other side.
    let near = Quat::from_axis_angle(-about, NEAR_VIEW) * view;
    [raised(about), near, raised(-flat)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_suns_above_the_surface() {
        let normal = Vec3::Y;
        for elevation in [5.0_f32, 40.0, 80.0, 90.0] {
            let e = elevation.to_radians();
            let view = Vec3::new(0.0, e.sin(), e.cos());
            let [side, near, behind] = suns(normal, view, Vec3::NEG_Z);
            for sun in [side, near, behind] {
                assert!((sun.length() - 1.0).abs() < 1e-5 && sun.y > 0.05, "{elevation}: {sun}");
            }
            assert!((near.angle_between(view) - NEAR_VIEW).abs() < 1e-3, "{near}");
            // The side is at right angles to the plane of view and normal; behind is across from the eye.
            assert!(side.dot(view) - ELEVATION.sin() * e.sin() < 1e-5 && side.x.abs() > 0.8);
            assert!(behind.z < -0.8 && behind.x.abs() < 1e-5);
        }
    }
}
