//! The surfels of a fine level: five bytes each, or both sides of a sheet in five.
//!
//! ```text
//! surfel  u32  bit 0  mask          16    4 × 4 squares of 2 × 2 cells
//!             16  normal        2 × i8  octahedral, 1/127
//!         u8   bit 0  weight         5    (n + 1)/32
//!              7  colour         1    which of its voxel's two
//! sheet   u32  bit 0  masks     2 × 16    of the side that the slab's normal points to, and of the other
//!         u8   bit 0  weight         5    (n + 1)/32, of the lesser side
//!              7  lesser         1    which side that is
//! counts  of 32 voxels: u32 records before them, 32 × 4 bits how many each has
//! ```
//!
//! Most fine voxels of thin things hold a piece of one sheet: what faces along the slab's normal and against it, with the
//! first and the second of the voxel's colours. Where nothing hides either side, there is no record.

use std::ops::Range;

use glam::Vec3;

use crate::sample::{Sample, octahedral};
use crate::surfel::Surfel;

/// Steps of a weight.
const WEIGHT: u32 = 32;

/// What is kept of a surfel, or of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Record(u32, u8);

impl Record {
    /// A sheet of which nothing hides anything.
    pub(super) const OPEN: Self = Self(u32::MAX, WEIGHT as u8 - 1);

    /// Of a surfel whose mask is one of squares, with the second of its voxel's colours or the first.
    pub(super) fn new(surfel: &Surfel, is_second: bool) -> Self {
        let [x, y] = surfel.sample().octahedral().map(|c| u32::from(c.cast_unsigned()));
        let mask = u32::from(surfel.coarse_mask().unwrap_or_default());
        Self(mask | x << 16 | y << 24, weight_bits(surfel) | u8::from(is_second) << 7)
    }

    /// The surfel, by its voxel's colours.
    pub(super) fn surfel(self, colors: [[u8; 3]; 2]) -> Surfel {
        let Self(bits, share) = self;
        let normal = [16, 24].map(|at| ((bits >> at) as u8).cast_signed());
        let color = colors[usize::from(share >> 7)];
        Surfel::of_parts(Sample::of_parts(normal, color, weight(share)), spread(bits as u16))
    }

    /// The two sides of a sheet, by its normal and their colours.
    pub(super) fn sides(self, normal: Vec3, colors: [[u8; 3]; 2]) -> [Surfel; 2] {
        let Self(bits, share) = self;
        let lesser = usize::from(share >> 7);
        [0, 1].map(|side| {
            let normal = octahedral(if side == 0 { normal } else { -normal });
            let weight = if side == lesser { weight(share) } else { u8::MAX };
            let sample = Sample::of_parts(normal, colors[side], weight);
            Surfel::of_parts(sample, spread((bits >> (16 * side)) as u16))
        })
    }
}

/// The two sides of a sheet.
pub(super) struct Pair {
    sides: [Surfel; 2],
}

impl Pair {
    /// Of two surfels, one along `normal` and one against it, and which of them is which; `None` of any others.
    pub(super) fn new(surfels: &[Surfel], normal: Vec3) -> Option<(Self, [usize; 2])> {
        let &[a, b] = surfels else { return None };
        let wanted = [normal, -normal].map(octahedral);
        let order = [[0, 1], [1, 0]]
            .into_iter()
            .find(|order| order.map(|i| surfels[i].sample().octahedral()) == wanted)?;
        let sides = order.map(|i| [a, b][i]);
        sides.iter().any(|side| side.weight() == 1.0).then_some((Self { sides }, order))
    }

    pub(super) fn record(&self) -> Record {
        let [front, back] = &self.sides;
        let masks = self.sides.map(|side| u32::from(side.coarse_mask().unwrap_or_default()));
        let lesser = u8::from(back.weight() < front.weight());
        let weight = weight_bits(&self.sides[usize::from(lesser)]);
        Record(masks[0] | masks[1] << 16, weight | lesser << 7)
    }
}

