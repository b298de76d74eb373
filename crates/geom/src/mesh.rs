//! An indexed mesh of triangles and quads, as importers make it and skins stand on it.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::MaterialId;

/// A triangle or a quad: indices of its corners in [`Mesh::positions`], counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// Three or four indices; the fourth is [`Face::NONE`] for a triangle.
    pub vertices: [u32; 4],
    /// Which material the face wears.
    pub material: MaterialId,
}

impl Face {
    /// The fourth index of a triangle.
    pub const NONE: u32 = u32::MAX;

    /// A triangle.
    pub fn triangle(vertices: [u32; 3], material: MaterialId) -> Self {
        let [a, b, c] = vertices;
        Self { vertices: [a, b, c, Self::NONE], material }
    }

    /// A quad; its four corners follow each other around it.
    pub fn quad(vertices: [u32; 4], material: MaterialId) -> Self {
        Self { vertices, material }
    }

    /// Whether the face has four corners.
    pub fn is_quad(&self) -> bool {
        self.vertices[3] != Self::NONE
    }

    /// The three or four indices.
    pub fn corners(&self) -> &[u32] {
        if self.is_quad() { &self.vertices } else { &self.vertices[..3] }
    }
}

/// An indexed mesh. Vertices that coincide are one vertex (importers weld them), so that neighbouring faces
/// share indices; what differs between the faces at a vertex is kept by corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// What the file called it; may be empty.
    pub name: String,
    /// Scene space, metres.
    pub positions: Vec<Vec3>,
    /// Triangles and quads.
    pub faces: Vec<Face>,
    /// Texture coordinates by face and corner (v upwards, as in OBJ: row 0 of an image is at v = 1).
    pub uvs: Option<Vec<[Vec2; 4]>>,
    /// Shading normals by face and corner, unit length.
    pub normals: Option<Vec<[Vec3; 4]>>,
    /// Linear colours and alpha by face and corner, which multiply the material's. Only content that texels are made
    /// from has them.
    pub colors: Option<Vec<[Vec4; 4]>>,
    /// What else the file says of each vertex.
    pub attributes: Vec<Attribute>,
}

/// One number a vertex, by name: a painted weight, a length, a stiffness.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attribute {
    /// As in the file, with the component after a dot where there are several: `_LENGTH`, `COLOR_0.r`.
    pub name: String,
    /// By vertex.
    pub values: Vec<f32>,
}

/// What makes a mesh unusable; each variant says where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// There is nothing to render.
    #[error("mesh `{mesh}` has no faces")]
    NoFaces {
        /// The mesh's name.
        mesh: String,
    },
    /// A face names a vertex that does not exist.
    #[error("mesh `{mesh}`, face {face}: vertex index {index} is out of range ({count} vertices)")]
    IndexOutOfRange {
        /// The mesh's name.
        mesh: String,
        /// Which face.
        face: usize,
        /// The index it names.
        index: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex is NaN, infinite, or beyond [`Mesh::POSITION_LIMIT`].
    #[error("mesh `{mesh}`, vertex {vertex}: position {position} is not a usable number")]
    NonFinite {
        /// The mesh's name.
        mesh: String,
        /// Which vertex.
        vertex: usize,
        /// What it holds.
        position: Vec3,
    },
    /// A vertex attribute has not one entry a vertex, or holds numbers that are not finite.
    #[error("mesh `{mesh}`: attribute `{attribute}` is unusable at vertex {vertex}")]
    VertexAttribute {
        /// The mesh's name.
        mesh: String,
        /// The attribute's name.
        attribute: String,
        /// The first vertex without a usable entry.
        vertex: usize,
    },
    /// An attribute list has not one entry a face, or holds numbers that are not finite.
    #[error("mesh `{mesh}`: attribute `{attribute}` is unusable at face {face}")]
    Attribute {
        /// The mesh's name.
        mesh: String,
        /// `uvs`, `normals` or `colors`.
        attribute: &'static str,
        /// The first face without a usable entry.
        face: usize,
    },
}

impl Mesh {
    /// Positions must stay below this in magnitude, so that products of three of them fit in an `f32`.
    pub const POSITION_LIMIT: f32 = 1e12;

