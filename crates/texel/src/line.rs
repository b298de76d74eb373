//! A line against the matter of one voxel, with only as much of the voxel unpacked as it takes to miss it.

use glam::{IVec3, Vec3, Vec3A};

use crate::compact::CompactView;
use crate::packed::Packed;

/// Where the matter of a voxel lies and how dense it is, unpacked piece by piece.
pub(crate) trait Matter {
    /// The corners of the tight box.
    fn region_box(&self) -> [Vec3; 2];
    /// The slab's normal and its two distances.
    fn region_slab(&self) -> (Vec3, [f32; 2]);
    /// Depth a step `d`.
    fn depth_per_step(&self, d: Vec3) -> f32;
}

/// Implements [`Matter`] by the methods of the same names.
macro_rules! matter {
    ($($type:ty),+) => {$(
        impl Matter for $type {
            #[inline]
            fn region_box(&self) -> [Vec3; 2] {
                Self::region_box(self)
            }

            #[inline]
            fn region_slab(&self) -> (Vec3, [f32; 2]) {
                Self::region_slab(self)
            }

            #[inline]
            fn depth_per_step(&self, d: Vec3) -> f32 {
                Self::depth_per_step(self, d)
            }
        }
    )+};
}

matter!(Packed, CompactView<'_>);

/// A line through a level, prepared to be asked of many voxels.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where its parameter is 0, in voxels of the level.
    pub(crate) from: Vec3A,
    /// What a parameter of 1 moves it by.
    pub(crate) step: Vec3A,
    /// 1 / step, never infinite: where it moves by (nearly) nothing, so large that the sign of a distance decides.
    pub(crate) inverse: Vec3A,
}

/// What a line meets in a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where it enters and leaves the matter, as parameters.
    pub range: [f32; 2],
    /// Optical depth between the two.
    pub depth: f32,
}

impl Line {
    /// The line from `from` that moves by `step` a parameter of 1, in voxels of a level.
    #[inline]
    pub fn new(from: Vec3, step: Vec3) -> Self {
        const STEEPEST: Vec3A = Vec3A::splat(1e12);
        let (from, step) = (Vec3A::from(from), Vec3A::from(step));
        let inverse = step.recip().clamp(-STEEPEST, STEEPEST);
        Self { from, step, inverse: Vec3A::select(step.cmpeq(Vec3A::ZERO), STEEPEST, inverse) }
    }

    /// The part of `range` inside the matter of the voxel in `cell`, with its depth; `None` where that is nothing.
    /// The same as [`Voxel::clip`](crate::Voxel::clip) and [`depth_per_step`](crate::Voxel::depth_per_step).
    #[inline]
    pub(crate) fn cross(&self, matter: &impl Matter, cell: IVec3, range: [f32; 2]) -> Option<Crossing> {
        let p = self.from - cell.as_vec3a();
        let [lo, hi] = matter.region_box();
        let (lo, hi) = (Vec3A::from(lo), Vec3A::from(hi));
        let (a, b) = ((lo - p) * self.inverse, (hi - p) * self.inverse);
        let enter = a.min(b).max_element().max(range[0]);
        let leave = a.max(b).min_element().min(range[1]);
        if enter >= leave {
            return None;
        }
        let (normal, [low, high]) = matter.region_slab();
        let normal = Vec3A::from(normal);
        let (height, speed) = (normal.dot(p), normal.dot(self.step));
        let (mut enter, mut leave) = (enter, leave);
        if speed.abs() < 1e-12 {
            // Slower than this the line stays on its side of both planes over any voxel.
            if height < low || height > high {
                return None;
            }
        } else {
            let inverse = speed.recip();
            let (a, b) = ((low - height) * inverse, (high - height) * inverse);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
            if enter >= leave {
                return None;
            }
        }
        let depth = matter.depth_per_step(self.step.into()) * (leave - enter);
        (depth > 0.0).then_some(Crossing { range: [enter, leave], depth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::{BuildOptions, Fur, Step, build};

    #[test]
    fn crossing_is_clip_and_depth() {
        let fur = Fur { count: 30, ..Fur::long() };
        let texel = build("fur", fur, &BuildOptions::preview(), &|_| ()).unwrap();
        let mut met = 0;
        for level in texel.levels() {
            for trial in 0..8 * level.len() as u32 {
                let index = trial / 8;
                let random = &mut Random::new(5, trial.into());
                let mut unit = || Vec3::new(random.unit(), random.unit(), random.unit());
                let (p, mut d) = (unit(), unit() - unit());
                if trial % 7 == 0 {
                    d.x = 0.0;
                }
                let cell = IVec3::new(trial as i32 % 5 - 2, 3, 0);
                let from = p - d + cell.as_vec3();
                let range = [0.0, 2.0];
                let voxel = level.voxel(index);
                let factor = level.bearings().map_or(1.0, |b| b.factor(d, index, cell.z, level.resolution()));
                // `from` was rounded with the cell added: both must see the same point.
                let clipped = voxel.clip(from - cell.as_vec3(), d, range);
                let step = Step { cell, voxel: index, enter: range[0], leave: range[1] };
                let crossing = level.cross(&Line::new(from, d), &step);
                match (clipped, crossing) {
                    (Some([a, b]), Some(c)) => {
                        met += 1;
                        let depth = factor * voxel.depth_per_step(d) * (b - a);
                        assert!((c.range[0] - a).abs() + (c.range[1] - b).abs() < 1e-4, "{c:?} {a} {b}");
                        assert!(
                            (c.depth - depth).abs() <= 1e-3 * depth + 1e-4 * factor * voxel.depth_per_step(d)
                        );
                    }
                    (None, None) => {}
                    // Only what is shorter than rounding may be met by one and missed by the other.
                    (Some([a, b]), None) => assert!(b - a < 1e-4 || voxel.depth_per_step(d) == 0.0),
                    (None, Some(c)) => assert!(c.range[1] - c.range[0] < 1e-4),
                }
            }
        }
        assert!(met > 1000, "only {met} crossings");
    }
}
