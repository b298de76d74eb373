//! Where samples go: Owen-scrambled Sobol points, of their own in every pixel. [Burley20]

use glam::{DVec2, Vec2, Vec3};
use std::f32::consts::TAU;

/// The points of one pixel, for one use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points {
    seed: u32,
}

/// What points are used for: each use has points that have nothing to do with the others'.
#[derive(Clone, Copy, Debug)]
pub(super) enum Use {
    Pixel,
    Sky,
    Light(u32),
}

impl Points {
    /// Most samples that a pixel can have: the sequence has no more.
    pub(super) const MOST: u32 = 1 << 16;

    /// The points of pixel (x, y) in the set `seed`.
    pub(super) fn new([x, y]: [u32; 2], seed: u32, which: Use) -> Self {
        let which = match which {
            Use::Pixel => 0,
            Use::Sky => 1,
            Use::Light(i) => i.wrapping_add(2),
        };
        Self { seed: [x, y, seed, which].into_iter().fold(0, |hash, word| mix(hash ^ word)) }
    }

    /// The point of sample `i` (below [`Points::MOST`]) in `[0, 1)²`.
    pub(super) fn get(self, i: u32) -> Vec2 {
        let i = i.min(Self::MOST - 1);
        Vec2::new(sobol_burley::sample(i, 0, self.seed), sobol_burley::sample(i, 1, self.seed))
    }
}

/// What the free flight of one ray through densities is drawn from: of its own for each use, sample, pixel and set.
pub(super) fn flight(pixel: [u32; 2], seed: u32, which: Use, sample: u32) -> u64 {
    let points = Points::new(pixel, seed, which).seed;
    u64::from(points) << 32 | u64::from(sample)
}

/// A bijection of 32 bits in which every bit depends on all: two rounds of multiply and shift. [Wellons18]
fn mix(mut x: u32) -> u32 {
    x = x.wrapping_add(0x9e37_79b9);
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// A direction around `normal`, by the cosine to it.
pub(super) fn cosine_around(normal: Vec3, point: Vec2) -> Vec3 {
    let disk = on_disk(point);
    let (x, y) = normal.any_orthonormal_pair();
    let height = (1.0 - disk.length_squared()).max(0.0).sqrt() as f32;
    (disk.x as f32 * x + disk.y as f32 * y + height * normal).normalize_or(normal)
}

/// A direction to a point of a disk that is seen along `axis`, its radius `tangent` at distance 1; not unit length:
/// the disk is as far as `axis` is long.
pub(super) fn towards_disk(axis: Vec3, tangent: f32, point: Vec2) -> Vec3 {
    if tangent == 0.0 {
        return axis;
    }
    let disk = on_disk(point);
    let (x, y) = axis.any_orthonormal_pair();
    axis + tangent * (disk.x as f32 * x + disk.y as f32 * y)
}

/// A point of the unit disk, all parts of it alike.
fn on_disk(point: Vec2) -> DVec2 {
    let (sin, cos) = (TAU * point.y).sin_cos();
    f64::from(point.x).sqrt() * DVec2::new(f64::from(cos), f64::from(sin))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_evenly_and_differ_between_uses() {
        // 256 points of a (0, 2)-sequence: one in each of 16 × 16 squares.
        let points = |which| Points::new([3, 5], 7, which);
        let mut cells: Vec<usize> = (0..256)
            .map(|i| points(Use::Pixel).get(i))
            .map(|p| (p.x * 16.0) as usize + 16 * (p.y * 16.0) as usize)
            .collect();
        cells.sort_unstable();
        assert_eq!(cells, (0..256).collect::<Vec<_>>());
        let firsts = [Use::Pixel, Use::Sky, Use::Light(0), Use::Light(1)].map(|which| points(which).get(0));
        for (i, a) in firsts.iter().enumerate() {
            assert!(firsts[..i].iter().all(|b| a.distance(*b) > 1e-3));
        }
        assert_ne!(Points::new([5, 3], 7, Use::Pixel).get(0), points(Use::Pixel).get(0));
    }

    #[test]
    fn directions_go_by_the_cosine() {
        // The mean cosine of a cosine-weighted hemisphere is 2/3, and its mean direction lies along the normal.
        let normal = Vec3::new(0.6, -0.64, 0.48);
        let points = Points::new([0, 0], 0, Use::Sky);
        let mean = (0..4096).map(|i| cosine_around(normal, points.get(i))).sum::<Vec3>() / 4096.0;
        assert!((mean - normal * 2.0 / 3.0).length() < 2e-3, "{mean}");
    }
}
