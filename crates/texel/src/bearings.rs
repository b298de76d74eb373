//! By how much deeper the voxels of a coarse level are along each direction than their ellipsoids say.
//!
//! The depths that an ellipsoid gives vary as a quadric does, and are alike from both ends of any diameter of the
//! horizon. What a texel hides of its copies varies otherwise: balls in rows hide more aslant the rows than along them, and
//! strands let through who looks along them, and next to nobody else. And of voxels at the same height one stops much and
//! the next little of what comes from a side. So what is left after `calibrate.rs` is kept beside the voxels, as a factor
//! for each direction: of each voxel where they are few, else of all at about the same height. Each then stops as many
//! sightlines as the geometry in it does: the whole hides what it should, and each voxel is as much of what is seen.

use glam::Vec3;
use rayon::prelude::*;

use crate::Level;
use crate::reflectance::{UPPER, around};
use crate::sightline::Sightline;

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
        let mut logs = vec![[0.0_f32; UPPER]; count];
        for _ in 0..ROUNDS {
            let mut needs = vec![[Need::default(); UPPER]; count];
            paths.iter().for_each(|path| path.follow(&logs, &mut needs));
            for (log, need) in logs.as_flattened_mut().iter_mut().zip(needs.as_flattened()) {
                *log = need.next(*log);
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
    UPPER * Classes::of(resolution).count(voxels)
}

/// The nodes around a direction or its opposite, whichever is above.
#[inline]
fn nodes(direction: Vec3) -> [(usize, f32); 4] {
    around(if direction.z < 0.0 { -direction } else { direction })
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
