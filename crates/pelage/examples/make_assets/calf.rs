//! A calf: its body a cage for Catmull and Clark's rule, made from rounded limbs that flow into each other; two images
//! over its side view say how long its hair is and of what colour.

use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use glam::{Vec2, Vec3, vec2, vec3};
use image::{Rgb, RgbImage};

use crate::net::Net;

/// Writes the cage, its materials, the two images and the scene.
pub fn write(folder: &Path) -> io::Result<()> {
    fs::write(folder.join("calf.obj"), model())?;
    fs::write(folder.join("calf.mtl"), MATERIALS)?;
    fs::write(folder.join("calf.toml"), SCENE)?;
    save(&folder.join("calf-length.png"), &|p| Vec3::splat(length(p)))?;
    save(&folder.join("calf-coat.png"), &coat)
}

/// The length of its hair by the side view, z and y: long on the body and the tail's tuft, short on the face, the ears
/// and the legs.
fn length(p: Vec2) -> f32 {
    let shin = smooth((0.40 - p.y) / 0.2) * smooth((p.x + 0.62) / 0.04);
    let face = smooth((p.x - 0.58) / 0.16) * smooth((p.y - 0.72) / 0.1);
    let crown = 1.0 - smooth(p.distance(vec2(0.66, 1.3)) / 0.09);
    let nose = smooth((0.11 - p.distance(vec2(0.99, 0.99))) / 0.06);
    (1.0 - (0.82 * shin).max(0.84 * face).max(nose)).max(0.75 * crown)
}

/// The colour of its coat by the side view: russet, with a white face, chest, belly, socks and tail's tuft.
fn coat(p: Vec2) -> Vec3 {
    let ragged =
        0.022 * (29.0 * p.x + 2.0 * (17.0 * p.y).sin()).sin() + 0.014 * (53.0 * p.y + 31.0 * p.x).sin();
    let edge = |inside: f32| smooth(0.5 + (inside + ragged) / 0.05);
    let blaze = edge((p.x - 0.73).min(p.y - 0.84));
    let patch = edge(0.075 - p.distance(vec2(0.755, 1.15)));
    let chest = edge(0.17 - vec2(p.x - 0.56, 0.8 * (p.y - 0.64)).length());
    let belly = edge((0.5 - p.y).min(0.3 - (p.x + 0.04).abs()));
    let sock = edge(0.25 - p.y + 0.1 * (p.x + 0.05).abs());
    let tuft = edge((0.46 - p.y).min(-0.6 - p.x));
    let white = (blaze * (1.0 - patch)).max(chest).max(belly).max(sock).max(tuft);
    let russet = vec3(0.82, 0.5, 0.27) * (1.0 - 0.16 * smooth((p.y - 0.6) / 0.3));
    russet.lerp(vec3(0.97, 0.93, 0.86), white)
}

const MATERIALS: &str = "newmtl Coat\nKd 1 1 1\nmap_Kd calf-coat.png\n\n\
                         newmtl Ear\nKd 0.9 0.62 0.54\n\n\
                         newmtl Nose\nKd 0.5 0.27 0.24\nKs 0.25 0.25 0.25\nNs 60\n\n\
                         newmtl Nostril\nKd 0.06 0.03 0.03\n\n\
                         newmtl Eye\nKd 0.014 0.009 0.007\nKs 0.6 0.6 0.6\nNs 400\n\n\
                         newmtl Hoof\nKd 0.1 0.075 0.06\nKs 0.1 0.1 0.1\nNs 20\n";

const SCENE: &str = r##"# A calf, combed from nose to tail, its hair short on the face and the legs. docs/scene.md explains every field.
[[geometry]]
file = "calf.obj"
subdivide = 1

[[geometry]]
surface.plane.size = [40, 40]
patches = [1, 1]
name = "Ground"
color = [0.34, 0.42, 0.2]

[[skin]]
on = ["Coat", "Ear"]
texel.fur = { preset = "long", root_color = [0.86, 0.84, 0.82], color_variation = 0.12 }
# The mesh has texture coordinates, for the images: copies of the texel are laid out by others, as wide everywhere.
layout = "conformal"
height = 0.05
aspect = 1.6

# From the nose over the head, the neck and the back to the tail, and down.
[[skin.groom]]
comb.along.curve = [[0, 0.9, 1.06], [0, 1.2, 0.86], [0, 1.26, 0.6], [0, 1.0, 0.42], [0, 0.92, 0], [0, 0.86, -0.55], [0, 0.3, -0.8]]
comb.angle = 55

