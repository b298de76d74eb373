//! Where things stand on the tile.

use glam::Vec2;
use pelage_geom::evenly;

use crate::random::Random;

/// How far strands and plants are moved off their places: enough that no lattice is seen.
pub(super) const LOOSELY: f32 = 0.4;

/// The `i`-th of `count` points scattered evenly over the periodic tile: the R₂ sequence [Roberts18], each moved off its
/// place by up to `jitter` times the distance between neighbours, along s and along t.
pub(super) fn scattered(i: u32, count: u32, jitter: f32, random: &mut Random) -> Vec2 {
    let jitter = Vec2::new(random.signed(), random.signed()) * jitter / (count.max(1) as f32).sqrt();
    let p = evenly(i as usize).as_vec2() + jitter;
    (p - p.floor()).min(Vec2::splat(1.0 - f32::EPSILON))
}
