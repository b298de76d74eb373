//! The heart: what a cone sees on its way through the scene.
//!
//! A cone is followed in four steps, one file each:
//!
//! 1. [`passages`]: which boxes its axis goes through, from where to where;
//! 2. [`path`]: through each box, the curve that the straight axis is in texel space, in exact chords;
//! 3. [`march`]: along the chords, the voxels of the levels that fit the cone's width ([`lod`]), as a [`Trail`]; where
//!    copies of the texel differ, copy by copy ([`stretch`]), and where the skin ends, at finer levels ([`border`]);
//! 4. [`composite`]: the trails of all boxes merged by distance, front to back, cut by opaque surfaces.
//!
//! [`shadow`] does the same towards a light, where only the transmittance matters; [`shade`] lights the voxels that were
//! seen ([`facing`], [`below`]) and [`opaque`] the surfaces.

mod below;
mod border;
pub(crate) mod composite;
mod deep_shadow;
pub(crate) mod edges;
mod facing;
pub(crate) mod gloss;
mod light_lines;
pub(crate) mod lod;
pub(crate) mod march;
mod opaque;
pub(crate) mod passages;
pub(crate) mod path;
pub(crate) mod shade;
pub(crate) mod shadow;
mod stretch;
mod widths;

use std::hash::{Hash, Hasher};

use path::Chord;

use crate::Counts;

/// Which voxel of which box: rays that meet the same one share its shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct VoxelKey {
    /// The box, among all of the scene.
    pub patch: u32,
    /// Level of the texel.
    pub level: u8,
    /// The voxel within that level; s and t may lie in another copy of the texel. Where copies differ, it is the voxel
    /// of the copy's own texel, plus the whole copies before it.
    pub cell: [i32; 3],
}

impl Hash for VoxelKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { patch, level, cell } = *self;
        state.write_u64(u64::from(patch) << 32 | u64::from(level) << 24 ^ u64::from(cell[2] as u32));
        state.write_u64(u64::from(cell[0] as u32) << 32 | u64::from(cell[1] as u32));
    }
}

impl VoxelKey {
    /// The copy that it lies in.
    #[inline]
    pub fn copy(&self) -> [i32; 2] {
        [self.cell[0] >> self.level, self.cell[1] >> self.level]
    }

    /// The voxel in that copy.
    #[inline]
    pub fn within(&self) -> [i32; 3] {
        let ([x, y, z], mask) = (self.cell, (1 << self.level) - 1);
        [x & mask, y & mask, z & mask]
    }
}

/// The part of a ray inside the matter of one voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub key: VoxelKey,
    /// Index of the voxel in its level.
    pub voxel: u32,
    /// Weight of the even one of the two levels in use there.
    pub even: f32,
    /// Optical depth.
    pub depth: f32,
    /// What gets through it.
    pub through: f32,
    /// Distance at which the ray enters it, in scene units.
    pub t: f32,
    /// Which of [`Trail::chords`] it lies on, and from where to where of it, as fractions.
    pub chord: u32,
    pub range: [f32; 2],
}

/// What a ray meets on its way, before anything hides anything.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    /// The pieces of the even levels and of the odd ones in the box that was gone through last, each in order of
    /// distance.
    pub runs: [Vec<Piece>; 2],
    /// The chords of all boxes so far.
    pub chords: Vec<Chord>,
    /// What was done for all trails so far.
    pub counts: Counts,
}

impl Trail {
    pub fn clear(&mut self) {
        self.runs.iter_mut().for_each(Vec::clear);
        self.chords.clear();
    }

    /// The pieces of both runs by distance; of two at the same one, the coarser first.
    pub fn pieces(&self) -> impl Iterator<Item = &Piece> {
        let [mut even, mut odd] = [self.runs[0].as_slice(), self.runs[1].as_slice()];
        std::iter::from_fn(move || {
            let run = match (even.first(), odd.first()) {
                (Some(a), Some(b)) if (b.t, b.key.level) < (a.t, a.key.level) => &mut odd,
                (None, _) => &mut odd,
                _ => &mut even,
            };
            let (first, rest) = run.split_first()?;
            *run = rest;
            Some(first)
        })
    }

    /// Where the ray enters and leaves the matter of a piece: distances, in scene units.
    pub fn distances(&self, piece: &Piece) -> [f32; 2] {
        let [near, far] = self.chords[piece.chord as usize].distances(piece.range);
        [near as f32, far as f32]
    }
}

/// A ray on its way, blended from two: one sees the even levels only, one the odd, and what either has lost it has lost
/// alone. So between two levels a picture is the mean of the two pictures: what gets past a strand in one cell gets
/// past it in the next, which blending cell by cell would forget. Where the cone's width changes along the ray, its
/// part moves from one to the other with what it has lost by then. [method §6]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    /// What is left, in the even and in the odd levels.
    left: [f32; 2],
    /// The even levels' weight.
    even: f32,
}

impl Blend {
    pub const START: Self = Self { left: [0.5; 2], even: 0.5 };

    /// Goes through a piece of a level that gets `through` of it through, where the even levels weigh `even`; returns
    /// how much of the whole ray it hides.
    #[inline]
    pub fn pass(&mut self, level: u8, even: f32, through: f32) -> f32 {
        self.weigh(even);
        let left = &mut self.left[usize::from(level % 2)];
        let hidden = *left * (1.0 - through);
        *left -= hidden;
        hidden
    }

    /// Gives the even levels the weight `even`.
    #[inline]
    fn weigh(&mut self, even: f32) {
        if even == self.even {
            return;
        }
        let (from, kept) =
            if even < self.even { (0, even / self.even) } else { (1, (1.0 - even) / (1.0 - self.even)) };
        let moved = self.left[from] * (1.0 - kept);
        self.left[from] -= moved;
        self.left[1 - from] += moved;
        self.even = even;
    }

    /// How much has got through so far.
    #[inline]
    pub fn transmittance(&self) -> f32 {
        self.left[0] + self.left[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blend_is_the_mean_of_two_pictures() {
        // Two cells; the coarse level (2) lets ½ through in each, the fine one (3) all or nothing, in both alike.
        for (fine, expected) in [(1.0, 1.0), (0.0, 0.0)] {
            for weight in [0.0, 0.25, 0.7, 1.0] {
                let (mut blend, mut hidden) = (Blend::START, 0.0);
                for _ in 0..2 {
                    hidden += blend.pass(2, 1.0 - weight, 0.5);
                    hidden += blend.pass(3, 1.0 - weight, fine);
                }
                let mean = (1.0 - weight) * 0.25 + weight * expected;
                assert!((blend.transmittance() - mean).abs() < 1e-6);
                assert!((hidden + mean - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn weights_that_change_lose_nothing() {
        // Half is lost in level 4, at a weight of 1; then level 5 takes over by and by: all of it carries the loss.
        let mut blend = Blend::START;
        assert_eq!(blend.pass(4, 1.0, 0.5), 0.5);
        for even in [0.9, 0.6, 0.1, 0.0] {
            assert_eq!(blend.pass(5, even, 1.0), 0.0);
            assert!((blend.transmittance() - 0.5).abs() < 1e-6);
        }
        // And to level 6, from which as much is hidden as it has.
        assert!((blend.pass(6, 1.0, 0.0) - 0.5).abs() < 1e-6);
        assert!(blend.transmittance() < 1e-6);
    }
}
