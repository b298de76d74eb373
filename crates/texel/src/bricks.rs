//! Which cells of a level are occupied, and which voxel stands in each: the level flattened into 8³ bricks.
//!
//! ```text
//! coarse   (R/8)³ × u32    x fastest      EMPTY | k   the aligned cube of 8·2^k cells around it is empty
//!                                         b           brick b
//! bricks   b: words [u64; 8]              one bit a cell; a word is a 4³ block, a byte of it a 2³ block
//!             ranks 7 × 9 bits            voxels before each word but the first, within the brick [Vigna08]
//!             first u32                   voxels before the brick
//! voxel of a cell = first + rank of the word + popcount(the word's bits below the cell's)
//! ```
//!
//! Cells stand in Morton order (x lowest) within bricks, bricks in Morton order within the level: voxels are
//! therefore in the Morton order of their cells, children follow each other, and empty 2³ and 4³ blocks show
//! as a zero byte or word. Two dependent loads find a voxel; there is no stack. Levels of less than 8 cells a
//! side use the low corner of one brick.
//!
//! Measured on hair: 24 ns a cell against 35 for a pointer octree.

use glam::IVec3;

/// Marks an entry of the coarse grid whose low bits are the logarithm of an empty cube's size in bricks.
const EMPTY: u32 = 1 << 31;

/// The Morton code of a cell: bits of x, y, z interleaved, x lowest. Coordinates below 2¹⁰.
pub(crate) fn morton(cell: [u32; 3]) -> u32 {
    let spread = |v: u32| {
        let v = (v | v << 16) & 0x0300_00ff;
        let v = (v | v << 8) & 0x0300_f00f;
        let v = (v | v << 4) & 0x030c_30c3;
        (v | v << 2) & 0x0924_9249
    };
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}

/// The cell of a Morton code.
pub(crate) fn demorton(code: u32) -> [u32; 3] {
    let gather = |v: u32| {
        let v = v & 0x0924_9249;
        let v = (v | v >> 2) & 0x030c_30c3;
        let v = (v | v >> 4) & 0x0300_f00f;
        let v = (v | v >> 8) & 0x0300_00ff;
        (v | v >> 16) & 0x3ff
    };
    [gather(code), gather(code >> 1), gather(code >> 2)]
}

/// 512 cells, in 76 bytes: without padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, packed(4))]
pub(crate) struct Brick {
    /// Occupancy, a word a 4³ block.
    pub(crate) words: [u64; 8],
    /// How many of its voxels stand before each word: 9 bits a word from the second on, up from the lowest.
    ranks: u64,
    /// How many voxels stand before it.
    first: u32,
}

impl Brick {
    /// With `first` voxels before it.
    fn new(words: [u64; 8], first: u32) -> Self {
        let (mut ranks, mut before) = (0, 0);
        for (i, word) in words[..7].iter().enumerate() {
            before += u64::from(word.count_ones());
            ranks |= before << (9 * i);
        }
        Self { words, ranks, first }
    }

    /// How many of its cells are occupied.
    fn len(&self) -> u32 {
        let words = self.words;
        words.iter().map(|word| word.count_ones()).sum()
    }

    /// How many voxels stand before a word, below 8.
    #[inline]
    fn before(&self, word: usize) -> u32 {
        // For the first word, the highest bit: no rank reaches it.
        self.first + (self.ranks >> (9 * ((word as u32 + 7) % 8)) & 511) as u32
    }
}

/// Where a cell stands: what the walk needs to know next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// All the aligned cube of this many cells a side (a power of two, at least 8) is empty.
    Void(i32),
    /// The cell's 4³ block: its occupancy and the voxels before it.
    Block(u64, u32),
}

/// The occupancy of one level.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bricks {
    resolution: u32,
    len: u32,
    coarse: Vec<u32>,
    bricks: Vec<Brick>,
}

impl Bricks {
    /// From the Morton codes of the occupied cells, strictly ascending, below `resolution³`; `resolution` is a
    /// power of two.
    pub(crate) fn new(resolution: u32, codes: &[u32]) -> Self {
        let occupied = codes.chunk_by(|a, b| a >> 9 == b >> 9).map(|cells| {
            let mut words = [0; 8];
            cells.iter().for_each(|code| words[(code >> 6 & 7) as usize] |= 1 << (code & 63));
            (cells[0] >> 9, words)
        });
        Self::of_occupied(resolution, occupied)
    }

    /// From the Morton codes of the bricks that hold something, ascending, each with its occupancy.
    fn of_occupied(resolution: u32, occupied: impl Iterator<Item = (u32, [u64; 8])>) -> Self {
        let side = (resolution / 8).max(1) as usize;
        let mut bricks: Vec<Brick> = Vec::new();
        let mut coarse = vec![EMPTY; side * side * side];
        let mut len = 0;
        for (code, words) in occupied {
            let [x, y, z] = demorton(code).map(|v| v as usize);
            coarse[x + side * (y + side * z)] = bricks.len() as u32;
            let brick = Brick::new(words, len);
            len += brick.len();
            bricks.push(brick);
        }
        grow_empty_cubes(&mut coarse, side);
        Self { resolution, len, coarse, bricks }
    }

