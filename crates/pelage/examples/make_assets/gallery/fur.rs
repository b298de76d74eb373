//! A round animal with ears and a tail of two colours.

use std::f32::consts::TAU;

use glam::{Mat3, Vec3, vec3};

use super::super::part::{Obj, Part, ellipsoid};
use super::{Scene, View, ground};

/// The scene.
pub fn scene() -> Scene {
    let mut obj = Obj::new("materials.mtl");
    let body = |d: Vec3| {
        // A pear, and a little hollow where it stands.
        let wide = 1.0 - 0.16 * d.y;
        vec3(0.0, 0.46, 0.0) + d * vec3(0.4 * wide, 0.43, 0.38 * wide)
    };
    obj.add(&Part::ball("Body", 10, body), "Coat");
    let muzzle = ellipsoid("Muzzle", 5, vec3(0.0, 0.5, 0.335), vec3(0.14, 0.1, 0.1), Mat3::IDENTITY);
    obj.add(&muzzle, "Cream");
    for side in [-1.0, 1.0] {
        let turn = Mat3::from_rotation_z(-0.45 * side);
        obj.add(&ellipsoid("Ear", 4, vec3(0.2 * side, 0.87, 0.04), vec3(0.085, 0.14, 0.05), turn), "Coat");
    }
    // It begins behind the body and curls up beside it.
    let tail = |around: f32, along: f32| {
        let angle = -0.9 + 3.3 * along;
        let middle = vec3(0.5 - 0.12 * along, 0.3, -0.16)
            + vec3(angle.sin(), -angle.cos(), 0.0) * vec3(0.2, 0.24, 0.0);
        let out = vec3(angle.cos(), angle.sin(), 0.0);
        let radius = 0.02 + 0.1 * (along * (1.0 - along) * 4.0).max(0.0).sqrt();
        let (sine, cosine) = (TAU * around).sin_cos();
        // `out` is along the curve: across it are z and what is left.
        let across = Vec3::Z.cross(out);
        middle + (across * cosine + Vec3::Z * sine) * radius
    };
    obj.add_by(&Part::tube("Tail", [10, 16], false, tail), |centre, _| {
        if centre.y > 0.45 && centre.x < 0.62 { "Cream" } else { "Coat" }
    });
    for side in [-1.0, 1.0] {
        let at = vec3(0.145 * side, 0.64, 0.36);
        obj.add(&ellipsoid("Eye", 8, at, Vec3::splat(0.062), Mat3::IDENTITY).smooth(), "Eye");
        let foot = vec3(0.15 * side, 0.07, 0.36);
        obj.add(&ellipsoid("Foot", 5, foot, vec3(0.085, 0.06, 0.12), Mat3::IDENTITY), "Cream");
    }
    obj.add(
        &ellipsoid("Nose", 8, vec3(0.0, 0.55, 0.475), vec3(0.042, 0.03, 0.03), Mat3::IDENTITY).smooth(),
        "Nose",
    );
    obj.add(&ground(3.0), "Floor");
    Scene {
        name: "fur",
        obj: obj.text,
        cage: None,
        text: r##"
[[skin]]
on = ["Coat", "Cream"]
height = 0.075
lean = [0, -0.55, 0]
aspect = 1.4

[skin.texel.fur]
preset = "long"
count = 1500
clump_size = 20
frizz = 0.06
root_color = [0.62, 0.56, 0.48]
tip_color = [0.98, 0.95, 0.9]
undercoat_color = [0.85, 0.8, 0.74]

[[light]]
directional = { direction = [0.6, -0.75, -0.55], illuminance = [3.1, 2.85, 2.5], angle = 3 }

[environment]
sky = [0.62, 0.72, 0.88]
ground = [0.4, 0.36, 0.3]

[render]
size = [480, 360]
exposure = 0.25
background = "#cfd8d6"
"##,
        near: View { eye: vec3(-0.55, 0.75, 1.5), target: vec3(-0.08, 0.66, 0.25), fov: 22.0 },
        far: View { eye: vec3(0.7, 0.95, 3.2), target: vec3(0.08, 0.43, 0.0), fov: 23.0 },
    }
}
