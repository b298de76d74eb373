//! A fine level in little room: 16 bytes a voxel, 4 a surfel.
//!
//! Fine voxels are many and small: of each a pixel shows a part, so a last percent of it does not show. Directions and
//! colours are names in the level's palettes.
//!
//! ```text
//! voxel   bit  0  lo, hi        6 × 6   1/63
//!             36  normal        12      in the palette of directions
//!             48  middle        7       of the slab, 1/126 of the way through the box along the normal
//!             55  thickness     7       of the slab, ((n + 1)/128)² of that way
//!         bit  0  root          6 × 6   of Σ: xx yy zz xy xz yz, signed, times the scale / 31
//!             36  scale         6       2^(n/2 − 13); 0 for nothing
//!             42  colours       2 × 11  in the palette of colours
//! surfel  bit  0  mask          16      4 × 4 squares of 2 × 2 cells
//!             16  normal        12      in the palette of directions
//!             28  weight        3       (n + 1)/8
//!             31  colour        1       which of its voxel's two
//! counts  of 16 voxels: u32 surfels before them, 16 × 4 bits how many each has
//! ```
//!
//! Σ is kept by its root R, Σ = R², because a depth is |R d|: a step of R is a step of the depth in every direction, and
//! no rounding makes Σ negative.

use glam::{Mat3, Vec3};
use pelage_geom::Symmetric3;
use rayon::prelude::*;

use crate::Voxel;
use crate::packed::{Packed, normal, unit};
use crate::palette::Palette;
use crate::surfel::{Surfel, Surfels};

/// A fine voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CompactVoxel {
    region: u64,
    opacity: u64,
}

/// Bits of a name in the palettes.
const DIRECTION: u32 = 12;
const COLOR: u32 = 11;

/// The voxels and surfels of a fine level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compact {
    /// Octahedral, as in a [`Packed`].
    pub(crate) directions: Palette<2>,
    /// As in a [`Packed`].
    pub(crate) colors: Palette<3>,
    pub(crate) voxels: Vec<CompactVoxel>,
    pub(crate) surfels: Vec<u32>,
    counts: Vec<Counts>,
}

/// How many surfels stand before 16 voxels, and how many each of them has, four bits each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    first: u32,
    each: [u32; 2],
}

impl Compact {
    /// From what was measured; `None` where that is too much: a voxel with more than 15 surfels, or a mask in which the
    /// squares of 2 × 2 cells are not all of one kind.
    pub(crate) fn new(voxels: &[Packed], surfels: &Surfels) -> Option<Self> {
        let each = || (0..voxels.len() as u32).map(|voxel| surfels.of(voxel));
        if surfels.all().iter().any(|s| s.coarse_mask().is_none()) || each().any(|of| of.len() > 15) {
            return None;
        }
        let normals = voxels.iter().map(Packed::normal).chain(surfels.all().iter().map(Surfel::octahedral));
        let (directions, named) = Palette::gather(&normals.collect::<Vec<_>>(), 1 << DIRECTION);
        let (of_voxels, of_surfels) = named.split_at(voxels.len());
        // Where there are surfels, theirs are the colours that are seen.
        let plain =
            voxels.iter().zip(each()).filter(|(_, of)| of.is_empty()).map(|(voxel, _)| voxel.albedo());
        let all: Vec<[u8; 3]> = surfels.all().iter().map(Surfel::root_color).chain(plain).collect();
        let all: Vec<[i16; 3]> = all.into_iter().map(|color| color.map(i16::from)).collect();
        let (colors, named) = Palette::gather(&all, 1 << COLOR);
        let (surfel_colors, plain) = named.split_at(surfels.all().len());

        let (mut pairs, mut short) =
            (Vec::with_capacity(voxels.len()), Vec::with_capacity(surfels.all().len()));
        let mut plain = plain.iter();
        for of in each() {
            let from = short.len();
            let names = surfel_colors.get(from..from + of.len()).unwrap_or(&[]);
            let pair = match (names, plain.len()) {
                ([], 0) => [0; 2],
                ([], _) => [plain.next().copied().unwrap_or_default(); 2],
                _ => furthest(names, &colors),
            };
            for ((surfel, &color), &direction) in of.iter().zip(names).zip(&of_surfels[from..]) {
                let second = distance(&colors, color, pair[1]) < distance(&colors, color, pair[0]);
                short.push(surfel_bits(surfel, direction, second));
            }
            pairs.push(pair);
        }
        let voxels = voxels.par_iter().zip(of_voxels).zip(&pairs);
        let voxels = voxels.map(|((voxel, &direction), &pair)| {
            CompactVoxel::new(voxel, direction, normal(directions.get(direction.into())), pair)
        });
        let voxels = voxels.collect();
        let counts = Counts::of(each().map(<[Surfel]>::len));
        Some(Self { directions, colors, voxels, surfels: short, counts })
    }