    /// The Morton code of each brick and its occupancy.
    pub(crate) fn occupied(&self) -> impl ExactSizeIterator<Item = (u32, [u64; 8])> + '_ {
        let origins = self.origins();
        self.bricks.iter().zip(origins).map(|(brick, origin)| (morton(origin), brick.words))
    }

    /// From what [`occupied`](Self::occupied) gave, or what is wrong with it.
    pub(crate) fn from_occupied(resolution: u32, occupied: &[(u32, [u64; 8])]) -> Result<Self, &'static str> {
        let side = (resolution / 8).max(1);
        let ascending = occupied.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !ascending || occupied.last().is_some_and(|&(code, _)| code >= side.pow(3)) {
            return Err("has bricks out of order");
        }
        // Of a small level only the first cells of its one brick exist.
        let cells =
            |words: &[u64; 8]| (0..8).rev().find_map(|w| words[w].checked_ilog2().map(|b| 64 * w as u32 + b));
        match occupied
            .iter()
            .map(|(_, words)| cells(words))
            .find(|last| last.is_none_or(|l| l >= resolution.pow(3)))
        {
            Some(None) => Err("has an empty brick"),
            Some(Some(_)) => Err("has cells outside of itself"),
            None => Ok(Self::of_occupied(resolution, occupied.iter().copied())),
        }
    }

    /// Cells a side.
    pub(crate) fn resolution(&self) -> u32 {
        self.resolution
    }

    /// How many cells are occupied.
    pub(crate) fn len(&self) -> u32 {
        self.len
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(self.coarse.as_slice()) + size_of_val(self.bricks.as_slice())
    }

    /// The voxel in a cell of the level, if it is occupied; coordinates below the resolution.
    pub(crate) fn find(&self, cell: IVec3) -> Option<u32> {
        match self.place(cell) {
            Place::Void(_) => None,
            Place::Block(word, first) => voxel_in(word, first, cell),
        }
    }

    /// What stands at a cell whose coordinates are below the resolution.
    #[inline]
    pub(crate) fn place(&self, cell: IVec3) -> Place {
        let side = (self.resolution as i32 / 8).max(1);
        let at = (cell.x >> 3) + side * ((cell.y >> 3) + side * (cell.z >> 3));
        let entry = self.coarse[at as usize];
        if entry & EMPTY != 0 {
            return Place::Void(8 << (entry & !EMPTY));
        }
        let brick = &self.bricks[entry as usize];
        let word = (cell.x >> 2 & 1 | (cell.y >> 2 & 1) << 1 | (cell.z >> 2 & 1) << 2) as usize;
        Place::Block(brick.words[word], brick.before(word))
    }

    /// The Morton codes of the parents of the occupied cells, ascending.
    pub(crate) fn parents(&self) -> impl Iterator<Item = u32> + '_ {
        // A byte of a word is a block of 2³ cells.
        self.occupied().flat_map(|(code, words)| {
            let blocks = words.into_iter().flat_map(u64::to_le_bytes);
            (0..).zip(blocks).filter(|&(_, block)| block != 0).map(move |(i, _)| code << 6 | i)
        })
    }

    /// The occupied cells, in the order of their voxels.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.bricks.iter().zip(self.origins()).flat_map(|(brick, origin)| {
            (0..512_u32).filter(|&bit| brick.words[(bit >> 6) as usize] >> (bit & 63) & 1 == 1).map(
                move |bit| {
                    let inside = demorton(bit);
                    std::array::from_fn(|axis| 8 * origin[axis] + inside[axis])
                },
            )
        })
    }

    /// Where each brick stands, in bricks.
    fn origins(&self) -> Vec<[u32; 3]> {
        let side = (self.resolution as usize / 8).max(1);
        let mut origins = vec![[0; 3]; self.bricks.len()];
        for (at, &entry) in self.coarse.iter().enumerate() {
            if entry & EMPTY == 0 {
                origins[entry as usize] = [at % side, at / side % side, at / side / side].map(|v| v as u32);
            }
        }
        origins
    }

    /// What does not fit, if anything: ranks, the size of the lists, empty cubes that are not empty.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let side = (self.resolution as usize / 8).max(1);
        if !self.resolution.is_power_of_two() || self.coarse.len() != side * side * side {
            return Some("the coarse grid has not the level's size");
        }
        let mut seen = vec![false; self.bricks.len()];
        for &entry in &self.coarse {
            if entry & EMPTY == 0 {
                match seen.get_mut(entry as usize) {
                    Some(seen) if !*seen => *seen = true,
                    _ => return Some("a brick is missing or named twice"),
                }
            }
        }
        let mut grown: Vec<u32> =
            self.coarse.iter().map(|&entry| if entry & EMPTY == 0 { entry } else { EMPTY }).collect();
        grow_empty_cubes(&mut grown, side);
        if grown != self.coarse {
            return Some("an empty cube is not the largest there is");
        }
        if seen.contains(&false) {
            return Some("a brick stands nowhere");
        }
        let mut voxels = 0;
        for brick in &self.bricks {
            if *brick != Brick::new(brick.words, voxels) {
                return Some("voxels are miscounted");
            }
            voxels += brick.len();
        }
        if voxels != self.len {
            return Some("voxels are miscounted");
        }
        (self.resolution < 8 && self.cells().any(|cell| cell.iter().any(|&c| c >= self.resolution)))
            .then_some("a cell lies outside the level")
    }
}

