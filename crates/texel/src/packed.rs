//! A voxel in 32 bytes, two to a cache line: the walk waits for memory, not for arithmetic.
//!
//! ```text
//! byte  0  sigma     6 × i16   xx yy zz xy xz yz, times 2^(exponent − 127)
//!      12  normal    2 × i16   octahedral, 1/32767
//!      16  slab      2 × u16   −√3 to √3, rounded outwards
//!      20  lo, hi    6 × u8    1/255, rounded outwards
//!      26  albedo    3 × u8    square roots, 1/255
//!      29  exponent  u8        of sigma, biased as in an f32
//!      30  zero      u8 × 2
//! ```
//!
//! The region is snapped to what can be stored before opacity is measured in it (see [`Region`]), so rounding
//! it costs no bias.
//!
//! [`Region`]: crate::region::Region

use glam::{Vec2, Vec3};
use pelage_geom::{Symmetric3, Vec3x4};
use wide::f32x4;

use crate::Voxel;

/// The bytes of a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub(crate) struct Packed {
    sigma: [i16; 6],
    normal: [i16; 2],
    slab: [u16; 2],
    lo: [u8; 3],
    hi: [u8; 3],
    albedo: [u8; 3],
    exponent: u8,
}

const SQRT_3: f32 = 1.732_050_8;
/// Steps of a slab's distance per voxel edge.
const SLAB_STEPS: f32 = 65535.0 / (2.0 * SQRT_3);

impl Packed {
    pub(crate) fn new(voxel: &Voxel) -> Self {
        let Symmetric3 { xx, yy, zz, xy, xz, yz } = voxel.sigma;
        let entries = [xx, yy, zz, xy, xz, yz];
        let largest = entries.iter().fold(1e-30_f32, |largest, e| largest.max(e.abs()));
        // The smallest power of two that brings the largest entry under 2¹⁵.
        let exponent = ((largest / 32767.0).log2().ceil() + 127.0).clamp(1.0, 254.0) as u8;
        Self {
            sigma: entries.map(|e| (e / power(exponent)).round() as i16),
            normal: octahedral(voxel.slab_normal),
            slab: voxel.slab.map(|s| ((s + SQRT_3) * SLAB_STEPS).round() as u16),
            lo: bytes(voxel.lo),
            hi: bytes(voxel.hi),
            albedo: bytes(voxel.albedo.map(f32::sqrt)),
            exponent,
        }
    }

    #[inline]
    pub(crate) fn unpack(&self) -> Voxel {
        let root = unit(self.albedo);
        let [lo, hi] = self.region_box();
        let (slab_normal, slab) = self.region_slab();
        Voxel { sigma: self.sigma(), lo, hi, slab_normal, slab, albedo: root * root }
    }

    /// The corners of the tight box.
    #[inline]
    pub(crate) fn region_box(&self) -> [Vec3; 2] {
        [unit(self.lo), unit(self.hi)]
    }

    /// The slab's normal and its two distances.
    #[inline]
    pub(crate) fn region_slab(&self) -> (Vec3, [f32; 2]) {
        let distance = |steps: u16| f32::from(steps) * (1.0 / SLAB_STEPS) - SQRT_3;
        (normal(self.normal), [distance(self.slab[0]), distance(self.slab[1])])
    }

    #[inline]
    pub(crate) fn sigma(&self) -> Symmetric3 {
        let scale = power(self.exponent);
        let entry = |i: usize| f32::from(self.sigma[i]) * scale;
        Symmetric3 { xx: entry(0), yy: entry(1), zz: entry(2), xy: entry(3), xz: entry(4), yz: entry(5) }
    }

    /// Depth a step `d`.
    #[inline]
    pub(crate) fn depth_per_step(&self, d: Vec3) -> f32 {
        self.sigma().quadratic(d).max(0.0).sqrt()
    }

    /// The slab's normal, octahedral.
    pub(crate) fn normal(&self) -> [i16; 2] {
        self.normal
    }

    /// Square roots of the albedo, 1/255.
    pub(crate) fn albedo(&self) -> [u8; 3] {
        self.albedo
    }

    /// Its bytes as they are drawn above, little endian.
    pub(crate) fn to_bytes(self) -> [u8; 32] {
        let mut bytes = [0; 32];
        let pairs = self.sigma.into_iter().chain(self.normal).map(i16::to_le_bytes);
        let pairs = pairs.chain(self.slab.map(u16::to_le_bytes));
        bytes.chunks_exact_mut(2).zip(pairs).for_each(|(bytes, pair)| bytes.copy_from_slice(&pair));
        bytes[20..23].copy_from_slice(&self.lo);
        bytes[23..26].copy_from_slice(&self.hi);
        bytes[26..29].copy_from_slice(&self.albedo);
        bytes[29] = self.exponent;
        bytes
    }

    /// What [`to_bytes`](Self::to_bytes) made bytes of.
    pub(crate) fn from_bytes(bytes: [u8; 32]) -> Self {
        let signed = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let three = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2]];
        Self {
            sigma: std::array::from_fn(|i| signed(2 * i)),
            normal: [signed(12), signed(14)],
            slab: [signed(16), signed(18)].map(i16::cast_unsigned),
            lo: three(20),
            hi: three(23),
            albedo: three(26),
            exponent: bytes[29],
        }
    }
}

/// Numbers in `[0, 1]` as bytes.
pub(crate) fn bytes(v: Vec3) -> [u8; 3] {
    v.to_array().map(|c| (255.0 * c).round() as u8)
}