fn weight_bits(surfel: &Surfel) -> u8 {
    (WEIGHT as f32 * surfel.weight()).round().clamp(1.0, WEIGHT as f32) as u8 - 1
}

/// The weight of a record, 1/255.
fn weight(share: u8) -> u8 {
    (((u32::from(share) & (WEIGHT - 1)) + 1) * 255).div_ceil(WEIGHT) as u8
}

/// 4 × 4 squares as 8 × 8 cells.
fn spread(squares: u16) -> u64 {
    // Bit 4 r + c to 16 r + 2 c, then each to the four cells of its square.
    let rows = u64::from(squares);
    let rows = (rows | rows << 24) & 0x0000_00ff_0000_00ff;
    let rows = (rows | rows << 12) & 0x000f_000f_000f_000f;
    let columns = (rows | rows << 2) & 0x0033_0033_0033_0033;
    let columns = (columns | columns << 1) & 0x0055_0055_0055_0055;
    columns * 0x0303
}

/// The records of a level's voxels, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CompactSurfels {
    bits: Vec<u32>,
    shares: Vec<u8>,
    voxels: usize,
    counts: Vec<Counts>,
}

/// How many records stand before [`GROUP`] voxels, and how many each of them has, four bits each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    first: u32,
    each: [u32; 4],
}

/// Voxels that are counted together.
const GROUP: usize = 32;

impl CompactSurfels {
    /// Of what each voxel has, at most 15.
    pub(super) fn new(each: &[Vec<Record>]) -> Self {
        let all = || each.iter().flatten();
        let counts = Counts::of(each.iter().map(Vec::len));
        let (bits, shares) = (all().map(|r| r.0).collect(), all().map(|r| r.1).collect());
        Self { bits, shares, voxels: each.len(), counts }
    }

    /// From tables as they are stored, and how many records each voxel has (at most 15); or what is wrong with them.
    pub(crate) fn from_tables(counts: &[u8], bits: Vec<u32>, shares: Vec<u8>) -> Result<Self, &'static str> {
        if counts.iter().any(|&count| count > 15) {
            return Err("has a voxel of too many surfels");
        }
        let sum: usize = counts.iter().map(|&count| usize::from(count)).sum();
        if sum != bits.len() || sum != shares.len() {
            return Err("miscounts its surfels");
        }
        let voxels = counts.len();
        let counts = Counts::of(counts.iter().map(|&count| count.into()));
        Ok(Self { bits, shares, voxels, counts })
    }

    /// The tables as they are stored.
    pub(crate) fn tables(&self) -> (&[u32], &[u8]) {
        (&self.bits, &self.shares)
    }

    /// Of how many voxels.
    pub(super) fn voxels(&self) -> usize {
        self.voxels
    }

    /// How many records each voxel has.
    pub(crate) fn counts(&self) -> impl ExactSizeIterator<Item = u8> + '_ {
        (0..self.voxels).map(|i| self.counts[i / GROUP].range(i % GROUP).len() as u8)
    }

    /// The records of a voxel.
    pub(super) fn of(&self, voxel: usize) -> impl Iterator<Item = Record> + '_ {
        let range = self.counts.get(voxel / GROUP).map_or(0..0, |counts| counts.range(voxel % GROUP));
        let own = |range: Range<usize>| Some((self.bits.get(range.clone())?, self.shares.get(range)?));
        let (bits, shares) = own(range).unwrap_or((&[], &[]));
        bits.iter().zip(shares).map(|(&bits, &share)| Record(bits, share))
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.bits[..]) + size_of_val(&self.shares[..]) + size_of_val(&self.counts[..])
    }
}

