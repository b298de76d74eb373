//! By how much deeper the voxels of a coarse level are along each direction than their ellipsoids say.
//!
//! The depths that an ellipsoid gives vary as a quadric does. What a texel hides among its copies varies otherwise: balls in
//! rows hide more aslant the rows than along them, and strands let through who looks along them, and next to nobody else.
//! And of voxels at the same height one stops much and the next little of what comes from a side. So what is left after
//! `calibrate.rs` is kept beside the voxels, as a factor for each direction: of each voxel where they are few, else of all
//! at about the same height. Each then stops as many sightlines as the geometry in it does: the whole hides what it should,
//! and each voxel is as much of what is seen.

use std::iter::Sum;

use glam::Vec3;
use rayon::prelude::*;

use crate::Level;
use crate::calibrate::is_solid;
use crate::reflectance::{UPPER, around};
use crate::sightline::{FLATTEST, Sightline};

/// Voxels of the same class have the same factors.
#[derive(Clone, Copy)]
enum Classes {
    /// Each voxel is one.
    Voxels,
    /// So many voxels above each other are one, as wide as the texel.
    Layers(i32),
}

impl Classes {
    #[inline]
    fn of(resolution: u32) -> Self {
        match resolution {
            ..=4 => Self::Voxels,
            _ => Self::Layers((resolution / LAYERS) as i32),
        }
    }

    #[inline]
    fn number(self, voxel: u32, z: i32) -> usize {
        match self {
            Self::Voxels => voxel as usize,
            Self::Layers(height) => (z / height) as usize,
        }
    }

    fn count(self, voxels: usize) -> usize {
        match self {
            Self::Voxels => voxels,
            Self::Layers(_) => LAYERS as usize,
        }
    }
}

/// Classes of levels whose voxels are many.
const LAYERS: u32 = 8;

/// The factors of a level, at the nodes of the upper hemisphere of `nodes.rs`: who looks along a line from its other end sees
/// as much.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Bearings {
    /// log₂, in 1/32; class after class.
    logs: Vec<i8>,
}

/// Steps of a logarithm to the base 2.
const STEPS: f32 = 32.0;

impl Bearings {
    /// How many levels have them, from the coarsest on.
    pub const LEVELS: usize = 5;

    /// The factor along a direction, of any length, of a voxel at the height z of a level.
    #[inline]
    pub fn factor(&self, direction: Vec3, voxel: u32, z: i32, resolution: u32) -> f32 {
        let row = &self.logs[Classes::of(resolution).number(voxel, z) * UPPER..];
        let sum: f32 = nodes(direction).iter().map(|(node, weight)| weight * f32::from(row[*node])).sum();
        (sum * STEPS.recip()).exp2()
    }

    /// The factors with which as many of the sightlines from about each direction are stopped by what they meet in each class as are
    /// in truth.
    pub fn fit(level: &Level, sightlines: &[Sightline]) -> Self {
        /// Each goes about half of the way that is left.
        const ROUNDS: usize = 16;
        let classes = Classes::of(level.resolution());
        let count = classes.count(level.len());
        let paths: Vec<Path> = sightlines.par_iter().map(|line| Path::new(line, level, classes)).collect();
        // A line that comes to a sheet where two voxels meet is stopped in one of them, and by next to nothing in the other:
        // that makes no holes in the sheet.
        let mut solid = vec![true; count];
        for (voxel, cell) in (0..).zip(level.cells()) {
            solid[classes.number(voxel, cell[2] as i32)] &= is_solid(&level.voxel(voxel));
        }
        let mut logs = vec![[0.0_f32; UPPER]; count];
        for _ in 0..ROUNDS {
            let of_some = |paths: &[Path]| {
                let mut needs = vec![[Need::default(); UPPER]; count];
                paths.iter().for_each(|path| path.follow(&logs, &mut needs));
                needs
            };
            // In parts of a fixed size, whose sums are the same for any number of threads.
            let parts: Vec<Vec<[Need; UPPER]>> = paths.par_chunks(1 << 14).map(of_some).collect();
            for (i, log) in logs.as_flattened_mut().iter_mut().enumerate().filter(|(i, _)| !solid[i / UPPER])
            {
                *log = parts.iter().map(|needs| needs.as_flattened()[i]).sum::<Need>().next(*log);
            }
        }
        let whole = |log: &f32| (STEPS * core::f32::consts::LOG2_E * log).round() as i8;
        Self { logs: logs.as_flattened().iter().map(whole).collect() }
    }

    pub fn logs(&self) -> &[i8] {
        &self.logs
    }

    /// From what [`logs`](Self::logs) gave: as many as a level [has](count).
    pub fn new(logs: Vec<i8>) -> Self {
        Self { logs }
    }
}

/// How many numbers a level of so many voxels, so many a side, has.
pub(crate) fn count(resolution: u32, voxels: usize) -> usize {
    UPPER.saturating_mul(Classes::of(resolution).count(voxels))
}

