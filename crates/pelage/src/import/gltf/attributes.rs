//! What a primitive says of its vertices besides their geometry: colours, and attributes of the file's own. Grooms
//! are masked by them.

use glam::Vec3;
use gltf::json;
use json::Index;
use json::accessor::{Accessor, Type};
use json::mesh::{Primitive, Semantic};
use json::validation::Checked;

use super::super::ImportError;
use super::super::weld::Welder;
use super::Importer;
use super::buffers::Document;

impl Importer<'_> {
    /// Gives the vertices at `positions`, which are those of `primitive`, its colours and its own attributes; returns
    /// the names of those that cannot be used.
    pub(super) fn attributes(
        &self,
        primitive: &Primitive,
        positions: &[Vec3],
        welder: &mut Welder,
    ) -> Vec<String> {
        let mut unusable = Vec::new();
        for (semantic, &accessor) in &primitive.attributes {
            let Checked::Valid(semantic @ (Semantic::Extras(_) | Semantic::Colors(_))) = semantic else {
                continue;
            };
            let name = semantic.to_string();
            match components(&self.document, accessor) {
                Ok(Some(lists)) if lists.iter().all(|(_, list)| list.len() == positions.len()) => {
                    for (component, values) in lists {
                        welder.attribute(&format!("{name}{component}"), positions, &values);
                    }
                }
                _ => unusable.push(name),
            }
        }
        unusable
    }
}

/// A list of numbers, and how its name ends.
type Component = (&'static str, Vec<f32>);

/// The components of an accessor; `None` for matrices.
fn components(document: &Document, index: Index<Accessor>) -> Result<Option<Vec<Component>>, ImportError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", "accessor")?;
    let Checked::Valid(shape) = accessor.type_ else { return Ok(None) };
    Ok(match shape {
        Type::Scalar => Some(apart([""], &document.floats(index)?)),
        Type::Vec2 => Some(apart([".r", ".g"], &document.floats(index)?)),
        Type::Vec3 => Some(apart([".r", ".g", ".b"], &document.floats(index)?)),
        Type::Vec4 => Some(apart([".r", ".g", ".b", ".a"], &document.floats(index)?)),
        Type::Mat2 | Type::Mat3 | Type::Mat4 => None,
    })
}

fn apart<const N: usize>(names: [&'static str; N], elements: &[[f32; N]]) -> Vec<Component> {
    let list = |i: usize| elements.iter().map(|element| element[i]).collect();
    names.into_iter().enumerate().map(|(i, name)| (name, list(i))).collect()
}

#[cfg(test)]
mod tests {
    use crate::import::{ImportOptions, import};

    /// A triangle with `_LENGTH` (one number), `COLOR_0` (three bytes of 255) and `_ODD`, which has too few elements.
    #[test]
    fn numbers_and_colours_of_vertices_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut binary: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.25, 0.5, 2.0]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        binary.extend([255, 0, 51, 0, 0, 255, 0, 0, 0, 0, 102, 0]);
        std::fs::write(folder.path().join("a.bin"), &binary).expect("a file");
        let text = r#"{
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "_LENGTH": 1, "COLOR_0": 2, "_ODD": 3 } }] }],
            "buffers": [{ "uri": "a.bin", "byteLength": 60 }],
            "bufferViews": [
                { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 12 },
                { "buffer": 0, "byteOffset": 48, "byteLength": 12, "byteStride": 4 }
            ],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
                { "bufferView": 1, "componentType": 5126, "count": 3, "type": "SCALAR" },
                { "bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR" }
            ]
        }"#;
        let path = folder.path().join("a.gltf");
        std::fs::write(&path, text).expect("a file");
        let imported = import(&path, &ImportOptions::default()).expect("a mesh");
        let attributes = &imported.meshes[0].attributes;
        let values = |name: &str| attributes.iter().find(|a| a.name == name).map(|a| a.values.clone());
        assert_eq!(values("_LENGTH"), Some(vec![0.25, 0.5, 2.0]));
        assert_eq!(values("COLOR_0.r"), Some(vec![1.0, 0.0, 0.0]));
        assert_eq!(values("COLOR_0.b"), Some(vec![0.2, 0.0, 0.4]));
        assert_eq!(attributes.len(), 4);
        let warned: Vec<String> = imported.warnings.iter().map(ToString::to_string).collect();
        assert!(
            warned.len() == 1 && warned[0].ends_with("attribute `_ODD` cannot be used and is left out"),
            "{warned:?}"
        );
    }
}
