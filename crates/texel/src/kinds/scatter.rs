//! Where things stand on the tile.

use glam::Vec2;

use crate::random::Random;

/// The `i`-th of `count` points scattered evenly over the periodic tile: the R₂ sequence [Roberts18], jittered
/// within the distance between neighbours.
pub(super) fn scattered(i: u32, count: u32, random: &mut Random) -> Vec2 {
    // 1/ρ and 1/ρ² with ρ³ = ρ + 1.
    let [x, y] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|a| (0.5 + f64::from(i) * a).fract());
    let jitter = Vec2::new(random.signed(), random.signed()) * 0.4 / (count.max(1) as f32).sqrt();
    let p = Vec2::new(x as f32, y as f32) + jitter;
    (p - p.floor()).min(Vec2::splat(1.0 - f32::EPSILON))
}