/// The nodes around a direction or its opposite, whichever is above, and their weights. Their sum falls from 1 to 0 from about
/// the flattest sightlines on, as nothing is known of what is flatter: level lines have no end that is above.
#[inline]
fn nodes(direction: Vec3) -> [(usize, f32); 4] {
    let up = if direction.z < 0.0 { -direction } else { direction };
    let known = (up.z / (FLATTEST * up.abs().element_sum()).max(f32::MIN_POSITIVE)).min(1.0);
    around(up).map(|(node, weight)| (node, known * weight))
}

/// What a sightline meets in a level.
struct Path {
    nodes: [(usize, f32); 4],
    /// Class after class that it goes through: its number, the depth in it, and whether the geometry stops the line there.
    met: Vec<(u32, f32, bool)>,
}

impl Path {
    fn new(line: &Sightline, level: &Level, classes: Classes) -> Self {
        let mut met: Vec<(u32, f32, bool)> = Vec::new();
        let mut gone = false;
        line.meet(level, |voxel, z, depth, is_stopped| {
            let class = classes.number(voxel, z) as u32;
            let stops = is_stopped && !gone;
            gone |= stops;
            match met.last_mut() {
                Some(last) if last.0 == class => *last = (class, last.1 + depth, last.2 || stops),
                _ => met.push((class, depth, stops)),
            }
        });
        Self { nodes: nodes(line.direction()), met }
    }

    /// Adds what it says of the factors to what they need.
    fn follow(&self, logs: &[[f32; UPPER]], needs: &mut [[Need; UPPER]]) {
        let mut reached = 1.0;
        for &(class, depth, stops) in &self.met {
            let class = class as usize;
            let log: f32 = self.nodes.iter().map(|(node, weight)| weight * logs[class][*node]).sum();
            let depth = log.exp() * depth;
            let passing = (-depth).exp();
            let stopped = if stops { 1.0 } else { 0.0 };
            for (node, weight) in self.nodes {
                let need = &mut needs[class][node];
                need.missing += weight * (stopped - reached * (1.0 - passing));
                need.gained += weight * reached * depth * passing;
            }
            reached *= passing;
        }
    }
}

/// What the factor of a class at a node needs.
#[derive(Clone, Copy, Default)]
struct Need {
    /// How many sightlines more the class should stop.
    missing: f32,
    /// How many more it would if its depths were e times as large, were that no limit.
    gained: f32,
}

impl Sum for Need {
    fn sum<I: Iterator<Item = Self>>(needs: I) -> Self {
        needs.fold(Self::default(), |a, b| Self {
            missing: a.missing + b.missing,
            gained: a.gained + b.gained,
        })
    }
}

