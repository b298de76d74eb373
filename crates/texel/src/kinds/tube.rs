//! Tubes along curves: strands, stems, needles, yarn.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::Geometry;

/// The direction of a curve at its point `k`, a unit vector; up for a curve without a length.
pub(super) fn tangent(points: &[Vec3], k: usize) -> Vec3 {
    let last = points.len().saturating_sub(1);
    (points[(k + 1).min(last)] - points[k.saturating_sub(1)]).normalize_or(Vec3::Z)
}

/// A tube along a curve, its sides turned by `turn` radians about it: `radius` and `color` at a fraction of it, 0
/// at its first point. Where the radius is 0 it ends in a point; elsewhere its ends are open.
pub(super) fn tube(
    geometry: &mut Geometry,
    points: &[Vec3],
    sides: u32,
    turn: f32,
    radius: impl Fn(f32) -> f32,
    color: impl Fn(f32) -> Vec3,
) {
    let last = points.len().saturating_sub(1);
    // One frame carried along the curve, so that the sides do not twist.
    let mut right = tangent(points, 0).any_orthonormal_vector();
    let mut ring: Vec<Vec3> = Vec::new();
    for (k, &point) in points.iter().enumerate() {
        let along = tangent(points, k);
        right = (right - along * along.dot(right)).normalize_or(along.any_orthonormal_vector());
        let up = along.cross(right);
        let r = radius(k as f32 / last as f32);
        let next: Vec<Vec3> = (0..sides)
            .map(|side| Vec2::from_angle(turn + TAU * side as f32 / sides as f32) * r)
            .map(|p| point + right * p.x + up * p.y)
            .collect();
        if k > 0 {
            let color = color((k as f32 - 0.5) / last as f32).clamp(Vec3::ZERO, Vec3::ONE);
            for side in 0..sides as usize {
                let beside = (side + 1) % sides as usize;
                let [a, b, c, d] = [ring[side], ring[beside], next[beside], next[side]];
                if a != b {
                    geometry.push([a, b, c], color);
                }
                if c != d {
                    geometry.push([a, c, d], color);
                }
            }
        }
        ring = next;
    }
}
