//! The scenes of the gallery: each grown kind on something that it grows on, seen from near and from far.

mod foliage;
mod fur;
mod grass;
mod moss;
mod needles;
mod pile;

use std::path::Path;
use std::{fs, io};

use glam::{Vec3, vec3};

use super::part::Part;

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
    let scenes =
        [fur::scene(), grass::scene(), moss::scene(), pile::scene(), foliage::scene(), needles::scene()];
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

/// A plane below everything, facing up.
fn ground(size: f32) -> Part {
    Part::sheet("Ground", [1, 1], move |u, v| vec3((u - 0.5) * size, 0.0, (0.5 - v) * size))
}
