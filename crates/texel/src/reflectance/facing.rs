//! How the surface of a voxel faces: some normals, which make up for what nodes cannot say.
//!
//! Between nodes a cosine is rounded off where it begins, and the cosine of a bent surface is another one. Both can be told of
//! what faces alike, if nothing hides it: by its normal. So a table is corrected by how much all facings together
//! reflect to how much they would by way of the nodes.

use glam::{Mat3, Vec3};
use pelage_geom::Vec3x4;
use wide::f32x4;

use super::byte;
use super::nodes::{FIT, NODES};

/// Facings of a voxel.
pub(crate) const FACINGS: usize = 24;

/// Bytes of a facing.
pub(crate) const FACING_BYTES: usize = 5;

/// Of the surface of a voxel, all that faces alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Facing {
    /// Its mean normal, 1/127.
    normal: [i8; 3],
    /// How much is seen of it from everywhere, in 1/255 of the voxel's most.
    weight: u8,
    /// How far its normals lie from the mean, as a sine, 1/255.
    spread: u8,
}

impl Facing {
    /// Which one a normal belongs to: by the signs of its coordinates, and which of them is the largest.
    pub(super) fn number(normal: Vec3) -> usize {
        let axis = normal.abs().max_position();
        let [x, y, z] = normal.to_array().map(|x| usize::from(x < 0.0));
        8 * axis + x + 2 * y + 4 * z
    }

    /// All, from the sums of the weighed normals and of the weights of each.
    pub(super) fn all(sums: &[(Vec3, f32); FACINGS]) -> [Self; FACINGS] {
        let most = sums.iter().fold(f32::MIN_POSITIVE, |most, sum| most.max(sum.1));
        sums.map(|(sum, weight)| {
            let normal = sum.normalize_or_zero().to_array().map(|x| (127.0 * x).round() as i8);
            let length = (sum.length() / weight.max(f32::MIN_POSITIVE)).min(1.0);
            let spread = (255.0 * (1.0 - length * length).sqrt()).round() as u8;
            Self { normal, weight: (255.0 * weight / most).round() as u8, spread }
        })
    }

    pub(super) fn to_bytes(self) -> [u8; FACING_BYTES] {
        let [x, y, z] = self.normal.map(|x| x as u8);
        [x, y, z, self.weight, self.spread]
    }

    pub(super) fn from_bytes([x, y, z, weight, spread]: [u8; FACING_BYTES]) -> Self {
        Self { normal: [x, y, z].map(|x| x as i8), weight, spread }
    }

    fn normal(&self) -> Vec3 {
        super::signed(self.normal).normalize_or_zero()
    }

    /// The mean cosine of its normals to a unit vector, those that face away counted as 0; about.
    fn cosine(&self, d: Vec3) -> f32 {
        let (x, spread) = (self.normal().dot(d), byte(self.spread));
        0.5 * (x + (x * x + spread * spread).sqrt())
    }
}

/// The facings of a voxel, and what the nodes say of each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facings {
    all: [Facing; FACINGS],
    /// The cosines of each at the nodes, roots of parts of [`MOST`]; of a node all beside each other.
    nodes: Vec<[u8; FACINGS]>,
}

/// The largest value at a node that comes nearest to a cosine.
const MOST: f32 = 1.3;

impl Facings {
    pub(super) fn new(all: [Facing; FACINGS]) -> Self {
        let mut nodes = vec![[0; FACINGS]; NODES];
        for (i, facing) in all.iter().enumerate().filter(|(_, facing)| facing.weight > 0) {
            for (node, cosine) in nodes.iter_mut().zip(FIT.of(|d| facing.cosine(d))) {
                node[i] = (255.0 * (cosine.clamp(0.0, MOST) / MOST).sqrt()).round() as u8;
            }
        }
        Self { all, nodes }
    }

    pub(super) fn all(&self) -> &[Facing; FACINGS] {
        &self.all
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(self) + size_of_val(&self.nodes[..])
    }

    /// Of surface that faces alike: by how much more is reflected from the direction `light` to `eye` (unit vectors of texel space; with the nodes around
    /// each) than the nodes say, where `inverse` maps steps of the scene to steps of the texel, and the light's unit
    /// vector to one `length` long.
    ///
    /// The cosine of a normal n that is carried along is (n·l) `length` / |n `inverse`|.
    #[inline]
    pub(super) fn correction(
        &self,
        [(eye, eye_nodes), (light, light_nodes)]: [(Vec3, &[(usize, f32); 4]); 2],
        inverse: &Mat3,
        length: f32,
    ) -> f32 {
        let carried = inverse.transpose();
        let (eye, light) = (Vec3x4::splat(eye), Vec3x4::splat(light));
        let [mut exact, mut said, mut seen, mut said_seen] = [f32x4::ZERO; 4];
        for (four, facings) in self.all.as_chunks::<4>().0.iter().enumerate() {
            let lane = |of: &dyn Fn(&Facing) -> f32| {
                let [a, b, c, d] = facings;
                f32x4::new([of(a), of(b), of(c), of(d)])
            };
            let weight = lane(&|facing| facing.weight.into());
            if weight == f32x4::ZERO {
                continue;
            }
            let normal = Vec3x4 {
                x: lane(&|facing| facing.normal[0].into()),
                y: lane(&|facing| facing.normal[1].into()),
                z: lane(&|facing| facing.normal[2].into()),
            };
            let normal = normal.normalize_or_zero();
            let spread = lane(&|facing| byte(facing.spread));
            let cosine = |d: Vec3x4| {
                let x = normal.dot(d);
                f32x4::splat(0.5) * (x + (x * x + spread * spread).sqrt())
            };
            let at_nodes = |nodes: &[(usize, f32); 4]| {
                nodes.iter().fold(f32x4::ZERO, |sum, (node, weight)| {
                    let of = |i: usize| byte(self.nodes[*node][4 * four + i]);
                    let root = f32x4::new([of(0), of(1), of(2), of(3)]);
                    sum + root * root * f32x4::splat(MOST * weight)
                })
            };
            let stretched = normal.carried(&carried).length().max(f32x4::splat(f32::MIN_POSITIVE));
            let (to_eye, to_nodes) = (weight * cosine(eye), weight * at_nodes(eye_nodes));
            exact += to_eye * cosine(light) / stretched;
            said += to_nodes * at_nodes(light_nodes);
            seen += to_eye;
            said_seen += to_nodes;
        }
        // Of what is seen: that too is told by the nodes.
        let said = said.reduce_add() * seen.reduce_add();
        let exact = length * exact.reduce_add() * said_seen.reduce_add();
        if said > 0.0 { (exact / said).min(MOST_CORRECTION) } else { 1.0 }
    }
}

impl Facings {
    /// By how much the cosine to the light, of what is seen and lit, is another one because of how the voxel is bent.
    #[inline]
    pub(super) fn bent(&self, eye: Vec3, light: Vec3, inverse: &Mat3, length: f32) -> f32 {
        let (mut carried, mut whole) = (0.0, 0.0);
        for facing in self.all.iter().filter(|facing| facing.weight > 0) {
            let normal = facing.normal();
            let both = f32::from(facing.weight) * normal.dot(eye).max(0.0) * normal.dot(light).max(0.0);
            let stretched = (inverse.transpose() * normal).length();
            carried += both / stretched.max(f32::MIN_POSITIVE);
            whole += both;
        }
        if whole > 0.0 { length * carried / whole } else { 1.0 }
    }
}

/// Where nodes say next to nothing, what they say is mostly rounding.
const MOST_CORRECTION: f32 = 4.0;
