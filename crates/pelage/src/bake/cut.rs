//! Painted triangles to triangles of one colour each, without what alpha takes away.
//!
//! A triangle is halved across its longest edge as long as its colour or its alpha varies in it, down to about a voxel
//! of the finest level. There
//!
//! - its colour is the texture's, averaged over it;
//! - of a mask it is cut along the line where alpha passes the cutoff, taken as linear over a piece of at most half a
//!   voxel;
//! - of a blend it shrinks, about any point of it, to the part alpha of its area: a screen of holes smaller than voxels, so
//!   that a voxel of any level is covered as much as alpha says. A screen as regular as voxels are would beat with them.

use glam::Vec3;
use pelage_geom::AlphaMode;
use pelage_texel::Geometry;

use super::paint::{Corner, Paint};

/// How finely triangles are cut, in texel edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fineness {
    voxel: f32,
}

impl Fineness {
    /// Longest edges of a piece of one colour, in voxels: two of them fill a voxel's square.
    const COLOR: f32 = core::f32::consts::SQRT_2;
    /// The same where a mask cuts.
    const MASK: f32 = 0.5;
    /// The same where holes stand for transparency.
    const BLEND: f32 = 1.0;

    /// For a texel of so many voxels a side.
    pub(super) fn new(resolution: u32) -> Self {
        Self { voxel: 1.0 / resolution as f32 }
    }
}

/// Where the texel ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl Extent {
    /// The unit cube; of what repeats, the slab between its floor and its top, as far as copies wrap.
    pub(super) fn new(tile: bool) -> Self {
        let far = Geometry::REACH;
        if tile {
            Self { low: Vec3::new(-far, -far, 0.0), high: Vec3::new(far, far, 1.0) }
        } else {
            Self { low: Vec3::ZERO, high: Vec3::ONE }
        }
    }

    /// Whether a triangle lies outside, as far as its bounds tell.
    pub(super) fn misses(&self, [a, b, c]: [Vec3; 3]) -> bool {
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
        low.cmpgt(self.high).any() || high.cmplt(self.low).any()
    }
}

/// What is left of the triangles, and what was not.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    pub(super) triangles: Vec<[Vec3; 3]>,
    pub(super) colors: Vec<Vec3>,
    /// In squares of the texel's edge.
    pub(super) area: f64,
    /// Whether alpha took anything away.
    pub(super) cut: bool,
}

impl Pieces {
    /// Adds a triangle of one colour, unless it has no area.
    pub(super) fn push(&mut self, [a, b, c]: [Vec3; 3], color: Vec3) {
        let area = 0.5 * (b - a).cross(c - a).length();
        if area > 0.0 {
            self.triangles.push([a, b, c]);
            self.colors.push(color);
            self.area += f64::from(area);
        }
    }

    fn polygon(&mut self, corners: &[Vec3], color: Vec3) {
        for pair in corners.get(1..).unwrap_or(&[]).windows(2) {
            self.push([corners[0], pair[0], pair[1]], color);
        }
    }
}

/// What of a triangle is there.
#[derive(Clone, Copy, PartialEq)]
enum Presence {
    All,
    Nothing,
    Some,
}

/// Cuts `triangle`; stops adding above `most` triangles.
pub(super) fn cut(
    triangle: &[Corner; 3],
    paint: &Paint,
    extent: Extent,
    fineness: Fineness,
    most: usize,
    pieces: &mut Pieces,
) {
    // Halving the longest edge again and again ends below a voxel after some 2 log₂(64·512) steps.
    let mut pending = vec![*triangle];
    while let Some(triangle) = pending.pop() {
        let positions = triangle.map(|corner| corner.position);
        if extent.misses(positions) || pieces.triangles.len() > most {
            continue;
        }
        let presence = presence(&triangle, paint);
        if presence == Presence::Nothing {
            pieces.cut = true;
            continue;
        }
        let [a, b, c] = triangle;
        let edges = [(b, c), (c, a), (a, b)].map(|(p, q)| p.position.distance(q.position));
        let longest = edges[0].max(edges[1]).max(edges[2]);
        let enough = match paint.mode() {
            _ if presence == Presence::All => Fineness::COLOR,
            AlphaMode::Mask(_) => Fineness::MASK,
            _ => Fineness::BLEND,
        };
        let is_even = presence == Presence::All && has_one_color(&triangle, paint);
        // A corner far outside could not be placed within a voxel.
        let far = positions.iter().any(|p| p.abs().max_element() > Geometry::REACH);
        if !far && (is_even || longest <= enough * fineness.voxel) {
            finish(&triangle, presence, paint, pieces);
            continue;
        }
        let apex = (0..3).find(|&i| edges[i] == longest).unwrap_or(0);
        let [a, b, c] = [triangle[apex], triangle[(apex + 1) % 3], triangle[(apex + 2) % 3]];
        let middle = b.middle(&c);
        pending.extend([[a, middle, c], [a, b, middle]]);
    }
}