/// Bytes as numbers in `[0, 1]`.
#[inline]
pub(crate) fn unit(bytes: [u8; 3]) -> Vec3 {
    let [x, y, z] = bytes;
    Vec3::new(x.into(), y.into(), z.into()) * (1.0 / 255.0)
}

/// 2^(exponent − 127), for exponents 1 to 254.
#[inline]
fn power(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << 23)
}

/// The point of a unit vector on the octahedron.
pub(crate) fn octahedral(n: Vec3) -> [i16; 2] {
    unfolded(n).to_array().map(|c| (32767.0 * c).round() as i16)
}

#[inline]
pub(crate) fn normal(square: [i16; 2]) -> Vec3 {
    let [x, y] = square;
    folded(Vec2::new(x.into(), y.into()) * (1.0 / 32767.0))
}

/// A direction's point on the octahedron, unfolded into the square `[−1, 1]²` [Cigolle14].
#[inline]
pub(crate) fn unfolded(d: Vec3) -> Vec2 {
    let p = d / d.abs().element_sum();
    if p.z < 0.0 { fold(p.truncate()) } else { p.truncate() }
}

/// The unit vector of a point of the square.
#[inline]
pub(crate) fn folded(p: Vec2) -> Vec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let p = if z < 0.0 { fold(p) } else { p };
    p.extend(z).normalize()
}

/// [`folded`] of four points.
#[inline]
pub(crate) fn folded_x4([x, y]: [f32x4; 2]) -> Vec3x4 {
    let (one, sign) = (f32x4::ONE, f32x4::splat(-0.0));
    let z = one - x.abs() - y.abs();
    let below = z.simd_lt(f32x4::ZERO);
    let fold = |along: f32x4, other: f32x4| below.select((one - other.abs()) | (along & sign), along);
    Vec3x4 { x: fold(x, y), y: fold(y, x), z }.normalize_or_zero()
}

/// Swaps the octahedron's upper half with the corners of the square.
#[inline]
fn fold(p: Vec2) -> Vec2 {
    Vec2::new((1.0 - p.y.abs()).copysign(p.x), (1.0 - p.x.abs()).copysign(p.y))
}

/// The nearest direction that can be stored.
pub(crate) fn snapped_normal(n: Vec3) -> Vec3 {
    normal(octahedral(n))
}

/// The smallest box that can be stored around a box in `[0, 1]³`.
pub(crate) fn snapped_box(lo: Vec3, hi: Vec3) -> [Vec3; 2] {
    // A thousandth of a step, so that what is snapped already stays.
    [
        ((255.0 * lo + 1e-3).floor() / 255.0).max(Vec3::ZERO),
        ((255.0 * hi - 1e-3).ceil() / 255.0).min(Vec3::ONE),
    ]
}

/// The thinnest slab that can be stored around a slab.
pub(crate) fn snapped_slab([low, high]: [f32; 2]) -> [f32; 2] {
    let [low, high] = [low, high].map(|s| (s + SQRT_3) * SLAB_STEPS);
    [low.floor(), high.ceil()].map(|s| s.clamp(0.0, 65535.0) / SLAB_STEPS - SQRT_3)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_voxel_takes_32_bytes() {
        assert_eq!(size_of::<Packed>(), 32);
    }

    proptest! {
        #[test]
        fn what_is_packed_returns(
            scale in -20.0_f32..20.0,
            rows in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            n in prop::array::uniform3(-1.0_f32..1.0),
            low in prop::array::uniform3(0.0_f32..0.5),
            size in prop::array::uniform3(0.02_f32..0.5),
            numbers in prop::array::uniform3(0.0_f32..1.0),
        ) {
            let n = Vec3::from_array(n);
            prop_assume!(n.length() > 0.1);
            let [lo, hi] = snapped_box(Vec3::from_array(low), Vec3::from_array(low) + Vec3::from_array(size));
            let sigma = rows.map(|r| Symmetric3::outer(Vec3::from_array(r))).into_iter().sum::<Symmetric3>();
            let voxel = Voxel {
                sigma: sigma * scale.exp2(),
                lo,
                hi,
                slab_normal: snapped_normal(n.normalize()),
                slab: snapped_slab([-0.3, -0.3 + numbers[0]]),
                albedo: Vec3::from_array(numbers),
            };
            prop_assert!((voxel.slab_normal - n.normalize()).length() < 1e-4);
            prop_assert!(lo.cmple(Vec3::from_array(low) + 1e-5).all());
            let back = Packed::new(&voxel).unpack();
            // Half a step of 2⁻¹⁴ of the largest entry.
            let largest = voxel.sigma.trace();
            let difference = (back.sigma - voxel.sigma).to_mat3();
            prop_assert!(difference.abs_diff_eq(glam::Mat3::ZERO, largest / 30000.0));
            prop_assert!((back.lo - lo).length() < 1e-6 && (back.hi - hi).length() < 1e-6);
            prop_assert!((back.slab_normal - voxel.slab_normal).length() < 1e-6);
            prop_assert!((back.slab[0] - voxel.slab[0]).abs() < 1e-6 && (back.slab[1] - voxel.slab[1]).abs() < 1e-6);
            // Half a step of a square root: at most 1/255 of the whole.
            prop_assert!((back.albedo - voxel.albedo).abs().max_element() < 1.0 / 250.0);
            // Packing again changes nothing.
            prop_assert_eq!(Packed::new(&back), Packed::new(&voxel));
        }
    }
}
