//! glTF primitives to meshes and strands: triangles and lines of every kind, morphed and posed as the file stands.

use glam::{Mat4, Vec2, Vec3, Vec4};
use gltf::json;
use json::Index;
use json::accessor::{Accessor, Type};
use json::mesh::{Mode, Primitive, Semantic};
use json::validation::Checked;
use pelage_geom::{MaterialId, Mesh};

use super::super::strand::{Strand, chains};
use super::super::weld::{Corner, Welder};
use super::super::{Fault, ImportError};
use super::Importer;
use super::material::UvMap;

/// What bends a mesh away from its own coordinates.
pub(super) struct Pose<'a> {
    /// How much of each morph target is added.
    pub(super) weights: &'a [f32],
    /// For each joint: joint to scene × inverse bind matrix. `None` without a skin.
    pub(super) joints: Option<Vec<Mat4>>,
}

/// The vertices of a primitive; its lists are as long as its positions.
struct Vertices {
    positions: Vec<[f32; 3]>,
    /// v upwards; `None` for those that are not finite.
    uvs: Option<Vec<Option<Vec2>>>,
    normals: Option<Vec<[f32; 3]>>,
    colors: Option<Vec<Vec4>>,
    radii: Option<Vec<f32>>,
    /// Whether the pose turned it inside out.
    mirrored: bool,
}

impl Vertices {
    fn corner(&self, i: usize) -> Corner {
        Corner {
            position: Vec3::from(self.positions[i]),
            uv: self.uvs.as_ref().and_then(|uvs| uvs[i]),
            normal: self.normals.as_ref().map(|normals| Vec3::from(normals[i])),
            color: self.colors.as_ref().map(|colors| colors[i]),
        }
    }

    fn strand(&self, chain: &[u32], material: MaterialId) -> Strand {
        let at = || chain.iter().map(|&i| i as usize);
        Strand {
            points: at().map(|i| Vec3::from(self.positions[i])).collect(),
            radii: self.radii.as_ref().map(|radii| at().map(|i| radii[i]).collect()),
            uvs: self.uvs.as_ref().map(|uvs| at().map(|i| uvs[i].unwrap_or_default()).collect()),
            colors: self.colors.as_ref().map(|colors| at().map(|i| colors[i]).collect()),
            material,
        }
    }
}