    /// From tables as they are stored, and how many surfels each voxel has (at most 15); or what is wrong with them.
    pub(crate) fn from_tables(
        directions: Palette<2>,
        colors: Palette<3>,
        voxels: Vec<CompactVoxel>,
        counts: &[u8],
        surfels: Vec<u32>,
    ) -> Result<Self, &'static str> {
        if counts.iter().any(|&count| count > 15) {
            return Err("has a voxel of too many surfels");
        }
        if counts.len() != voxels.len()
            || counts.iter().map(|&c| usize::from(c)).sum::<usize>() != surfels.len()
        {
            return Err("miscounts its surfels");
        }
        let counts = Counts::of(counts.iter().map(|&count| count.into()));
        let compact = Self { directions, colors, voxels, surfels, counts };
        compact.fault().map_or(Ok(compact), Err)
    }

    /// What is named and not there, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let [directions, colors] = [self.directions.points().len(), self.colors.points().len()];
        let sound =
            |v: &CompactVoxel| v.direction() < directions && v.colors().into_iter().all(|c| c < colors);
        if !self.voxels.iter().all(sound) {
            return Some("names a direction or colour that there is not");
        }
        let sound = self.surfels.iter().all(|bits| (bits >> 16) as usize & 0xfff < directions);
        (!sound).then_some("names a direction that there is not")
    }

    /// The voxel as it is walked and shaded.
    pub(crate) fn voxel(&self, index: usize) -> CompactView<'_> {
        CompactView { voxel: &self.voxels[index], directions: &self.directions }
    }

    /// All of a voxel; its albedo is the mean of its two colours.
    pub(crate) fn unpack(&self, index: usize) -> Voxel {
        let view = self.voxel(index);
        let [lo, hi] = view.region_box();
        let (slab_normal, slab) = view.region_slab();
        let [a, b] = view.voxel.colors().map(|name| unit(self.root_color(name)));
        Voxel { sigma: view.sigma(), lo, hi, slab_normal, slab, albedo: 0.5 * (a * a + b * b) }
    }

    fn root_color(&self, name: usize) -> [u8; 3] {
        self.colors.get(name).map(|c| c.clamp(0, 255) as u8)
    }

    /// The surfels of a voxel.
    pub(crate) fn surfels_of(&self, index: usize) -> impl ExactSizeIterator<Item = Surfel> + '_ {
        let range = self.counts.get(index / 16).map_or(0..0, |counts| counts.range(index % 16));
        let colors =
            self.voxels.get(index).map_or([0; 2], CompactVoxel::colors).map(|name| self.root_color(name));
        let own = self.surfels.get(range).unwrap_or(&[]);
        own.iter().map(move |&bits| {
            let normal = self.directions.get((bits >> 16) as usize & 0xfff);
            let weight = (((bits >> 28 & 7) + 1) * 255 + 4) / 8;
            Surfel::of_parts(normal, colors[(bits >> 31) as usize], weight as u8, spread(bits as u16))
        })
    }

    /// How many surfels each voxel has.
    pub(crate) fn surfel_counts(&self) -> impl ExactSizeIterator<Item = u8> + '_ {
        (0..self.voxels.len()).map(|i| self.counts[i / 16].range(i % 16).len() as u8)
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        let lists =
            size_of_val(&self.voxels[..]) + size_of_val(&self.surfels[..]) + size_of_val(&self.counts[..]);
        lists + self.directions.memory() + self.colors.memory()
    }
}

