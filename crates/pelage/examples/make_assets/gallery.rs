//! The scenes of the gallery: each grown kind on something that it grows on, seen from near and from far.

use std::f32::consts::TAU;
use std::path::Path;
use std::{fs, io};

use glam::{Mat3, Vec2, Vec3, vec2, vec3};

use super::part::{Obj, Part, bumps, crust, ellipsoid};

/// A scene of the gallery.
struct Scene {
    name: &'static str,
    /// The mesh file, and that up to which content reaches where it is not as high everywhere.
    obj: String,
    cage: Option<String>,
    /// What stands in the scene files between geometry and camera.
    text: &'static str,
    near: View,
    far: View,
}

/// A camera.
struct View {
    eye: Vec3,
    target: Vec3,
    /// Vertical, in degrees.
    fov: f32,
}

/// Writes meshes, materials, views and scenes.
pub fn write(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let scenes = [fur(), grass(), moss(), pile(), foliage(), needles()];
    fs::write(folder.join("materials.mtl"), MATERIALS)?;
    for Scene { name, obj, cage, text, near, far } in &scenes {
        fs::write(folder.join(format!("{name}.obj")), obj)?;
        if let Some(cage) = cage {
            fs::write(folder.join(format!("{name}-top.obj")), cage)?;
        }
        for (distance, View { eye, target, fov }) in [("near", near), ("far", far)] {
            let scene = format!(
                "# `texel.{name}` from {distance}. docs/kinds.md explains its fields, docs/scene.md the others.\n\
                 geometry = [{{ file = \"{name}.obj\" }}]\n{text}\n\
                 [camera.look_at]\neye = {eye}\ntarget = {target}\nfov = {fov}\n"
            );
            fs::write(folder.join(format!("{name}-{distance}.toml")), scene)?;
        }
    }
    Ok(())
}

const MATERIALS: &str = "\
# Made by crates/pelage/examples/make_assets
newmtl Coat
Kd 0.72 0.4 0.17
newmtl Cream
Kd 0.95 0.82 0.62
newmtl Eye
Kd 0.012 0.01 0.01
Ks 0.5 0.5 0.5
Pr 0.2
newmtl Nose
Kd 0.06 0.035 0.03
Ks 0.2 0.2 0.2
Pr 0.3
newmtl Floor
Kd 0.55 0.5 0.44
newmtl Soil
Kd 0.12 0.085 0.05
newmtl Rock
Kd 0.3 0.29 0.27
newmtl Wood
Kd 0.42 0.25 0.12
Ks 0.04 0.04 0.04
Pr 0.35
newmtl Bark
Kd 0.16 0.11 0.075
newmtl Terracotta
Kd 0.55 0.22 0.11
newmtl Wall
Kd 0.62 0.6 0.56
newmtl Bauble
Kd 0.62 0.02 0.03
Ks 0.35 0.35 0.35
Pr 0.15
newmtl Gold
Kd 0.75 0.45 0.08
Ks 0.4 0.3 0.1
Pr 0.2
newmtl Ground
Kd 0.85 0.78 0.64
newmtl Border
Kd 0.42 0.05 0.05
newmtl Motif
Kd 0.05 0.1 0.24
";

/// A round animal with ears and a tail of two colours.
fn fur() -> Scene {
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

/// A plane below everything, facing up.
fn ground(size: f32) -> Part {
    Part::sheet("Ground", [1, 1], move |u, v| vec3((u - 0.5) * size, 0.0, (0.5 - v) * size))
}

/// Rolling land and stones.
fn grass() -> Scene {
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

/// A boulder and a smaller one, mossy from above.
fn moss() -> Scene {
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

/// A rug with a border and a motif, on a wooden floor, with one corner turned up.
fn pile() -> Scene {
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

/// A clipped ball of leaves on a trunk, in a pot.
fn foliage() -> Scene {
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

/// A wreath with baubles on a wall.
fn needles() -> Scene {
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
