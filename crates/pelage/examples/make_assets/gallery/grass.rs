//! Rolling land and stones.

use glam::vec3;

use super::super::part::{Obj, Part, bumps};
use super::{Scene, View};

/// The scene.
pub fn scene() -> Scene {
    let land =
        |x: f32, z: f32| 0.32 * (0.7 * x + 0.6).sin() * (0.55 * z - 0.4).cos() + 0.06 * (1.9 * x - z).sin();
    let mut obj = Obj::new("materials.mtl");
    let size = 9.0;
    let hills = Part::sheet("Hills", [44, 44], |u, v| {
        let [x, z] = [(u - 0.5) * size, 1.8 - v * size];
        vec3(x, land(x, z), z)
    });
    obj.add(&hills, "Soil");
    for (x, z, size) in [(0.42, 0.35, 0.23), (0.85, 0.1, 0.13), (-1.5, -2.2, 0.4), (1.9, -3.0, 0.5)] {
        let stone = Part::ball("Stone", 12, |d| {
            let radius = size * (1.0 + 0.14 * bumps(d + x, 2.2));
            vec3(x, land(x, z) + 0.25 * size, z) + d * vec3(1.25, 0.75, 1.0) * radius
        });
        obj.add(&stone.smooth(), "Rock");
    }
    Scene {
        name: "grass",
        obj: obj.text,
        cage: None,
        text: r##"
[[skin]]
on = "Soil"
wears_material = false
height = 0.14
lean = [0.25, 0, 0.1]
aspect = 1.45
variety = { turns = true, mirrors = true, height = 0.2, color = 0.12 }

[skin.texel]
variants = 2

[skin.texel.grass]
preset = "tussock"

[[light]]
directional = { direction = [0.8, -0.55, -0.25], illuminance = [3.6, 3.1, 2.4], angle = 0.53 }

[environment]
sky = [0.5, 0.68, 0.95]
ground = [0.18, 0.2, 0.08]

[render]
size = [480, 360]
background = "#c6dcee"
"##,
        near: View { eye: vec3(0.05, 0.5, 1.55), target: vec3(0.35, 0.24, 0.3), fov: 30.0 },
        far: View { eye: vec3(-0.3, 1.5, 3.4), target: vec3(0.1, 0.0, -1.0), fov: 34.0 },
    }
}
