//! Symmetric 3×3 matrices in six numbers: quadratic forms such as optical depth and the SGGX ellipsoid.

use core::iter::Sum;
use core::ops::{Add, AddAssign, Mul, Sub};

use glam::{DMat3, DVec3, Mat3, Vec3};

/// A symmetric 3×3 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric3 {
    /// Row 0, column 0.
    pub xx: f32,
    /// Row 1, column 1.
    pub yy: f32,
    /// Row 2, column 2.
    pub zz: f32,
    /// Rows 0 and 1.
    pub xy: f32,
    /// Rows 0 and 2.
    pub xz: f32,
    /// Rows 1 and 2.
    pub yz: f32,
}

impl Symmetric3 {
    /// All zero.
    pub const ZERO: Self = Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0 };

    /// The unit matrix.
    pub const IDENTITY: Self = Self { xx: 1.0, yy: 1.0, zz: 1.0, ..Self::ZERO };

    /// The matrix with `diagonal` and zeros beside it.
    pub fn from_diagonal(diagonal: Vec3) -> Self {
        Self { xx: diagonal.x, yy: diagonal.y, zz: diagonal.z, ..Self::ZERO }
    }

    /// n nᵀ.
    #[inline]
    pub fn outer(n: Vec3) -> Self {
        Self { xx: n.x * n.x, yy: n.y * n.y, zz: n.z * n.z, xy: n.x * n.y, xz: n.x * n.z, yz: n.y * n.z }
    }

    /// The symmetric part ½(m + mᵀ) of `m`.
    #[inline]
    pub fn from_mat3(m: Mat3) -> Self {
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
        Self {
            xx: x.x,
            yy: y.y,
            zz: z.z,
            xy: 0.5 * (x.y + y.x),
            xz: 0.5 * (x.z + z.x),
            yz: 0.5 * (y.z + z.y),
        }
    }

    /// The same as a full matrix.
    #[inline]
    pub fn to_mat3(self) -> Mat3 {
        Mat3::from_cols_array(&[
            self.xx, self.xy, self.xz, self.xy, self.yy, self.yz, self.xz, self.yz, self.zz,
        ])
    }

    /// S d.
    #[inline]
    pub fn mul_vec3(self, d: Vec3) -> Vec3 {
        Vec3::new(
            self.xx * d.x + self.xy * d.y + self.xz * d.z,
            self.xy * d.x + self.yy * d.y + self.yz * d.z,
            self.xz * d.x + self.yz * d.y + self.zz * d.z,
        )
    }

    /// dᵀ S d. Rounding may leave it a little under zero where S is singular.
    #[inline]
    pub fn quadratic(self, d: Vec3) -> f32 {
        d.dot(self.mul_vec3(d))
    }

    /// mᵀ S m: the same form in the coordinates that `m` maps from.
    #[inline]
    pub fn congruence(self, m: Mat3) -> Self {
        let columns = [m.x_axis, m.y_axis, m.z_axis];
        let [x, y, z] = columns.map(|c| self.mul_vec3(c));
        Self {
            xx: columns[0].dot(x),
            yy: columns[1].dot(y),
            zz: columns[2].dot(z),
            xy: columns[0].dot(y),
            xz: columns[0].dot(z),
            yz: columns[1].dot(z),
        }
    }

    /// The sum of the diagonal, which is that of the eigenvalues.
    #[inline]
    pub fn trace(self) -> f32 {
        self.xx + self.yy + self.zz
    }

    /// Whether every entry is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz].iter().all(|x| x.is_finite())
    }

    /// Eigenvalues in descending order, and unit eigenvectors in the columns of a rotation.
    ///
    /// Cyclic Jacobi in `f64`, so that repeated and zero eigenvalues need no care; any orthonormal basis of
    /// their space may come back for repeated ones. Entries must be finite.
    pub fn eigen(self) -> (Vec3, Mat3) {
        let (values, vectors) = self.eigen_f64();
        (values.as_vec3(), vectors.as_mat3())
    }

    /// The nearest positive semi-definite matrix: negative eigenvalues become zero.
    pub fn clamped_positive(self) -> Self {
        let (values, vectors) = self.eigen_f64();
        if values.z >= 0.0 {
            return self;
        }
        let scaled = vectors * DMat3::from_diagonal(values.max(DVec3::ZERO));
        Self::from_mat3((scaled * vectors.transpose()).as_mat3())
    }

    fn eigen_f64(self) -> (DVec3, DMat3) {
        /// Jacobi converges quadratically: four or five sweeps are usual, the rest is margin.
        const SWEEPS: usize = 12;
        /// What may be left beside the diagonal, relative to it; less than `f64` resolves.
        const NEGLIGIBLE: f64 = 1e-18;
        let mut a = self.to_mat3().as_dmat3().to_cols_array_2d();
        let mut v = DMat3::IDENTITY.to_cols_array_2d();
        for _ in 0..SWEEPS {
            let beside = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
            if beside <= NEGLIGIBLE * (a[0][0].abs() + a[1][1].abs() + a[2][2].abs()) {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                // a ← Gᵀ a G and v ← v G, both held by columns.
                for m in [&mut a, &mut v] {
                    let (head, tail) = m.split_at_mut(q);
                    for (x, y) in head[p].iter_mut().zip(&mut tail[0]) {
                        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                    }
                }
                for column in &mut a {
                    let (x, y) = (column[p], column[q]);
                    (column[p], column[q]) = (c * x - s * y, s * x + c * y);
                }
                (a[p][q], a[q][p]) = (0.0, 0.0);
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
        let [x, y, z] = order.map(|i| DVec3::from_array(v[i]));
        // The third follows from the others, so that the basis is a rotation.
        let vectors = DMat3::from_cols(x, y, z * x.cross(y).dot(z).signum());
        (DVec3::from_array(order.map(|i| a[i][i])), vectors)
    }
}

impl Add for Symmetric3 {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yz: self.yz + other.yz,
        }
    }
}