impl Counts {
    fn of(each: impl ExactSizeIterator<Item = usize>) -> Vec<Self> {
        let mut all = Vec::with_capacity(each.len().div_ceil(GROUP));
        let mut first = 0;
        for (voxel, count) in each.enumerate() {
            if voxel % GROUP == 0 {
                all.push(Self { first, each: [0; 4] });
            }
            if let Some(Self { each, .. }) = all.last_mut() {
                each[voxel % GROUP / 8] |= (count as u32) << (4 * (voxel % 8));
            }
            first += count as u32;
        }
        all
    }

    /// The records of the `i`-th of its voxels.
    #[inline]
    fn range(self, i: usize) -> Range<usize> {
        let [a, b, c, d] = self.each.map(u64::from);
        let halves = [a | b << 32, c | d << 32];
        let shift = 4 * (i as u32 % 16);
        let own = halves[i / 16];
        let before = sum(own & ((1 << shift) - 1)) + if i < 16 { 0 } else { sum(halves[0]) };
        let start = self.first as usize + before;
        start..start + (own >> shift & 15) as usize
    }
}

/// The sum of sixteen numbers of four bits each.
#[inline]
fn sum(counts: u64) -> usize {
    const LOW: u64 = 0x0f0f_0f0f_0f0f_0f0f;
    // By bytes: at most 16 × 15 = 240 in all.
    let pairs = (counts & LOW) + (counts >> 4 & LOW);
    (pairs.wrapping_mul(0x0101_0101_0101_0101) >> 56) as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sample::snapped_normal;

    #[test]
    fn squares_are_spread_over_their_cells() {
        for squares in [0, 1, 0x8000, 0x1234, 0xfedc, 0xffff] {
            let open = spread(squares);
            for cell in 0..64 {
                let square = 4 * (cell / 16) + cell % 8 / 2;
                assert_eq!(open >> cell & 1, u64::from(squares >> square & 1), "{squares:x} {cell}");
            }
        }
    }

    proptest! {
        #[test]
        fn counts_say_where_surfels_are(each in prop::collection::vec(0_usize..16, 0..100)) {
            let counts = Counts::of(each.iter().copied());
            let mut start = 0;
            for (voxel, &count) in each.iter().enumerate() {
                prop_assert_eq!(counts[voxel / GROUP].range(voxel % GROUP), start..start + count);
                start += count;
            }
        }

        #[test]
        fn a_record_is_the_surfel_but_for_its_weight(
            n in prop::array::uniform3(-1.0_f32..1.0),
            squares in prop::array::uniform2(any::<u16>()),
            part in 0.01_f32..1.0,
            turned in any::<bool>(),
        ) {
            let n = Vec3::from_array(n);
            prop_assume!(n.length() > 0.1);
            let n = n.normalize();
            let colors = [Vec3::X, Vec3::Y];
            let of = |i: usize, normal, weight| Surfel::new(normal, colors[i], weight, spread(squares[i]));
            let root_colors = [[255, 0, 0], [0, 255, 0]];
            let near = |a: Surfel, b: Surfel| {
                // Half a step of 1/32, a whole one for what is lighter than one, and half one of 1/255.
                let close = (a.weight() - b.weight()).abs() < 1.0 / 32.0;
                close && a.normal() == b.normal() && a.color() == b.color() && a.coarse_mask() == b.coarse_mask()
            };
            for i in 0..2 {
                let surfel = of(i, n, part);
                prop_assert!(near(Record::new(&surfel, i == 1).surfel(root_colors), surfel));
            }
            let sides = [of(0, n, if turned { part } else { 1.0 }), of(1, -n, if turned { 1.0 } else { part })];
            let (pair, order) = Pair::new(&[sides[1], sides[0]], n).unwrap();
            prop_assert_eq!(order, [1, 0]);
            let back = pair.record().sides(n, root_colors);
            prop_assert!(near(back[0], sides[0]) && near(back[1], sides[1]), "{:?} {:?}", back, sides);
            // Two that face another way are no sheet.
            let other = snapped_normal((n + Vec3::splat(0.2)).normalize());
            prop_assert!(Pair::new(&[sides[0], of(1, other, 1.0)], n).is_none());
        }
    }
}
