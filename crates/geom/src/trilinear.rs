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
                let c = &self.corners;
                // Differences before interpolation: what cancels, cancels exactly.
                let along = |i: usize, j: usize, k: usize, l: usize, m: usize, n: usize, p: usize, q: usize, a: $scalar, b: $scalar| {
                    (c[j] - c[i]).lerp(c[l] - c[k], a).lerp((c[n] - c[m]).lerp(c[q] - c[p], a), b)
                };
                <$mat>::from_cols(
                    along(0, 1, 2, 3, 4, 5, 6, 7, u.y, u.z),
                    along(0, 2, 1, 3, 4, 6, 5, 7, u.x, u.z),
                    along(0, 4, 1, 5, 2, 6, 3, 7, u.x, u.y),
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