impl Counts {
    fn of(each: impl ExactSizeIterator<Item = usize>) -> Vec<Self> {
        let mut all = Vec::with_capacity(each.len().div_ceil(16));
        let mut first = 0;
        for (voxel, count) in each.enumerate() {
            if voxel % 16 == 0 {
                all.push(Self { first, each: [0; 2] });
            }
            if let Some(Self { each, .. }) = all.last_mut() {
                each[voxel / 8 % 2] |= (count as u32) << (4 * (voxel % 8));
            }
            first += count as u32;
        }
        all
    }

    /// The surfels of the `i`-th of its voxels, below 16.
    #[inline]
    fn range(self, i: usize) -> std::ops::Range<usize> {
        let each = u64::from(self.each[0]) | u64::from(self.each[1]) << 32;
        let before = each & ((1 << (4 * i)) - 1);
        // By bytes: at most 16 × 15 = 240 in all.
        const LOW: u64 = 0x0f0f_0f0f_0f0f_0f0f;
        let pairs = (before & LOW) + (before >> 4 & LOW);
        let before = (pairs.wrapping_mul(0x0101_0101_0101_0101) >> 56) as usize;
        let start = self.first as usize + before;
        start..start + (each >> (4 * i) & 15) as usize
    }
}

/// The bits of a surfel; its mask is one of squares.
fn surfel_bits(surfel: &Surfel, direction: u16, second: bool) -> u32 {
    let weight = (8.0 * surfel.weight()).round().clamp(1.0, 8.0) as u32 - 1;
    let mask = u32::from(surfel.coarse_mask().unwrap_or_default());
    mask | u32::from(direction) << 16 | weight << 28 | u32::from(second) << 31
}

/// 4 × 4 squares as 8 × 8 cells.
fn spread(squares: u16) -> u64 {
    (0..16)
        .filter(|square| squares >> square & 1 != 0)
        .fold(0, |mask, square| mask | 0x0303 << (16 * (square / 4) + 2 * (square % 4)))
}

fn distance(colors: &Palette<3>, a: u16, b: u16) -> i32 {
    let [a, b] = [a, b].map(|name| colors.get(name.into()).map(i32::from));
    (0..3).map(|axis| (a[axis] - b[axis]).pow(2)).sum()
}

/// The two of some colours that are furthest apart, the first of the palette first.
fn furthest(names: &[u16], colors: &Palette<3>) -> [u16; 2] {
    let pairs =
        names.iter().enumerate().flat_map(|(i, &a)| names[i..].iter().map(move |&b| [a.min(b), a.max(b)]));
    pairs.max_by_key(|&[a, b]| distance(colors, a, b)).unwrap_or_default()
}

/// Steps of the slab's middle.
const MIDDLE: f32 = 126.0;
/// Steps of an entry of the root.
const ROOT: f32 = 31.0;

impl CompactVoxel {
    fn new(packed: &Packed, direction: u16, normal: Vec3, colors: [u16; 2]) -> Self {
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
        region |= ((MIDDLE * 0.5 * (a + b)).round() as u64) << 48;
        region |= (thickness as u64) << 55;
        let empty = Self { region, opacity: 0 };
        let view = CompactView { voxel: &empty, directions: &Palette::default() };
        let kept = view.slab_along(normal);
        // What rounding adds to the way through the matter, the depth a unit of way loses.
        let across = |[lo, hi]: [Vec3; 2], [low, high]: [f32; 2], n: Vec3| {
            let through = (hi - lo) / n.abs().max(Vec3::splat(1e-6));
            through.min_element().min(high - low)
        };
        let stretch = across([lo, hi], slab, old_normal) / across([low / 63.0, high / 63.0], kept, normal);
        let [first, second] = colors.map(u64::from);
        let opacity = root_bits(packed.sigma() * stretch.powi(2)) | first << 42 | second << 53;
        Self { region, opacity }
    }

    #[inline]
    fn steps(&self, from: u32) -> Vec3 {
        let step = |axis: u32| (self.region >> (from + 6 * axis) & 63) as f32;
        Vec3::new(step(0), step(1), step(2)) * (1.0 / 63.0)
    }