impl Need {
    /// A logarithm nearer to what is needed.
    fn next(self, log: f32) -> f32 {
        /// What speaks for a factor of 1, in sightlines.
        const PRIOR: f32 = 1.0;
        /// No factor is further from 1 than this, as a logarithm.
        const MOST: f32 = 2.0;
        let step = (self.missing - PRIOR * log) / (self.gained + PRIOR);
        (log + step.clamp(-0.5, 0.5)).clamp(-MOST, MOST)
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use glam::Vec2;

    use super::*;
    use crate::random::Random;
    use crate::{BuildOptions, Geometry, Hypertexture, Line, Texel, build};

    /// Two by two square pillars, half as wide as they are apart, from the surface to the top.
    fn pillars() -> Texel {
        let pillar = |i: usize| {
            let corner = Vec3::new(0.125 + 0.5 * (i % 2) as f32, 0.125 + 0.5 * (i / 2) as f32, 0.0);
            let at = |i: usize, z: f32| {
                let ring = [[0.0, 0.0], [0.25, 0.0], [0.25, 0.25], [0.0, 0.25]][i % 4];
                corner + Vec3::new(ring[0], ring[1], z)
            };
            let walls = (0..4).flat_map(move |i| {
                let [a, b, c, d] = [at(i, 0.0), at(i + 1, 0.0), at(i + 1, 1.0), at(i, 1.0)];
                [[a, b, c], [a, c, d]]
            });
            let ends = [0.0, 1.0].map(|z| [[at(0, z), at(1, z), at(2, z)], [at(0, z), at(2, z), at(3, z)]]);
            walls.chain(ends.into_iter().flatten()).collect::<Vec<_>>()
        };
        let triangles: Vec<[Vec3; 3]> = (0..4).flat_map(pillar).collect();
        let colors = vec![Vec3::ONE; triangles.len()];
        let geometry = Geometry { triangles, colors, ..Geometry::default() };
        let options = BuildOptions { depth: 3, ..BuildOptions::preview() };
        build("pillars", geometry, &options, &|_| ()).expect("it is sound")
    }

    /// How much of what comes down from a direction a level stops, on the mean over a copy.
    fn stopped(level: &Level, up: Vec3) -> f32 {
        const SIDE: usize = 32;
        let size = level.resolution() as f32;
        let ray = |i: usize| {
            let [x, y] = [i % SIDE, i / SIDE].map(|i| size * (i as f32 + 0.5) / SIDE as f32);
            let from = Vec3::new(x, y, size);
            1.0 - level.transmittance(from, from - size * up / up.z)
        };
        (0..SIDE * SIDE).map(ray).sum::<f32>() / (SIDE * SIDE) as f32
    }

    #[test]
    fn along_rows_is_seen_through_what_is_closed_aslant() {
        // From 45° a way down is 1 long, twice as far as pillars are apart: along the rows half of all ways are in gaps, on the
        // diagonal hardly one passes between pillars. All are counted.
        let texel = pillars();
        let inside = |x: f32| (0.125..0.375).contains(&x.rem_euclid(0.5));
        let in_truth = |up: Vec3| {
            let passes = |i: usize| {
                let [x, y] = [i % 50, i / 50].map(|i| (i as f32 + 0.5) / 100.0);
                let way = |k: i32| k as f32 / 100.0 / up.z;
                (0..100).all(|k| !(inside(x - way(k) * up.x) && inside(y - way(k) * up.y)))
            };
            1.0 - (0..2500).filter(|i| passes(*i)).count() as f32 / 2500.0
        };
        // As nodes are 15° apart: on the mean over some directions about those two.
        let about = |around: f32, of: &dyn Fn(Vec3) -> f32| {
            let angles = (-5..=5).flat_map(|i| (-2..=2).map(move |j| (0.035 * i as f32, 0.05 * j as f32)));
            let one =
                |(turn, tilt): (f32, f32)| of((Vec2::from_angle(around + turn) * (1.0 + tilt)).extend(1.0));
            angles.map(one).sum::<f32>() / 55.0
        };
        let (level, mut without) = (texel.level(0), texel.level(0).clone());
        without.set_bearings(None);
        let [rows, aslant] = [0.0, 0.75 * PI].map(|around| {
            let truth = about(around, &in_truth);
            [level, &without].map(|level| about(around, &|up| stopped(level, up)) - truth)
        });
        // Gaps are narrower than what is between nodes: a third of what was wrong is left there.
        assert!(rows[0].abs() < 0.045 && aslant[0].abs() < 0.01, "{rows:?} {aslant:?}");
        assert!(rows[1] > 0.1 && aslant[1] < -0.05, "{rows:?} {aslant:?}");
    }

    #[test]
    fn a_line_has_the_same_factor_from_either_end() {
        let bearings = Bearings::new((0..UPPER as i8).collect());
        let factor = |d| bearings.factor(d, 0, 0, 1);
        let random = &mut Random::new(4, 0);
        for _ in 0..1000 {
            let d = 0.01 * random.direction();
            assert_eq!(factor(d), factor(-d), "{d}");
            // Along the surface the ellipsoid alone counts, and what is nearly along it goes there evenly.
            assert_eq!(factor(d.with_z(0.0)), 1.0, "{d}");
            assert!((factor(d.with_z(1e-6 * d.length())) - 1.0).abs() < 1e-3, "{d}");
        }
    }

    #[test]
    fn what_is_right_stays_and_what_is_half_is_doubled() {
        let thin = Hypertexture { density: 3.0, ..Hypertexture::calm() };
        let options = BuildOptions { depth: 3, ..BuildOptions::preview() };
        let texel = build("ball", thin, &options, &|_| ()).expect("it is sound");
        for l in [1, 3] {
            let mut level = texel.level(l).clone();
            level.set_bearings(None);
            // Stopped by the level itself, were it so many times as deep.
            let lines = |times: f32| {
                Sightline::of_all_bearings(4000, true, |i, from, to| {
                    let size = level.resolution() as f32;
                    let line = Line::new(size * from, size * (to - from));
                    let mut left = -Random::new(i as u64, 3).unit().max(1e-6).ln();
                    for step in level.walk_along(&line, [0.0, 1.0]) {
                        let Some(met) = level.cross(&line, &step) else { continue };
                        left -= times * met.depth;
                        if left <= 0.0 {
                            return met.range[1];
                        }
                    }
                    f32::INFINITY
                })
            };
            for times in [1.0, 2.0] {
                let logs = Bearings::fit(&level, &lines(times));
                assert_eq!(logs.logs().len(), count(level.resolution(), level.len()));
                // The median of where the ball is: what hardly anything goes through is held near 1.
                let inside = if l == 1 { 0..8 } else { 2..6 };
                let mut logs = logs.logs()[inside.start * UPPER..inside.end * UPPER].to_vec();
                logs.sort_unstable();
                let factor = (f32::from(logs[logs.len() / 2]) / STEPS).exp2();
                assert!((factor / times - 1.0).abs() < 0.1, "level {l}: {factor} for {times}");
            }
        }
    }
}
