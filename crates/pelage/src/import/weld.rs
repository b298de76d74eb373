//! Builds a mesh from loose polygons: corners at exactly equal positions become one vertex, so that neighbouring
//! faces share it and the skin over them is closed. What differs between faces stays with their corners.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use pelage_geom::{Face, MaterialId, Mesh};

/// One corner of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) position: Vec3,
    /// v upwards.
    pub(crate) uv: Option<Vec2>,
    /// Any length.
    pub(crate) normal: Option<Vec3>,
}

/// A mesh in the making.
#[derive(Default)]
pub(crate) struct Welder {
    mesh: Mesh,
    vertex_at: HashMap<[u32; 3], u32>,
    uvs: Vec<[Vec2; 4]>,
    normals: Vec<[Vec3; 4]>,
    without_uvs: usize,
    without_normals: usize,
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
    pub(crate) fn new(name: impl Into<String>) -> Self {
        Self { mesh: Mesh { name: name.into(), ..Mesh::default() }, ..Self::default() }
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
        for (i, corner) in corners.iter().enumerate() {
            vertices[i] = self.vertex(corner.position);
            uvs[i] = corner.uv.unwrap_or_default();
            normals[i] = corner.normal.and_then(Vec3::try_normalize).unwrap_or_default();
        }
        self.without_uvs += usize::from(corners.iter().any(|c| c.uv.is_none()));
        self.without_normals += usize::from(normals[..corners.len()].contains(&Vec3::ZERO));
        self.mesh.faces.push(Face { vertices, material });
        self.uvs.push(uvs);
        self.normals.push(normals);
    }

    fn vertex(&mut self, position: Vec3) -> u32 {
        // Adding zero makes −0 and +0 the same.
        let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
        *self.vertex_at.entry(key).or_insert_with(|| {
            self.mesh.positions.push(position);
            self.mesh.positions.len() as u32 - 1
        })
    }

    /// The mesh. Attributes are kept if every face has them.
    pub(crate) fn finish(self) -> (Mesh, Lost) {
        let Self { mut mesh, uvs, normals, without_uvs, without_normals, .. } = self;
        let count = mesh.faces.len();
        mesh.uvs = (without_uvs == 0).then_some(uvs);
        mesh.normals = (without_normals == 0).then_some(normals);
        let lost = |without| without > 0 && without < count;
        (mesh, Lost { uvs: lost(without_uvs), normals: lost(without_normals) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f32, y: f32) -> Corner {
        Corner { position: Vec3::new(x, y, 0.0), uv: Some(Vec2::new(x, y)), normal: Some(Vec3::Z) }
    }

    #[test]
    fn neighbours_share_vertices_and_quads_stay_quads() {
        let mut welder = Welder::new("strip");
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
        let mut welder = Welder::new("");
        let corners = [corner(0., 0.), corner(2., 0.), corner(3., 1.), corner(1., 2.), corner(-1., 1.)];
        assert_eq!(welder.polygon(&corners, MaterialId(0)), 3);
        assert_eq!(welder.polygon(&corners[..2], MaterialId(0)), 0);
        let (mesh, _) = welder.finish();
        // Shoelace: ½ |0 + 2 + (6−1) + (1+2) + 0| = 5.
        assert!((mesh.area() - 5.0).abs() < 1e-6);
    }

    #[test]
    fn attributes_are_all_or_nothing() {
        let mut welder = Welder::new("");
        let bare = Corner { uv: None, normal: Some(Vec3::ZERO), ..corner(0., 0.) };
        welder.polygon(&[corner(0., 0.), corner(1., 0.), corner(1., 1.)], MaterialId(0));
        welder.polygon(&[bare, corner(1., 0.), corner(1., 1.)], MaterialId(0));
        let (mesh, lost) = welder.finish();
        assert_eq!((mesh.uvs, mesh.normals), (None, None));
        assert_eq!(lost, Lost { uvs: true, normals: true });
    }
}