    /// Checks indices, attribute lengths and numbers, so that what follows need not.
    ///
    /// # Errors
    /// The first fault found, with its face or vertex.
    pub fn validate(&self) -> Result<(), MeshError> {
        let mesh = || self.name.clone();
        if self.faces.is_empty() {
            return Err(MeshError::NoFaces { mesh: mesh() });
        }
        for (vertex, &position) in self.positions.iter().enumerate() {
            // `cmple` is false for NaN too.
            if !position.abs().cmple(Vec3::splat(Self::POSITION_LIMIT)).all() {
                return Err(MeshError::NonFinite { mesh: mesh(), vertex, position });
            }
        }
        let count = self.positions.len();
        for (face, f) in self.faces.iter().enumerate() {
            if let Some(&index) = f.corners().iter().find(|&&i| i as usize >= count) {
                return Err(MeshError::IndexOutOfRange { mesh: mesh(), face, index, count });
            }
        }
        let usable_uv = |i: usize, uvs: &[[Vec2; 4]]| {
            uvs.get(i).is_some_and(|c| c[..self.faces[i].corners().len()].iter().all(|x| x.is_finite()))
        };
        let usable_normal = |i: usize, normals: &[[Vec3; 4]]| {
            normals.get(i).is_some_and(|c| c[..self.faces[i].corners().len()].iter().all(|x| x.is_finite()))
        };
        let usable_color = |i: usize, colors: &[[Vec4; 4]]| {
            colors.get(i).is_some_and(|c| c[..self.faces[i].corners().len()].iter().all(|x| x.is_finite()))
        };
        for face in 0..self.faces.len() {
            if self.uvs.as_ref().is_some_and(|uvs| !usable_uv(face, uvs)) {
                return Err(MeshError::Attribute { mesh: mesh(), attribute: "uvs", face });
            }
            if self.normals.as_ref().is_some_and(|normals| !usable_normal(face, normals)) {
                return Err(MeshError::Attribute { mesh: mesh(), attribute: "normals", face });
            }
            if self.colors.as_ref().is_some_and(|colors| !usable_color(face, colors)) {
                return Err(MeshError::Attribute { mesh: mesh(), attribute: "colors", face });
            }
        }
        for Attribute { name, values } in &self.attributes {
            let usable = |i: usize| values.get(i).is_some_and(|x| x.is_finite());
            if let Some(vertex) = (0..count.max(values.len())).find(|&i| i >= count || !usable(i)) {
                return Err(MeshError::VertexAttribute { mesh: mesh(), attribute: name.clone(), vertex });
            }
        }
        Ok(())
    }

    /// Moves the mesh by `transform`; normals turn by its inverse transpose, and a mirroring transform
    /// reverses the faces so that they still wind counter-clockwise seen from outside.
    pub fn transform(&mut self, transform: Mat4) {
        for p in &mut self.positions {
            *p = transform.transform_point3(*p);
        }
        let linear = glam::Mat3::from_mat4(transform);
        if let Some(normals) = &mut self.normals {
            // The cofactor matrix is the inverse transpose up to a factor, and exists for a singular matrix too.
            let cofactor = glam::Mat3::from_cols(
                linear.y_axis.cross(linear.z_axis),
                linear.z_axis.cross(linear.x_axis),
                linear.x_axis.cross(linear.y_axis),
            ) * linear.determinant().signum();
            for n in normals.iter_mut().flatten() {
                *n = (cofactor * *n).normalize_or(*n);
            }
        }
        if linear.determinant() < 0.0 {
            self.reverse_faces();
        }
    }

    fn reverse_faces(&mut self) {
        for i in 0..self.faces.len() {
            // Keeping the first corner leaves a quad's (u, v) axes exchanged rather than shifted.
            let last = self.faces[i].corners().len() - 1;
            self.faces[i].vertices.swap(1, last);
            if let Some(uvs) = &mut self.uvs {
                uvs[i].swap(1, last);
            }
            if let Some(normals) = &mut self.normals {
                normals[i].swap(1, last);
            }
            if let Some(colors) = &mut self.colors {
                colors[i].swap(1, last);
            }
        }
    }

    /// The smallest and largest coordinates, or `None` without vertices.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold([first; 2], |[lo, hi], &p| [lo.min(p), hi.max(p)]))
    }

    /// Area-weighted normal of face `index` (half the cross product of its diagonals for a quad): its length
    /// is the face's area.
    pub fn area_vector(&self, index: usize) -> Vec3 {
        let face = &self.faces[index];
        let p = |i: usize| self.positions[face.vertices[i] as usize];
        if face.is_quad() {
            0.5 * (p(2) - p(0)).cross(p(3) - p(1))
        } else {
            0.5 * (p(1) - p(0)).cross(p(2) - p(0))
        }
    }

    /// The total area of all faces, in square metres.
    pub fn area(&self) -> f32 {
        (0..self.faces.len()).map(|i| f64::from(self.area_vector(i).length())).sum::<f64>() as f32
    }
}
