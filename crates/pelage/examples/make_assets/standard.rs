//! The standard scenes of `pelage validate`: four contents on three skins, and four more on one.

use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use glam::{Vec2, Vec3, vec3};
use pelage::geom::Mesh;
use pelage::skin::surface;

/// What stands on each skin: its name, and its line in the scene.
const CONTENTS: [(&str, &str); 4] = [
    ("fur", "texel.fur = { preset = \"hair\" }"),
    ("grass", "texel.grass = {}"),
    ("leaves", "texel.leaves = {}"),
    ("sheet", "texel.sheet = {}"),
];

/// What stands on the flat skin only: many small things each, slow to judge.
const GROWN: &[(&str, &str)] = &[
    ("moss", "texel.moss = {}"),
    ("pile", "texel.pile = {}"),
    ("foliage", "texel.foliage = {}"),
    ("needles", "texel.needles = {}"),
];

/// A skin: its name, what it is, what makes it of a mesh, and from where it is seen.
struct Form {
    name: &'static str,
    what: &'static str,
    mesh: &'static str,
    skin: &'static str,
    view: &'static str,
}

const FORMS: [Form; 3] = [
    Form {
        name: "flat",
        what: "a plane of 24 × 24 cubes",
        mesh: "flat.obj",
        skin: "height = 0.2",
        view: "azimuth = 30, elevation = 28",
    },
    Form {
        name: "torus",
        what: "a torus of 48 × 24 boxes",
        mesh: "torus.obj",
        skin: "height = 0.13",
        view: "azimuth = 0, elevation = 38",
    },
    Form {
        name: "bent",
        what: "a plane of 6 × 6 boxes, combed to 40° and twisted",
        mesh: "base.obj",
        skin: "cage = \"bent.obj\"",
        view: "azimuth = 30, elevation = 28",
    },
];

/// Writes meshes and scenes.
pub fn write(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    // Large enough that what is judged is a coat, not its border: at 4 pixels a box the middle fills the picture.
    fs::write(folder.join("flat.obj"), obj(&surface::plane(4.8, 24, 24)))?;
    let base = surface::plane(1.2, 6, 6);
    fs::write(folder.join("base.obj"), obj(&base))?;
    fs::write(folder.join("bent.obj"), obj(&combed(&base)))?;
    fs::write(folder.join("torus.obj"), obj(&surface::torus(1.0, 0.5, 48, 24)))?;
    for Form { name, what, mesh, skin, view } in FORMS {
        let grown = if name == "flat" { GROWN } else { &[] };
        for (content, texel) in CONTENTS.iter().chain(grown) {
            let text = format!(
                "# Standard scene of `pelage validate`: {content} on {what}, without the surface below.\n\
                 geometry = [{{ file = \"{mesh}\", visible = false }}]\n\n\
                 [[skin]]\n{texel}\n{skin}\ntiling = 1\n\n\
                 [camera]\nframed = {{ {view} }}\n\n\
                 [render]\nsize = [800, 500]\n"
            );
            fs::write(folder.join(format!("{name}-{content}.toml")), text)?;
        }
    }
    Ok(())
}

/// The top of the cage over a plane: its vertices 0.2 m away, combed 40° off the normal, in a direction that turns by
/// 25° from each vertex to the next.
fn combed(plane: &Mesh) -> Mesh {
    let mut top = plane.clone();
    for p in &mut top.positions {
        let steps = (p.x - p.z) / 0.2;
        let (sine, cosine) = 40_f32.to_radians().sin_cos();
        let way = Vec2::from_angle((25.0 * steps).to_radians()) * sine;
        *p += 0.2 * vec3(way.x, cosine, way.y);
    }
    top
}

/// Without texture coordinates: one copy of the texel stands on each face.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::from("# Made by crates/pelage/examples/make_assets\n");
    for p in &mesh.positions {
        // Adding zero turns −0 into 0.
        let p = (*p * 1e5).round() / 1e5 + Vec3::ZERO;
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for face in &mesh.faces {
        let corners: Vec<String> = face.corners().iter().map(|v| (v + 1).to_string()).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}