impl Importer<'_> {
    /// All triangles of a mesh in one, in the mesh's own coordinates (in scene space if it is skinned), or `None` if
    /// there is no face in it. Its strands go to what is imported, in the same coordinates.
    pub(super) fn mesh(
        &mut self,
        index: usize,
        name: &str,
        pose: &Pose,
    ) -> Result<Option<Mesh>, ImportError> {
        let mut welder = Welder::new(name, self.content);
        for p in 0..self.document.root.meshes[index].primitives.len() {
            self.primitive(index, p, pose, &mut welder)?;
        }
        if welder.is_empty() {
            return Ok(None);
        }
        let (mesh, lost) = welder.finish();
        if lost.uvs || lost.normals && !self.content {
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
        let is_strands = match mode {
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => false,
            Mode::Lines | Mode::LineLoop | Mode::LineStrip if self.content => true,
            _ => {
                let left_out = if self.content { "points are" } else { "points and lines are" };
                self.warn(field, format!("{left_out} left out"));
                return Ok(());
            }
        };
        if attribute(primitive, Semantic::Positions).is_none() {
            self.warn(field, "a primitive without positions is left out".into());
            return Ok(());
        }
        let material = match primitive.material {
            Some(index) => {
                document.get(&document.root.materials, index, "material", &field)?;
                index.value()
            }
            None => self.materials.list.len() - 1,
        };
        let vertices = self.vertices(primitive, self.materials.uv_maps[material], pose, &field)?;
        let count = vertices.positions.len();
        let indices = match primitive.indices {
            Some(index) => document.unsigned::<1>(index)?.into_iter().map(|[i]| i).collect(),
            None => (0..count as u32).collect::<Vec<_>>(),
        };
        if let Some(&index) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(fault(Fault::Index { what: "vertex", index: i64::from(index), count }));
        }
        let material = MaterialId(material as u32);
        if is_strands {
            let chains = chains(&segments(mode, &indices));
            let strands: Vec<Strand> = chains.iter().map(|chain| vertices.strand(chain, material)).collect();
            let segments = strands.iter().map(|strand| strand.points.len() - 1).sum();
            self.imported.strands.extend(strands);
            return self.count_faces(segments, &field);
        }
        let mut faces = 0;
        for mut triangle in triangles(mode, &indices) {
            if vertices.mirrored {
                triangle.swap(1, 2);
            }
            faces += welder.polygon(&triangle.map(|i| vertices.corner(i as usize)), material);
        }
        if !self.content {
            let positions: Vec<Vec3> = vertices.positions.iter().map(|&p| Vec3::from(p)).collect();
            for name in self.attributes(primitive, &positions, welder) {
                self.warn(field.clone(), format!("attribute `{name}` cannot be used and is left out"));
            }
        }
        self.count_faces(faces, &field)
    }

    /// The vertices of a primitive that has positions, morphed and posed.
    fn vertices(
        &self,
        primitive: &Primitive,
        uv_map: UvMap,
        pose: &Pose,
        field: &str,
    ) -> Result<Vertices, ImportError> {
        let document = &self.document;
        let fault = |fault: Fault| document.fault(field, fault);
        let positions = attribute(primitive, Semantic::Positions).map(|a| document.floats::<3>(a));
        let mut positions = positions.transpose()?.unwrap_or_default();
        let count = positions.len();
        let uvs = attribute(primitive, Semantic::TexCoords(uv_map.set)).map(|a| document.floats::<2>(a));
        let uvs = uvs.transpose()?;
        let mut normals =
            attribute(primitive, Semantic::Normals).map(|a| document.floats::<3>(a)).transpose()?;
        let wanted = |semantic| attribute(primitive, semantic).filter(|_| self.content);
        let colors = wanted(Semantic::Colors(0)).map(|a| self.colors(a)).transpose()?;
        let radii = wanted(Semantic::Extras("RADIUS".into())).map(|a| document.floats::<1>(a)).transpose()?;
        let radii: Option<Vec<f32>> = radii.map(|radii| radii.into_iter().map(|[r]| r).collect());
        let lengths = [
            uvs.as_ref().map(Vec::len),
            normals.as_ref().map(Vec::len),
            colors.as_ref().map(Vec::len),
            radii.as_ref().map(Vec::len),
        ];
        if let Some(other) = lengths.into_iter().flatten().find(|&length| length != count) {
            return Err(fault(Fault::Syntax(format!(
                "has {count} positions, but {other} of another attribute"
            ))));
        }
        for (target, &weight) in primitive.targets.iter().flatten().zip(pose.weights) {
            add_morph(&mut positions, target.positions.map(|a| document.floats(a)).transpose()?, weight);
            if let Some(normals) = &mut normals {
                add_morph(normals, target.normals.map(|a| document.floats(a)).transpose()?, weight);
            }
        }
        let mut mirrored = false;
        if let Some(joints) = &pose.joints {
            let blend = self.blend(primitive, joints, count, field)?;
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
        if let Some(bad) = radii.iter().flatten().find(|r| !(**r >= 0.0 && r.is_finite())) {
            return Err(fault(Fault::NotANumber(format!("the _RADIUS {bad}"))));
        }
        let uvs = uvs.map(|uvs| uvs.into_iter().map(|uv| uv_map.apply(Vec2::from(uv))).collect());
        Ok(Vertices { positions, uvs, normals, colors, radii, mirrored })
    }

    /// Vertex colours: linear, with alpha 1 where there are three channels. [glTF §3.7.2.1]
    fn colors(&self, accessor: Index<Accessor>) -> Result<Vec<Vec4>, ImportError> {
        let document = &self.document;
        let listed = document.get(&document.root.accessors, accessor, "accessor", "accessor")?;
        let colors: Vec<Vec4> = if listed.type_ == Checked::Valid(Type::Vec3) {
            document.floats::<3>(accessor)?.into_iter().map(|rgb| Vec3::from(rgb).extend(1.0)).collect()
        } else {
            document.floats::<4>(accessor)?.into_iter().map(Vec4::from).collect()
        };
        if let Some(bad) = colors.iter().find(|color| !color.is_finite()) {
            let field = format!("accessors[{}]", accessor.value());
            return Err(document.fault(field, Fault::NotANumber(format!("the colour {bad}"))));
        }
        Ok(colors.into_iter().map(|color| color.clamp(Vec4::ZERO, Vec4::ONE)).collect())
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

/// The segments of an index list; those between a vertex and itself are none. [glTF §3.7.2.1]
fn segments(mode: Mode, indices: &[u32]) -> Vec<[u32; 2]> {
    let closing = match (mode, indices) {
        (Mode::LineLoop, [first, .., last]) => Some([*last, *first]),
        _ => None,
    };
    let step = if mode == Mode::Lines { 2 } else { 1 };
    let pairs = indices.windows(2).step_by(step).map(|pair| [pair[0], pair[1]]);
    pairs.chain(closing).filter(|[a, b]| a != b).collect()
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

    #[test]
    fn lines_strips_and_loops() {
        let list = [0, 1, 2, 2, 3];
        assert_eq!(segments(Mode::Lines, &list), [[0, 1]]);
        assert_eq!(segments(Mode::LineStrip, &list), [[0, 1], [1, 2], [2, 3]]);
        assert_eq!(segments(Mode::LineLoop, &list), [[0, 1], [1, 2], [2, 3], [3, 0]]);
        assert!(segments(Mode::LineLoop, &[7]).is_empty());
    }
}