[[skin.groom]]
gravity = 0.6

# White is long.
[[skin.groom]]
scale = 0.13
where = { image = "calf-length.png", invert = true }

[[skin.groom]]
noise = { height = 0.3, tilt = 14, size = 0.09 }

[[skin.groom]]
clump = { size = 0.07, amount = 0.25 }

[[skin.groom]]
smooth = { steps = 3 }

[camera.look_at]
eye = [1.55, 1.08, 3.0]
target = [0.05, 0.64, 0.1]
fov = 26.5

[[light]]
directional = { direction = [-0.15, -0.75, -0.6], illuminance = [3.1, 2.9, 2.6], angle = 2 }

[environment]
sky = [0.6, 0.75, 0.95]
ground = [0.3, 0.32, 0.2]

[render]
size = [960, 600]
exposure = 0.4
background = "sky"
"##;

/// A limb from one ball to another.
struct Limb {
    ends: [Vec3; 2],
    radii: [f32; 2],
}

const fn limb(a: [f32; 3], ra: f32, b: [f32; 3], rb: f32) -> Limb {
    Limb { ends: [Vec3::from_array(a), Vec3::from_array(b)], radii: [ra, rb] }
}

/// Trunk, neck, head and tail, on the plane of symmetry.
const MIDDLE: [Limb; 9] = [
    limb([0.0, 0.68, -0.36], 0.215, [0.0, 0.67, 0.26], 0.21),
    limb([0.0, 0.62, -0.1], 0.2, [0.0, 0.62, 0.1], 0.205),
    limb([0.0, 0.74, 0.36], 0.165, [0.0, 1.02, 0.58], 0.115),
    // Skull, cheeks, muzzle.
    limb([0.0, 1.15, 0.64], 0.125, [0.0, 1.09, 0.76], 0.118),
    limb([0.0, 1.07, 0.74], 0.115, [0.0, 0.985, 0.89], 0.092),
    limb([-0.042, 0.965, 0.915], 0.083, [0.042, 0.965, 0.915], 0.083),
    limb([0.0, 0.82, -0.55], 0.05, [0.0, 0.68, -0.66], 0.034),
    limb([0.0, 0.68, -0.66], 0.034, [0.0, 0.46, -0.68], 0.03),
    limb([0.0, 0.42, -0.68], 0.045, [0.0, 0.34, -0.68], 0.05),
];

/// Legs and brows of its left side, mirrored for the right one.
const SIDE: [Limb; 9] = [
    // Shoulder, forearm, shin, hoof.
    limb([0.1, 0.6, 0.3], 0.12, [0.115, 0.38, 0.31], 0.068),
    limb([0.115, 0.38, 0.31], 0.066, [0.115, 0.14, 0.3], 0.046),
    limb([0.115, 0.14, 0.3], 0.046, [0.115, 0.05, 0.325], 0.062),
    limb([0.115, 0.03, 0.33], 0.064, [0.115, -0.02, 0.335], 0.068),
    // Thigh, hock, shin, hoof.
    limb([0.11, 0.62, -0.4], 0.145, [0.12, 0.42, -0.46], 0.078),
    limb([0.12, 0.42, -0.46], 0.07, [0.12, 0.15, -0.43], 0.047),
    limb([0.12, 0.15, -0.43], 0.047, [0.12, 0.05, -0.4], 0.062),
    limb([0.12, 0.03, -0.395], 0.064, [0.12, -0.02, -0.39], 0.068),
    limb([0.07, 1.2, 0.74], 0.035, [0.1, 1.19, 0.7], 0.035),
];

/// Where its left ear is in the middle, its axes (along it, across its flat side, through it) and half their lengths.
const EAR: Vec3 = vec3(0.235, 1.16, 0.615);
const EAR_SIZE: Vec3 = vec3(0.135, 0.072, 0.034);
const EYE: Vec3 = vec3(0.103, 1.12, 0.785);

fn ear_axes() -> [Vec3; 3] {
    let along = vec3(0.92, -0.16, -0.22).normalize();
    let through = vec3(0.12, -0.12, 0.95);
    let across = through.cross(along).normalize();
    [along, across, along.cross(across)]
}

