//! Writes the files in `assets/`: `cargo run -p pelage --example make_assets -- assets`.
//!
//! Everything in that folder comes from this program, the same bytes every time; see `assets/README.md`.
//!
//! Longer than most files here: each creature is described once, in plain numbers.

mod calf;
mod dressed;
mod gallery;
mod hypertexture;
mod net;
mod part;
mod standard;

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;
use std::{env, fs, io};

use glam::{Mat3, Vec2, Vec3, vec2, vec3};

fn main() -> io::Result<()> {
    let folder = env::args().nth(1).unwrap_or_else(|| "assets".into());
    let folder = Path::new(&folder);
    let (obj, mtl) = creatures();
    fs::write(folder.join("fluff.obj"), obj)?;
    fs::write(folder.join("fluff.mtl"), mtl)?;
    fs::write(folder.join("fluff.toml"), SCENE)?;
    fs::write(folder.join("stage.glb"), stage()?)?;
    fs::write(folder.join("dressed.glb"), dressed::dressed())?;
    calf::write(folder)?;
    gallery::write(&folder.join("gallery"))?;
    hypertexture::write(&folder.join("gallery"))?;
    standard::write(&folder.join("validate"))
}

/// Three creatures on a rug.
const SCENE: &str = r##"# Three fluffy creatures on a rug. docs/scene.md explains every field.
geometry = [{ file = "fluff.obj" }]

[[skin]]
on = "Cream"
texel.fur = { preset = "long" }
height = 0.14
lean = [0, -0.5, 0]
aspect = 1.5

[[skin]]
on = "Teal"
texel.fur = { preset = "plush", resolution = 64 }
height = 0.06
aspect = 1.5

[[skin]]
on = "Rose"
texel.fur = { preset = "long" }
height = 0.1
lean = [0, -0.3, 0]
aspect = 1.5

[[skin]]
on = "Rug"
texel.fur = { preset = "plush", resolution = 64 }
height = 0.05
aspect = 1.5

[camera.look_at]
eye = [0.55, 0.95, 3.6]
target = [0.02, 0.42, 0.0]
fov = 25

[[light]]
directional = { direction = [0.55, -0.8, -0.5], illuminance = [3.1, 2.9, 2.6], angle = 2 }

[environment]
sky = [0.6, 0.75, 0.95]
ground = [0.35, 0.3, 0.24]

[render]
size = [1280, 800]
background = "#d3e4ee"
"##;

/// A surface of revolution about Y: `columns` around, `rows` from the bottom pole to the top one.
///
/// `shape` gives radius and height at an angle from the bottom, 0 to π.
struct Lathe {
    columns: usize,
    rows: usize,
    shape: fn(f32) -> Vec2,
}

/// Where a part stands.
#[derive(Clone, Copy)]
struct Placement {
    scale: Vec3,
    turn: Mat3,
    at: Vec3,
}

fn sphere(angle: f32) -> Vec2 {
    vec2(angle.sin(), -angle.cos())
}

/// A little wider at the bottom than at the top.
fn pear(angle: f32) -> Vec2 {
    sphere(angle) * vec2(1.0 + 0.1 * angle.cos(), 1.0)
}

#[derive(Default)]
struct Obj {
    text: String,
    positions: usize,
    uvs: usize,
    normals: usize,
}

impl Obj {
    fn begin(&mut self, name: &str, material: &str) {
        let _ = write!(self.text, "o {name}\nusemtl {material}\n");
    }

