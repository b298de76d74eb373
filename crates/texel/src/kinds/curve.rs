//! Curves that stems and twigs follow.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::tube::tangent;

/// A unit vector `inclination` radians off the upright, at an azimuth.
pub(super) fn heading(azimuth: f32, inclination: f32) -> Vec3 {
    let (sine, cosine) = inclination.sin_cos();
    (Vec2::from_angle(azimuth) * sine).extend(cosine)
}

/// The unit vector across `axis` on the side of `towards`; any one across where that is along the axis.
fn across(axis: Vec3, towards: Vec3) -> Vec3 {
    /// Radians: what is left of unit vectors that are nearer to each other is mostly rounding.
    const PARALLEL: f32 = 1e-3;
    let side = towards - axis * axis.dot(towards);
    if side.length() > PARALLEL { side.normalize() } else { axis.any_orthonormal_vector() }
}

/// The unit vector that is `angle` radians off `from`, on the side of `towards`.
pub(super) fn turned(from: Vec3, towards: Vec3, angle: f32) -> Vec3 {
    let side = across(from, towards);
    let (sine, cosine) = angle.sin_cos();
    from * cosine + side * sine
}

/// An arc: it starts along `along` and turns by `bend` radians on its way towards `towards`.
pub(super) fn arc(
    start: Vec3,
    along: Vec3,
    towards: Vec3,
    bend: f32,
    length: f32,
    segments: u32,
) -> Vec<Vec3> {
    let mut point = start;
    let mut points = vec![point];
    for k in 0..segments {
        let middle = (k as f32 + 0.5) / segments as f32;
        point += turned(along, towards, bend * middle) * (length / segments as f32);
        points.push(point);
    }
    points
}

/// The point at a fraction of a curve, and its direction there, a unit vector.
pub(super) fn at(points: &[Vec3], fraction: f32) -> (Vec3, Vec3) {
    let last = points.len().saturating_sub(1);
    let place = fraction.clamp(0.0, 1.0) * last as f32;
    let k = (place as usize).min(last.saturating_sub(1));
    let part = place - k as f32;
    let next = (k + 1).min(last);
    let along = tangent(points, k).lerp(tangent(points, next), part).normalize_or(Vec3::Z);
    (points[k].lerp(points[next], part), along)
}

/// The unit vector across `axis` at an angle around it, counted from the one that is turned most upwards.
pub(super) fn around(axis: Vec3, angle: f32) -> Vec3 {
    let up = across(axis, Vec3::Z);
    let turn = Vec2::from_angle(angle);
    up * turn.x + axis.cross(up) * turn.y
}

/// The angle from one leaf to the next around a stem: the golden one.
pub(super) const GOLDEN: f32 = 0.381_966 * TAU;
