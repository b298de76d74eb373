//! A shaggy calf: a handful of cubes for Catmull–Clark's rule to make round, with two images over its side view: how
//! long its hair is, and of what colour.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use glam::{IVec3, Vec2, Vec3, ivec3, vec2, vec3};
use image::{Rgb, RgbImage};

/// Writes the cage, its materials, the two images and the scene.
pub fn write(folder: &Path) -> io::Result<()> {
    fs::write(folder.join("calf.obj"), cage())?;
    fs::write(folder.join("calf.mtl"), MATERIALS)?;
    fs::write(folder.join("calf.toml"), SCENE)?;
    save(&folder.join("calf-length.png"), &|p| {
        // Long on the body; short from the cheeks on, and on the legs.
        let face = smooth((p.x - 0.44) / 0.16) * smooth((p.y - 0.45) / 0.2);
        let shin = smooth((0.34 - p.y) / 0.16);
        Vec3::splat(1.0 - (0.8 * face).max(0.75 * shin))
    })?;
    save(&folder.join("calf-coat.png"), &|p| {
        let spots =
            [(-0.42, 0.66, 0.17), (0.02, 0.5, 0.15), (0.5, 0.98, 0.17), (-0.1, 0.86, 0.12), (0.3, 0.3, 0.1)];
        let ragged = 0.03 * (31.0 * p.x + 3.0 * (17.0 * p.y).sin()).sin() + 0.02 * (43.0 * p.y).sin();
        let inside = |&(x, y, r): &(f32, f32, f32)| r + ragged - vec2(x, y).distance(p);
        let nearest = spots.iter().map(inside).fold(f32::NEG_INFINITY, f32::max);
        vec3(0.93, 0.86, 0.74).lerp(vec3(0.5, 0.24, 0.1), smooth(0.5 + nearest / 0.03))
    })
}

const MATERIALS: &str = "newmtl Coat\nKd 1 1 1\nmap_Kd calf-coat.png\n\nnewmtl Nose\nKd 0.2 0.11 0.1\nKs 0.2 0.2 0.2\nNs 40\n\n\
                         newmtl Hoof\nKd 0.09 0.07 0.06\n";

const SCENE: &str = r##"# A calf, combed from nose to tail, its hair short on the face and the legs. docs/scene.md explains every field.
[[geometry]]
file = "calf.obj"
subdivide = 3

[[geometry]]
surface.sphere.radius = 0.045
name = "Eye"
color = [0.012, 0.01, 0.01]
translate = [0.2, 1.1, 0.79]

[[geometry]]
surface.sphere.radius = 0.045
name = "Eye"
color = [0.012, 0.01, 0.01]
translate = [-0.2, 1.1, 0.79]

[[geometry]]
surface.plane.size = [40, 40]
patches = [1, 1]
name = "Ground"
color = [0.34, 0.4, 0.2]

[[skin]]
on = "Coat"
texel.fur = { preset = "long", root_color = [0.75, 0.72, 0.7] }
layout = "per-patch"
height = 0.065
aspect = 1.2

# From the nose over the head, the neck and the back to the tail, and down.
[[skin.groom]]
comb.along.curve = [[0, 0.85, 1.15], [0, 1.15, 0.8], [0, 0.95, 0.45], [0, 0.85, 0], [0, 0.8, -0.5], [0, 0.1, -0.8]]
comb.angle = 52

[[skin.groom]]
gravity = 0.5

# White is long.
[[skin.groom]]
scale = 0.22
where = { image = "calf-length.png", invert = true }

[[skin.groom]]
noise = { height = 0.3, tilt = 14, size = 0.12 }

[[skin.groom]]
clump = { size = 0.1, amount = 0.25 }

[[skin.groom]]
smooth = { steps = 3 }

[camera.look_at]
eye = [2.5, 1.35, 2.7]
target = [0.02, 0.62, 0.12]
fov = 28

[[light]]
directional = { direction = [-0.45, -0.8, -0.5], illuminance = [3.1, 2.9, 2.6], angle = 2 }

[environment]
sky = [0.6, 0.75, 0.95]
ground = [0.3, 0.32, 0.2]

[render]
size = [1280, 960]
background = "sky"
"##;

/// The cubes that it is made of, as boxes of lattice cells: from the first corner to the second.
const PARTS: [(IVec3, IVec3); 11] = [
    // Trunk, neck, head, muzzle.
    (ivec3(0, 2, 1), ivec3(3, 4, 5)),
    (ivec3(0, 3, 5), ivec3(3, 4, 6)),
    (ivec3(0, 4, 5), ivec3(3, 6, 7)),
    (ivec3(0, 4, 7), ivec3(3, 5, 8)),
    // Legs.
    (ivec3(0, 0, 1), ivec3(1, 2, 2)),
    (ivec3(2, 0, 1), ivec3(3, 2, 2)),
    (ivec3(0, 0, 4), ivec3(1, 2, 5)),
    (ivec3(2, 0, 4), ivec3(3, 2, 5)),
    // Ears.
    (ivec3(-1, 5, 5), ivec3(0, 6, 6)),
    (ivec3(3, 5, 5), ivec3(4, 6, 6)),
    // Tail.
    (ivec3(1, 3, -1), ivec3(2, 4, 1)),
];

