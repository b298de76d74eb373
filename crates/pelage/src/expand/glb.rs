//! Binary glTF: one mesh a part, its vertices interleaved in one buffer. [glTF]

use std::io::{self, Write};

use glam::Vec3;
use pelage_tracer::reference::{Expansion, Part};
use serde_json::{Value, json};

use super::each;

/// A vertex: position, normal, and a colour of four 16-bit parts.
const VERTEX: u64 = 12 + 12 + 8;

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;

/// The file's header, and that of each of its two chunks.
const HEADERS: u64 = 12 + 8 + 8;

pub(super) fn size(expansion: &Expansion) -> u64 {
    HEADERS + text(expansion).len() as u64 + binary(expansion)
}

fn binary(expansion: &Expansion) -> u64 {
    3 * VERTEX * expansion.triangles()
}

/// The parts that have triangles; glTF has no empty meshes.
fn parts<'a>(expansion: &'a Expansion) -> impl Iterator<Item = (usize, &'a Part)> {
    expansion.parts().iter().enumerate().filter(|(_, part)| part.triangles > 0)
}

/// The JSON chunk, filled up with spaces to whole words of four.
fn text(expansion: &Expansion) -> String {
    let (mut nodes, mut meshes, mut materials) = (Vec::new(), Vec::new(), Vec::new());
    let (mut accessors, mut views) = (Vec::<Value>::new(), Vec::new());
    let mut offset = 0;
    for (i, (_, part)) in parts(expansion).enumerate() {
        let count = 3 * part.triangles;
        let first = accessors.len();
        let [lo, hi] = part.bounds.map(|p| p.to_array());
        let accessor = |at: u64, component: u32, kind: &str| json!({ "bufferView": i, "byteOffset": at, "componentType": component, "count": count, "type": kind });
        let mut positions = accessor(0, FLOAT, "VEC3");
        positions["min"] = json!(lo);
        positions["max"] = json!(hi);
        let mut colors = accessor(24, UNSIGNED_SHORT, "VEC4");
        colors["normalized"] = json!(true);
        accessors.extend([positions, accessor(12, FLOAT, "VEC3"), colors]);
        views.push(
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": VERTEX * count, "byteStride": VERTEX }),
        );
        offset += VERTEX * count;
        let attributes = json!({ "POSITION": first, "NORMAL": first + 1, "COLOR_0": first + 2 });
        meshes
            .push(json!({ "name": part.name, "primitives": [{ "attributes": attributes, "material": i }] }));
        nodes.push(json!({ "name": part.name, "mesh": i }));
        let matt = json!({ "metallicFactor": 0.0, "roughnessFactor": part.roughness });
        materials.push(json!({ "name": part.name, "doubleSided": true, "pbrMetallicRoughness": matt }));
    }
    let mut text = json!({
        "asset": { "version": "2.0", "generator": "pelage" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": offset }],
    })
    .to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    text
}

pub(super) fn write(
    expansion: &Expansion,
    file: &mut dyn Write,
    tell: &mut dyn FnMut() -> io::Result<()>,
) -> io::Result<()> {
    let text = text(expansion);
    let word = |length: u64| u32::try_from(length).map(u32::to_le_bytes).map_err(io::Error::other);
    let binary = binary(expansion);
    file.write_all(b"glTF")?;
    file.write_all(&2_u32.to_le_bytes())?;
    file.write_all(&word(HEADERS + text.len() as u64 + binary)?)?;
    file.write_all(&word(text.len() as u64)?)?;
    file.write_all(b"JSON")?;
    file.write_all(text.as_bytes())?;
    file.write_all(&word(binary)?)?;
    file.write_all(b"BIN\0")?;
    for (part, _) in parts(expansion) {
        each(expansion, part, file, tell, &mut |file, triangle| {
            let mut bytes = [0_u8; 3 * VERTEX as usize];
            for (i, vertex) in bytes.chunks_exact_mut(VERTEX as usize).enumerate() {
                floats(&mut vertex[..12], triangle.corners[i]);
                floats(&mut vertex[12..24], triangle.normals[i]);
                let color = triangle.colors[i].extend(1.0).to_array();
                for (slot, x) in vertex[24..].chunks_exact_mut(2).zip(color) {
                    slot.copy_from_slice(&((x.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
                }
            }
            file.write_all(&bytes)
        })?;
    }
    Ok(())
}

fn floats(slots: &mut [u8], vector: Vec3) {
    for (slot, x) in slots.chunks_exact_mut(4).zip(vector.to_array()) {
        slot.copy_from_slice(&x.to_le_bytes());
    }
}
