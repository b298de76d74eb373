//! A clipped ball of leaves on a trunk, in a pot.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};

use super::super::part::{Obj, Part, bumps};
use super::{Scene, View, ground};

/// The scene.
pub fn scene() -> Scene {
    let mut obj = Obj::new("materials.mtl");
    let crown = |d: Vec3| vec3(0.0, 0.98, 0.0) + d * 0.3 * (1.0 + 0.05 * bumps(d, 2.0));
    obj.add(&Part::ball("Crown", 4, crown), "Soil");
    let turned = |name, profile: &'static [(f32, f32)]| {
        Part::tube(name, [32, profile.len() - 1], false, |around, along| {
            let (radius, height) = profile[(along * (profile.len() - 1) as f32).round() as usize];
            let (sine, cosine) = (TAU * around).sin_cos();
            vec3(radius * sine, height, radius * cosine)
        })
    };
    let trunk = turned("Trunk", &[(0.045, 0.3), (0.034, 0.4), (0.03, 0.6), (0.034, 0.75)]);
    obj.add(&trunk.smooth(), "Bark");
    let pot = &[(0.0, 0.0), (0.15, 0.0), (0.2, 0.29), (0.2, 0.3)];
    obj.add(&turned("Pot", pot), "Terracotta");
    let rim = &[(0.2, 0.29), (0.225, 0.29), (0.23, 0.36), (0.2, 0.36), (0.19, 0.32)];
    obj.add(&turned("Rim", rim), "Terracotta");
    obj.add(&turned("Earth", &[(0.2, 0.325), (0.0, 0.335)]), "Soil");
    obj.add(&ground(8.0), "Floor");
    Scene {
        name: "foliage",
        obj: obj.text,
        cage: None,
        text: r##"
[[skin]]
on = "Crown"
wears_material = false
height = 0.13
aspect = 1.3
texel.foliage = { preset = "shrub" }
variety = { turns = true, mirrors = true, height = 0.15, color = 0.1 }

[[light]]
directional = { direction = [0.6, -0.75, -0.5], illuminance = [3.4, 3.1, 2.6], angle = 0.53 }

[environment]
sky = [0.6, 0.74, 0.92]
ground = [0.36, 0.33, 0.28]

[render]
size = [480, 360]
background = "#dbe3e4"
"##,
        near: View { eye: vec3(0.25, 1.25, 1.3), target: vec3(0.0, 1.07, 0.2), fov: 26.0 },
        far: View { eye: vec3(0.6, 1.2, 3.6), target: vec3(0.0, 0.7, 0.0), fov: 25.0 },
    }
}
