//! A glTF file that says itself what its meshes and materials wear: see `docs/gltf.md`.

use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec3};
use serde_json::{Value, json};

/// A ball in plush on a lawn, with a camera: the lawn by the extension `PELAGE_skin` on its mesh, the plush by custom
/// properties of the ball's material, as Blender writes them.
pub fn dressed() -> Vec<u8> {
    let mut file = Buffers::default();
    let lawn = file.surface(12, 12, |u, v| [vec3(4.0 * u - 2.0, 0.0, 2.0 - 4.0 * v), Vec3::Y]);
    let ball = file.surface(32, 16, |u, v| {
        // The last column stands where the first does, and both poles are points.
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u.fract()).sin_cos(), (PI * v).sin_cos());
        let sin_v = if v == 1.0 { 0.0 } else { sin_v };
        let normal = vec3(sin_v * sin_u, -cos_v, sin_v * cos_u);
        [vec3(0.0, 0.55, 0.0) + 0.5 * normal, normal]
    });
    let json = json!({
        "asset": { "version": "2.0", "generator": "pelage make_assets" },
        "extensionsUsed": ["PELAGE_skin"],
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "name": "Lawn", "mesh": 0 },
            { "name": "Ball", "mesh": 1 },
            { "name": "Camera", "camera": 0, "translation": [0, 1.1, 3.2], "rotation": [-0.0958458, 0, 0, 0.9953962] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.62, "znear": 0.01 } }],
        "materials": [
            { "name": "Earth", "pbrMetallicRoughness": { "baseColorFactor": [0.12, 0.09, 0.06, 1], "metallicFactor": 0 } },
            {
                "name": "Plush",
                "pbrMetallicRoughness": { "baseColorFactor": [0.7, 0.25, 0.12, 1], "metallicFactor": 0 },
                "extras": { "pelage_texel": "fur:plush", "pelage_height": 0.06, "pelage_resolution": 64 },
            },
        ],
        "meshes": [
            {
                "name": "lawn",
                "primitives": [lawn.primitive(0)],
                "extensions": { "PELAGE_skin": {
                    "texel": { "grass": { "preset": "lawn", "resolution": 64 } },
                    "height": 0.12,
                    "wears_material": false,
                    "groom": [{ "noise": { "tilt": 15, "height": 0.2, "size": 0.4 } }],
                } },
            },
            { "name": "ball", "primitives": [ball.primitive(1)] },
        ],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    glb(json.to_string(), &file.bytes)
}

/// The numbers of a file, and what tells of them.
#[derive(Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// The accessors of a surface: positions, normals, texture coordinates, indices.
struct Surface([usize; 4]);

impl Surface {
    fn primitive(&self, material: usize) -> Value {
        let [position, normal, uv, indices] = self.0;
        json!({
            "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv },
            "indices": indices,
            "material": material,
        })
    }
}

impl Buffers {
    /// A grid of positions and normals over `[0,1]²`, two triangles a cell.
    fn surface(&mut self, columns: u16, rows: u16, at: impl Fn(f32, f32) -> [Vec3; 2]) -> Surface {
        let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
        for (i, j) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))) {
            let [u, v] = [f32::from(i) / f32::from(columns), f32::from(j) / f32::from(rows)];
            let [position, normal] = at(u, v);
            positions.push(position.to_array());
            normals.push(normal.to_array());
            // glTF's v runs downwards.
            uvs.push([u, 1.0 - v]);
        }
        let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| j * (columns + 1) + i));
        let indices: Vec<u16> = cells
            .flat_map(|k| [[k, k + 1, k + columns + 2], [k, k + columns + 2, k + columns + 1]].concat())
            .collect();
        let lo = positions.iter().copied().map(Vec3::from).fold(Vec3::INFINITY, Vec3::min);
        let hi = positions.iter().copied().map(Vec3::from).fold(Vec3::NEG_INFINITY, Vec3::max);
        let position = self.list("VEC3", positions.len(), &floats(&positions));
        self.accessors[position]["min"] = json!(lo.to_array());
        self.accessors[position]["max"] = json!(hi.to_array());
        let normal = self.list("VEC3", normals.len(), &floats(&normals));
        let uv = self.list("VEC2", uvs.len(), &floats(&uvs));
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let index = self.list("SCALAR", indices.len(), &bytes);
        self.accessors[index]["componentType"] = 5123.into();
        Surface([position, normal, uv, index])
    }

    /// An accessor of floats.
    fn list(&mut self, kind: &str, count: usize, bytes: &[u8]) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.views.len() - 1;
        self.accessors
            .push(json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }));
        self.accessors.len() - 1
    }
}

fn floats<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

/// A binary glTF file of these two chunks.
pub fn glb(json: String, bin: &[u8]) -> Vec<u8> {
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = Vec::new();
    glb.extend_from_slice(b"glTF");
    for word in [2, (12 + 8 + json.len() + 8 + bin.len()) as u32, json.len() as u32] {
        glb.extend_from_slice(&word.to_le_bytes());
    }
    glb.extend_from_slice(b"JSON");
    glb.extend_from_slice(&json);
    glb.extend_from_slice(&(bin.len() as u32).to_le_bytes());
    glb.extend_from_slice(b"BIN\0");
    glb.extend_from_slice(bin);
    glb
}
