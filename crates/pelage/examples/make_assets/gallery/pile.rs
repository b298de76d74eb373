//! A rug with a border and a motif, on a wooden floor, with one corner turned up.

use glam::{Vec2, vec2, vec3};

use super::super::part::{Obj, Part};
use super::{Scene, View};

/// The scene.
pub fn scene() -> Scene {
    let [length, width] = [2.0, 1.4];
    let [columns, rows] = [50, 35];
    let rug = Part::sheet("Rug", [columns, rows], |u, v| {
        let [x, z] = [(u - 0.5) * length, (0.5 - v) * width];
        // A fold across one end.
        let fold = 0.07 * (-((x - 0.2 * z - 0.72) / 0.1).powi(2)).exp();
        vec3(x, 0.012 + fold, z)
    });
    let mut obj = Obj::new("materials.mtl");
    obj.add_by(&rug, |p, _| {
        let [i, j] = [(p.x / length + 0.5) * columns as f32, (0.5 - p.z / width) * rows as f32];
        let from_edge = i.min(j).min(columns as f32 - i).min(rows as f32 - j).floor() as i32;
        // Whole faces from the middle: a lattice of diamonds.
        let middle = vec2(i - 0.5 * columns as f32, j - 0.5 * rows as f32);
        let diamond = |c: Vec2| (middle - c).abs().element_sum();
        match from_edge {
            0 | 1 | 4 => "Border",
            2 | 3 => "Ground",
            5.. if diamond(Vec2::ZERO) < 9.0 && diamond(Vec2::ZERO) > 5.5 => "Motif",
            5.. if diamond(Vec2::ZERO) < 3.5 => "Border",
            5.. if [-14.0, 14.0].iter().any(|&x| diamond(vec2(x, 0.0)) < 5.0) => "Motif",
            _ => "Ground",
        }
    });
    for k in -14..10 {
        let z = 0.25 * k as f32;
        let board = Part::sheet("Board", [1, 1], |u, v| vec3((u - 0.5) * 8.0, 0.0, z + 0.245 - 0.24 * v));
        obj.add(&board, "Wood");
    }
    let gaps = Part::sheet("Gaps", [1, 1], |u, v| vec3((u - 0.5) * 8.0, -0.004, (0.5 - v) * 8.0));
    obj.add(&gaps, "Bark");
    Scene {
        name: "pile",
        obj: obj.text,
        cage: None,
        text: r##"
[[skin]]
on = ["Ground", "Border", "Motif"]
height = 0.035
aspect = 1.6
texel.pile = { preset = "cut" }

[[light]]
directional = { direction = [0.75, -0.6, -0.35], illuminance = [3.4, 3.0, 2.5], angle = 2 }

[environment]
sky = [0.6, 0.66, 0.75]
ground = [0.3, 0.24, 0.18]

[render]
size = [480, 360]
background = "#d9d4cb"
"##,
        near: View { eye: vec3(-0.95, 0.28, 1.15), target: vec3(-0.72, 0.02, 0.5), fov: 24.0 },
        far: View { eye: vec3(-0.6, 1.7, 3.0), target: vec3(0.02, 0.0, -0.05), fov: 28.0 },
    }
}
