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
//!
//! Longer than most files here: half of it is the tests, which need the walk's inside.

use glam::{IVec3, Vec3A};

use crate::Line;
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
    line: Line,
    /// In each axis 1 where the line moves forwards (or not at all), else 0: which wall of a cell it leaves by.
    ahead: Vec3A,
    /// 1 or −1: to the next cell.
    next: Vec3A,
    /// Unwrapped coordinates are masked by this to wrap.
    mask: i32,
    /// The cells that exist, before wrapping: `low..=high`.
    low: Vec3A,
    high: Vec3A,
    /// The cell, in whole numbers: as floats the three axes step together.
    cell: Vec3A,
    /// The parameters of the walls by which the line leaves the cell.
    exit: Vec3A,
    t: f32,
    end: f32,
    /// The 4³ block that was read last: its place, its occupancy and the voxels before it.
    block: IVec3,
    word: u64,
    first: u32,
}

/// Coordinates beyond this many cells have lost the cell they lie in (an f32 has 24 bits): such segments meet nothing.
const REACH: f32 = (1 << 22) as f32;

/// Added to a whole number of magnitude up to 2²², it leaves the number's two's complement in the low bits.
const WHOLE: f32 = (3 << 22) as f32;

/// A vector of whole numbers below 2²² as integers: what `as` does, without its care for numbers that are not.
#[inline]
fn whole(v: Vec3A) -> IVec3 {
    let bits = |c: f32| c.to_bits() as i32 - WHOLE.to_bits() as i32;
    let [x, y, z] = (v + Vec3A::splat(WHOLE)).to_array();
    IVec3::new(bits(x), bits(y), bits(z))
}

impl<'a> Walk<'a> {
    /// Walks along a line (in cells) between two parameters; periodic in x and y if asked, clipped otherwise and in z.
    #[inline]
    pub(crate) fn new(bricks: &'a Bricks, periodic: bool, line: &Line, range: [f32; 2]) -> Self {
        let size = bricks.resolution() as f32;
        let &Line { from, step, inverse } = line;
        let (low, high) = if periodic {
            (Vec3A::new(-REACH, -REACH, 0.0), Vec3A::new(REACH, REACH, size))
        } else {
            (Vec3A::ZERO, Vec3A::splat(size))
        };
        let (a, b) = ((low - from) * inverse, (high - from) * inverse);
        let ends = [from + step * range[0], from + step * range[1]];
        let usable = ends.iter().all(|p| p.abs().cmplt(Vec3A::splat(REACH)).all()) && bricks.len() > 0;
        let t = a.min(b).max_element().max(range[0]);
        let end = if usable { a.max(b).min_element().min(range[1]) } else { t };
        let last = high - Vec3A::ONE;
        let cell = (from + step * t).floor().clamp(low, last);
        let backwards = step.cmplt(Vec3A::ZERO);
        let ahead = Vec3A::select(backwards, Vec3A::ZERO, Vec3A::ONE);
        Self {
            bricks,
            line: *line,
            ahead,
            next: Vec3A::select(backwards, Vec3A::NEG_ONE, Vec3A::ONE),
            mask: bricks.resolution() as i32 - 1,
            low,
            high: last,
            cell,
            exit: (cell + ahead - from) * inverse,
            t,
            end,
            block: IVec3::MAX,
            word: 0,
            first: 0,
        }
    }

    /// Moves on to the cells `next`, at the parameter `at`.
    #[inline]
    fn enter(&mut self, next: Vec3A, at: f32) {
        self.t = if at > self.t { at } else { self.t };
        self.cell = next;
        self.exit = (next + self.ahead - self.line.from) * self.line.inverse;
        if (next.cmplt(self.low) | next.cmpgt(self.high)).any() {
            self.end = self.end.min(self.t);
        }
    }

    /// Moves to where the segment leaves the cell: across two walls at once, where they meet.
    #[inline]
    fn cross_cell(&mut self) {
        let at = self.exit.min_element();
        let crossed = self.exit.cmple(Vec3A::splat(at));
        self.enter(self.cell + Vec3A::select(crossed, self.next, Vec3A::ZERO), at);
    }

