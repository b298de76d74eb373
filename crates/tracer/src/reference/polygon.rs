//! Triangles cut by planes, in `f64`.

use glam::DVec3;

/// A convex polygon: a triangle cut by at most nine planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    vertices: [DVec3; Self::MOST],
    len: usize,
}

impl Polygon {
    const MOST: usize = 12;

    pub(super) fn new(triangle: [DVec3; 3]) -> Self {
        let mut vertices = [DVec3::ZERO; Self::MOST];
        vertices[..3].copy_from_slice(&triangle);
        Self { vertices, len: 3 }
    }

    pub(super) fn vertices(&self) -> &[DVec3] {
        &self.vertices[..self.len]
    }

    /// The part where `normal · p ≥ at`.
    ///
    /// The point where an edge is cut is computed from its ends in one order, so that the two polygons at an edge,
    /// and the two sides of a plane, agree on it.
    pub(super) fn cut(&self, normal: DVec3, at: f64) -> Self {
        let mut kept = Self { vertices: [DVec3::ZERO; Self::MOST], len: 0 };
        let mut push = |vertex| {
            // A plane adds at most one vertex to a convex polygon; only rounding could make it less convex.
            if let Some(slot) = kept.vertices.get_mut(kept.len) {
                *slot = vertex;
                kept.len += 1;
            }
        };
        let v = self.vertices();
        for (i, &b) in v.iter().enumerate() {
            let a = v[if i == 0 { v.len() - 1 } else { i - 1 }];
            let [da, db] = [a, b].map(|p| normal.dot(p) - at);
            if (da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0) {
                push(if da < db { a + (b - a) * (da / (da - db)) } else { b + (a - b) * (db / (db - da)) });
            }
            if db >= 0.0 {
                push(b);
            }
        }
        kept
    }

    /// The polygon as triangles around its first vertex; none of a polygon without area.
    pub(super) fn fan(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let v = self.vertices();
        (2..v.len()).map(|i| [v[0], v[i - 1], v[i]]).filter(|t| doubled_area(t) > 0.0)
    }
}

/// Twice the area of a triangle.
pub(super) fn doubled_area([a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = DVec3> {
        proptest::array::uniform3(-2.0_f64..2.0).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn the_two_sides_of_a_plane_are_the_whole(a in corner(), b in corner(), c in corner(), at in -1.0_f64..1.0) {
            let whole = Polygon::new([a, b, c]);
            let area = |p: &Polygon| p.fan().map(|t| doubled_area(&t)).sum::<f64>();
            let (below, above) = (whole.cut(-DVec3::X, -at), whole.cut(DVec3::X, at));
            prop_assert!((area(&below) + area(&above) - area(&whole)).abs() < 1e-12);
            prop_assert!(below.vertices().iter().all(|p| p.x <= at + 1e-12));
            prop_assert!(above.vertices().iter().all(|p| p.x >= at - 1e-12));
        }
    }
}