fn presence(triangle: &[Corner; 3], paint: &Paint) -> Presence {
    let threshold = match paint.mode() {
        AlphaMode::Opaque => return Presence::All,
        AlphaMode::Mask(cutoff) => [cutoff; 2],
        // Half a step of 255 is nothing, or all.
        AlphaMode::Blend => [0.5 / 255.0, 254.5 / 255.0],
    };
    let [low, high] = paint.alpha_range(triangle);
    if low >= threshold[1] {
        Presence::All
    } else if high < threshold[0] {
        Presence::Nothing
    } else {
        Presence::Some
    }
}

/// Whether the colour varies by no more than eight steps of 255 on a screen whose gamma is 2.
fn has_one_color(triangle: &[Corner; 3], paint: &Paint) -> bool {
    const STEPS: f32 = 8.0 / 255.0;
    let [low, high] = paint.color_range(triangle).map(|color| color.map(f32::sqrt));
    (high - low).max_element() <= STEPS
}

/// Adds a triangle that is cut no further.
fn finish(triangle: &[Corner; 3], presence: Presence, paint: &Paint, pieces: &mut Pieces) {
    let [a, b, c] = *triangle;
    let middle = Corner::centroid(triangle);
    // The side of a square of the triangle's area, on the texture.
    let footprint = (0.5 * (b.uv - a.uv).perp_dot(c.uv - a.uv).abs()).sqrt();
    let color = paint.color(&middle, footprint);
    let positions = triangle.map(|corner| corner.position);
    match (presence, paint.mode()) {
        (Presence::Nothing, _) => {}
        (Presence::All, _) | (_, AlphaMode::Opaque) => pieces.push(positions, color),
        (Presence::Some, AlphaMode::Mask(cutoff)) => {
            let above = triangle.map(|corner| paint.alpha(&corner, 0.5 * footprint) - cutoff);
            pieces.cut |= above.iter().any(|&above| above < 0.0);
            let mut kept = Vec::with_capacity(4);
            for i in 0..3 {
                let j = (i + 1) % 3;
                if above[i] >= 0.0 {
                    kept.push(positions[i]);
                }
                if (above[i] >= 0.0) != (above[j] >= 0.0) {
                    kept.push(positions[i].lerp(positions[j], above[i] / (above[i] - above[j])));
                }
            }
            pieces.polygon(&kept, color);
        }
        (Presence::Some, AlphaMode::Blend) => {
            pieces.cut = true;
            let part = paint.alpha(&middle, footprint).clamp(0.0, 1.0);
            let about = any_point(positions);
            pieces.push(positions.map(|p| about + part.sqrt() * (p - about)), color);
        }
    }
}

/// A point of a triangle that looks as if it were drawn by lot, the same every time.
fn any_point([a, b, c]: [Vec3; 3]) -> Vec3 {
    // The finaliser of MurmurHash3 over the bits of the corners.
    let mut state = 0_u32;
    for x in [a, b, c].iter().flat_map(Vec3::to_array) {
        state = (state ^ x.to_bits()).wrapping_mul(0x85eb_ca6b);
        state = (state ^ state >> 13).wrapping_mul(0xc2b2_ae35);
        state ^= state >> 16;
    }
    let [u, v] = [state & 0xffff, state >> 16].map(|bits| (bits as f32 + 0.5) / 65536.0);
    let root = u.sqrt();
    a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
}