    /// With texture coordinates, for what wears a skin, or with smooth normals, for what does not.
    fn lathe(&mut self, lathe: &Lathe, place: &Placement, dressed: bool) {
        let Lathe { columns, rows, shape } = *lathe;
        // Rings 1 to rows − 1, then the two poles.
        let local = |i: usize, j: usize| {
            let around = TAU * i as f32 / columns as f32;
            let Vec2 { x: radius, y: height } = shape(PI * j as f32 / rows as f32);
            vec3(radius * around.sin(), height, radius * around.cos())
        };
        let mut points: Vec<Vec3> = Vec::new();
        for j in 1..rows {
            points.extend((0..columns).map(|i| local(i, j)));
        }
        let poles = [points.len(), points.len() + 1];
        points.extend([local(0, 0), local(0, rows)]);
        for p in &points {
            self.line("v", place.at + place.turn * (*p * place.scale));
            if !dressed {
                self.line("vn", place.turn * (*p / place.scale).normalize());
            }
        }
        if dressed {
            for j in 0..=rows {
                for i in 0..=columns {
                    // Halfway between its neighbours at a pole.
                    let shift = if j == 0 || j == rows { 0.5 } else { 0.0 };
                    let (u, v) = ((i as f32 + shift) / columns as f32, j as f32 / rows as f32);
                    let _ = writeln!(self.text, "vt {u:.5} {v:.5}");
                }
            }
        }
        let vertex = |i: usize, j: usize| match j {
            0 => poles[0],
            j if j == rows => poles[1],
            j => (j - 1) * columns + i % columns,
        };
        for j in 0..rows {
            for i in 0..columns {
                let mut corners = vec![(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                if j == 0 {
                    corners.remove(1);
                } else if j + 1 == rows {
                    corners.remove(2);
                }
                self.text.push('f');
                for (i, j) in corners {
                    let v = self.positions + vertex(i, j) + 1;
                    let _ = if dressed {
                        write!(self.text, " {v}/{}", self.uvs + j * (columns + 1) + i + 1)
                    } else {
                        write!(self.text, " {v}//{}", self.normals + vertex(i, j) + 1)
                    };
                }
                self.text.push('\n');
            }
        }
        self.positions += points.len();
        if dressed {
            self.uvs += (rows + 1) * (columns + 1);
        } else {
            self.normals += points.len();
        }
    }

    /// A disc of `n` × `n` quads, facing up: a square whose concentric rings became circles. [ShirleyChiu97]
    fn disc(&mut self, radius: f32, n: usize) {
        for k in 0..(n + 1) * (n + 1) {
            let uv = vec2((k % (n + 1)) as f32, (k / (n + 1)) as f32) / n as f32;
            let s = 2.0 * uv - 1.0;
            let (r, angle) = if s.x.abs() > s.y.abs() {
                (s.x, FRAC_PI_2 * 0.5 * s.y / s.x)
            } else if s.y == 0.0 {
                (0.0, 0.0)
            } else {
                (s.y, FRAC_PI_2 - FRAC_PI_2 * 0.5 * s.x / s.y)
            };
            // Halfway to the square itself, so that no quad in the corners is a flat triangle.
            let round = r * vec2(angle.cos(), angle.sin());
            let p = radius * round.lerp(s * 0.85, 0.3);
            self.line("v", vec3(p.x, 0.0, -p.y));
            let _ = writeln!(self.text, "vt {:.5} {:.5}", uv.x, uv.y);
        }
        for k in 0..n * n {
            let corner = k / n * (n + 1) + k % n + 1;
            let [a, b, c, d] = [corner, corner + 1, corner + n + 2, corner + n + 1];
            let _ = writeln!(
                self.text,
                "f {}/{} {}/{} {}/{} {}/{}",
                self.positions + a,
                self.uvs + a,
                self.positions + b,
                self.uvs + b,
                self.positions + c,
                self.uvs + c,
                self.positions + d,
                self.uvs + d
            );
        }
        self.positions += (n + 1) * (n + 1);
        self.uvs += (n + 1) * (n + 1);
    }

    fn line(&mut self, keyword: &str, v: Vec3) {
        // Adding zero turns −0 into 0.
        let v = (v * 1e4).round() / 1e4 + Vec3::ZERO;
        let _ = writeln!(self.text, "{keyword} {} {} {}", v.x, v.y, v.z);
    }
}

/// A body with eyes, a beak and feet.
struct Creature {
    name: &'static str,
    fur: &'static str,
    /// On the ground, below its middle.
    at: Vec3,
    /// Radius of the body, its height relative to it, and the height of its fur.
    radius: f32,
    tall: f32,
    height: f32,
    /// Which way it looks, in degrees from the front.
    facing: f32,
    /// Radius of an eye relative to the body, and how far eyes stand apart and up, in degrees.
    eye: f32,
    apart: f32,
    up: f32,
}

fn creatures() -> (String, &'static str) {
    let mut obj = Obj {
        text: "# Made by crates/pelage/examples/make_assets\nmtllib fluff.mtl\n".into(),
        ..Obj::default()
    };
    obj.begin("Rug", "Rug");
    obj.disc(1.75, 20);
    let creatures = [
        Creature {
            name: "Biscuit",
            fur: "Cream",
            at: vec3(0.05, 0.0, -0.25),
            radius: 0.48,
            tall: 0.95,
            height: 0.13,
            facing: 4.0,
            eye: 0.19,
            apart: 21.0,
            up: 20.0,
        },
        Creature {
            name: "Pebble",
            fur: "Teal",
            at: vec3(0.82, 0.0, 0.2),
            radius: 0.3,
            tall: 1.25,
            height: 0.06,
            facing: -14.0,
            eye: 0.24,
            apart: 24.0,
            up: 28.0,
        },
        Creature {
            name: "Pip",
            fur: "Rose",
            at: vec3(-0.68, 0.0, 0.38),
            radius: 0.22,
            tall: 0.92,
            height: 0.1,
            facing: 24.0,
            eye: 0.3,
            apart: 27.0,
            up: 18.0,
        },
    ];
    for creature in &creatures {
        creature.write(&mut obj);
    }
    (obj.text, MATERIALS)
}

impl Creature {
    fn write(&self, obj: &mut Obj) {
        let turn = Mat3::from_rotation_y(self.facing.to_radians());
        let body = self.radius * vec3(1.0, self.tall, 1.0);
        // The fur lifts it off the ground, but the weight presses half of that down.
        let centre = self.at + Vec3::Y * (body.y + 0.5 * self.height);
        obj.begin(self.name, self.fur);
        obj.lathe(
            &Lathe { columns: 36, rows: 20, shape: pear },
            &Placement { scale: body, turn, at: centre },
            true,
        );

        // A point over the body, `out` metres above its surface.
        let on = |azimuth: f32, elevation: f32, out: f32| {
            let (a, e) = (azimuth.to_radians(), elevation.to_radians());
            let direction = vec3(a.sin() * e.cos(), e.sin(), a.cos() * e.cos());
            // The pear is 1 − 0.1 y as wide as a sphere at height y.
            let width = 1.0 - 0.1 * direction.y;
            let surface = direction * body * vec3(width, 1.0, width);
            centre + turn * (surface + out * direction)
        };
        let ball = |columns, rows| Lathe { columns, rows, shape: sphere };
        let eye = self.eye * self.radius;
        obj.begin(&format!("{}Eyes", self.name), "Eye");
        for side in [-1.0, 1.0] {
            let at = on(side * self.apart, self.up, 0.85 * self.height - 0.35 * eye);
            obj.lathe(&ball(18, 12), &Placement { scale: Vec3::splat(eye), turn, at }, false);
        }
        obj.begin(&format!("{}Glints", self.name), "Glint");
        for side in [-1.0, 1.0] {
            let at = on(side * self.apart, self.up, 0.85 * self.height - 0.35 * eye)
                + eye * vec3(-0.35, 0.5, 0.76).normalize() * 0.86;
            obj.lathe(&ball(12, 8), &Placement { scale: Vec3::splat(0.25 * eye), turn, at }, false);
        }
        obj.begin(&format!("{}Beak", self.name), "Beak");
        let beak = Placement {
            scale: self.radius * vec3(0.13, 0.085, 0.2),
            turn: turn * Mat3::from_rotation_x(0.25),
            at: on(0.0, self.up - 17.0, 0.75 * self.height),
        };
        obj.lathe(&ball(12, 8), &beak, false);
        obj.begin(&format!("{}Feet", self.name), "Beak");
        for side in [-1.0, 1.0] {
            let forward = vec3(side * 0.42 * self.radius, 0.0, self.radius + 0.4 * self.height);
            let foot = Placement {
                scale: self.radius * vec3(0.2, 0.11, 0.3),
                turn: turn * Mat3::from_rotation_y(side * 0.25),
                at: self.at + turn * forward + Vec3::Y * (0.045 + 0.11 * self.radius),
            };
            obj.lathe(&ball(12, 8), &foot, false);
        }
    }
}

const MATERIALS: &str = "\
# Made by crates/pelage/examples/make_assets
newmtl Cream
Kd 1.0 0.66 0.28
newmtl Teal
Kd 0.06 0.5 0.62
newmtl Rose
Kd 1.0 0.26 0.36
newmtl Rug
Kd 0.3 0.5 0.16
newmtl Eye
Kd 0.012 0.01 0.01
Ks 0.5 0.5 0.5
Pr 0.22
newmtl Glint
Kd 0.9 0.9 0.9
Ke 0.6 0.6 0.6
newmtl Beak
Kd 0.9 0.36 0.06
Ks 0.08 0.08 0.08
Pr 0.4
";

/// A floor with a texture, a block and its mirror image, a camera and two lights, in one binary glTF.
fn stage() -> io::Result<Vec<u8>> {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8]| {
        views.push(format!("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", bin.len(), bytes.len()));
        bin.extend_from_slice(bytes);
        bin.resize(bin.len().next_multiple_of(4), 0);
    };
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let shorts = |values: &[u16]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    // The floor: 2 m, its texture four times across.
    view(&floats(&[-1., 0., 1., 1., 0., 1., 1., 0., -1., -1., 0., -1.]));
    view(&floats(&[0., 1., 1., 1., 1., 0., 0., 0.]));
    view(&shorts(&[0, 1, 2, 0, 2, 3]));
    // A wedge: right-angled, so that it differs from its mirror image.
    view(&floats(&[0., 0., 0., 0.4, 0., 0., 0., 0., 0.4, 0., 0.6, 0.]));
    view(&shorts(&[0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2]));
    view(&checkerboard()?);
    let json = format!(
        r#"{{"asset":{{"version":"2.0","generator":"pelage make_assets"}},"scene":0,"scenes":[{{"nodes":[0,1,2,3,4,5]}}],
"extensionsUsed":["KHR_lights_punctual","KHR_texture_transform"],
"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"directional","color":[1,0.9,0.8],"intensity":3}},{{"type":"point","color":[0.5,0.7,1],"intensity":2}}]}}}},
"nodes":[{{"name":"Floor","mesh":0}},{{"name":"Wedge","mesh":1,"translation":[0.1,0,0]}},{{"name":"Mirrored","mesh":1,"translation":[-0.1,0,0],"scale":[-1,1,1]}},
{{"name":"View","camera":0,"translation":[0,1.2,3],"rotation":[-0.1736482,0,0,0.9848078]}},
{{"name":"Sun","rotation":[-0.5,0,0,0.8660254],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},
{{"name":"Lamp","translation":[1,1,1],"extensions":{{"KHR_lights_punctual":{{"light":1}}}}}}],
"cameras":[{{"type":"perspective","perspective":{{"yfov":0.7,"znear":0.01}}}}],
"materials":[{{"name":"Tiles","doubleSided":true,"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"scale":[4,4]}}}}}}}}}},
{{"name":"Clay","pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":0.5,"baseColorFactor":[0.8,0.3,0.2,1]}}}}],
"textures":[{{"source":0}}],"images":[{{"bufferView":5,"mimeType":"image/png"}}],
"meshes":[{{"name":"floor","primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}},{{"name":"wedge","primitives":[{{"attributes":{{"POSITION":3}},"indices":4,"material":1}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,0,-1],"max":[1,0,1]}},{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},{{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}},
{{"bufferView":3,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[0.4,0.6,0.4]}},{{"bufferView":4,"componentType":5123,"count":12,"type":"SCALAR"}}],
"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        views.join(","),
        bin.len()
    );
    Ok(dressed::glb(json, &bin))
}

/// 16 × 16 pixels: four squares of sRGB (230, 225, 210) and (60, 80, 110), the first at the upper left.
fn checkerboard() -> io::Result<Vec<u8>> {
    let pixel =
        |x, y| if (x / 8 + y / 8) % 2 == 0 { image::Rgb([230, 225, 210]) } else { image::Rgb([60, 80, 110]) };
    let mut png = Cursor::new(Vec::new());
    image::RgbImage::from_fn(16, 16, pixel)
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(io::Error::other)?;
    Ok(png.into_inner())
}
