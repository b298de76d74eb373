//! Builds a mesh from loose polygons: corners at exactly equal positions become one vertex, so that neighbouring
//! faces share it and the skin over them is closed. What differs between faces stays with their corners.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use pelage_geom::{Attribute, Face, MaterialId, Mesh};

/// One corner of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) position: Vec3,
    /// v upwards.
    pub(crate) uv: Option<Vec2>,
    /// Any length.
    pub(crate) normal: Option<Vec3>,
    /// Linear, with alpha.
    pub(crate) color: Option<Vec4>,
}

/// A mesh in the making.
#[derive(Default)]
pub(crate) struct Welder {
    mesh: Mesh,
    vertex_at: HashMap<[u32; 3], u32>,
    uvs: Vec<[Vec2; 4]>,
    normals: Vec<[Vec3; 4]>,
    colors: Vec<[Vec4; 4]>,
    without_uvs: usize,
    without_normals: usize,
    has_colors: bool,
    /// Texture coordinates that only some faces have are kept: zero elsewhere.
    patchy: bool,
}

/// What a finished mesh had to do without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    /// Some faces have texture coordinates, but not all: none are kept.
    pub(crate) uvs: bool,
    /// Some faces have usable normals, but not all: none are kept.
    pub(crate) normals: bool,
}

impl Welder {
    /// With `patchy`, texture coordinates that only some faces have are kept, and zero elsewhere.
    pub(crate) fn new(name: impl Into<String>, patchy: bool) -> Self {
        Self { mesh: Mesh { name: name.into(), ..Mesh::default() }, patchy, ..Self::default() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.mesh.faces.is_empty()
    }

    /// Adds a polygon: triangles and quads as they are, larger ones as a fan around their first corner. Returns
    /// how many faces were added; fewer than three corners are none.
    pub(crate) fn polygon(&mut self, corners: &[Corner], material: MaterialId) -> usize {
        match corners {
            [_, _, _] | [_, _, _, _] => {
                self.face(corners, material);
                1
            }
            [first, rest @ ..] => {
                for pair in rest.windows(2) {
                    self.face(&[*first, pair[0], pair[1]], material);
                }
                rest.len().saturating_sub(1)
            }
            [] => 0,
        }
    }

    fn face(&mut self, corners: &[Corner], material: MaterialId) {
        let mut vertices = [Face::NONE; 4];
        let mut uvs = [Vec2::ZERO; 4];
        let mut normals = [Vec3::ZERO; 4];
        let mut colors = [Vec4::ONE; 4];
        for (i, corner) in corners.iter().enumerate() {
            vertices[i] = self.vertex(corner.position);
            uvs[i] = corner.uv.unwrap_or_default();
            normals[i] = corner.normal.and_then(Vec3::try_normalize).unwrap_or_default();
            colors[i] = corner.color.unwrap_or(Vec4::ONE);
            self.has_colors |= corner.color.is_some();
        }
        self.without_uvs += usize::from(corners.iter().any(|c| c.uv.is_none()));
        self.without_normals += usize::from(normals[..corners.len()].contains(&Vec3::ZERO));
        self.mesh.faces.push(Face { vertices, material });
        self.uvs.push(uvs);
        self.normals.push(normals);
        self.colors.push(colors);
    }

    fn vertex(&mut self, position: Vec3) -> u32 {
        *self.vertex_at.entry(key(position)).or_insert_with(|| {
            self.mesh.positions.push(position);
            self.mesh.positions.len() as u32 - 1
        })
    }

    /// Says something of the vertices at some positions; those that no face has are passed over, and numbers that are
    /// not finite are 0.
    pub(crate) fn attribute(&mut self, name: &str, positions: &[Vec3], numbers: &[f32]) {
        let attributes = &mut self.mesh.attributes;
        let index = attributes.iter().position(|a| a.name == name).unwrap_or_else(|| {
            attributes.push(Attribute { name: name.to_owned(), values: Vec::new() });
            attributes.len() - 1
        });
        let values = &mut attributes[index].values;
        values.resize(self.mesh.positions.len(), 0.0);
        for (position, &number) in positions.iter().zip(numbers) {
            if let Some(&vertex) = self.vertex_at.get(&key(*position)) {
                values[vertex as usize] = if number.is_finite() { number } else { 0.0 };
            }
        }
    }

    /// The mesh. Texture coordinates and normals are kept if every face has them, colours if one has.
    pub(crate) fn finish(self) -> (Mesh, Lost) {
        let Self { mut mesh, uvs, normals, colors, without_uvs, without_normals, has_colors, .. } = self;
        let count = mesh.faces.len();
        let without_uvs = if self.patchy && without_uvs < count { 0 } else { without_uvs };
        mesh.uvs = (without_uvs == 0).then_some(uvs);
        mesh.normals = (without_normals == 0).then_some(normals);
        mesh.colors = has_colors.then_some(colors);
        for attribute in &mut mesh.attributes {
            // Faces that came later may have brought vertices that do not have it.
            attribute.values.resize(mesh.positions.len(), 0.0);
        }
        let lost = |without| without > 0 && without < count;
        (mesh, Lost { uvs: lost(without_uvs), normals: lost(without_normals) })
    }
}

/// The same for equal positions. Adding zero makes −0 and +0 the same.
fn key(position: Vec3) -> [u32; 3] {
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f32, y: f32) -> Corner {
        Corner {
            position: Vec3::new(x, y, 0.0),
            uv: Some(Vec2::new(x, y)),
            normal: Some(Vec3::Z),
            color: None,
        }
    }

    #[test]
    fn neighbours_share_vertices_and_quads_stay_quads() {
        let mut welder = Welder::new("strip", false);
        welder.polygon(&[corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)], MaterialId(0));
        welder.polygon(&[corner(1., -0.0), corner(2., 0.), corner(2., 1.), corner(1., 1.)], MaterialId(0));
        let (mesh, lost) = welder.finish();
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(mesh.faces[1].vertices, [1, 4, 5, 2]);
        assert!(mesh.faces.iter().all(Face::is_quad));
        assert_eq!(lost, Lost::default());
        assert_eq!(mesh.validate(), Ok(()));
    }

    #[test]
    fn a_pentagon_is_a_fan_of_three() {
        let mut welder = Welder::new("", false);
        let corners = [corner(0., 0.), corner(2., 0.), corner(3., 1.), corner(1., 2.), corner(-1., 1.)];
        assert_eq!(welder.polygon(&corners, MaterialId(0)), 3);
        assert_eq!(welder.polygon(&corners[..2], MaterialId(0)), 0);
        let (mesh, _) = welder.finish();
        // Shoelace: ½ |0 + 2 + (6−1) + (1+2) + 0| = 5.
        assert!((mesh.area() - 5.0).abs() < 1e-6);
    }

    #[test]
    fn attributes_are_all_or_nothing() {
        let mut welder = Welder::new("", false);
        let bare = Corner { uv: None, normal: Some(Vec3::ZERO), ..corner(0., 0.) };
        welder.polygon(&[corner(0., 0.), corner(1., 0.), corner(1., 1.)], MaterialId(0));
        welder.polygon(&[bare, corner(1., 0.), corner(1., 1.)], MaterialId(0));
        let (mesh, lost) = welder.finish();
        assert_eq!((mesh.uvs, mesh.normals), (None, None));
        assert_eq!(lost, Lost { uvs: true, normals: true });
    }
}
