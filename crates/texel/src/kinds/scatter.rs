//! Where things stand on the tile.

use glam::Vec2;

use crate::random::Random;

/// How far strands and plants are moved off their places: enough that no lattice is seen.
pub(super) const LOOSELY: f32 = 0.4;

/// The `i`-th of `count` points scattered evenly over the periodic tile: the R₂ sequence [Roberts18], each moved off its
/// place by up to `jitter` times the distance between neighbours, along s and along t.
pub(super) fn scattered(i: u32, count: u32, jitter: f32, random: &mut Random) -> Vec2 {
    // 1/ρ and 1/ρ² with ρ³ = ρ + 1.
    let [x, y] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|a| (0.5 + f64::from(i) * a).fract());
    let jitter = Vec2::new(random.signed(), random.signed()) * jitter / (count.max(1) as f32).sqrt();
    let p = Vec2::new(x as f32, y as f32) + jitter;
    (p - p.floor()).min(Vec2::splat(1.0 - f32::EPSILON))
}
