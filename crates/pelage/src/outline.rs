//! The boxes of skins as lines in a file, for other programs to show: coloured from red, where a box is about to fold,
//! over yellow to green, where its corner is a right angle.

use std::io::{self, Write};
use std::path::Path;

use pelage_skin::Outline;
use serde_json::json;

use crate::expand::{ExpandError, ModelFormat};
use crate::output::replace;

/// Writes the boxes of `skins`, each with its name.
///
/// OBJ has lines and vertex colours. PLY (text) has an edge list and, by vertex, `det_j` and `scaled_jacobian`. GLB has
/// a mesh of lines a skin with the attributes `_DET_J` and `_SCALED_JACOBIAN`.
///
/// # Errors
/// The file could not be written, and then is what it was before.
pub fn write_outline(
    skins: &[(String, Outline)],
    path: &Path,
    format: ModelFormat,
) -> Result<(), ExpandError> {
    let write = |file: &mut dyn Write| match format {
        ModelFormat::Obj => obj(skins, file),
        ModelFormat::Ply => ply(skins, file),
        ModelFormat::Glb => glb(skins, file),
    };
    Ok(replace(path, |file| write(file))?)
}

/// Red at 0, yellow at ½, green at 1, as parts from 0 to 1.
fn color(quality: f32) -> [f32; 3] {
    let x = 2.0 * quality.clamp(0.0, 1.0);
    [(2.0 - x).min(1.0), x.min(1.0), 0.0]
}

fn obj(skins: &[(String, Outline)], file: &mut dyn Write) -> io::Result<()> {
    file.write_all(b"# Boxes, written by pelage: metres, +Y up; red is folded, green a right angle.\n")?;
    let mut first = 1;
    for (name, outline) in skins {
        let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        writeln!(file, "o {name}")?;
        for (p, quality) in outline.points.iter().zip(&outline.qualities) {
            let [r, g, b] = color(*quality);
            writeln!(file, "v {} {} {} {r:.3} {g:.3} {b:.3}", p.x, p.y, p.z)?;
        }
        for [a, b] in &outline.edges {
            writeln!(file, "l {} {}", first + a, first + b)?;
        }
        first += outline.points.len() as u32;
    }
    Ok(())
}

