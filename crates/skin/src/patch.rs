//! The skin itself: shared vertices, the patches between them, and the box over each patch.

use glam::{Vec2, Vec3};
use pelage_geom::{Attribute, DTrilinear, Face, Hexahedron, MaterialId, Trilinear};

use crate::Report;

/// Texel coordinates of a patch: affine in its box coordinates.
///
/// A point at box coordinates (u, v) lies at (s, t) = `origin` + u·`u` + v·`v`, counted in copies of the texel:
/// whole numbers are the borders between copies, and w is the texel's own. Only the fractional parts matter, so
/// each patch is shifted by whole numbers to lie near 0, and neighbours may differ by whole numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// (s, t) at corner A.
    pub origin: Vec2,
    /// Change of (s, t) from A to B.
    pub u: Vec2,
    /// Change of (s, t) from A to C.
    pub v: Vec2,
}

impl Lattice {
    /// One copy of the texel, whole, on the patch.
    pub const UNIT: Self = Self { origin: Vec2::ZERO, u: Vec2::X, v: Vec2::Y };

    /// Texel coordinates at box coordinates `uv`.
    #[inline]
    pub fn point(&self, uv: Vec2) -> Vec2 {
        self.origin + uv.x * self.u + uv.y * self.v
    }

    /// Area of the unit square of box coordinates, in copies; negative where the texel is mirrored.
    pub fn determinant(&self) -> f32 {
        self.u.perp_dot(self.v)
    }
}

/// Which copies of the texel a patch lies in. A copy that several patches share has the same island and number for all
/// of them, so that what varies from copy to copy is one thing in all of its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Anchor {
    /// The part of the surface in which copies are numbered: a chart where they go by texture coordinates, else a face.
    pub island: u32,
    /// The number there of the copy that the patch's [`Lattice`] has between (0, 0) and (1, 1).
    pub first: [i32; 2],
}

impl Anchor {
    /// The number in the island of a copy of the lattice.
    #[inline]
    pub fn number(&self, copy: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|axis| self.first[axis].wrapping_add(copy[axis]))
    }
}

/// A quad or a triangle of the base surface, with the box that stands on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Corners A, B, C, D in box order (index u + 2v), in [`Skin::base`] and [`Skin::top`]; D is [`Face::NONE`]
    /// for a prism.
    pub vertices: [u32; 4],
    /// The face of the mesh that it covers, whole or in part.
    pub face: u32,
    /// What that face wears.
    pub material: MaterialId,
    /// Where in the texel it lies.
    pub lattice: Lattice,
    /// In which of its copies.
    pub anchor: Anchor,
}

impl Patch {
    /// Whether its box is a prism.
    pub fn is_prism(&self) -> bool {
        self.vertices[3] == Face::NONE
    }

    /// The three or four indices, in box order.
    pub fn corners(&self) -> &[u32] {
        if self.is_prism() { &self.vertices[..3] } else { &self.vertices }
    }

    /// The same indices counter-clockwise around the patch, seen from outside, as a [`Face`] holds them.
    pub fn outline(&self) -> [u32; 4] {
        let [a, b, c, d] = self.vertices;
        if self.is_prism() { [a, b, c, Face::NONE] } else { [a, b, d, c] }
    }
}

/// All the boxes of a surface. Neighbours share whole walls: the same vertex indices, so the same points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Where the boxes stand, by vertex; scene space, metres.
    pub base: Vec<Vec3>,
    /// Where they reach, by vertex: a box goes from `base[i]` to `top[i]`.
    pub top: Vec<Vec3>,
    /// One box each.
    pub patches: Vec<Patch>,
    /// The mesh's own texture coordinates by patch and corner, in box order, for colour textures. A prism's
    /// fourth completes the parallelogram.
    pub uvs: Option<Vec<[Vec2; 4]>>,
    /// The mesh's vertex attributes, by vertex of the skin.
    pub attributes: Vec<Attribute>,
    /// What multiplies the colours of what fills it, by vertex; linear. `None` is white.
    pub colors: Option<Vec<Vec3>>,
    /// How it came about.
    pub report: Report,
}

impl Skin {
    /// The box over patch `patch`, an index below [`Skin::len`].
    #[inline]
    pub fn hexahedron(&self, patch: usize) -> Hexahedron {
        hexahedron(&self.patches[patch].vertices, &self.base, &self.top)
    }

    /// The smallest and largest coordinates of the box over patch `patch`, an index below [`Skin::len`]; of a
    /// prism only its own six points count.
    #[inline]
    pub fn bounds(&self, patch: usize) -> [Vec3; 2] {
        let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        self.patches[patch].corners().iter().fold(empty, |[lo, hi], &i| {
            let (base, top) = (self.base[i as usize], self.top[i as usize]);
            [lo.min(base).min(top), hi.max(base).max(top)]
        })
    }

    /// What multiplies the colours of what fills patch `patch`, at box coordinates (u, v): between its corners as the box
    /// is. White where [`Skin::colors`] tells nothing.
    pub fn color(&self, patch: usize, [u, v]: [f32; 2]) -> Vec3 {
        let Some((colors, patch)) = self.colors.as_ref().zip(self.patches.get(patch)) else {
            return Vec3::ONE;
        };
        let of = |i: u32| colors.get(i as usize).copied().unwrap_or(Vec3::ONE);
        let [a, b, c, d] = patch.vertices;
        if patch.is_prism() {
            of(a) + u * (of(b) - of(a)) + v * (of(c) - of(a))
        } else {
            of(a).lerp(of(b), u).lerp(of(c).lerp(of(d), u), v)
        }
    }

    /// How many boxes there are.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }
}

/// The map of the box on `vertices` alone, without what rays ask of its walls; a prism's is completed as
/// [`Hexahedron::prism`] does.
#[inline]
pub(crate) fn map(vertices: &[u32; 4], base: &[Vec3], top: &[Vec3]) -> DTrilinear {
    let [a, b, c, d] = vertices.map(|i| i as usize);
    let corners = |points: &[Vec3]| {
        let [a, b, c] = [points[a], points[b], points[c]].map(Vec3::as_dvec3);
        let d = if vertices[3] == Face::NONE { b + c - a } else { points[d].as_dvec3() };
        [a, b, c, d]
    };
    DTrilinear::new(corners(base), corners(top))
}

/// The box on `vertices` (box order; the fourth [`Face::NONE`] for a prism).
#[inline]
pub(crate) fn hexahedron(vertices: &[u32; 4], base: &[Vec3], top: &[Vec3]) -> Hexahedron {
    let [a, b, c, d] = vertices.map(|i| i as usize);
    if vertices[3] == Face::NONE {
        let triangle = |points: &[Vec3]| [points[a], points[b], points[c]];
        Hexahedron::prism(triangle(base), triangle(top))
    } else {
        let box_order = |points: &[Vec3]| [points[a], points[b], points[c], points[d]];
        Hexahedron::cuboid(Trilinear::new(box_order(base), box_order(top)))
    }
}
