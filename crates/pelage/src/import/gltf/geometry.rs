//! glTF primitives to meshes: triangles of every kind, morphed and posed as the file stands.

use glam::{Mat4, Vec2, Vec3};
use gltf::json;
use json::Index;
use json::accessor::Accessor;
use json::mesh::{Mode, Primitive, Semantic};
use json::validation::Checked;
use pelage_geom::{MaterialId, Mesh};

use super::super::weld::{Corner, Welder};
use super::super::{Fault, ImportError};
use super::Importer;

/// What bends a mesh away from its own coordinates.
pub(super) struct Pose<'a> {
    /// How much of each morph target is added.
    pub(super) weights: &'a [f32],
    /// For each joint: joint to scene × inverse bind matrix. `None` without a skin.
    pub(super) joints: Option<Vec<Mat4>>,
}

impl Importer<'_> {
    /// All primitives of a mesh in one, in the mesh's own coordinates (in scene space if it is skinned), or `None`
    /// if there is no face in it.
    pub(super) fn mesh(
        &mut self,
        index: usize,
        name: &str,
        pose: &Pose,
    ) -> Result<Option<Mesh>, ImportError> {
        let mut welder = Welder::new(name);
        for p in 0..self.document.root.meshes[index].primitives.len() {
            self.primitive(index, p, pose, &mut welder)?;
        }
        if welder.is_empty() {
            return Ok(None);
        }
        let (mesh, lost) = welder.finish();
        if lost.uvs || lost.normals {
            self.warn(
                format!("meshes[{index}]"),
                "texture coordinates or normals that only some primitives have are left out".into(),
            );
        }
        Ok(Some(mesh))
    }

    fn primitive(
        &mut self,
        mesh: usize,
        p: usize,
        pose: &Pose,
        welder: &mut Welder,
    ) -> Result<(), ImportError> {
        let document = &self.document;
        let primitive = &document.root.meshes[mesh].primitives[p];
        let field = format!("meshes[{mesh}].primitives[{p}]");
        let fault = |fault: Fault| document.fault(field.as_str(), fault);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(fault(Fault::Syntax("has an unknown mode".into())));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.warn(field, "points and lines are left out".into());
            return Ok(());
        }
        let Some(positions) = attribute(primitive, Semantic::Positions) else {
            self.warn(field, "a primitive without positions is left out".into());
            return Ok(());
        };
        let count_of = |i: usize, list: usize| {
            if i == list {
                Ok(())
            } else {
                Err(fault(Fault::Syntax(format!("has {list} positions, but {i} of another attribute"))))
            }
        };
        let mut positions = document.floats::<3>(positions)?;
        let count = positions.len();
        let material = match primitive.material {
            Some(index) => {
                document.get(&document.root.materials, index, "material", &field)?;
                index.value()
            }
            None => self.materials.list.len() - 1,
        };
        let uv_map = self.materials.uv_maps[material];
        let uvs = attribute(primitive, Semantic::TexCoords(uv_map.set)).map(|a| document.floats::<2>(a));
        let uvs = uvs.transpose()?;
        let mut normals =
            attribute(primitive, Semantic::Normals).map(|a| document.floats::<3>(a)).transpose()?;
        count_of(uvs.as_ref().map_or(count, Vec::len), count)?;
        count_of(normals.as_ref().map_or(count, Vec::len), count)?;
        for (target, &weight) in primitive.targets.iter().flatten().zip(pose.weights) {
            add_morph(&mut positions, target.positions.map(|a| document.floats(a)).transpose()?, weight);
            if let Some(normals) = &mut normals {
                add_morph(normals, target.normals.map(|a| document.floats(a)).transpose()?, weight);
            }
        }
        let mut mirrored = false;
        if let Some(joints) = &pose.joints {
            let blend = self.blend(primitive, joints, count, &field)?;
            mirrored = blend.first().is_some_and(|m| m.determinant() < 0.0);
            for (p, m) in positions.iter_mut().zip(&blend) {
                *p = m.transform_point3(Vec3::from(*p)).to_array();
            }
            for (n, m) in normals.iter_mut().flatten().zip(&blend) {
                *n = m.transform_vector3(Vec3::from(*n)).to_array();
            }
        }
        if let Some(bad) = positions.iter().find(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(fault(Fault::NotANumber(format!("{bad:?}"))));
        }
        let indices = match primitive.indices {
            Some(index) => document.unsigned::<1>(index)?.into_iter().map(|[i]| i).collect(),
            None => (0..count as u32).collect::<Vec<_>>(),
        };
        if let Some(&index) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(fault(Fault::Index { what: "vertex", index: i64::from(index), count }));
        }
        let corner = |i: u32| {
            let i = i as usize;
            Corner {
                position: Vec3::from(positions[i]),
                uv: uvs.as_ref().and_then(|uvs| uv_map.apply(Vec2::from(uvs[i]))),
                normal: normals.as_ref().map(|normals| Vec3::from(normals[i])),
            }
        };
        let mut faces = 0;
        for mut triangle in triangles(mode, &indices) {
            if mirrored {
                triangle.swap(1, 2);
            }
            faces += welder.polygon(&triangle.map(corner), MaterialId(material as u32));
        }
        self.count_faces(faces, &field)
    }

    /// The matrix of each vertex of a skinned primitive: Σ weight · joint. [glTF §3.7.3]
    fn blend(
        &self,
        primitive: &Primitive,
        joints: &[Mat4],
        count: usize,
        field: &str,
    ) -> Result<Vec<Mat4>, ImportError> {
        let mut blend = vec![Mat4::ZERO; count];
        let mut total = vec![0.0_f32; count];
        for set in 0.. {
            let (Some(j), Some(w)) =
                (attribute(primitive, Semantic::Joints(set)), attribute(primitive, Semantic::Weights(set)))
            else {
                break;
            };
            let (indices, weights) = (self.document.unsigned::<4>(j)?, self.document.floats::<4>(w)?);
            for (vertex, (indices, weights)) in indices.iter().zip(&weights).enumerate().take(count) {
                for (&index, &weight) in indices.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
                    let joint = joints.get(index as usize).ok_or_else(|| {
                        let (index, count) = (i64::from(index), joints.len());
                        self.document.fault(field, Fault::Index { what: "joint", index, count })
                    })?;
                    blend[vertex] += *joint * weight;
                    total[vertex] += weight;
                }
            }
        }
        for (matrix, total) in blend.iter_mut().zip(total) {
            // Weights should add up to one, and quantised ones nearly do. A vertex without any stays where it is.
            *matrix = if total > 0.0 { *matrix * (1.0 / total) } else { Mat4::IDENTITY };
        }
        Ok(blend)
    }
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

fn add_morph(values: &mut [[f32; 3]], deltas: Option<Vec<[f32; 3]>>, weight: f32) {
    for (value, delta) in values.iter_mut().zip(deltas.unwrap_or_default()) {
        *value = (Vec3::from(*value) + weight * Vec3::from(delta)).to_array();
    }
}

/// The triangles of an index list, all wound the same way. [glTF §3.7.2.1]
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => match indices {
            [first, rest @ ..] => rest.windows(2).map(|w| [*first, w[0], w[1]]).collect(),
            [] => Vec::new(),
        },
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans() {
        let list = [0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::TriangleStrip, &list), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(triangles(Mode::TriangleFan, &list), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(triangles(Mode::Triangles, &list), [[0, 1, 2]]);
        assert!(triangles(Mode::TriangleFan, &[]).is_empty());
    }
}
