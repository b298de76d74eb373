//! How the surface of a voxel faces: some normals, which make up for what nodes cannot say.
//!
//! Between nodes a cosine is rounded off where it begins, and the cosine of a bent surface is another one. Both can be told of
//! what faces alike, if nothing hides it: by its normal. So a table is corrected by how much all facings together
//! reflect to how much they would by way of the nodes. Highlights are theirs alone: nodes are too far apart.

use glam::Vec3;
use pelage_geom::Vec3x4;
use wide::f32x4;

use super::Bend;
use super::nodes::{FIT, NODES};
use super::table::{byte, signed};

/// Facings of a voxel: nine of each side of a cube, and two that are not there, as they are taken by fours.
pub(crate) const FACINGS: usize = 56;

/// Bytes of a facing.
pub(super) const FACING_BYTES: usize = 5;

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
    /// Which one a normal belongs to: by the side of the cube that it goes through, and each third of 90° there.
    pub(super) fn number(normal: Vec3) -> usize {
        const TAN_15: f32 = 0.267_949;
        let axis = normal.abs().max_position();
        let third = |other: usize| {
            let tangent = normal[(axis + other) % 3] / normal[axis];
            usize::from(tangent > -TAN_15) + usize::from(tangent > TAN_15)
        };
        9 * (2 * axis + usize::from(normal[axis] < 0.0)) + 3 * third(1) + third(2)
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

    /// The mean cosine of its normals to a unit vector, those that face away counted as 0; about.
    fn cosine(&self, d: Vec3) -> f32 {
        let (x, spread) = (signed(self.normal).normalize_or_zero().dot(d), byte(self.spread));
        0.5 * (x + (x * x + spread * spread).sqrt())
    }
}

/// The facings of a voxel, and what the nodes say of each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facings {
    all: [Facing; FACINGS],
    /// Of the fours of which anything is seen: what faces alike is in a few.
    said: Vec<Said>,
}

/// What the nodes say of four facings.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    /// Which four.
    four: u8,
    /// Their cosines at each node, roots of parts of [`MOST`].
    nodes: [[u8; 4]; NODES],
}

/// Where none of four weighs more than this, in 1/255 of the voxel's most, what the nodes say of them is left out.
const NOTHING: u8 = 3;

/// The largest value at a node that comes nearest to a cosine.
const MOST: f32 = 1.3;

impl Facings {
    /// `alike` says whether what is seen of the voxel from anywhere faces alike: else nothing asks what the nodes say.
    pub(super) fn new(all: [Facing; FACINGS], alike: bool) -> Self {
        let said = |four: usize, facings: &[Facing; 4]| {
            let mut nodes = [[0; 4]; NODES];
            for (i, facing) in facings.iter().enumerate().filter(|(_, facing)| facing.weight > 0) {
                for (node, cosine) in nodes.iter_mut().zip(FIT.of(|d| facing.cosine(d))) {
                    node[i] = (255.0 * (cosine.clamp(0.0, MOST) / MOST).sqrt()).round() as u8;
                }
            }
            Said { four: four as u8, nodes }
        };
        let fours = all.as_chunks::<4>().0.iter().enumerate();
        let seen = fours.filter(|(_, four)| alike && four.iter().any(|facing| facing.weight > NOTHING));
        let said = seen.map(|(four, facings)| said(four, facings)).collect();
        Self { all, said }
    }

    pub(super) fn all(&self) -> &[Facing; FACINGS] {
        &self.all
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(self) + size_of_val(&self.said[..])
    }