    #[inline]
    fn direction(&self) -> usize {
        (self.region >> 36) as usize & 0xfff
    }

    #[inline]
    fn colors(&self) -> [usize; 2] {
        [42, 53].map(|bit| (self.opacity >> bit) as usize & 0x7ff)
    }

    /// The scale of the root, and its entries in units of it.
    #[inline]
    fn root(&self) -> (f32, [f32; 6]) {
        // 6 bits, moved to the top to bring their sign down.
        let entry = |i: usize| ((self.opacity << (58 - 6 * i)) as i64 >> 58) as f32;
        (scale((self.opacity >> 36) as u32 & 63), std::array::from_fn(entry))
    }

    pub(crate) fn to_bytes(self) -> [u8; 16] {
        (u128::from(self.region) | u128::from(self.opacity) << 64).to_le_bytes()
    }

    pub(crate) fn from_bytes(bytes: [u8; 16]) -> Self {
        let bits = u128::from_le_bytes(bytes);
        Self { region: bits as u64, opacity: (bits >> 64) as u64 }
    }
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
    voxel: &'a CompactVoxel,
    directions: &'a Palette<2>,
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
        let middle = (self.voxel.region >> 48 & 127) as f32 * (1.0 / MIDDLE);
        let root = ((self.voxel.region >> 55 & 127) + 1) as f32 * (1.0 / 128.0);
        let (middle, half) = (way.start + way.length * middle, 0.5 * way.length * root * root);
        [middle - half, middle + half]
    }

    #[inline]
    pub(crate) fn sigma(&self) -> Symmetric3 {
        let (scale, [xx, yy, zz, xy, xz, yz]) = self.voxel.root();
        let root = Symmetric3 { xx, yy, zz, xy, xz, yz }.to_mat3() * scale;
        Symmetric3::from_mat3(root * root)
    }

    /// Depth a step `d`.
    #[inline]
    pub(crate) fn depth_per_step(&self, d: Vec3) -> f32 {
        let (scale, [xx, yy, zz, xy, xz, yz]) = self.voxel.root();
        scale * Symmetric3 { xx, yy, zz, xy, xz, yz }.mul_vec3(d).length()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::packed::{snapped_box, snapped_normal, snapped_slab};
    use crate::{BuildOptions, Fur, build_exact};

    #[test]
    fn sizes() {
        assert_eq!((size_of::<CompactVoxel>(), size_of::<Counts>()), (16, 12));
    }

    proptest! {
        #[test]
        fn counts_say_where_surfels_are(each in prop::collection::vec(0_usize..16, 0..70)) {
            let counts = Counts::of(each.iter().copied());
            let mut start = 0;
            for (voxel, &count) in each.iter().enumerate() {
                prop_assert_eq!(counts[voxel / 16].range(voxel % 16), start..start + count);
                start += count;
            }
        }

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
            prop_assert_eq!(CompactVoxel::from_bytes(compact.voxels[0].to_bytes()), compact.voxels[0]);
        }
    }

    #[test]
    fn a_texel_keeps_its_surfels() {
        let options = BuildOptions { depth: 6, ..BuildOptions::preview() };
        let exact = build_exact("fur", Fur { count: 10, ..Fur::long() }, &options, &|_| ()).unwrap();
        let compact = exact.clone().compacted();
        assert_eq!(compact.validate(), Ok(()));
        let (a, b) = (exact.level(6), compact.level(6));
        let mut seen = 0;
        for voxel in 0..a.len() as u32 {
            let (a, b): (Vec<_>, Vec<_>) = (a.surfels(voxel).collect(), b.surfels(voxel).collect());
            assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(&b) {
                seen += 1;
                assert_eq!(a.coarse_mask(), b.coarse_mask());
                // Few strands have few normals: the palette holds them all. Weights are rounded to eighths.
                assert_eq!(a.normal(), b.normal());
                assert!((a.weight() - b.weight()).abs() <= 0.13, "{} {}", a.weight(), b.weight());
            }
        }
        assert!(seen > 500 && 2 * b.memory() < a.memory(), "{seen} {} {}", b.memory(), a.memory());
    }
}