fn ply(skins: &[(String, Outline)], file: &mut dyn Write) -> io::Result<()> {
    let points: usize = skins.iter().map(|(_, outline)| outline.points.len()).sum();
    let edges: usize = skins.iter().map(|(_, outline)| outline.edges.len()).sum();
    write!(
        file,
        "ply\nformat ascii 1.0\ncomment boxes, written by pelage; metres, +Y up\nelement vertex {points}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float det_j\nproperty float scaled_jacobian\n\
         element edge {edges}\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    )?;
    for (_, outline) in skins {
        let numbers = outline.determinants.iter().zip(&outline.qualities);
        for (p, (determinant, quality)) in outline.points.iter().zip(numbers) {
            let [r, g, b] = color(*quality).map(|x| (255.0 * x).round() as u8);
            writeln!(file, "{} {} {} {r} {g} {b} {determinant:e} {quality}", p.x, p.y, p.z)?;
        }
    }
    let mut first = 0;
    for (_, outline) in skins {
        for [a, b] in &outline.edges {
            writeln!(file, "{} {}", first + a, first + b)?;
        }
        first += outline.points.len() as u32;
    }
    Ok(())
}

fn glb(skins: &[(String, Outline)], file: &mut dyn Write) -> io::Result<()> {
    const FLOAT: u32 = 5126;
    const UNSIGNED_INT: u32 = 5125;
    const LINES: u32 = 1;
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    let (mut accessors, mut views, mut binary) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (name, outline)) in skins.iter().filter(|(_, outline)| !outline.edges.is_empty()).enumerate() {
        let count = outline.points.len();
        let lo = outline.points.iter().fold(glam::Vec3::INFINITY, |lo, p| lo.min(*p));
        let hi = outline.points.iter().fold(glam::Vec3::NEG_INFINITY, |hi, p| hi.max(*p));
        let mut list = |bytes: Vec<u8>, count: usize, component: u32, shape: &str| {
            views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
            binary.extend(bytes);
            accessors.push(json!({
                "bufferView": views.len() - 1, "componentType": component, "count": count, "type": shape
            }));
            accessors.len() - 1
        };
        let floats = |numbers: &mut dyn Iterator<Item = f32>| numbers.flat_map(f32::to_le_bytes).collect();
        let positions = floats(&mut outline.points.iter().flat_map(|p| p.to_array()));
        let colors = floats(&mut outline.qualities.iter().flat_map(|q| color(*q)));
        let position = list(positions, count, FLOAT, "VEC3");
        let color = list(colors, count, FLOAT, "VEC3");
        let determinant = list(floats(&mut outline.determinants.iter().copied()), count, FLOAT, "SCALAR");
        let quality = list(floats(&mut outline.qualities.iter().copied()), count, FLOAT, "SCALAR");
        let indices = outline.edges.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let indices = list(indices, 2 * outline.edges.len(), UNSIGNED_INT, "SCALAR");
        accessors[position]["min"] = json!(lo.to_array());
        accessors[position]["max"] = json!(hi.to_array());
        let attributes = json!({
            "POSITION": position, "COLOR_0": color, "_DET_J": determinant, "_SCALED_JACOBIAN": quality
        });
        let lines = json!({ "attributes": attributes, "indices": indices, "mode": LINES });
        meshes.push(json!({ "name": name, "primitives": [lines] }));
        nodes.push(json!({ "name": name, "mesh": i }));
    }
    let mut text = json!({
        "asset": { "version": "2.0", "generator": "pelage" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
    })
    .to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let word = |length: usize| u32::try_from(length).map(u32::to_le_bytes).map_err(io::Error::other);
    file.write_all(b"glTF\x02\0\0\0")?;
    file.write_all(&word(28 + text.len() + binary.len())?)?;
    file.write_all(&word(text.len())?)?;
    file.write_all(b"JSON")?;
    file.write_all(text.as_bytes())?;
    file.write_all(&word(binary.len())?)?;
    file.write_all(b"BIN\0")?;
    file.write_all(&binary)
}

#[cfg(test)]
mod tests {
    use pelage_skin::{SkinOptions, extrude, surface};

    use super::*;
    use crate::import::{ImportOptions, import};

    #[test]
    fn upright_boxes_are_green_and_every_edge_is_there_once() {
        let skin = extrude(&surface::plane(2.0, 2, 1), &|_| true, &SkinOptions::new(0.5)).expect("a skin");
        let outline = skin.outline();
        // Two boxes side by side: 2 · 7 level edges and 6 upright ones.
        assert_eq!((outline.points.len(), outline.edges.len()), (12, 20));
        // Boxes of 1 m × 2 m × ½ m.
        assert!(outline.determinants.iter().all(|d| (d - 1.0).abs() < 1e-6));
        assert!(outline.qualities.iter().all(|q| (q - 1.0).abs() < 1e-6));
        assert_eq!(
            (color(-1.0), color(0.5), color(1.0)),
            ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0])
        );
        let folder = tempfile::tempdir().expect("a folder");
        let skins = [("a b".to_owned(), outline)];
        let written = |name: &str, format| {
            let path = folder.path().join(name);
            write_outline(&skins, &path, format).expect("a file");
            std::fs::read(&path).expect("a file")
        };
        let text = String::from_utf8(written("a.obj", ModelFormat::Obj)).expect("text");
        assert!(text.contains("o a_b\nv -1 0 1 0.000 1.000 0.000\n"), "{text}");
        assert_eq!(text.lines().filter(|line| line.starts_with("l ")).count(), 20);
        let text = String::from_utf8(written("a.ply", ModelFormat::Ply)).expect("text");
        assert_eq!(text.lines().skip_while(|line| *line != "end_header").count(), 1 + 12 + 20);
        // Lines are no faces to the importer, but it reads all the rest.
        let glb = written("a.glb", ModelFormat::Glb);
        assert_eq!(glb.len(), u32::from_le_bytes([glb[8], glb[9], glb[10], glb[11]]) as usize);
        let error = import(&folder.path().join("a.glb"), &ImportOptions::default()).expect_err("no faces");
        assert!(error.to_string().contains("holds no faces"), "{error}");
    }
}
