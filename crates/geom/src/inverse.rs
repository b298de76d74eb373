//! From the scene back into a box: the inverse of the trilinear map, by safe Newton iteration. [seed §5.1]
//!
//! The paper iterates U ← U + J⁻¹(X − T(U)) from the centre until it converges. Here the step is halved while it
//! would make the residual grow, the iterations are bounded, and what went wrong is said. [`crate::paper`] keeps
//! the paper's own form.

use glam::{DVec3, Vec3};

use crate::{DTrilinear, Trilinear};

/// Why a point has no coordinates in a box. Coordinates are those of the last iterate.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InverseError {
    /// The point lies beside the box, at these coordinates of its extrapolation.
    #[error("the point lies outside the box, at {coordinates}")]
    Outside {
        /// Box coordinates, at least one of them outside `[0,1]`.
        coordinates: DVec3,
    },
    /// The Jacobian has no inverse where the iteration came to.
    #[error("the box is singular at {coordinates}")]
    Singular {
        /// Box coordinates.
        coordinates: DVec3,
    },
    /// The iteration came to a stop, or to its bound, before it reached the point.
    #[error("the inverse did not converge: {residual} scene units remain at {coordinates}")]
    NotConverged {
        /// Box coordinates.
        coordinates: DVec3,
        /// The distance that remains, in scene units.
        residual: f64,
    },
}

/// Bound on the Newton steps. Convergence is quadratic; four to six are usual, damped starts need some more.
const STEPS: usize = 32;
/// Bound on halving one step: at 2⁻¹⁰ of it the residual will not shrink any more.
const HALVINGS: usize = 10;

macro_rules! inverse {
    ($name:ident, $scalar:ty, $vec:ty, $wide:ident) => {
        impl $name {
            /// The coordinates in `[0,1]³` of the scene point `x`, found from the centre of the box; where that
            /// fails, and `x` is within the corners' bounds, from the centres of its octants.
            ///
            /// `tolerance` is the distance by which T(u) may miss `x`, relative to the diagonal of the box's bounds
            /// (or the rounding of the corners, where that is more);
            /// coordinates outside `[0,1]` by no more than `tolerance` are inside, and are clamped.
            ///
            /// # Errors
            /// See [`InverseError`]. In a box that is folded a point may be missed although it has coordinates.
            pub fn inverse(&self, x: $vec, tolerance: $scalar) -> Result<$vec, InverseError> {
                let found = self.inverse_from(x, <$vec>::splat(0.5), tolerance);
                let [lo, hi] = self.bounds();
                if found.is_ok() || x.clamp(lo, hi) != x {
                    return found;
                }
                // Outside a strongly bent box its extrapolation folds, and Newton may slip into the fold.
                let octants = Self::identity().corners.map(|corner| 0.25 + 0.5 * corner);
                octants
                    .iter()
                    .find_map(|&start| self.inverse_from(x, start, tolerance).ok())
                    .map_or(found, Ok)
            }

            /// The same as [`Self::inverse`], found from the coordinates `start`.
            ///
            /// # Errors
            /// See [`InverseError`].
            pub fn inverse_from(
                &self,
                x: $vec,
                start: $vec,
                tolerance: $scalar,
            ) -> Result<$vec, InverseError> {
                let u = self.inverse_extended(x, start, tolerance)?;
                let inside = u.clamp(<$vec>::ZERO, <$vec>::ONE);
                if (u - inside).abs().max_element() <= tolerance {
                    Ok(inside)
                } else {
                    Err(InverseError::Outside { coordinates: $wide(u) })
                }
            }

            /// Coordinates of `x` in the extrapolated box, wherever they are; found from `start`, with the
            /// `tolerance` of [`Self::inverse`]. Beyond the box the map folds, and another point may come back.
            ///
            /// # Errors
            /// [`InverseError::Singular`] or [`InverseError::NotConverged`].
            pub fn inverse_extended(
                &self,
                x: $vec,
                start: $vec,
                tolerance: $scalar,
            ) -> Result<$vec, InverseError> {
                let [lo, hi] = self.bounds();
                // A box far from the origin holds its own points no better than its coordinates.
                let rounding = 4.0 * <$scalar>::EPSILON * lo.abs().max(hi.abs()).max_element();
                let near = rounding.max(tolerance * (hi - lo).length());
                let mut u = start;
                let mut missing = x - self.point(u);
                let mut distance = missing.length();
                for _ in 0..STEPS {
                    let step =
                        self.solve(u, missing).ok_or(InverseError::Singular { coordinates: $wide(u) })?;
                    // Within tolerance one more step costs what the check of it would, and squares the error.
                    if distance <= near {
                        return Ok(u + step);
                    }
                    let mut fraction: $scalar = 1.0;
                    let mut halvings = 0;
                    loop {
                        let next = u + fraction * step;
                        let next_missing = x - self.point(next);
                        let next_distance = next_missing.length();
                        if next_distance < distance {
                            (u, missing, distance) = (next, next_missing, next_distance);
                            break;
                        }
                        if halvings == HALVINGS {
                            return Err(InverseError::NotConverged {
                                coordinates: $wide(u),
                                residual: distance.into(),
                            });
                        }
                        halvings += 1;
                        fraction *= 0.5;
                    }
                }
                Err(InverseError::NotConverged { coordinates: $wide(u), residual: distance.into() })
            }

            /// J(u)⁻¹ d by Cramer's rule, or `None` where that is not finite.
            #[inline]
            fn solve(&self, u: $vec, d: $vec) -> Option<$vec> {
                let j = self.jacobian(u);
                let (a, b, c) = (j.x_axis, j.y_axis, j.z_axis);
                let bc = b.cross(c);
                let scaled = <$vec>::new(d.dot(bc), d.dot(c.cross(a)), d.dot(a.cross(b)));
                let step = scaled / a.dot(bc);
                step.is_finite().then_some(step)
            }
        }
    };
}

fn widen(u: Vec3) -> DVec3 {
    u.as_dvec3()
}

fn same(u: DVec3) -> DVec3 {
    u
}

inverse!(Trilinear, f32, Vec3, widen);
inverse!(DTrilinear, f64, DVec3, same);
