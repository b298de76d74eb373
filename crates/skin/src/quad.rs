//! The shape of a quad: whether it is convex, how far from planar, and along which diagonal it is best cut.
//!
//! Corners follow each other around the quad.

use glam::DVec3;

/// Corners whose sine is below this have no angle: the map of a box would be all but singular there.
const SMALLEST_SINE: f64 = 1e-3;

/// Whether a corner turns the wrong way, or hardly at all.
pub(crate) fn is_concave(p: [DVec3; 4]) -> bool {
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    (0..4).any(|i| {
        let (before, after) = (p[i] - p[(i + 3) % 4], p[(i + 1) % 4] - p[i]);
        before.cross(after).dot(normal) <= SMALLEST_SINE * before.length() * after.length()
    })
}

/// Distance between the diagonals over the square root of the area: 0 for a planar quad.
pub(crate) fn nonplanarity(p: [DVec3; 4]) -> f64 {
    let area = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]);
    (p[1] - p[0]).dot(area).abs() / area.length().powf(1.5)
}

/// The corners of the two triangles that the quad is cut into: along its shorter diagonal (the first of two equal
/// ones), unless that would leave a triangle without area or facing the other way.
pub(crate) fn halves(p: [DVec3; 4]) -> [[usize; 3]; 2] {
    const FIRST: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    const SECOND: [[usize; 3]; 2] = [[1, 2, 3], [1, 3, 0]];
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let area = |[i, j, k]: [usize; 3]| (p[j] - p[i]).cross(p[k] - p[i]).dot(normal);
    let smaller = |[a, b]: [[usize; 3]; 2]| area(a).min(area(b));
    let (first, second) = (smaller(FIRST), smaller(SECOND));
    let least = SMALLEST_SINE * (area(FIRST[0]) + area(FIRST[1]));
    let first_is_better = if first > least && second > least {
        (p[2] - p[0]).length_squared() <= (p[3] - p[1]).length_squared()
    } else {
        first >= second
    };
    if first_is_better { FIRST } else { SECOND }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(z: f64, p: [(f64, f64); 4]) -> [DVec3; 4] {
        let mut corners = p.map(|(x, y)| DVec3::new(x, y, 0.0));
        corners[0].z = z;
        corners
    }

    #[test]
    fn a_corner_that_points_inwards_is_cut_through() {
        let arrow = quad(0.0, [(0.0, 0.0), (1.0, 0.0), (0.2, 0.2), (0.0, 1.0)]);
        assert!(is_concave(arrow));
        // From the concave corner 2 to corner 0, though it would be shorter only by chance.
        assert_eq!(halves(arrow), [[0, 1, 2], [0, 2, 3]]);
        let turned = [arrow[1], arrow[2], arrow[3], arrow[0]];
        assert_eq!(halves(turned), [[1, 2, 3], [1, 3, 0]]);
    }

    #[test]
    fn a_flat_corner_is_cut_through_whatever_the_lengths() {
        // Corner 1 lies in the middle of a side: the cut from 0 to 2 would leave a triangle without area.
        let flat = quad(0.0, [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.5, 5.0)]);
        assert!(is_concave(flat));
        assert_eq!(halves(flat), [[1, 2, 3], [1, 3, 0]]);
    }

    #[test]
    fn a_convex_quad_is_cut_along_its_shorter_diagonal() {
        let kite = quad(0.0, [(0.0, 0.0), (3.0, -1.0), (4.0, 0.0), (3.0, 1.0)]);
        assert!(!is_concave(kite));
        assert_eq!(halves(kite), [[1, 2, 3], [1, 3, 0]]);
    }

    #[test]
    fn nonplanarity_is_relative() {
        // The unit square with a corner raised by z: the diagonals pass each other at z / √(4 + 2z²) · … exactly
        // |(p1 − p0) · n| with n ∝ (z, z, 2) / 2 (twice the area vector's half): z / √(1 + z²/2) · ½.
        let square = |z: f64| quad(z, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert_eq!(nonplanarity(square(0.0)), 0.0);
        let z = 0.4f64;
        let area = (1.0 + 0.5 * z * z).sqrt();
        assert!((nonplanarity(square(z)) - 0.5 * z / area / area.sqrt()).abs() < 1e-12);
        let big = square(z).map(|p| 100.0 * p);
        assert!((nonplanarity(big) - nonplanarity(square(z))).abs() < 1e-12);
    }
}
