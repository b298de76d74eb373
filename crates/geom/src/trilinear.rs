//! The trilinear map of a box, T: `[0,1]³` → scene, and its Jacobian. [seed §4.3]

use glam::{DMat3, DVec3, Mat3, Vec3};

macro_rules! trilinear {
    ($name:ident, $scalar:ty, $vec:ty, $mat:ty, $precision:literal) => {
        #[doc = concat!("A box bent by trilinear interpolation of its eight corners, in ", $precision, " precision.")]
        ///
        /// Corner `i` has `u = i & 1`, `v = i >> 1 & 1`, `w = i >> 2 & 1`. Coordinates outside `[0,1]` extrapolate.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            /// The corners A … H, in scene units.
            pub corners: [$vec; 8],
        }

        impl $name {
            /// A box that stands on the base `[A, B, C, D]` and reaches the top `[E, F, G, H]` (corner order,
            /// not around the quad).
            pub fn new(base: [$vec; 4], top: [$vec; 4]) -> Self {
                let ([a, b, c, d], [e, f, g, h]) = (base, top);
                Self { corners: [a, b, c, d, e, f, g, h] }
            }

            /// The unit cube, mapped onto itself.
            pub fn identity() -> Self {
                let bit = |i: usize, k: usize| (i >> k & 1) as $scalar;
                Self { corners: core::array::from_fn(|i| <$vec>::new(bit(i, 0), bit(i, 1), bit(i, 2))) }
            }

            /// T(u): where the point `u` of the box lies in the scene.
            #[inline]
            pub fn point(&self, u: $vec) -> $vec {
                let c = &self.corners;
                let base = c[0].lerp(c[1], u.x).lerp(c[2].lerp(c[3], u.x), u.y);
                let top = c[4].lerp(c[5], u.x).lerp(c[6].lerp(c[7], u.x), u.y);
                base.lerp(top, u.z)
            }

            /// J(u): columns ∂T/∂u, ∂T/∂v, ∂T/∂w, in scene units per box unit.
            #[inline]
            pub fn jacobian(&self, u: $vec) -> $mat {
                let [a, b, c, d, e, f, g, h] = self.corners;
                // Differences before interpolation: what cancels, cancels exactly.
                <$mat>::from_cols(
                    (b - a).lerp(d - c, u.y).lerp((f - e).lerp(h - g, u.y), u.z),
                    (c - a).lerp(d - b, u.x).lerp((g - e).lerp(h - f, u.x), u.z),
                    (e - a).lerp(f - b, u.x).lerp((g - c).lerp(h - d, u.x), u.y),
                )
            }

            /// det J(u): scene volume per box volume; positive everywhere in a box that is not folded.
            #[inline]
            pub fn determinant(&self, u: $vec) -> $scalar {
                self.jacobian(u).determinant()
            }

            /// The smallest and largest coordinates of the corners, which bound the box for `u` in `[0,1]³`.
            pub fn bounds(&self) -> [$vec; 2] {
                let first = self.corners[0];
                self.corners.iter().fold([first; 2], |[lo, hi], &p| [lo.min(p), hi.max(p)])
            }

            /// Lengths of the three axes at the centre, in scene units: the sides of the box.
            pub fn sides(&self) -> $vec {
                let j = self.jacobian(<$vec>::splat(0.5));
                <$vec>::new(j.x_axis.length(), j.y_axis.length(), j.z_axis.length())
            }
        }
    };
}

trilinear!(Trilinear, f32, Vec3, Mat3, "single");
trilinear!(DTrilinear, f64, DVec3, DMat3, "double");

impl From<Trilinear> for DTrilinear {
    /// Exact: every `f32` is an `f64`.
    fn from(map: Trilinear) -> Self {
        Self { corners: map.corners.map(|c| c.as_dvec3()) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn boxes() -> impl Strategy<Value = DTrilinear> {
        proptest::array::uniform8(proptest::array::uniform3(-4.0_f64..4.0))
            .prop_map(|corners| DTrilinear { corners: corners.map(DVec3::from_array) })
    }

    fn coordinates() -> impl Strategy<Value = DVec3> {
        proptest::array::uniform3(0.0_f64..=1.0).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn the_jacobian_is_the_derivative(map in boxes(), u in coordinates()) {
            let j = map.jacobian(u);
            let h = 1e-3;
            for (axis, column) in [(DVec3::X, j.x_axis), (DVec3::Y, j.y_axis), (DVec3::Z, j.z_axis)] {
                // The map is linear along each axis: the central difference is exact.
                let difference = (map.point(u + h * axis) - map.point(u - h * axis)) / (2.0 * h);
                prop_assert!(difference.distance(column) < 1e-10);
            }
        }

        #[test]
        fn points_stay_within_the_bounds(map in boxes(), u in coordinates()) {
            let ([lo, hi], p) = (map.bounds(), map.point(u));
            prop_assert!((p - p.clamp(lo, hi)).abs().max_element() < 1e-14);
        }

        #[test]
        fn it_is_the_paper_s_formula(map in boxes(), p in coordinates()) {
            let [a, b, c, d, e, f, g, h] = map.corners;
            let [u, v, w] = p.to_array();
            let base = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * c + u * d);
            let top = (1.0 - v) * ((1.0 - u) * e + u * f) + v * ((1.0 - u) * g + u * h);
            prop_assert!(map.point(p).distance((1.0 - w) * base + w * top) < 1e-13);
        }
    }

    #[test]
    fn corners_are_exact() {
        let map = Trilinear { corners: core::array::from_fn(|i| Vec3::new(0.1, 0.7, 1.3) * i as f32 + 1e3) };
        for (i, &corner) in map.corners.iter().enumerate() {
            assert_eq!(map.point(Trilinear::identity().corners[i]), corner);
        }
    }

    #[test]
    fn a_stretched_cube() {
        let mut map = Trilinear::identity();
        for c in &mut map.corners {
            *c *= Vec3::new(2.0, 3.0, 4.0);
        }
        assert_eq!(map.sides(), Vec3::new(2.0, 3.0, 4.0));
        assert_eq!(map.determinant(Vec3::splat(0.2)), 24.0);
        assert_eq!(map.bounds(), [Vec3::ZERO, Vec3::new(2.0, 3.0, 4.0)]);
    }
}
