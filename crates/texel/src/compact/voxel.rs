//! A fine voxel in 16 bytes.
//!
//! ```text
//! region   bit  0  lo, hi        6 × 6   1/63
//!              36  normal        13      in the palette of directions
//!              49  middle        7       of the slab, 1/126 of the way through the box along the normal
//!              56  thickness     7       of the slab, ((n + 1)/128)² of that way
//!              63  sheet         1       whether its surfels are the two sides of one
//! opacity  bit  0  root          6 × 6   of Σ: xx yy zz xy xz yz, signed, times the scale / 31
//!              36  scale         6       2^(n/2 − 13); 0 for nothing
//!              42  colour        11      in the palette of colours
//!              53  second        11      the bits in which the name of the second differs: none, as a rule
//! ```
//!
//! Σ is kept by its root R, Σ = R², because a depth is |R d|: a step of R is a step of the depth in every direction, and
//! no rounding makes Σ negative.

use glam::{Mat3, Vec3};
use pelage_geom::Symmetric3;

use crate::packed::{Packed, normal};
use crate::palette::Palette;

/// A fine voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CompactVoxel {
    region: u64,
    opacity: u64,
}

/// How many names there are in the palettes.
pub(super) const DIRECTIONS: usize = 1 << 13;
pub(super) const COLORS: usize = 1 << 11;

/// Steps of the slab's middle.
const MIDDLE: f32 = 126.0;
/// Steps of an entry of the root.
const ROOT: f32 = 31.0;

impl CompactVoxel {
    /// Of a voxel, the name of its slab's direction and that itself, the names of its colours, and whether it is a sheet.
    pub(super) fn new(
        packed: &Packed,
        direction: u16,
        normal: Vec3,
        colors: [u16; 2],
        is_sheet: bool,
    ) -> Self {
        let [lo, hi] = packed.region_box();
        let low = (63.0 * lo).round().min(Vec3::splat(62.0));
        let high = (63.0 * hi).round().max(low + 1.0);
        let mut region = 0;
        for (i, step) in low.to_array().into_iter().chain(high.to_array()).enumerate() {
            region |= (step as u64) << (6 * i);
        }
        let (old_normal, slab) = packed.region_slab();
        let way = Way::through([low / 63.0, high / 63.0], normal);
        // The normal turns about the middle of the matter.
        let turned = (normal - old_normal).dot(0.5 * (lo + hi));
        let [a, b] = slab.map(|s| ((s + turned - way.start) / way.length).clamp(0.0, 1.0));
        let thickness = ((128.0 * (b - a).max(0.0).sqrt()).round() - 1.0).clamp(0.0, 127.0);
        region |= u64::from(direction) << 36;
        region |= ((MIDDLE * 0.5 * (a + b)).round() as u64) << 49;
        region |= (thickness as u64) << 56;
        region |= u64::from(is_sheet) << 63;
        let empty = Self { region, opacity: 0 };
        let view = CompactView { voxel: &empty, directions: &Palette::default() };
        let kept = view.slab_along(normal);
        // What rounding adds to the way through the matter, the depth a unit of way loses.
        let across = |[lo, hi]: [Vec3; 2], [low, high]: [f32; 2], n: Vec3| {
            let through = (hi - lo) / n.abs().max(Vec3::splat(1e-6));
            through.min_element().min(high - low)
        };
        let stretch = across([lo, hi], slab, old_normal) / across([low / 63.0, high / 63.0], kept, normal);
        let [first, second] = [colors[0], colors[0] ^ colors[1]].map(u64::from);
        let opacity = root_bits(packed.sigma() * stretch.powi(2)) | first << 42 | second << 53;
        Self { region, opacity }
    }

    #[inline]
    fn steps(&self, from: u32) -> Vec3 {
        // Through i32: there is no instruction for the others.
        let step = |axis: u32| (self.region >> (from + 6 * axis) & 63) as i32 as f32;
        Vec3::new(step(0), step(1), step(2)) * (1.0 / 63.0)
    }

    #[inline]
    pub(super) fn direction(&self) -> usize {
        (self.region >> 36) as usize % DIRECTIONS
    }

    #[inline]
    pub(super) fn colors(&self) -> [usize; 2] {
        let (first, second) =
            ((self.opacity >> 42) as usize % COLORS, (self.opacity >> 53) as usize % COLORS);
        [first, first ^ second]
    }