/// Where a corner of the lattice lies, in metres.
fn place(corner: IVec3) -> Vec3 {
    const X: [f32; 6] = [-0.52, -0.27, -0.09, 0.09, 0.27, 0.52];
    const Y: [f32; 7] = [0.0, 0.22, 0.42, 0.66, 0.92, 1.1, 1.28];
    const Z: [f32; 10] = [-0.86, -0.74, -0.66, -0.38, -0.02, 0.3, 0.56, 0.72, 0.94, 1.16];
    let at = |list: &[f32], i: i32| list[i as usize];
    let mut p = vec3(at(&X, corner.x + 1), at(&Y, corner.y), at(&Z, corner.z + 1));
    if corner.y <= 1 {
        // Legs become thinner downwards, about their own middles.
        let middle = vec3(0.18 * p.x.signum(), p.y, if corner.z <= 2 { -0.52 } else { 0.43 });
        p = middle + 0.85 * (p - middle);
    }
    if corner.z <= 0 {
        // The tail hangs, and ends in a tuft.
        let (low, high) = if corner.z == 0 { (0.7, 0.84) } else { (0.24, 0.34) };
        p = vec3(0.6 * p.x, if corner.y == 3 { low } else { high }, p.z);
    }
    if corner.z >= 5 && corner.y >= 3 && (0..=3).contains(&corner.x) {
        // Neck and head are narrower than the trunk, the muzzle more so.
        p.x *= [0.86, 0.92, 0.86, 0.68][(corner.z - 5) as usize];
        if corner.z == 8 {
            p.y = 0.5 * (p.y + 0.97) - 0.02;
        }
    }
    if corner.x < 0 || corner.x > 3 {
        // Ears point sideways and a little down, and back.
        p = vec3(p.x, 0.55 * p.y + 0.44, p.z - 0.05);
        p.z = 0.55 * p.z + 0.26;
    }
    p
}

/// The faces between filled and empty cells, with the side view as texture coordinates.
fn cage() -> String {
    let mut cells = BTreeSet::new();
    for (from, to) in PARTS {
        for z in from.z..to.z {
            for y in from.y..to.y {
                cells.extend((from.x..to.x).map(|x| [x, y, z]));
            }
        }
    }
    let mut numbers = BTreeMap::new();
    let mut corners = Vec::new();
    let mut faces: BTreeMap<&str, Vec<[usize; 4]>> = BTreeMap::new();
    for &cell in &cells {
        let cell = IVec3::from(cell);
        for axis in 0..3 {
            for outwards in [false, true] {
                let mut step = IVec3::ZERO;
                step[axis] = if outwards { 1 } else { -1 };
                if cells.contains(&(cell + step).to_array()) {
                    continue;
                }
                let (mut u, mut v) = (IVec3::ZERO, IVec3::ZERO);
                u[(axis + 1) % 3] = 1;
                v[(axis + 2) % 3] = 1;
                let from = if outwards { cell + step } else { cell };
                let mut around = [from, from + u, from + u + v, from + v];
                if !outwards {
                    around.swap(1, 3);
                }
                let quad = around.map(|corner| {
                    *numbers.entry(corner.to_array()).or_insert_with(|| {
                        corners.push(corner);
                        corners.len()
                    })
                });
                let material = match (axis, outwards) {
                    (1, false) if cell.y == 0 => "Hoof",
                    (2, true) if cell.z == 7 => "Nose",
                    _ => "Coat",
                };
                faces.entry(material).or_default().push(quad);
            }
        }
    }
    let mut text = String::from("# A calf to be subdivided.\nmtllib calf.mtl\no Calf\n");
    for p in corners.iter().map(|&c| place(c)) {
        let _ =
            writeln!(text, "v {:.4} {:.4} {:.4}\nvt {:.5} {:.5}", p.x, p.y, p.z, across(p).x, across(p).y);
    }
    for (material, quads) in faces {
        let _ = writeln!(text, "usemtl {material}");
        for [a, b, c, d] in quads {
            let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}");
        }
    }
    text
}

/// The side view in the unit square: z from −1 to 1.4 and y from −0.2 to 1.6.
fn across(p: Vec3) -> Vec2 {
    vec2((p.z + 1.0) / 2.4, (p.y + 0.2) / 1.8)
}

/// An image of a colour (as a screen shows it) over the side view.
fn save(path: &Path, color: &dyn Fn(Vec2) -> Vec3) -> io::Result<()> {
    let (width, height) = (192, 144);
    let image = RgbImage::from_fn(width, height, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / width as f32, 1.0 - (y as f32 + 0.5) / height as f32);
        let c = color(vec2(2.4 * u - 1.0, 1.8 * v - 0.2));
        Rgb(c.to_array().map(|x| (255.0 * x.clamp(0.0, 1.0)).round() as u8))
    });
    image.save(path).map_err(io::Error::other)
}

fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
