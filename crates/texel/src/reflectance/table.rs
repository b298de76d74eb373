//! The reflectances of a level as they are kept: in bytes.

use glam::Vec3;
use rayon::prelude::*;

use super::facing::{FACING_BYTES, FACINGS, Facing, Facings};
use super::nodes::{NODES, around};
use super::{Measured, Reflectance, faces_alike};
use crate::packed::unit;

/// Pairs of nodes in any order, and each with itself.
pub(crate) const PAIRS: usize = NODES * (NODES + 1) / 2;

/// Where a pair stands in a table.
#[inline]
pub(super) fn pair(a: usize, b: usize) -> usize {
    let (low, high) = (a.min(b), a.max(b));
    high * (high + 1) / 2 + low
}

/// What is known of a node: of what is seen from there, or lit. 16 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Node {
    /// The root of S, as a part of the voxel's largest.
    pub(super) root: u8,
    /// The fourth root of D with itself, as a part of the voxel's largest: what entries are in parts of.
    pub(super) scale: u8,
    /// Mean colour, square roots.
    pub(super) color: [u8; 3],
    /// Mean normal, of any length up to 1.
    pub(super) normal: [i8; 3],
    /// What is open of the hemispheres, above and below the surface that the texel stands on, and the mean of the open
    /// directions: as [`Surfel::sky`](crate::Surfel::sky).
    pub(super) sky: [(u8, [i8; 3]); 2],
}

const NODE_BYTES: usize = 16;

/// The reflectances of a level's voxels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Reflectances {
    /// [`NODES`] of each voxel.
    nodes: Vec<Node>,
    /// Of each voxel.
    facings: Vec<Facings>,
    /// What the largest entry of each voxel's table stands for, over the largest S.
    largest: Vec<f32>,
    /// Of each voxel D of two nodes over the mean, a geometric one, of D of each with itself, as a part of the largest, square
    /// roots: [`PAIRS`].
    tables: Vec<u8>,
}

/// What a file holds: the largest entries, [`NODES`] nodes, [`FACINGS`] facings and a table of
/// [`PAIRS`] bytes of each voxel.
pub(crate) struct Parts<L, N, F, T> {
    pub(crate) largest: L,
    pub(crate) nodes: N,
    pub(crate) facings: F,
    pub(crate) tables: T,
}

impl Reflectances {
    pub(crate) fn new(each: Vec<Measured>) -> Self {
        let mut all = Self::default();
        for Measured { nodes, facings, largest, table } in each {
            all.nodes.extend(nodes);
            all.facings.push(Facings::new(facings, face_alike(&nodes)));
            all.largest.push(largest);
            all.tables.extend(table);
        }
        all
    }

    /// Whether the level has any.
    pub(crate) fn is_there(&self) -> bool {
        !self.nodes.is_empty()
    }

