//! Blades: flat things with an outline, bent along and folded across. Grass and every leaf that has a shape.

use glam::Vec3;

use crate::Geometry;

/// Where a blade stands and how it is shaped. Lengths are in texel edges, angles in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blade {
    /// Where it begins.
    pub(super) base: Vec3,
    /// Where it goes at its base; a unit vector.
    pub(super) along: Vec3,
    /// Which way its upper side faces at its base; a unit vector across `along`.
    pub(super) normal: Vec3,
    /// Along it.
    pub(super) length: f32,
    /// How far its tip is bent over, away from `normal`: an arc.
    pub(super) droop: f32,
    /// How far each half is raised towards `normal`; 0 for a flat blade.
    pub(super) fold: f32,
    /// Straight pieces along it.
    pub(super) segments: u32,
}

impl Blade {
    /// Triangles of a blade that is wide at its base and, if it is not `pointed`, at its tip.
    pub(super) fn triangles(segments: u32, folded: bool, pointed_base: bool, pointed_tip: bool) -> u32 {
        let halves = if folded { 2 } else { 1 };
        halves * (2 * segments - u32::from(pointed_base) - u32::from(pointed_tip))
    }

    /// Adds it: `half_width` in texel edges and `color` at a fraction of its length.
    pub(super) fn grow(
        &self,
        geometry: &mut Geometry,
        half_width: impl Fn(f32) -> f32,
        color: impl Fn(f32) -> Vec3,
    ) {
        let across = self.along.cross(self.normal);
        let step = self.length / self.segments as f32;
        let turned = |x: f32| {
            let (sine, cosine) = (self.droop * x).sin_cos();
            [self.along * cosine - self.normal * sine, self.normal * cosine + self.along * sine]
        };
        let (sine, cosine) = self.fold.sin_cos();
        // Left edge, midrib, right edge.
        let row = |spine: Vec3, x: f32| {
            let [_, normal] = turned(x);
            let raised = normal * sine;
            let w = half_width(x);
            [spine + (raised - across * cosine) * w, spine, spine + (raised + across * cosine) * w]
        };
        let mut spine = self.base;
        let mut below = row(spine, 0.0);
        for k in 0..self.segments {
            let [middle, to] = [0.5, 1.0].map(|part| (k as f32 + part) / self.segments as f32);
            // An arc: the angle grows evenly along it.
            spine += turned(middle)[0] * step;
            let above = row(spine, to);
            let color = color(middle).clamp(Vec3::ZERO, Vec3::ONE);
            let columns: &[[usize; 2]] = if self.fold == 0.0 { &[[0, 2]] } else { &[[0, 1], [1, 2]] };
            for &[left, right] in columns {
                let [a, b, c, d] = [below[left], below[right], above[right], above[left]];
                if a != b {
                    geometry.push([a, b, c], color);
                }
                if c != d {
                    geometry.push([a, c, d], color);
                }
            }
            below = above;
        }
    }
}