/// How far a point is outside of it, nearly; metres.
fn distance(p: Vec3) -> f32 {
    let p = vec3(p.x.abs(), p.y, p.z);
    let of = |limb: &Limb, p: Vec3| {
        let [a, b] = limb.ends;
        let x = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, x)) - (limb.radii[0] + x * (limb.radii[1] - limb.radii[0]))
    };
    let middle = MIDDLE.iter().map(|l| of(l, p)).reduce(|a, b| blended(a, b, 0.05)).unwrap_or(f32::MAX);
    let side = SIDE.iter().map(|l| of(l, p)).reduce(|a, b| blended(a, b, 0.025)).unwrap_or(f32::MAX);
    let q = Vec3::from(ear_axes().map(|axis| axis.dot(p - EAR)));
    // Narrower towards its tip.
    let q = vec3(q.x, q.y / (1.0 - 2.2 * q.x.max(0.0)).max(0.5), q.z);
    let (k0, k1) = ((q / EAR_SIZE).length(), (q / (EAR_SIZE * EAR_SIZE)).length());
    let ear = k0 * (k0 - 1.0) / k1.max(1e-6);
    let all = blended(blended(middle, side, 0.05), ear, 0.02);
    // It stands on flat hooves, and its eyes lie in hollows.
    let all = all.max(0.004 - p.y);
    -blended(-all, p.distance(EYE + vec3(0.02, 0.0, 0.012)) - 0.041, 0.02)
}

/// The smaller of two distances, rounded where they meet over a width of `k`. [Quilez13]
fn blended(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - 0.25 * h * h * k
}

/// The body in quads, and eyes, nose and nostrils as balls in it.
fn model() -> String {
    let net = Net::new([vec3(-0.56, -0.12, -0.84), vec3(0.56, 1.4, 1.14)], 0.035, &distance);
    let material = |quad: &[usize; 4]| {
        let (p, normal) = (net.centre(quad), net.normal(quad));
        let ear = Vec3::from(ear_axes().map(|axis| axis.dot(vec3(p.x.abs(), p.y, p.z) - EAR)));
        if p.y < 0.075 {
            "Hoof"
        } else if ear.x.abs() < 0.085
            && ear.y.abs() < 0.035
            && p.x.abs() > 0.15
            && p.y > 1.0
            && normal.z > 0.6
        {
            "Ear"
        } else {
            "Coat"
        }
    };
    let mut text = String::from(
        "# A calf to be subdivided, made by crates/pelage/examples/make_assets.\nmtllib calf.mtl\no Calf\n",
    );
    for &p in &net.positions {
        let at = across(p);
        // Adding zero turns −0 into 0.
        let [x, y, z] = ((p * 1e4).round() / 1e4 + Vec3::ZERO).to_array();
        let _ = writeln!(text, "v {x} {y} {z}\nvt {:.4} {:.4}", at.x, at.y);
    }
    for wanted in ["Coat", "Ear", "Hoof"] {
        let _ = writeln!(text, "usemtl {wanted}");
        for quad in net.quads.iter().filter(|quad| material(quad) == wanted) {
            let [a, b, c, d] = quad.map(|v| v + 1);
            let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}");
        }
    }
    let mut first = net.positions.len();
    for side in [-1.0, 1.0] {
        for (name, at, size) in [
            ("Eye", EYE, Vec3::splat(0.041)),
            ("Nose", vec3(0.024, 0.99, 0.962), vec3(0.074, 0.05, 0.064)),
            ("Nostril", vec3(0.052, 1.0, 1.017), vec3(0.016, 0.011, 0.011)),
        ] {
            let at = vec3(side * at.x, at.y, at.z);
            ball(name, at, size, &mut first, &mut text);
        }
    }
    text
}

/// A cube that subdivision makes a ball, `size` to each side.
fn ball(name: &str, at: Vec3, size: Vec3, first: &mut usize, text: &mut String) {
    let _ = writeln!(text, "o {name}\nusemtl {name}");
    // A cube of 2 × 2 quads a side, its corners on the ball.
    let net = Net::new([Vec3::splat(-1.6), Vec3::splat(1.6)], 0.4, &|p| p.length() - 1.0);
    for p in &net.positions {
        let [x, y, z] = (((at + size * *p) * 1e4).round() / 1e4 + Vec3::ZERO).to_array();
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for quad in &net.quads {
        let [a, b, c, d] = quad.map(|v| v + 1 + *first);
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    }
    *first += net.positions.len();
}

/// The side view in the unit square: z from −1 to 1.4 and y from −0.2 to 1.6.
fn across(p: Vec3) -> Vec2 {
    vec2((p.z + 1.0) / 2.4, (p.y + 0.2) / 1.8)
}

/// An image of a colour (as a screen shows it) over the side view.
fn save(path: &Path, color: &dyn Fn(Vec2) -> Vec3) -> io::Result<()> {
    let (width, height) = (256, 192);
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
