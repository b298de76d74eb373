//! A boulder and a smaller one, mossy from above.

use glam::vec3;

use super::super::part::{Obj, Part, bumps, crust};
use super::{Scene, View, ground};

/// The scene.
pub fn scene() -> Scene {
    let mut obj = Obj::new("materials.mtl");
    let mut top = Obj::new("materials.mtl");
    let boulders = [
        (["Boulder", "Moss"], 18, vec3(0.0, 0.3, 0.0), vec3(0.72, 0.5, 0.55), 0.0),
        (["Cobble", "Tuft"], 8, vec3(0.8, 0.1, 0.38), vec3(0.25, 0.17, 0.21), 3.0),
    ];
    for ([name, on_it], n, at, size, phase) in boulders {
        let rock = Part::ball(name, n, |d| at + d * size * (1.0 + 0.13 * bumps(d + phase, 1.9)));
        // Thinner where it is steep, and none below.
        let [base, above] = crust(on_it, &rock, |p, normal| {
            let inside = ((normal.y - 0.15 - 0.2 * bumps(p, 5.0)) / 0.45).clamp(0.0, 1.0);
            0.07 * inside * (2.0 - inside)
        });
        obj.add(&rock.smooth(), "Rock");
        obj.add(&base, "Soil");
        top.add(&above, "Soil");
    }
    obj.add(&ground(8.0), "Floor");
    Scene {
        name: "moss",
        obj: obj.text,
        cage: Some(top.text),
        text: r##"
[[skin]]
on = ["Moss", "Tuft"]
cage = "moss-top.obj"
wears_material = false
tiling = 1
texel.moss = { preset = "cushion", dome = 0.3, capsules = 0.008 }
variety = { turns = true, mirrors = true, height = 0.15, color = 0.1 }

[[light]]
directional = { direction = [0.65, -0.8, -0.3], illuminance = [3.4, 3.0, 2.4], angle = 1 }

[environment]
sky = [0.55, 0.68, 0.8]
ground = [0.25, 0.22, 0.15]

[render]
size = [480, 360]
background = "#cdd6cf"
"##,
        near: View { eye: vec3(0.35, 1.05, 1.5), target: vec3(0.12, 0.66, 0.25), fov: 15.0 },
        far: View { eye: vec3(0.6, 1.25, 3.7), target: vec3(0.13, 0.33, 0.0), fov: 24.0 },
    }
}
