//! The heart: what a cone sees on its way through the scene.
//!
//! A cone is followed in four steps, one file each:
//!
//! 1. [`passages`]: which boxes its axis goes through, from where to where;
//! 2. [`path`]: through each box, the curve that the straight axis is in texel space, in exact chords;
//! 3. [`march`]: along the chords, the voxels of the levels that fit the cone's width ([`lod`]), as a [`Trail`];
//! 4. [`composite`]: the trails of all boxes merged by distance, front to back, cut by opaque surfaces.
//!
//! [`shadow`] does the same towards a light, where only the transmittance matters, and [`shade`] lights what
//! was seen.

pub(crate) mod composite;
pub(crate) mod lod;
pub(crate) mod march;
pub(crate) mod passages;
pub(crate) mod path;
pub(crate) mod shade;
pub(crate) mod shadow;

use glam::Vec3;

use path::Chord;

/// Which voxel of which box: rays that meet the same one share its shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct VoxelKey {
    /// The box, among all of the scene.
    pub patch: u32,
    /// Level of the texel.
    pub level: u8,
    /// The voxel within that level; s and t may lie in another copy of the texel.
    pub cell: [i32; 3],
}

/// The part of a ray inside the matter of one voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub key: VoxelKey,
    /// Index of the voxel in its level.
    pub voxel: u32,
    /// Whether it belongs to the finer of the two levels in use.
    pub fine: bool,
    /// Optical depth.
    pub depth: f32,
    /// What gets through it.
    pub through: f32,
    /// Which of [`Trail::chords`] it lies on, and from where to where of it, as fractions.
    pub chord: u32,
    pub range: [f32; 2],
}

/// One cell of the coarser level in use, with what the ray meets in it at both levels.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Where the ray enters it.
    pub t: f32,
    /// Weight of the finer level, in `[0, 1)`.
    pub blend: f32,
    /// Its pieces in [`Trail::pieces`], front to back within each level.
    pub pieces: std::ops::Range<u32>,
}

/// What a ray meets on its way, before anything hides anything.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    pub cells: Vec<Cell>,
    pub pieces: Vec<Piece>,
    pub chords: Vec<Chord>,
}

impl Trail {
    pub fn clear(&mut self) {
        self.cells.clear();
        self.pieces.clear();
        self.chords.clear();
    }

    /// Where the ray enters and leaves the matter of a piece: distances, in scene units.
    pub fn distances(&self, piece: &Piece) -> [f32; 2] {
        let [a, b] = self.chords[piece.chord as usize].t;
        piece.range.map(|x| (a + (b - a) * f64::from(x)) as f32)
    }

    /// The same, in texel coordinates (s, t, w).
    pub fn points(&self, piece: &Piece) -> [Vec3; 2] {
        let [a, b] = self.chords[piece.chord as usize].at;
        piece.range.map(|x| a.lerp(b, x))
    }

    /// The pieces of a cell.
    pub fn pieces_of(&self, cell: &Cell) -> &[Piece] {
        &self.pieces[cell.pieces.start as usize..cell.pieces.end as usize]
    }
}

/// The two levels of a cell as they hide each other: each has a transmittance of its own, and what gets through
/// the cell is their mean. Blending the transmittances, not the depths, keeps a half-covered cell half covered.
/// [method §6]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    weight: [f32; 2],
    through: [f32; 2],
}

impl Blend {
    pub fn new(cell: &Cell) -> Self {
        Self { weight: [1.0 - cell.blend, cell.blend], through: [1.0; 2] }
    }

    /// Goes through a piece of transmittance `through`; returns how much of what enters the cell it hides.
    #[inline]
    pub fn pass(&mut self, fine: bool, through: f32) -> f32 {
        let level = usize::from(fine);
        let hidden = self.weight[level] * self.through[level] * (1.0 - through);
        self.through[level] *= through;
        hidden
    }

    /// How much has got through so far.
    #[inline]
    pub fn transmittance(&self) -> f32 {
        self.weight[0] * self.through[0] + self.weight[1] * self.through[1]
    }
}