    /// Moves to where the segment leaves the aligned cube of `size` cells a side around the cell.
    #[inline]
    fn cross_cube(&mut self, size: i32) {
        let side = size as f32;
        // Powers of two: exact.
        let low = (self.cell * side.recip()).floor() * side;
        let walls = (low + self.ahead * side - self.line.from) * self.line.inverse;
        let at = walls.min_element();
        let crossed = walls.cmple(Vec3A::splat(at));
        let here = (self.line.from + self.line.step * self.t.max(at)).floor();
        let here = here.clamp(low, low + (side - 1.0));
        // Never backwards.
        let along = Vec3A::select(self.next.cmplt(Vec3A::ZERO), here.min(self.cell), here.max(self.cell));
        let beyond = low + self.ahead * (side + 1.0) - 1.0;
        self.enter(Vec3A::select(crossed, beyond, along), at);
    }
}

impl Iterator for Walk<'_> {
    type Item = Step;

    #[inline]
    fn next(&mut self) -> Option<Step> {
        while self.t < self.end {
            let cell = whole(self.cell);
            let wrapped = cell & self.mask;
            let block = cell >> 2;
            if block != self.block {
                match self.bricks.place(wrapped) {
                    Place::Void(size) => {
                        self.cross_cube(size);
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
                let enter = self.t;
                let end = self.end;
                self.cross_cell();
                let leave = self.t.min(end);
                if leave > enter {
                    return Some(Step { cell, voxel, enter, leave });
                }
            } else if self.word == 0 {
                self.cross_cube(4);
            } else if self.word >> (bit & !7) & 0xff == 0 {
                self.cross_cube(2);
            } else {
                self.cross_cell();
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::prelude::*;

    use super::*;
    use crate::bricks::morton;
    use crate::random::Random;

    /// From one point to another.
    fn walk(bricks: &Bricks, periodic: bool, from: Vec3, to: Vec3) -> Walk<'_> {
        Walk::new(bricks, periodic, &Line::new(from, to - from), [0.0, 1.0])
    }

    /// A level with a fraction of its cells occupied, in lumps so that empty cubes of every size occur.
    fn lumps(log: u32, fill: f32, seed: u64) -> Bricks {
        let size = 1 << log;
        let random = &mut Random::new(seed, 0);
        let mut codes = Vec::new();
        let mut kept = vec![];
        for shift in [0, 2, 4] {
            kept.push(
                (0..1_u32 << (3 * (log.saturating_sub(shift))))
                    .map(|_| random.unit() < fill)
                    .collect::<Vec<_>>(),
            );
        }
        for z in 0..size {
            for y in 0..size {
                for x in 0..size {
                    let code = morton([x, y, z]);
                    if [0, 2, 4]
                        .iter()
                        .zip(&kept)
                        .all(|(&s, kept)| kept.get(code as usize >> (3 * s)) == Some(&true))
                    {
                        codes.push(code);
                    }
                }
            }
        }
        codes.sort_unstable();
        Bricks::new(size, &codes)
    }

    /// Every cell near the segment, by the slab test, in f64: cell, enter, leave.
    fn all_cells(bricks: &Bricks, periodic: bool, from: Vec3, to: Vec3) -> Vec<(IVec3, f64, f64)> {
        let size = bricks.resolution() as i32;
        let (a, d) = (from.as_dvec3(), (to - from).as_dvec3());
        let [low, high] = [from.min(to).floor().as_ivec3(), from.max(to).floor().as_ivec3()];
        let mut met = Vec::new();
        for z in low.z.max(0)..=high.z.min(size - 1) {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let cell = IVec3::new(x, y, z);
                    let inside = |c: i32| (0..size).contains(&c);
                    if !(periodic || inside(x) && inside(y)) || bricks.find(cell & (size - 1)).is_none() {
                        continue;
                    }
                    let mut range = [0.0_f64, 1.0_f64];
                    for axis in 0..3 {
                        let [near, far] = [0.0, 1.0].map(|side| f64::from(cell[axis]) + side - a[axis]);
                        if d[axis] == 0.0 {
                            if near > 0.0 || far <= 0.0 {
                                range[1] = -1.0;
                            }
                        } else {
                            let [p, q] = [near / d[axis], far / d[axis]];
                            range = [range[0].max(p.min(q)), range[1].min(p.max(q))];
                        }
                    }
                    if range[1] > range[0] {
                        met.push((cell, range[0], range[1]));
                    }
                }
            }
        }
        met.sort_by(|a, b| a.1.total_cmp(&b.1));
        met
    }

    /// Checks a walk against the slab test. Coordinates of up to `reach` cells carry errors of `reach`·2⁻²³
    /// cells, and cells met for less than a few of those may be missed or met.
    fn check(bricks: &Bricks, periodic: bool, from: Vec3, to: Vec3, reach: f32) {
        let steps: Vec<Step> = walk(bricks, periodic, from, to).collect();
        let context = || format!("{from} to {to}, size {}", bricks.resolution());
        for pair in steps.windows(2) {
            assert!(pair[0].leave <= pair[1].enter, "order, {}", context());
        }
        let length = f64::from((to - from).length());
        let slack = 8.0 * f64::from(reach) * 2.0_f64.powi(-23);
        let slowest =
            (to - from).abs().to_array().into_iter().filter(|d| *d > 0.0).fold(f32::INFINITY, f32::min);
        // An error of `slack` cells across an axis is one of slack/|d| in the parameter.
        let tolerance = (slack / f64::from(slowest)).min(1.0);
        let expected = all_cells(bricks, periodic, from, to);
        for step in &steps {
            assert!(
                step.enter >= 0.0 && step.leave <= 1.0 && step.leave > step.enter,
                "range, {}",
                context()
            );
            let voxel = bricks.find(step.cell & (bricks.resolution() as i32 - 1));
            assert_eq!(voxel, Some(step.voxel), "{}", context());
            // The middle of every step lies in its cell.
            let middle =
                from.as_dvec3() + (to - from).as_dvec3() * f64::from(0.5 * (step.enter + step.leave));
            let outside = (middle - step.cell.as_dvec3() - 0.5).abs().max_element() - 0.5;
            assert!(outside <= slack, "{outside} outside {} at {step:?}, {}", step.cell, context());
        }
        for &(cell, enter, leave) in &expected {
            match steps.iter().find(|step| step.cell == cell) {
                Some(step) => {
                    let error =
                        (f64::from(step.enter) - enter).abs().max((f64::from(step.leave) - leave).abs());
                    assert!(error <= tolerance + 1e-6, "{error} at {cell}, {}", context());
                }
                None => assert!(
                    (leave - enter) * length <= 4.0 * slack + 2e-7 * length
                        || leave - enter <= 2.0 * tolerance,
                    "{cell} missed for {} cells, {}",
                    (leave - enter) * length,
                    context()
                ),
            }
        }
    }

    #[test]
    fn walks_meet_the_cells_that_the_slab_test_meets() {
        let random = &mut Random::new(7, 7);
        for (log, fill) in [(0, 1.0), (1, 0.6), (2, 0.7), (3, 0.7), (4, 0.6), (5, 0.8), (6, 0.75)] {
            let bricks = lumps(log, fill, u64::from(log));
            let size = bricks.resolution() as f32;
            for i in 0..6000 {
                let mut point = |spread: f32| {
                    let mut p = Vec3::new(random.signed(), random.signed(), random.signed()) * spread;
                    // On the grid, now and then, on some axes.
                    if i % 3 == 0 {
                        p = Vec3::new(p.x.round(), p.y, if i % 2 == 0 { p.z.round() } else { p.z });
                    }
                    p
                };
                let from = point(1.6 * size);
                let mut to = if i % 5 == 0 { from + point(0.7) } else { point(1.6 * size) };
                if i % 7 == 0 {
                    to[i % 3] = from[i % 3];
                }
                if i % 11 == 0 {
                    to[(i + 1) % 3] = from[(i + 1) % 3];
                }
                let periodic = i % 2 == 0;
                check(&bricks, periodic, from, to, 1.6 * size);
            }
        }
    }

    #[test]
    fn dense_samples_lie_in_the_steps() {
        let bricks = lumps(5, 0.8, 3);
        let random = &mut Random::new(1, 2);
        let mut occupied = 0;
        for _ in 0..500 {
            let mut point = || Vec3::new(random.signed(), random.signed(), random.unit()) * 40.0;
            let [from, to] = [point(), point()];
            let steps: Vec<Step> = walk(&bricks, true, from, to).collect();
            for sample in 0..400 {
                let t = (sample as f32 + 0.5) / 400.0;
                let p = from + (to - from) * t;
                // Samples within 1e-4 of a wall may fall to either side.
                let near_wall = (p - p.round()).abs().min_element() < 1e-4;
                if near_wall || p.z < 0.0 || p.z >= 32.0 {
                    continue;
                }
                let voxel = bricks.find(p.floor().as_ivec3() & 31);
                let step = steps.iter().find(|step| step.enter <= t && t < step.leave);
                assert_eq!(step.map(|step| step.voxel), voxel, "{p} from {from} to {to}");
                occupied += usize::from(voxel.is_some());
            }
        }
        assert!(occupied > 10_000, "{occupied}");
    }

    #[test]
    fn a_full_level_is_crossed_without_gaps() {
        let codes: Vec<u32> = (0..4096).collect();
        let bricks = Bricks::new(16, &codes);
        let random = &mut Random::new(5, 5);
        for _ in 0..2000 {
            let mut point = |z: f32| Vec3::new(100.0 * random.signed(), 100.0 * random.signed(), z);
            let [from, to] = [point(-1.0), point(17.0)];
            let steps: Vec<Step> = walk(&bricks, true, from, to).collect();
            for pair in steps.windows(2) {
                assert_eq!(pair[0].leave, pair[1].enter);
            }
            // z runs from −1 to 17, so 16 of its 18 cells' length is inside: 1/18 to 17/18.
            let [first, last] = [steps[0], steps[steps.len() - 1]];
            assert!((first.enter - 1.0 / 18.0).abs() < 1e-6 && (last.leave - 17.0 / 18.0).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_not_a_segment_meets_nothing() {
        let bricks = Bricks::new(8, &(0..512).collect::<Vec<_>>());
        let inside = Vec3::splat(3.5);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -5e6] {
            for axis in 0..3 {
                let mut p = inside;
                p[axis] = bad;
                assert_eq!(walk(&bricks, true, inside, p).count(), 0);
                assert_eq!(walk(&bricks, true, p, inside).count(), 0);
                assert_eq!(walk(&bricks, false, p, p).count(), 0);
            }
        }
        let empty = Bricks::new(8, &[]);
        assert_eq!(walk(&empty, true, Vec3::ZERO, Vec3::splat(8.0)).count(), 0);
        // A point inside a voxel is in it all the while.
        let steps: Vec<Step> = walk(&bricks, true, inside, inside).collect();
        assert_eq!((steps.len(), steps[0].enter, steps[0].leave), (1, 0.0, 1.0));
    }

    #[test]
    fn far_copies_end() {
        let bricks = lumps(4, 0.8, 1);
        // 4 million cells: no cell has a place of its own any more, but the walk ends, in order.
        let steps = walk(&bricks, true, Vec3::new(-4e6, 4e6, 0.1), Vec3::new(4e6, -3.9e6, 15.9));
        let mut last = 0.0;
        for step in steps {
            assert!(step.enter >= last && step.leave > step.enter);
            last = step.leave;
        }
    }

    proptest! {
        #[test]
        fn any_segment_agrees_with_the_slab_test(
            from in prop::array::uniform3(-20.0_f32..20.0),
            to in prop::array::uniform3(-20.0_f32..20.0),
            periodic in any::<bool>(),
        ) {
            let bricks = lumps(3, 0.7, 9);
            check(&bricks, periodic, Vec3::from_array(from), Vec3::from_array(to), 20.0);
        }
    }
}