impl AddAssign for Symmetric3 {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Symmetric3 {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f32> for Symmetric3 {
    type Output = Self;

    #[inline]
    fn mul(self, k: f32) -> Self {
        Self {
            xx: self.xx * k,
            yy: self.yy * k,
            zz: self.zz * k,
            xy: self.xy * k,
            xz: self.xz * k,
            yz: self.yz * k,
        }
    }
}

impl Sum for Symmetric3 {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, Add::add)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn entries() -> impl Strategy<Value = Symmetric3> {
        proptest::array::uniform6(-10.0_f32..10.0).prop_map(|[xx, yy, zz, xy, xz, yz]| Symmetric3 {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        })
    }

    fn close(a: Symmetric3, b: Symmetric3, tolerance: f32) -> bool {
        let d = a - b;
        [d.xx, d.yy, d.zz, d.xy, d.xz, d.yz].iter().all(|x| x.abs() <= tolerance)
    }

    proptest! {
        #[test]
        fn eigen_rebuilds_the_matrix(s in entries()) {
            let (values, q) = s.eigen();
            prop_assert!(values.x >= values.y && values.y >= values.z);
            prop_assert!((q.determinant() - 1.0).abs() < 1e-5);
            prop_assert!(close(Symmetric3::from_diagonal(values).congruence(q.transpose()), s, 2e-5));
        }

        #[test]
        fn congruence_is_the_product(s in entries(), m in proptest::array::uniform9(-2.0_f32..2.0)) {
            let m = Mat3::from_cols_array(&m);
            let full = Symmetric3::from_mat3(m.transpose() * s.to_mat3() * m);
            prop_assert!(close(s.congruence(m), full, 1e-3));
        }

        #[test]
        fn clamping_leaves_no_negative_direction(s in entries(), d in proptest::array::uniform3(-1.0_f32..1.0)) {
            let (clamped, d) = (s.clamped_positive(), Vec3::from_array(d));
            prop_assert!(clamped.quadratic(d) >= -1e-5);
            // It only ever adds the parts it removes.
            prop_assert!(clamped.quadratic(d) >= s.quadratic(d) - 1e-4);
        }
    }

    #[test]
    fn degenerate_matrices_have_eigenvectors() {
        for s in [
            Symmetric3::ZERO,
            Symmetric3::IDENTITY,
            Symmetric3::outer(Vec3::new(1.0, 2.0, 3.0)),
            Symmetric3::from_diagonal(Vec3::new(1e-30, 1e30, 0.0)),
        ] {
            let (values, q) = s.eigen();
            assert!(values.is_finite() && (q.determinant() - 1.0).abs() < 1e-5, "{s:?}: {values} {q}");
        }
        // n nᵀ has one eigenvalue n² = 14 and two zeros.
        let (values, q) = Symmetric3::outer(Vec3::new(1.0, 2.0, 3.0)).eigen();
        assert!((values - Vec3::new(14.0, 0.0, 0.0)).abs().max_element() < 1e-5);
        assert!(q.x_axis.dot(Vec3::new(1.0, 2.0, 3.0).normalize()).abs() > 1.0 - 1e-6);
    }

    #[test]
    fn products_of_vectors() {
        // (1,2,3) seen by (1,0,−1): n·d = −2, so dᵀ n nᵀ d = 4 and n nᵀ d = −2 n.
        let s = Symmetric3::outer(Vec3::new(1.0, 2.0, 3.0));
        let d = Vec3::new(1.0, 0.0, -1.0);
        assert_eq!(s.quadratic(d), 4.0);
        assert_eq!(s.mul_vec3(d), Vec3::new(-2.0, -4.0, -6.0));
        assert_eq!(s.to_mat3() * d, s.mul_vec3(d));
        assert_eq!(s.trace(), 14.0);
        assert_eq!([s, s].into_iter().sum::<Symmetric3>(), s * 2.0);
    }
}
