//! What a surface shows at a point of it: its material's colour and alpha, times their textures and the colours of
//! its vertices.

use glam::{Vec2, Vec3, Vec4};
use pelage_geom::{Alpha, AlphaMode, Material, TextureId};

use super::extremes::{Extremes, Range};

/// A point of a surface and what it wears there: all that varies linearly over a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    /// In texel space.
    pub(super) position: Vec3,
    pub(super) uv: Vec2,
    pub(super) color: Vec4,
}

impl Corner {
    /// The point in the middle between two; the same bits whichever comes first, so that neighbours stay closed.
    pub(super) fn middle(&self, other: &Self) -> Self {
        Self {
            position: 0.5 * (self.position + other.position),
            uv: 0.5 * (self.uv + other.uv),
            color: 0.5 * (self.color + other.color),
        }
    }

    /// The middle of a triangle.
    pub(super) fn centroid([a, b, c]: &[Self; 3]) -> Self {
        Self {
            position: (a.position + b.position + c.position) / 3.0,
            uv: (a.uv + b.uv + c.uv) / 3.0,
            color: (a.color + b.color + c.color) / 3.0,
        }
    }
}

/// A material, ready to be asked.
pub(super) struct Paint<'a> {
    base: Vec3,
    texture: Option<&'a Extremes<'a>>,
    alpha: Alpha,
    alpha_texture: Option<&'a Extremes<'a>>,
}

impl<'a> Paint<'a> {
    /// `texture` finds what a material refers to.
    pub(super) fn new(material: &Material, texture: impl Fn(TextureId) -> Option<&'a Extremes<'a>>) -> Self {
        Self {
            base: material.base_color,
            texture: material.base_color_texture.and_then(&texture),
            alpha: material.alpha,
            alpha_texture: material.alpha.texture.and_then(&texture),
        }
    }

    /// What its alpha means.
    pub(super) fn mode(&self) -> AlphaMode {
        self.alpha.mode
    }

    /// Linear albedo, averaged over about `footprint` (in units of uv).
    pub(super) fn color(&self, at: &Corner, footprint: f32) -> Vec3 {
        let texture = self.texture.map_or(Vec3::ONE, |map| map.texture().sample(at.uv, footprint));
        (self.base * texture * at.color.truncate()).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// Alpha, averaged likewise.
    pub(super) fn alpha(&self, at: &Corner, footprint: f32) -> f32 {
        let texture = self.alpha_texture.map_or(1.0, |map| map.texture().sample(at.uv, footprint).x);
        self.alpha.factor * texture * at.color.w
    }

    /// The smallest and largest colour anywhere in a triangle; possibly a little more, never less.
    pub(super) fn color_range(&self, triangle: &[Corner; 3]) -> Range {
        let [low, high] = within(self.texture, triangle);
        let [dark, bright] = extremes(triangle.map(|corner| corner.color));
        [self.base * low * dark.truncate(), (self.base * high * bright.truncate()).min(Vec3::ONE)]
    }

    /// The smallest and largest alpha anywhere in a triangle, likewise.
    pub(super) fn alpha_range(&self, triangle: &[Corner; 3]) -> [f32; 2] {
        let [low, high] = within(self.alpha_texture, triangle);
        let [thin, dense] = extremes(triangle.map(|corner| corner.color));
        [self.alpha.factor * low.x * thin.w, self.alpha.factor * high.x * dense.w]
    }
}

fn within(map: Option<&Extremes>, [a, b, c]: &[Corner; 3]) -> Range {
    map.map_or([Vec3::ONE; 2], |map| map.within(a.uv.min(b.uv).min(c.uv), a.uv.max(b.uv).max(c.uv)))
}

fn extremes([a, b, c]: [Vec4; 3]) -> [Vec4; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}
