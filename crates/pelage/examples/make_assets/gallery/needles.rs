//! A wreath with baubles on a wall.

use std::f32::consts::TAU;

use glam::{Mat3, Vec3, vec3};

use super::super::part::{Obj, Part, ellipsoid};
use super::{Scene, View};

/// The scene.
pub fn scene() -> Scene {
    let mut obj = Obj::new("materials.mtl");
    let ring = |radius: f32, thickness: f32| {
        move |around: f32, along: f32| {
            let (sine, cosine) = (TAU * along).sin_cos();
            let out = vec3(cosine, sine, 0.0);
            let (up, side) = (TAU * around).sin_cos();
            vec3(0.0, 0.7, 0.16) + out * (radius + thickness * side) - Vec3::Z * (thickness * up)
        }
    };
    obj.add(&Part::tube("Wreath", [5, 18], true, ring(0.42, 0.075)), "Bark");
    for k in 0..9 {
        let angle = TAU * (k as f32 + 0.3 * (2.4 * k as f32).sin()) / 9.0;
        let out = 0.42 + 0.06 * (5.1 * k as f32).sin();
        let at = vec3(out * angle.cos(), 0.7 + out * angle.sin(), 0.31 + 0.02 * (3.0 * k as f32).cos());
        let (size, material) = if k % 3 == 2 { (0.045, "Gold") } else { (0.058, "Bauble") };
        obj.add(&ellipsoid("Ball", 7, at, Vec3::splat(size), Mat3::IDENTITY).smooth(), material);
    }
    let wall = Part::sheet("Wall", [1, 1], |u, v| vec3((u - 0.5) * 8.0, (v - 0.5) * 8.0, 0.0));
    obj.add(&wall, "Wall");
    Scene {
        name: "needles",
        obj: obj.text,
        cage: None,
        text: r##"
[[skin]]
on = "Bark"
wears_material = false
height = 0.13
aspect = 1.25
texel.needles = { preset = "fir" }
variety = { turns = true, mirrors = true, height = 0.15, color = 0.1 }

[[light]]
directional = { direction = [0.55, -0.7, -0.75], illuminance = [3.2, 2.9, 2.5], angle = 2 }

[environment]
sky = [0.66, 0.72, 0.82]
ground = [0.36, 0.33, 0.3]

[render]
size = [480, 360]
background = "#d8d5cf"
"##,
        near: View { eye: vec3(-0.05, 0.75, 1.75), target: vec3(-0.3, 0.86, 0.25), fov: 24.0 },
        far: View { eye: vec3(0.25, 0.85, 3.6), target: vec3(0.0, 0.68, 0.1), fov: 25.0 },
    }
}
