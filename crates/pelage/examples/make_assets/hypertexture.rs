//! The gallery's densities: the paper's figure of one deformed texel with three amounts of noise, and a planet's clouds.

use std::f32::consts::FRAC_PI_4;
use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use glam::{Vec2, Vec3};

pub fn write(folder: &Path) -> io::Result<()> {
    fs::write(folder.join("hypertexture.obj"), texels(base))?;
    fs::write(folder.join("hypertexture-top.obj"), texels(top))?;
    fs::write(folder.join("hypertexture-floor.obj"), FLOOR)?;
    fs::write(folder.join("hypertexture.toml"), FIGURE)?;
    fs::write(folder.join("planet.obj"), planet())?;
    for (name, about, camera) in [
        ("near", "from near", "eye = [1.0, 0.9, 2.0]\ntarget = [0.22, 0.25, 0]\nfov = 27"),
        ("far", "from far", "eye = [2.6, 2.2, 6.6]\ntarget = [0, 0, 0]\nfov = 26"),
    ] {
        fs::write(folder.join(format!("hypertexture-{name}.toml")), clouds(about, camera))?;
    }
    Ok(())
}

/// A corner of the square that a texel stands on, (±1, ±1).
fn base(corner: Vec2) -> Vec3 {
    0.5 * Vec3::new(corner.x, 0.0, corner.y)
}

/// Above it: turned by 34°, smaller, and pushed aside.
fn top(corner: Vec2) -> Vec3 {
    let turned = Vec2::from_angle(0.6).rotate(0.42 * corner);
    Vec3::new(turned.x + 0.14, 1.0, turned.y)
}

/// The squares below or above the three texels, 1.25 apart.
fn texels(place: fn(Vec2) -> Vec3) -> String {
    let mut obj = String::from("# Written by make_assets.\n");
    for (i, name) in ["Calm", "Rough", "Wild"].into_iter().enumerate() {
        let middle = Vec3::X * 1.25 * (i as f32 - 1.0);
        let _ = writeln!(obj, "o {name}");
        for corner in [Vec2::new(-1.0, 1.0), Vec2::ONE, Vec2::new(1.0, -1.0), Vec2::NEG_ONE] {
            let p = middle + place(corner);
            let _ = writeln!(obj, "v {:.4} {:.4} {:.4}", p.x, p.y, p.z);
        }
        let _ = writeln!(obj, "f {} {} {} {}", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4);
    }
    obj
}

const FLOOR: &str = "\
# Written by make_assets.
mtllib materials.mtl
o Floor
usemtl Rock
v -30 0 30
v 30 0 30
v 30 0 -30
v -30 0 -30
f 1 2 3 4
";

const FIGURE: &str = r##"# One texel, deformed, with three amounts of noise. docs/kinds.md explains its fields, docs/scene.md the others.
geometry = [{ file = "hypertexture.obj", visible = false }, { file = "hypertexture-floor.obj" }]

[[skin]]
on = "Calm"
cage = "hypertexture-top.obj"
wears_material = false
tiling = 1
texel.hypertexture = { preset = "calm" }

[[skin]]
on = "Rough"
cage = "hypertexture-top.obj"
wears_material = false
tiling = 1
texel.hypertexture = { preset = "rough" }

[[skin]]
on = "Wild"
cage = "hypertexture-top.obj"
wears_material = false
tiling = 1
texel.hypertexture = { preset = "wild" }

[camera.look_at]
eye = [0.2, 1.6, 6.4]
target = [0.12, 0.42, 0]
fov = 14

[[light]]
directional = { direction = [0.75, -0.9, -0.55], illuminance = [3.6, 3.3, 2.9], angle = 1.5 }

[environment]
sky = [0.5, 0.6, 0.75]
ground = [0.3, 0.28, 0.25]

[render]
size = [720, 300]
background = "#cfd6dc"
"##;

/// A ball of radius 1 as a cube of 4 × 4 faces a side, without texture coordinates.
fn planet() -> String {
    const N: usize = 4;
    let mut obj = String::from("# Written by make_assets.\nmtllib materials.mtl\no Planet\nusemtl Soil\n");
    let mut points: Vec<Vec3> = Vec::new();
    let mut faces = String::new();
    for side in 0..6 {
        let axis = side % 3;
        let end = if side < 3 { 1.0 } else { -1.0 };
        // Equal angles rather than equal steps: faces of like size.
        let place = |i: usize| (FRAC_PI_4 * (2.0 * i as f32 / N as f32 - 1.0)).tan();
        let mut at = |i: usize, j: usize| {
            let mut p = Vec3::ZERO;
            p[axis] = end;
            p[(axis + 1) % 3] = place(i);
            p[(axis + 2) % 3] = end * place(j);
            let p = p.normalize();
            let known = points.iter().position(|q| q.distance(p) < 1e-4);
            known.unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            }) + 1
        };
        for (i, j) in (0..N * N).map(|k| (k % N, k / N)) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let _ = writeln!(faces, "f {a} {b} {c} {d}");
        }
    }
    for p in points {
        let _ = writeln!(obj, "v {:.5} {:.5} {:.5}", p.x, p.y, p.z);
    }
    obj + &faces
}

fn clouds(about: &str, camera: &str) -> String {
    format!(
        r##"# `texel.hypertexture` {about}: clouds. docs/kinds.md explains its fields, docs/scene.md the others.
geometry = [{{ file = "planet.obj" }}]

[[skin]]
on = "Planet"
height = 0.2
wears_material = false
tiling = 1
texel.hypertexture = {{ preset = "clouds" }}

[camera.look_at]
{camera}

[[light]]
directional = {{ direction = [-0.8, -0.75, -0.45], illuminance = [3.6, 3.4, 3.1], angle = 1 }}

[environment]
sky = [0.25, 0.32, 0.45]
ground = [0.12, 0.13, 0.16]

[render]
size = [480, 360]
background = "#101826"
"##
    )
}