/// The voxel of a cell in its 4³ block, whose occupancy is `word` and which has `first` voxels before it.
#[inline]
pub(crate) fn voxel_in(word: u64, first: u32, cell: IVec3) -> Option<u32> {
    let bit = 1_u64 << bit_of(cell);
    (word & bit != 0).then(|| first + (word & (bit - 1)).count_ones())
}

/// The position of a cell in the word of its 4³ block.
#[inline]
pub(crate) fn bit_of(cell: IVec3) -> u32 {
    const SPREAD: [u32; 4] = [0, 1, 8, 9];
    SPREAD[(cell.x & 3) as usize] | SPREAD[(cell.y & 3) as usize] << 1 | SPREAD[(cell.z & 3) as usize] << 2
}

/// Lets every empty entry name the largest aligned empty cube around it.
fn grow_empty_cubes(coarse: &mut [u32], side: usize) {
    let mut size = 2;
    while size <= side {
        let half = size / 2;
        let wanted = EMPTY | half.trailing_zeros();
        for z in (0..side).step_by(size) {
            for y in (0..side).step_by(size) {
                for x in (0..side).step_by(size) {
                    let at = |i: usize, step: usize| {
                        let [dx, dy, dz] = [i % 2, i / 2 % 2, i / 4].map(|d| d * step);
                        x + dx + side * (y + dy + side * (z + dz))
                    };
                    if (0..8).all(|i| coarse[at(i, half)] == wanted) {
                        for i in 0..size * size * size {
                            let [dx, dy, dz] = [i % size, i / size % size, i / size / size];
                            coarse[x + dx + side * (y + dy + side * (z + dz))] = wanted + 1;
                        }
                    }
                }
            }
        }
        size *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn morton_codes_interleave_and_return() {
        assert_eq!(morton([1, 0, 0]), 1);
        assert_eq!(morton([0, 1, 0]), 2);
        assert_eq!(morton([0, 0, 2]), 32);
        for cell in [[511, 0, 3], [1, 2, 3], [300, 511, 257]] {
            assert_eq!(demorton(morton(cell)), cell);
        }
    }

    #[test]
    fn nothing_is_one_empty_cube() {
        let bricks = Bricks::new(64, &[]);
        assert_eq!(bricks.place(IVec3::new(63, 0, 17)), Place::Void(64));
        assert_eq!(bricks.fault(), None);
        assert_eq!(bricks.cells().count(), 0);
    }

    #[test]
    fn one_cell_leaves_the_largest_empty_cubes() {
        let bricks = Bricks::new(64, &[morton([0, 0, 0])]);
        assert_eq!(bricks.place(IVec3::new(63, 0, 17)), Place::Void(32));
        assert_eq!(bricks.place(IVec3::new(8, 0, 0)), Place::Void(8));
        assert_eq!(bricks.place(IVec3::new(16, 31, 0)), Place::Void(16));
        assert_eq!(bricks.find(IVec3::ZERO), Some(0));
        assert_eq!(bricks.find(IVec3::new(1, 0, 0)), None);
    }

    #[test]
    fn a_broken_rank_is_found() {
        let mut bricks = Bricks::new(16, &[3, 700]);
        assert_eq!(bricks.fault(), None);
        bricks.bricks[1].ranks |= 1 << 9;
        assert_eq!(bricks.fault(), Some("voxels are miscounted"));
    }

    proptest! {
        #[test]
        fn every_cell_is_found_where_it_was_put(
            log in 0_u32..7,
            codes in prop::collection::btree_set(any::<u32>(), 0..300),
        ) {
            let resolution = 1 << log;
            let codes: std::collections::BTreeSet<u32> =
                codes.iter().map(|c| c % (1 << (3 * log))).collect();
            let codes: Vec<u32> = codes.into_iter().collect();
            let bricks = Bricks::new(resolution, &codes);
            prop_assert_eq!(bricks.fault(), None);
            let cells: Vec<u32> = bricks.cells().map(morton).collect();
            prop_assert_eq!(&cells, &codes);
            let parents: std::collections::BTreeSet<u32> = codes.iter().map(|code| code >> 3).collect();
            prop_assert!(bricks.parents().eq(parents));
            for (voxel, &code) in codes.iter().enumerate() {
                let cell = demorton(code).map(|v| v as i32);
                prop_assert_eq!(bricks.find(IVec3::from_array(cell)), Some(voxel as u32));
            }
            let found = (0..1_u32 << (3 * log.min(4)))
                .filter(|&c| bricks.find(IVec3::from_array(demorton(c).map(|v| v as i32))).is_some());
            let expected = codes.iter().filter(|&&c| c < 1 << (3 * log.min(4))).count();
            prop_assert_eq!(found.count(), expected);
        }
    }
}
