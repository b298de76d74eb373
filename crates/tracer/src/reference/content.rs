//! The explicit content of a texel: its triangles, cut to one tile, or its density.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use pelage_texel::{Geometry, Texel};

use super::medium::Medium;
use super::polygon::{Polygon, doubled_area};
use crate::accel::Tree;

/// The triangles of one tile of a texel, and a tree over them.
pub(super) struct Content {
    /// In texel coordinates, within `[0, 1]³`.
    pub pieces: Vec<Piece>,
    pub tree: Tree,
    /// Whether it repeats in s and t.
    pub periodic: bool,
}

/// A triangle of the tile, or the part of one that lies in it.
pub(super) struct Piece {
    pub corners: [DVec3; 3],
    /// Linear albedo.
    pub color: Vec3,
}

impl Content {
    /// Cuts the geometry to the tile. What periodic content has outside comes in from the neighbouring copies;
    /// other content ends at the tile, as it does in its voxels.
    pub(super) fn new(geometry: &Geometry, periodic: bool) -> Self {
        let mut pieces = Vec::with_capacity(geometry.triangles.len());
        for (corners, &color) in geometry.triangles.iter().zip(&geometry.colors) {
            let corners = corners.map(|p| p.as_dvec3());
            let copies = |axis: usize| {
                let [lo, hi] =
                    [f64::min, f64::max].map(|f| f(f(corners[0][axis], corners[1][axis]), corners[2][axis]));
                // A triangle in the plane between two tiles belongs to the upper one, as a voxel's matter does.
                let last = if lo == hi { lo.floor() } else { hi.ceil() - 1.0 };
                if periodic { lo.floor() as i32..=last as i32 } else { 0..=0 }
            };
            for t in copies(1) {
                for s in copies(0) {
                    let shift = DVec2::new(f64::from(s), f64::from(t)).extend(0.0);
                    let shifted = corners.map(|p| p - shift);
                    if is_inside(&shifted) {
                        if doubled_area(&shifted) > 0.0 {
                            pieces.push(Piece { corners: shifted, color });
                        }
                        continue;
                    }
                    let mut part = Polygon::new(shifted);
                    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                        part = part.cut(axis, 0.0).cut(-axis, -1.0);
                    }
                    pieces.extend(part.fan().map(|corners| Piece { corners, color }));
                }
            }
        }
        let bounds: Vec<[Vec3; 2]> = pieces
            .iter()
            .map(|piece| {
                let [a, b, c] = piece.corners.map(|p| p.as_vec3());
                [a.min(b).min(c), a.max(b).max(c)]
            })
            .collect();
        Self { tree: Tree::new(&bounds), pieces, periodic }
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> u64 {
        (size_of_val(self.pieces.as_slice()) + self.tree.memory()) as u64
    }
}

fn is_inside(corners: &[DVec3; 3]) -> bool {
    corners.iter().all(|p| p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all())
}

/// What the boxes of a coat hold.
pub(super) enum Filling {
    Triangles(Content),
    Density(Medium),
}

impl Filling {
    /// Whether it repeats in s and t.
    pub(super) fn is_periodic(&self) -> bool {
        match self {
            Self::Triangles(content) => content.periodic,
            Self::Density(medium) => medium.periodic,
        }
    }

    /// Whether there is nothing of it.
    pub(super) fn is_empty(&self) -> bool {
        matches!(self, Self::Triangles(content) if content.tree.nodes.is_empty())
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> u64 {
        match self {
            Self::Triangles(content) => content.memory(),
            Self::Density(medium) => medium.memory(),
        }
    }
}

/// Why there is no explicit content.
#[derive(Debug)]
pub(super) enum Missing {
    /// The texel does not know what it was made from.
    Source,
    /// What it was made from is not sound.
    Unsound(String),
}

/// The triangles that a texel was made from.
pub(super) fn geometry_of(texel: &Texel) -> Result<Arc<Geometry>, Missing> {
    let geometry = texel.source().geometry().ok_or(Missing::Source)?;
    geometry.validate().map_err(|error| Missing::Unsound(error.to_string()))?;
    Ok(geometry)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(content: &Content) -> f64 {
        content.pieces.iter().map(|p| 0.5 * doubled_area(&p.corners)).sum()
    }

    #[test]
    fn periodic_content_loses_nothing_at_the_tile() {
        // A unit square in the plane w = ½, shifted by (.3, .6): its four parts come back from the neighbours.
        let mut geometry = Geometry::default();
        let at = |s: f32, t: f32| Vec3::new(0.3 + s, 0.6 + t, 0.5);
        geometry.push_quad([at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)], Vec3::ONE);
        assert!((area(&Content::new(&geometry, true)) - 1.0).abs() < 1e-6);
        // Without repetition only [.3, 1] × [.6, 1] is left: .7 · .4.
        assert!((area(&Content::new(&geometry, false)) - 0.28).abs() < 1e-6);
    }

    #[test]
    fn content_ends_below_and_above() {
        // A square of 1 × 3 from w = −1 to 2, upright at s = ½: a third of it is in the texel.
        let mut geometry = Geometry::default();
        let at = |t: f32, w: f32| Vec3::new(0.5, t, w);
        geometry.push_quad([at(0.0, -1.0), at(1.0, -1.0), at(1.0, 2.0), at(0.0, 2.0)], Vec3::ONE);
        assert!((area(&Content::new(&geometry, true)) - 1.0).abs() < 1e-6);
    }
}
