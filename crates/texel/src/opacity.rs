//! How much of a texel can be seen through from the side or from above.

use glam::Vec3;

use crate::{Level, Line, Texel};

impl Level {
    /// What part of the light passes from one point to another, 0 to 1. Both in voxels of this level, as
    /// [`walk`](Self::walk).
    pub fn transmittance(&self, from: Vec3, to: Vec3) -> f32 {
        let line = Line::new(from, to - from);
        let met = self.walk_along(&line, [0.0, 1.0]).filter_map(|step| self.cross(&line, &step));
        (-met.map(|met| met.depth).sum::<f32>()).exp()
    }
}

impl Texel {
    /// What part of the light along an axis (0, 1, 2 for s, t, w) one copy of the texel stops at level `l`, 0 to 1: the
    /// mean over 64 × 64 rays. Nothing, where there is no such level or axis.
    pub fn opacity(&self, l: u32, axis: usize) -> f32 {
        const SIDE: usize = 64;
        let (Some(level), 0..3) = (self.levels().get(l as usize), axis) else { return 0.0 };
        let size = level.resolution() as f32;
        let mut along = Vec3::ZERO;
        along[axis] = size;
        let ray = |i: usize| {
            let mut from = Vec3::ZERO;
            // Not along the middles of cells, where a sheet between two of them would be missed.
            from[(axis + 1) % 3] = size * ((i % SIDE) as f32 + 0.37) / SIDE as f32;
            from[(axis + 2) % 3] = size * ((i / SIDE) as f32 + 0.37) / SIDE as f32;
            1.0 - level.transmittance(from, from + along)
        };
        (0..SIDE * SIDE).map(ray).sum::<f32>() / (SIDE * SIDE) as f32
    }
}
