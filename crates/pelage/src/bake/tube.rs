//! Strands to thin tubes.
//!
//! A tube has as many sides as its thickness in voxels needs, three where it is thinner than one. Its sides' girth is
//! that of the circle: seen from all around, a convex cross-section shows its girth / π in the mean (Cauchy), so that a
//! tube of any number of sides, turned any way, hides as much as a round one, 2 r a length.

use core::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::cut::{Extent, Pieces};

/// A point of a strand, in texel space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    pub(super) position: Vec3,
    /// Texel edges.
    pub(super) radius: f32,
    pub(super) color: Vec3,
}

/// Adds the tube along `knots`, closed at both ends, its sides turned by `turn` radians about it, for a finest level
/// of `resolution` voxels a side; what lies outside of `extent` is left out.
pub(super) fn tube(knots: &[Knot], turn: f32, resolution: u32, extent: Extent, pieces: &mut Pieces) {
    let knots = shaded(knots, 1.0 / resolution as f32);
    if knots.len() < 2 {
        return;
    }
    let thickest = knots.iter().fold(0.0, |most: f32, knot| knot.radius.max(most));
    let sides = match thickest * resolution as f32 {
        ..0.75 => 3,
        ..3.0 => 6,
        _ => 12,
    };
    let side = PI / sides as f32;
    let girth = side / side.sin();
    let last = knots.len() - 1;
    let tangent = |k: usize| {
        let [before, after] = [k.saturating_sub(1), (k + 1).min(last)].map(|k| knots[k].position);
        (after - before).normalize_or(Vec3::Z)
    };
    // One frame carried along the curve, so that the sides do not twist.
    let mut right = tangent(0).any_orthonormal_vector();
    let mut push = |triangle, color| {
        if !extent.misses(triangle) {
            pieces.push(triangle, color);
        }
    };
    let mut ring: Vec<Vec3> = Vec::new();
    for (k, knot) in knots.iter().enumerate() {
        let along = tangent(k);
        right = (right - along * along.dot(right)).normalize_or(along.any_orthonormal_vector());
        let up = along.cross(right);
        let corner = |i: usize| {
            let p = Vec2::from_angle(turn + TAU * i as f32 / sides as f32) * girth * knot.radius;
            knot.position + right * p.x + up * p.y
        };
        let next: Vec<Vec3> = (0..sides).map(corner).collect();
        for i in 0..ring.len() {
            let j = (i + 1) % ring.len();
            let color = 0.5 * (knots[k - 1].color + knot.color);
            push([ring[i], ring[j], next[j]], color);
            push([ring[i], next[j], next[i]], color);
        }
        if k == 0 || k == last {
            for i in 2..sides {
                push([next[0], next[i - 1], next[i]], knot.color);
            }
        }
        ring = next;
    }
}

/// The knots, with more of them between two whose colours differ; those that do not move on left out.
fn shaded(knots: &[Knot], voxel: f32) -> Vec<Knot> {
    // As large a step as between the pieces of a texture: see `cut`.
    const STEP: f32 = 8.0 / 255.0;
    let mut shaded: Vec<Knot> = Vec::with_capacity(knots.len());
    for &next in knots {
        let Some(&last) = shaded.last() else {
            shaded.push(next);
            continue;
        };
        let length = last.position.distance(next.position);
        if length == 0.0 {
            continue;
        }
        let difference = (next.color.map(f32::sqrt) - last.color.map(f32::sqrt)).abs().max_element();
        let pieces = (difference / STEP).min(length / voxel).ceil().clamp(1.0, 64.0) as u32;
        shaded.extend((1..=pieces).map(|i| {
            let at = i as f32 / pieces as f32;
            Knot {
                position: last.position.lerp(next.position, at),
                radius: last.radius + (next.radius - last.radius) * at,
                color: last.color.lerp(next.color, at),
            }
        }));
    }
    shaded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tube_has_the_area_of_a_round_one() {
        // A girth equal to the circle's makes the mantle exactly 2πrL, for any number of sides. The two ends are
        // polygons of n sides around a circle of g r, g = (π/n)/sin(π/n): n/2 · (g r)² sin(2π/n) each.
        let (radius, length) = (0.002, 0.8);
        for (resolution, sides) in [(64, 3.0), (512, 6.0), (4096, 12.0)] {
            let knot = |z: f32| Knot { position: Vec3::splat(z), radius, color: Vec3::ONE };
            let half = 0.5 * length / 3.0_f32.sqrt();
            let mut pieces = Pieces::default();
            let knots = [knot(0.5 - half), knot(0.4), knot(0.5 + half)];
            tube(&knots, 0.3, resolution, Extent::new(false), &mut pieces);
            let side: f32 = PI / sides;
            let corner = radius * side / side.sin();
            let ends = sides * corner * corner * (2.0 * side).sin();
            let round = f64::from(TAU * radius * length + ends);
            assert!((pieces.area / round - 1.0).abs() < 1e-4, "{resolution}: {} of {round}", pieces.area);
        }
    }

    #[test]
    fn colours_change_along_it() {
        let knot = |x: f32, color| Knot { position: Vec3::new(x, 0.5, 0.5), radius: 0.01, color };
        let mut pieces = Pieces::default();
        tube(&[knot(0.1, Vec3::ZERO), knot(0.9, Vec3::ONE)], 0.0, 256, Extent::new(false), &mut pieces);
        for (corners, color) in pieces.triangles.iter().zip(&pieces.colors) {
            let x = (corners[0].x + corners[1].x + corners[2].x) / 3.0;
            assert!((color.x - (x - 0.1) / 0.8).abs() < 0.05, "{x}: {color}");
        }
    }

    #[test]
    fn a_strand_that_stands_still_is_nothing() {
        let knot = Knot { position: Vec3::splat(0.5), radius: 0.1, color: Vec3::ONE };
        let mut pieces = Pieces::default();
        tube(&[knot; 3], 0.0, 64, Extent::new(false), &mut pieces);
        tube(&[], 0.0, 64, Extent::new(false), &mut pieces);
        assert!(pieces.triangles.is_empty());
    }
}
