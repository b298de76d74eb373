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

/// The components of an accessor, with how their names end; `None` for matrices.
fn components(
    document: &Document,
    index: Index<Accessor>,
) -> Result<Option<Vec<(&'static str, Vec<f32>)>>, ImportError> {
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

fn apart<const N: usize>(names: [&'static str; N], elements: &[[f32; N]]) -> Vec<(&'static str, Vec<f32>)> {
    let list = |i: usize| elements.iter().map(|element| element[i]).collect();
    names.into_iter().enumerate().map(|(i, name)| (name, list(i))).collect()
}
