//! Lines of sight through the content, and where it stops them: what the levels are held against.

use core::f32::consts::PI;

use glam::{Vec2, Vec3};
use pelage_geom::evenly;
use rayon::prelude::*;

use crate::random::Random;
use crate::reflectance::{UPPER, direction_above};
use crate::{Crossing, Level, Line};

/// A segment through the texel, and where the content first stops it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sightline {
    from: Vec3,
    to: Vec3,
    /// As a parameter from 0 to 1; infinite where it passes.
    hit: f32,
}

/// Flatter than this (radians) a sightline would cross dozens of tiles.
pub(crate) const FLATTEST: f32 = 0.06;

impl Sightline {
    /// `count` sightlines from above, all slopes alike, and where they end.
    ///
    /// `first_hit` says where the content stops the `i`-th of them, from one point to another, as a part of the way;
    /// infinite where it passes.
    pub(crate) fn of_all_slopes(
        count: usize,
        periodic: bool,
        first_hit: impl Fn(usize, Vec3, Vec3) -> f32 + Sync,
    ) -> Vec<Self> {
        let up = |i: usize, random: &mut Random| {
            let slope = FLATTEST + (0.5 * PI - FLATTEST) * (i as f32 + random.unit()) / count as f32;
            (Vec2::from_angle(2.0 * PI * random.unit()) * slope.cos()).extend(slope.sin())
        };
        Self::cast(count, periodic, up, first_hit)
    }

    /// So many sightlines from `each` part of the sky between the nodes of tables, and where they end, as
    /// [`of_all_slopes`](Self::of_all_slopes).
    pub(crate) fn of_all_bearings(
        each: usize,
        periodic: bool,
        first_hit: impl Fn(usize, Vec3, Vec3) -> f32 + Sync,
    ) -> Vec<Self> {
        let up = |i: usize, random: &mut Random| {
            let up = direction_above(i / each, random);
            Vec3 { z: up.z.max(FLATTEST), ..up }.normalize()
        };
        Self::cast(UPPER * each, periodic, up, first_hit)
    }

    fn cast(
        count: usize,
        periodic: bool,
        up: impl Fn(usize, &mut Random) -> Vec3 + Sync,
        first_hit: impl Fn(usize, Vec3, Vec3) -> f32 + Sync,
    ) -> Vec<Self> {
        let one = |i: usize| {
            let random = &mut Random::new(i as u64, 0x51a7);
            let up = up(i, random);
            let start = evenly(i).as_vec2();
            let (from, to) = if periodic {
                let from = start.extend(1.0);
                (from, from - up / up.z)
            } else {
                // Through any point of the cube, from outside it to outside it.
                let middle = start.extend(random.unit());
                (middle + 2.0 * up, middle - 2.0 * up)
            };
            Self { from, to, hit: first_hit(i, from, to) }
        };
        (0..count).into_par_iter().map(one).collect()
    }

    /// From one end to the other, texel space.
    pub(crate) fn direction(&self) -> Vec3 {
        self.to - self.from
    }

    /// What it meets in a level, in order: each voxel's index, its z, the optical depth there, and whether the content has
    /// stopped it by then.
    pub(crate) fn meet(&self, level: &Level, mut each: impl FnMut(u32, i32, f32, bool)) {
        let scale = level.resolution() as f32;
        let line = Line::new(self.from * scale, self.direction() * scale);
        for step in level.walk_along(&line, [0.0, 1.0]) {
            let Some(Crossing { range, depth }) = level.cross(&line, &step) else { continue };
            // The voxel that holds the hit, or the first behind it where rounding put the hit between two.
            each(step.voxel, step.cell.z, depth, self.hit <= range[1] + 1e-5);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflectance::around;

    #[test]
    fn they_come_from_all_of_the_sky_and_go_through_all_of_the_texel() {
        let passes = |_, _, _| f32::INFINITY;
        for (i, line) in Sightline::of_all_bearings(20, true, passes).iter().enumerate() {
            assert!(line.from.z == 1.0 && line.to.z.abs() < 1e-6);
            // None is nearer to the horizon than the limit; of the others each comes from its part.
            let up = -line.direction().normalize();
            assert!(up.z > 0.99 * FLATTEST);
            assert!(up.z < 0.1 || around(up).iter().any(|(node, weight)| *node == i / 20 && *weight >= 0.25));
        }
        let slopes = Sightline::of_all_slopes(300, false, passes);
        let mean = slopes.iter().map(|line| (-line.direction().normalize().z).asin()).sum::<f32>() / 300.0;
        assert!((mean - 0.5 * (FLATTEST + 0.5 * PI)).abs() < 1e-3);
        // Of what stands alone, from outside to outside.
        let beside = |p: Vec3| (p - 0.5).length() > 0.9;
        assert!(slopes.iter().all(|line| beside(line.from) && beside(line.to)));
    }
}
