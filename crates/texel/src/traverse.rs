//! The walk of a segment through one level: the hottest loop of the product.
//!
//! A step never carries an accumulated parameter: where the segment meets a wall is computed from the wall's
//! integer coordinate, so errors do not grow with the number of steps. In each direction the cell only moves
//! forwards and every step moves at least one axis by at least one cell, which bounds the walk by the number
//! of cells between its ends. The parameter is kept from running backwards (rounding can make a wall lie
//! before the one just crossed), so consecutive steps abut exactly and come in order; cells met for no length
//! at all are not reported.
//!
//! Empty space is crossed by aligned cubes: 8·2^k cells from the coarse grid, 4 or 2 from the occupancy word.

use glam::{IVec3, Vec3};

use crate::bricks::{Bricks, Place, bit_of};

/// A cell that a segment crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The cell, not wrapped: it may lie in another copy of the tile.
    pub cell: IVec3,
    /// Index of its voxel in the level.
    pub voxel: u32,
    /// Where the segment enters it, as a parameter in `[0, 1]` along the segment.
    pub enter: f32,
    /// Where it leaves it; greater than `enter`.
    pub leave: f32,
}

/// The occupied cells along a segment, in order. Made by [`Level::walk`](crate::Level::walk).
#[derive(Clone, Debug)]
pub struct Walk<'a> {
    bricks: &'a Bricks,
    from: Vec3,
    delta: Vec3,
    /// 1 / delta; 0 where the segment does not move.
    inverse: Vec3,
    /// Infinite where the segment does not move, else 0: added to the parameters of that axis's walls.
    never: Vec3,
    /// 1 where the segment moves forwards, else 0: which wall of a cell it leaves by.
    ahead: IVec3,
    /// Unwrapped coordinates are masked by this to wrap.
    mask: i32,
    /// The cells that exist, before wrapping: `low..high`.
    low: IVec3,
    high: IVec3,
    cell: IVec3,
    t: f32,
    end: f32,
    /// The 4³ block that was read last: its place, its occupancy and the voxels before it.
    block: IVec3,
    word: u64,
    first: u32,
}

impl<'a> Walk<'a> {
    /// Coordinates beyond this many cells have lost the cell they lie in (an f32 has 24 bits): such segments
    /// meet nothing.
    const REACH: f32 = (1 << 22) as f32;

    /// Walks from `from` to `to`, in cells; periodic in x and y if asked, clipped otherwise and in z.
    pub(crate) fn new(bricks: &'a Bricks, periodic: bool, from: Vec3, to: Vec3) -> Self {
        let size = bricks.resolution() as i32;
        let limit = if periodic { 2 * Self::REACH as i32 } else { size };
        let low = IVec3::new(if periodic { -limit } else { 0 }, if periodic { -limit } else { 0 }, 0);
        let high = IVec3::new(limit, limit, size);
        let mut delta = to - from;
        let mut range = [0.0_f32, 1.0_f32];
        let [mut inverse, mut never] = [Vec3::ZERO; 2];
        for axis in 0..3 {
            // Below this the reciprocal overflows; over the walk's reach it moves by less than an ulp of 1.
            if delta[axis].abs() < 1e-30 {
                delta[axis] = 0.0;
                never[axis] = f32::INFINITY;
            } else {
                inverse[axis] = delta[axis].recip();
            }
            if !(periodic && axis < 2) {
                let size = size as f32;
                if delta[axis] == 0.0 {
                    if from[axis] < 0.0 || from[axis] >= size {
                        range[1] = -1.0;
                    }
                } else {
                    let [a, b] = [-from[axis] * inverse[axis], (size - from[axis]) * inverse[axis]];
                    range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
                }
            }
        }
        let usable = from.abs().max_element() < Self::REACH && to.abs().max_element() < Self::REACH;
        let usable = usable && !from.is_nan() && !to.is_nan() && bricks.len() > 0;
        let [t, end] = if usable { range } else { [0.0, -1.0] };
        let cell = (from + delta * t).floor().as_ivec3().clamp(low, high - 1);
        let ahead = IVec3::new(i32::from(delta.x > 0.0), i32::from(delta.y > 0.0), i32::from(delta.z > 0.0));
        Self {
            bricks,
            from,
            delta,
            inverse,
            never,
            ahead,
            mask: size - 1,
            low,
            high,
            cell,
            t,
            end,
            block: IVec3::MAX,
            word: 0,
            first: 0,
        }
    }
}

impl Walk<'_> {
    /// Moves to where the segment leaves the aligned cube of `size` cells a side around the cell.
    #[inline]
    fn cross(&mut self, size: i32) {
        let low = self.cell & -size;
        let wall = (low + self.ahead * size).as_vec3();
        let at = (wall - self.from) * self.inverse + self.never;
        let axis = if at.x <= at.y {
            if at.x <= at.z { 0 } else { 2 }
        } else if at.y <= at.z {
            1
        } else {
            2
        };
        self.t = self.t.max(at[axis]);
        if size > 1 {
            let here = (self.from + self.delta * self.t).floor().as_ivec3().clamp(low, low + (size - 1));
            for other in 0..3 {
                let [cell, here] = [self.cell[other], here[other]];
                self.cell[other] = if self.ahead[other] == 1 { here.max(cell) } else { here.min(cell) };
            }
        }
        self.cell[axis] = low[axis] + self.ahead[axis] * (size + 1) - 1;
        if self.cell[axis] < self.low[axis] || self.cell[axis] >= self.high[axis] {
            self.end = self.end.min(self.t);
        }
    }
}

impl Iterator for Walk<'_> {
    type Item = Step;

    #[inline]
    fn next(&mut self) -> Option<Step> {
        while self.t < self.end {
            let wrapped = self.cell & self.mask;
            let block = self.cell >> 2;
            if block != self.block {
                match self.bricks.place(wrapped) {
                    Place::Void(size) => {
                        self.cross(size);
                        continue;
                    }
                    Place::Block(word, first) => {
                        (self.block, self.word, self.first) = (block, word, first);
                    }
                }
            }
            let bit = bit_of(wrapped);
            if self.word >> bit & 1 == 1 {
                let voxel = self.first + (self.word & ((1 << bit) - 1)).count_ones();
                let (cell, enter, end) = (self.cell, self.t, self.end);
                self.cross(1);
                let leave = self.t.min(end);
                if leave > enter {
                    return Some(Step { cell, voxel, enter, leave });
                }
            } else if self.word == 0 {
                self.cross(4);
            } else if self.word >> (bit & !7) & 0xff == 0 {
                self.cross(2);
            } else {
                self.cross(1);
            }
        }
        None
    }
}