    /// Whether its surfels are the two sides of a sheet.
    #[inline]
    pub(super) fn is_sheet(&self) -> bool {
        self.region >> 63 != 0
    }

    /// The scale of the root, and its entries in units of it.
    #[inline]
    fn root(&self) -> (f32, Symmetric3) {
        // 6 bits, moved to the top to bring their sign down.
        let entry = |i: u32| (((self.opacity << (58 - 6 * i)) as i64 >> 58) as i32) as f32;
        let root =
            Symmetric3 { xx: entry(0), yy: entry(1), zz: entry(2), xy: entry(3), xz: entry(4), yz: entry(5) };
        (scale((self.opacity >> 36) as u32 & 63), root)
    }

    /// Each number in bytes of its own, which pack better: lo, hi, normal, middle, thickness and sheet, root, scale,
    /// colour, second.
    pub(crate) fn to_bytes(self) -> [u8; 21] {
        let mut bytes = [0; 21];
        let fields = bytes.iter_mut().zip(FIELDS);
        fields.for_each(|(byte, (word, from, bits))| {
            *byte = ([self.region, self.opacity][word] >> from) as u8 & mask(bits);
        });
        bytes
    }

    /// What [`to_bytes`](Self::to_bytes) made bytes of; `None` of what has a number that is too large.
    pub(crate) fn from_bytes(bytes: [u8; 21]) -> Option<Self> {
        let mut words = [0; 2];
        for (byte, (word, from, bits)) in bytes.into_iter().zip(FIELDS) {
            if byte & !mask(bits) != 0 {
                return None;
            }
            words[word] |= u64::from(byte) << from;
        }
        let [region, opacity] = words;
        Some(Self { region, opacity })
    }
}

/// The bytes of a voxel in a file: of the region (0) or the opacity (1), the lowest bit, and how many.
const FIELDS: [(usize, u32, u32); 21] = [
    (0, 0, 6),
    (0, 6, 6),
    (0, 12, 6),
    (0, 18, 6),
    (0, 24, 6),
    (0, 30, 6),
    (0, 36, 8),
    (0, 44, 5),
    (0, 49, 7),
    (0, 56, 8),
    (1, 0, 6),
    (1, 6, 6),
    (1, 12, 6),
    (1, 18, 6),
    (1, 24, 6),
    (1, 30, 6),
    (1, 36, 6),
    (1, 42, 8),
    (1, 50, 3),
    (1, 53, 8),
    (1, 61, 3),
];

/// As many ones, up to 8.
fn mask(bits: u32) -> u8 {
    u8::MAX >> (8 - bits)
}

/// What a step of an entry of the root is, by its six bits.
#[inline]
fn scale(bits: u32) -> f32 {
    const HALF_OCTAVE: [f32; 2] = [1.0 / ROOT, std::f32::consts::SQRT_2 / ROOT];
    if bits == 0 { 0.0 } else { f32::from_bits((127 - 13 + bits / 2) << 23) * HALF_OCTAVE[bits as usize % 2] }
}

/// The root of Σ and its scale.
fn root_bits(sigma: Symmetric3) -> u64 {
    let (values, axes) = sigma.eigen();
    let roots = Mat3::from_diagonal(values.max(Vec3::ZERO).map(f32::sqrt));
    let Symmetric3 { xx, yy, zz, xy, xz, yz } = Symmetric3::from_mat3(axes * roots * axes.transpose());
    let entries = [xx, yy, zz, xy, xz, yz];
    let largest = entries.iter().fold(0.0_f32, |largest, e| largest.max(e.abs()));
    let Some(fitting) = (1..64).find(|&bits| ROOT * scale(bits) >= largest).filter(|_| largest > 0.0) else {
        return 0;
    };
    let mut bits = u64::from(fitting) << 36;
    for (i, entry) in entries.into_iter().enumerate() {
        let step = (entry / scale(fitting)).round().clamp(-ROOT, ROOT) as i64;
        bits |= (step as u64 & 63) << (6 * i);
    }
    bits
}

/// The way through a box along a direction: where it begins, and how long it is.
struct Way {
    start: f32,
    length: f32,
}

impl Way {
    #[inline]
    fn through([lo, hi]: [Vec3; 2], normal: Vec3) -> Self {
        let (middle, reach) = (normal.dot(0.5 * (lo + hi)), normal.abs().dot(0.5 * (hi - lo)));
        Self { start: middle - reach, length: 2.0 * reach }
    }
}