    /// Of surface that faces alike: by how much more is reflected from the light to the eye, unit vectors of texel space
    /// with the nodes around each, than the nodes say.
    #[inline]
    pub(super) fn correction(
        &self,
        [(eye, eye_nodes), (light, light_nodes)]: [(Vec3, &[(usize, f32); 4]); 2],
        bend: &Bend,
    ) -> f32 {
        let carried = bend.inverse.transpose();
        let (eye, light) = (Vec3x4::splat(eye), Vec3x4::splat(light));
        let [mut exact, mut said, mut seen, mut said_seen] = [f32x4::ZERO; 4];
        let (fours, _) = self.all.as_chunks::<4>();
        for Said { four, nodes: at } in &self.said {
            let FacingsX4 { normal, weight, spread } = FacingsX4::new(&fours[usize::from(*four)]);
            let cosine = |d: Vec3x4| {
                let x = normal.dot(d);
                f32x4::splat(0.5) * (x + (x * x + spread * spread).sqrt())
            };
            let at_nodes = |nodes: &[(usize, f32); 4]| {
                nodes.iter().fold(f32x4::ZERO, |sum, (node, weight)| {
                    let root = f32x4::new(at[*node].map(byte));
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
        let exact = bend.length * exact.reduce_add() * said_seen.reduce_add();
        if said > 0.0 { (exact / said).min(MOST_CORRECTION) } else { 1.0 }
    }

    /// Of what is seen and lit: by how much the cosine to the light is another one because of how the voxel is bent, and the
    /// mean of that times (n·h)^m.
    #[inline]
    pub(super) fn bent(&self, eye: Vec3, light: Vec3, bend: &Bend) -> [f32; 2] {
        let (carried, eye, light) = (bend.inverse.transpose(), Vec3x4::splat(eye), Vec3x4::splat(light));
        let [mut whole, mut cosine, mut highlights] = [f32x4::ZERO; 3];
        for FacingsX4 { normal, weight, spread } in self.by_fours() {
            let both = weight * normal.dot(eye).max(f32x4::ZERO) * normal.dot(light).max(f32x4::ZERO);
            if both == f32x4::ZERO {
                continue;
            }
            let normal = normal.carried(&carried);
            let length = normal.length().max(f32x4::splat(f32::MIN_POSITIVE));
            whole += both;
            cosine += both / length;
            if let Some((half, exponent)) = bend.highlight {
                let along = (normal.dot(Vec3x4::splat(half)) / length).max(f32x4::ZERO).to_array();
                let (both, spread) = (both.to_array(), spread.to_array());
                let one =
                    |i: usize| if both[i] > 0.0 { highlight(along[i], exponent, spread[i]) } else { 0.0 };
                highlights += f32x4::new(both) / length * f32x4::new([one(0), one(1), one(2), one(3)]);
            }
        }
        let whole = whole.reduce_add();
        if whole > 0.0 {
            [cosine, highlights].map(|sum| bend.length * sum.reduce_add() / whole)
        } else {
            [1.0, 0.0]
        }
    }

    fn by_fours(&self) -> impl Iterator<Item = FacingsX4> + '_ {
        self.all.as_chunks::<4>().0.iter().map(FacingsX4::new)
    }
}

/// Four facings side by side.
struct FacingsX4 {
    normal: Vec3x4,
    weight: f32x4,
    spread: f32x4,
}

impl FacingsX4 {
    #[inline]
    fn new([a, b, c, d]: &[Facing; 4]) -> Self {
        let lane = |of: fn(&Facing) -> f32| f32x4::new([of(a), of(b), of(c), of(d)]);
        let (x, y) = (lane(|facing| facing.normal[0].into()), lane(|facing| facing.normal[1].into()));
        let normal = Vec3x4 { x, y, z: lane(|facing| facing.normal[2].into()) }.normalize_or_zero();
        Self {
            normal,
            weight: lane(|facing| facing.weight.into()),
            spread: lane(|facing| byte(facing.spread)),
        }
    }
}

/// The mean of (n·h)^`exponent` over normals that lie as far as `spread` (a sine) about one for which n·h is `along`.
///
/// Both the highlight and the normals are taken for bells: of the angle θ, cos^m θ is about e^(−mθ²/2), and over the sphere it
/// comes to 2π / (m + 1).
fn highlight(along: f32, exponent: f32, spread: f32) -> f32 {
    let wider = exponent / (1.0 + 0.5 * exponent * spread * spread);
    (wider + 1.0) / (exponent + 1.0) * along.powf(wider)
}

/// Where nodes say next to nothing, what they say is mostly rounding.
const MOST_CORRECTION: f32 = 4.0;