    /// What a voxel shows to the unit vector `eye` of texel space; `None` if nothing of it is seen from there, or if
    /// nothing is known of it.
    #[inline]
    pub(crate) fn of(&self, voxel: u32, eye: Vec3) -> Option<Reflectance<'_>> {
        let voxel = voxel as usize;
        let nodes = self.nodes.get(voxel * NODES..(voxel + 1) * NODES)?;
        let largest = *self.largest.get(voxel)?;
        let table = self.tables.get(voxel * PAIRS..(voxel + 1) * PAIRS)?;
        let nearest = around(eye);
        let (mut entries, mut whole) = (nearest, 0.0);
        for (node, weight) in &mut entries {
            whole += *weight * nodes[*node].root().powi(2);
            *weight *= nodes[*node].scale();
        }
        if whole == 0.0 {
            return None;
        }
        let share = 1.0 / whole;
        for (_, weight) in &mut entries {
            *weight *= share;
        }
        let mut shown = Reflectance {
            nodes,
            facings: self.facings.get(voxel)?,
            largest,
            table,
            entries,
            nearest,
            eye,
            color: Vec3::ZERO,
            normal: Vec3::ZERO,
            sky: Default::default(),
        };
        for (node, weight) in nearest {
            let node = &nodes[node];
            let part = share * weight * node.root().powi(2);
            shown.color += part * node.color();
            shown.normal += part * signed(node.normal);
            for (sum, (open, directions)) in shown.sky.iter_mut().zip(node.sky) {
                sum.0 += part * byte(open);
                sum.1 += part * signed(directions);
            }
        }
        Some(shown)
    }

    /// What a file holds of them.
    pub(crate) fn parts(
        &self,
    ) -> Parts<
        impl ExactSizeIterator<Item = [u8; 4]>,
        impl ExactSizeIterator<Item = [u8; NODE_BYTES]>,
        impl ExactSizeIterator<Item = [u8; FACING_BYTES]>,
        &[u8],
    > {
        let facings = (0..self.facings.len() * FACINGS)
            .map(|i| self.facings[i / FACINGS].all()[i % FACINGS].to_bytes());
        let (largest, nodes) =
            (self.largest.iter().map(|x| x.to_le_bytes()), self.nodes.iter().map(|n| n.to_bytes()));
        Parts { largest, nodes, facings, tables: &self.tables }
    }

    /// From what [`parts`](Self::parts) gave, of as many voxels each; `None` if an entry is negative or no number.
    pub(crate) fn from_parts(
        parts: Parts<
            impl Iterator<Item = [u8; 4]>,
            impl Iterator<Item = [u8; NODE_BYTES]>,
            impl Iterator<Item = [u8; FACING_BYTES]>,
            Vec<u8>,
        >,
    ) -> Option<Self> {
        let Parts { largest, nodes, facings, tables } = parts;
        let largest: Vec<f32> = largest.map(f32::from_le_bytes).collect();
        if !largest.iter().all(|x| x.is_finite() && *x >= 0.0) {
            return None;
        }
        let nodes: Vec<Node> = nodes.map(Node::from_bytes).collect();
        let facings: Vec<Facing> = facings.map(Facing::from_bytes).collect();
        let voxels = facings.as_chunks().0.into_par_iter().zip(nodes.par_chunks_exact(NODES));
        let facings = voxels.map(|(facings, nodes)| Facings::new(*facings, face_alike(nodes))).collect();
        Some(Self { nodes, facings, largest, tables })
    }

    pub(crate) fn memory(&self) -> usize {
        let nodes = size_of_val(&self.nodes[..]) + self.facings.iter().map(Facings::memory).sum::<usize>();
        nodes + size_of_val(&self.largest[..]) + self.tables.len()
    }
}

/// Whether what is seen from any of the nodes begins to face alike.
fn face_alike(nodes: &[Node]) -> bool {
    nodes.iter().any(|node| faces_alike(signed(node.normal)) > 0.0)
}

impl Node {
    #[inline]
    pub(super) fn root(&self) -> f32 {
        byte(self.root)
    }

    #[inline]
    pub(super) fn scale(&self) -> f32 {
        let root = byte(self.scale);
        root * root
    }

    #[inline]
    pub(super) fn color(&self) -> Vec3 {
        let root = unit(self.color);
        root * root
    }

    fn to_bytes(self) -> [u8; NODE_BYTES] {
        let Self { root, scale, color: [r, g, b], normal: n, sky: [(above, up), (below, down)] } = self;
        let [[nx, ny, nz], [ux, uy, uz], [dx, dy, dz]] = [n, up, down].map(|v| v.map(|x| x as u8));
        [root, scale, r, g, b, nx, ny, nz, above, ux, uy, uz, below, dx, dy, dz]
    }

    fn from_bytes(bytes: [u8; NODE_BYTES]) -> Self {
        let [root, scale, r, g, b, nx, ny, nz, above, ux, uy, uz, below, dx, dy, dz] = bytes;
        let [normal, up, down] = [[nx, ny, nz], [ux, uy, uz], [dx, dy, dz]].map(|v| v.map(|x| x as i8));
        Self { root, scale, color: [r, g, b], normal, sky: [(above, up), (below, down)] }
    }
}

/// A byte as a number in `[0, 1]`.
#[inline]
pub(super) fn byte(byte: u8) -> f32 {
    f32::from(byte) * (1.0 / 255.0)
}

/// Bytes as numbers in `[−1, 1]`.
#[inline]
pub(super) fn signed([x, y, z]: [i8; 3]) -> Vec3 {
    Vec3::new(x.into(), y.into(), z.into()) * (1.0 / 127.0)
}
