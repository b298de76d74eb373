//! How much of a plane is covered, exactly: the area of its pieces, where they do not lie over each other.
//!
//! Leaves, blades and other sheets are most of what voxels hold, and a ray grid knows a fraction no better than to one
//! of its rays; of a screen of small pieces as regular as voxels are, every voxel would be wrong alike.

use glam::Vec2;

use crate::grid::Frame;
use crate::region::{Parts, Region};
use crate::voxelise::Polygon;

/// A piece on the plane.
struct Piece {
    corners: core::ops::Range<usize>,
    low: Vec2,
    high: Vec2,
}

/// The part of a planar region that its pieces cover, and their area as a part of a voxel's side; `None` where two of
/// them may overlap, or where there are too many to find out.
pub(crate) fn cover(region: &Region, parts: &Parts) -> Option<(f32, f32)> {
    // Sorted along x, each is held against the few at the same x: some milliseconds for as many as this.
    const MOST: usize = 4096;
    let frame = Frame::new(region.normal);
    let mut corners: Vec<Vec2> = Vec::new();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut area = 0.0;
    for (_, doubled, vertices) in parts.pieces() {
        if pieces.len() == MOST {
            return None;
        }
        let first = corners.len();
        corners.extend(vertices.iter().map(|&v| frame.project(v)));
        let own = &corners[first..];
        pieces.push(Piece {
            low: own.iter().fold(Vec2::INFINITY, |low, &p| low.min(p)),
            high: own.iter().fold(Vec2::NEG_INFINITY, |high, &p| high.max(p)),
            corners: first..corners.len(),
        });
        area += 0.5 * region.normal.dot(doubled).abs();
    }
    pieces.sort_unstable_by(|a, b| a.low.x.total_cmp(&b.low.x));
    let mut beside: Vec<&Piece> = Vec::new();
    for piece in &pieces {
        beside.retain(|other| other.high.x > piece.low.x);
        for other in &beside {
            let apart = piece.low.y >= other.high.y || piece.high.y <= other.low.y;
            let [a, b] = [piece, other].map(|piece| &corners[piece.corners.clone()]);
            if !apart && !is_beside(a, b) && !is_beside(b, a) {
                return None;
            }
        }
        beside.push(piece);
    }
    let whole = section(region);
    (whole > 0.0).then(|| ((area / whole).min(1.0), area))
}

/// Whether all of `other` lies beyond one edge of a convex piece.
fn is_beside(piece: &[Vec2], other: &[Vec2]) -> bool {
    /// Neighbours share an edge, to rounding: in voxel edges.
    const SEAM: f32 = 1e-4;
    let edges = (0..piece.len()).map(|i| (piece[i], piece[(i + 1) % piece.len()]));
    let turn = edges.clone().map(|(a, b)| a.perp_dot(b)).sum::<f32>().signum();
    edges.filter(|(a, b)| a != b).any(|(a, b)| {
        let edge = (b - a) * turn;
        let limit = SEAM * edge.length();
        other.iter().all(|&p| edge.perp_dot(p - a) <= limit)
    })
}

/// The area of the plane in the middle of a region's slab, inside its box.
fn section(region: &Region) -> f32 {
    // A triangle around all that may lie in the cube.
    const REACH: f32 = 8.0;
    let [x, y] = Frame::new(region.normal).across;
    let middle = region.normal * 0.5 * (region.slab[0] + region.slab[1]);
    let corner =
        |degrees: f32| middle + REACH * (x * degrees.to_radians().cos() + y * degrees.to_radians().sin());
    let mut polygon = Polygon::new([0.0, 120.0, 240.0].map(corner));
    for axis in 0..3 {
        polygon = polygon.cut(axis, region.lo[axis], 1.0).cut(axis, region.hi[axis], -1.0);
    }
    if polygon.vertices().len() < 3 { 0.0 } else { 0.5 * polygon.doubled_area().length() }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn cover_of(triangles: &[[Vec3; 3]]) -> Option<(f32, f32)> {
        let mut parts = Parts::default();
        parts.clip(triangles);
        let region = Region::new(&parts).expect("matter");
        assert!(region.is_planar());
        cover(&region, &parts)
    }

    fn square(low: [f32; 2], high: [f32; 2], place: impl Fn(f32, f32) -> Vec3) -> [[Vec3; 3]; 2] {
        let [a, b] = [place(low[0], low[1]), place(high[0], low[1])];
        let [c, d] = [place(high[0], high[1]), place(low[0], high[1])];
        // The second turned over: sides do not matter.
        [[a, b, c], [a, d, c]]
    }

    #[test]
    fn fractions_are_areas() {
        let flat = |x, y| Vec3::new(x, y, 0.3);
        // All of the voxel, and a quarter and a corner of it in a box of two thirds.
        let whole = square([-1.0, -1.0], [2.0, 2.0], flat);
        assert_eq!(cover_of(&whole), Some((1.0, 1.0)));
        let pieces = [square([0.0, 0.0], [0.4, 0.2], flat), square([0.4, 0.2], [0.8, 0.8], flat)].concat();
        let (part, area) = cover_of(&pieces).expect("no overlap");
        // (0.08 + 0.24)/0.64; the box is rounded outwards by less than 1/255 on each side.
        assert!((area - 0.32).abs() < 1e-5 && part <= 0.5 && part > 0.5 * 0.98, "{part} {area}");
        // A tilted plane through all of the voxel: z = 0.25 + x/2.
        let tilted = square([0.0, 0.0], [1.0, 1.0], |x, y| Vec3::new(x, y, 0.25 + 0.5 * x));
        let (part, area) = cover_of(&tilted).expect("no overlap");
        assert!(part > 0.99 && (area - 1.25_f32.sqrt()).abs() < 1e-4, "{part} {area}");
    }

    #[test]
    fn what_lies_over_something_is_not_told() {
        let flat = |x, y| Vec3::new(x, y, 0.3);
        let over = [square([0.0, 0.0], [0.6, 0.6], flat), square([0.5, 0.5], [0.9, 0.9], flat)].concat();
        assert_eq!(cover_of(&over), None);
        assert_eq!(
            cover_of(&[square([0.0, 0.0], [0.6, 0.6], flat), square([0.0, 0.0], [0.6, 0.6], flat)].concat()),
            None
        );
    }
}