/// A voxel, and what it names.
#[derive(Clone, Copy)]
pub(crate) struct CompactView<'a> {
    pub(super) voxel: &'a CompactVoxel,
    pub(super) directions: &'a Palette<2>,
}

impl CompactView<'_> {
    #[inline]
    pub(crate) fn region_box(&self) -> [Vec3; 2] {
        [self.voxel.steps(0), self.voxel.steps(18)]
    }

    #[inline]
    pub(crate) fn region_slab(&self) -> (Vec3, [f32; 2]) {
        let normal = normal(self.directions.get(self.voxel.direction()));
        (normal, self.slab_along(normal))
    }

    #[inline]
    fn slab_along(&self, normal: Vec3) -> [f32; 2] {
        let way = Way::through(self.region_box(), normal);
        let middle = (self.voxel.region >> 49 & 127) as i32 as f32 * (1.0 / MIDDLE);
        let root = ((self.voxel.region >> 56 & 127) as i32 + 1) as f32 * (1.0 / 128.0);
        let (middle, half) = (way.start + way.length * middle, 0.5 * way.length * root * root);
        [middle - half, middle + half]
    }

    #[inline]
    pub(crate) fn sigma(&self) -> Symmetric3 {
        let (scale, root) = self.voxel.root();
        let root = root.to_mat3() * scale;
        Symmetric3::from_mat3(root * root)
    }

    /// Depth a step `d`.
    #[inline]
    pub(crate) fn depth_per_step(&self, d: Vec3) -> f32 {
        let (scale, root) = self.voxel.root();
        scale * root.mul_vec3(d).length()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Voxel;
    use crate::compact::Compact;
    use crate::packed::{snapped_box, snapped_normal, snapped_slab};
    use crate::surfel::Surfels;

    #[test]
    fn a_voxel_takes_16_bytes() {
        assert_eq!(size_of::<CompactVoxel>(), 16);
    }

    proptest! {
        #[test]
        fn what_is_rounded_is_near(
            scale in -10.0_f32..10.0,
            rows in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            n in prop::array::uniform3(-1.0_f32..1.0),
            low in prop::array::uniform3(0.0_f32..0.5),
            size in prop::array::uniform3(0.1_f32..0.5),
            d in prop::array::uniform3(-1.0_f32..1.0),
        ) {
            let n = Vec3::from_array(n);
            prop_assume!(n.length() > 0.1);
            let low = Vec3::from_array(low);
            let [lo, hi] = snapped_box(low, low + Vec3::from_array(size));
            let slab_normal = snapped_normal(n.normalize());
            // The middle half of the box's extent along the normal.
            let way = Way::through([lo, hi], slab_normal);
            let slab = snapped_slab([0.25, 0.75].map(|part| way.start + part * way.length));
            let sigma = rows.map(|r| Symmetric3::outer(Vec3::from_array(r))).into_iter().sum::<Symmetric3>();
            let sigma = sigma * scale.exp2();
            let exact = Packed::new(&Voxel { sigma, lo, hi, slab_normal, slab, albedo: Vec3::ONE });
            let compact = Compact::new(&[exact], &Surfels::new(vec![vec![]])).unwrap();
            let back = compact.unpack(0);
            prop_assert!((back.lo - lo).abs().max_element() <= 0.5 / 63.0 + 1e-5);
            prop_assert!((back.hi - hi).abs().max_element() <= 0.5 / 63.0 + 1e-5);
            prop_assert_eq!(back.slab_normal, slab_normal);
            // Half a step of the box, of the middle (1/126) and of the thickness (2 √½ / 128): under .03.
            for (kept, was) in back.slab.iter().zip(slab) {
                prop_assert!((kept - was).abs() < 0.03, "{kept} {was}");
            }
            // Each entry of the root is half a step off at most, of which 31 are at least √½ of the largest; the way
            // through is corrected by under a fifth.
            let d = Vec3::from_array(d);
            let most = sigma.trace().sqrt() * d.length();
            let depths = [compact.voxel(0).depth_per_step(d), sigma.quadratic(d).max(0.0).sqrt()];
            prop_assert!((depths[0] - depths[1]).abs() < 0.25 * depths[1] + 0.07 * most, "{depths:?}");
            prop_assert!((compact.voxel(0).sigma().quadratic(d).sqrt() - depths[0]).abs() < 1e-3 * most);
            prop_assert_eq!(CompactVoxel::from_bytes(compact.voxels[0].to_bytes()), Some(compact.voxels[0]));
        }
    }
}
