//! The distribution of normals in a voxel, as an ellipsoid in six numbers. [SGGX15 §3] [Neyret98 §3]
//!
//! Write S = A Aᵀ. Flakes whose area vectors are A y, with y spread evenly over the unit sphere, show the area
//! |Aᵀω| = √(ωᵀSω) towards ω: everything here follows from that picture. It holds for a singular S too, so that
//! needles and flakes are ellipsoids like any other.

use glam::{DMat3, DVec3, Mat3, Vec3};

use crate::Symmetric3;

/// A distribution of normals: the SGGX matrix S, positive semi-definite, by whose quadratic form a direction sees
/// projected area.
///
/// The constructors scale it to one unit of flake area, whose mean projected area over all directions is near ½:
/// times ρ², with ρ the flake area by volume, it is the Σ whose √(dᵀΣd) is optical depth. Nothing else here
/// depends on its scale, unless it says so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ellipsoid(pub Symmetric3);

impl Ellipsoid {
    /// Normals evenly around the unit vector `axis`, as on a thin tube: shows (2/π) sin θ of its area at the
    /// angle θ to the axis.
    pub fn needle(axis: Vec3) -> Self {
        const SHOWN: f32 = core::f32::consts::FRAC_2_PI;
        Self((Symmetric3::IDENTITY - Symmetric3::outer(axis)) * (SHOWN * SHOWN))
    }

    /// The unit vector `normal` and its opposite, as on a thin sheet: shows |cos θ| of its area.
    pub fn flake(normal: Vec3) -> Self {
        Self(Symmetric3::outer(normal))
    }

    /// All normals alike, as on a ball: shows half of its area to every direction.
    pub fn isotropic() -> Self {
        Self(Symmetric3::IDENTITY * 0.25)
    }

    /// The ellipsoid of unit `normals` with weights (areas): it has the axes of their second moments, and along
    /// each axis exactly their projected area, by unit of weight. [SGGX15 §5]
    ///
    /// Weights must not be negative; without any weight the result is zero.
    pub fn from_normals<I>(normals: I) -> Self
    where
        I: IntoIterator<Item = (Vec3, f32)>,
        I::IntoIter: Clone,
    {
        let normals = normals.into_iter();
        let moments: Symmetric3 = normals.clone().map(|(n, weight)| Symmetric3::outer(n) * weight).sum();
        let (_, axes) = moments.eigen();
        let mut shown = DVec3::ZERO;
        let mut total = 0.0;
        for (n, weight) in normals {
            shown += f64::from(weight) * (axes.transpose() * n).abs().as_dvec3();
            total += f64::from(weight);
        }
        if total <= 0.0 {
            return Self::default();
        }
        let shown = (shown / total).as_vec3();
        Self(Symmetric3::from_diagonal(shown * shown).congruence(axes.transpose()))
    }

    /// The mean of `ellipsoids` with weights; zero without any weight.
    ///
    /// This averages squares of projected areas, which over-extinguishes where directions differ; where what is
    /// seen counts, measure it. [SGGX15 §6]
    pub fn mean(ellipsoids: impl IntoIterator<Item = (Self, f32)>) -> Self {
        let mut total = 0.0;
        let mut sum = Symmetric3::ZERO;
        for (Self(s), weight) in ellipsoids {
            sum += s * weight;
            total += weight;
        }
        if total > 0.0 { Self(sum * (1.0 / total)) } else { Self::default() }
    }

    /// σ(ω) = √(ωᵀSω): the area shown to the direction `w`, proportional to the length of `w`. [SGGX15 eq. 9]
    #[inline]
    pub fn projected_area(&self, w: Vec3) -> f32 {
        self.0.quadratic(w).max(0.0).sqrt()
    }

    /// D(m), area by solid angle of normals around the unit vector `m`, scaled so that
    /// σ(ω) = ∫ max(0, ω·m) D(m) dm. [SGGX15 eq. 10]
    ///
    /// Infinite on the support of a singular S, and zero beside it.
    pub fn density(&self, m: Vec3) -> f32 {
        // With the adjugate in place of the inverse nothing is divided by a vanishing determinant.
        let s = self.0.to_mat3().as_dmat3();
        let adjugate =
            DMat3::from_cols(s.y_axis.cross(s.z_axis), s.z_axis.cross(s.x_axis), s.x_axis.cross(s.y_axis));
        let determinant = s.x_axis.dot(adjugate.x_axis).max(0.0);
        let m = m.as_dvec3();
        let spread = m.dot(adjugate * m).max(0.0);
        if spread == 0.0 {
            return if self.0 == Symmetric3::ZERO { 0.0 } else { f32::INFINITY };
        }
        (determinant * determinant.sqrt() / (core::f64::consts::PI * spread * spread)) as f32
    }

    /// The density by solid angle of the normals `m` that the unit direction `w` sees:
    /// max(0, ω·m) D(m) / σ(ω), which integrates to one. [SGGX15 eq. 12]
    ///
    /// Zero where nothing is seen.
    pub fn visible_density(&self, w: Vec3, m: Vec3) -> f32 {
        let (cosine, area) = (w.dot(m), self.projected_area(w));
        if cosine <= 0.0 || area <= 0.0 { 0.0 } else { cosine * self.density(m) / area }
    }

    /// One of the normals that the unit direction `w` sees, by the two numbers `x` of `[0,1)²`: evenly spread
    /// numbers give normals by [`Self::visible_density`]. See [`Self::visible`] for many of them.
    #[inline]
    pub fn sample_visible(&self, w: Vec3, x: [f32; 2]) -> Vec3 {
        self.visible(w).sample(x)
    }

    /// The normals that the unit direction `w` sees, ready to be sampled.
    pub fn visible(&self, w: Vec3) -> VisibleNormals {
        VisibleNormals::new(self.0, w)
    }

    /// J⁻ᵀ S J⁻¹: the ellipsoid in the space that `j` maps to; a uniform scale s turns σ into σ/s.
    ///
    /// Returns `None` if `j` has no finite inverse. [seed §5.2]
    pub fn push(&self, j: &Mat3) -> Option<Self> {
        let inverse = j.as_dmat3().inverse().as_mat3();
        inverse.is_finite().then(|| Self(self.0.congruence(inverse)))
    }
}

/// The normals of an ellipsoid that one direction sees.
///
/// In a frame whose first axis is ω, S = L Lᵀ with L = ( s 0 ; l R ), where s = σ(ω), l the rest of the first
/// column and R the symmetric root of what remains. Then Lᵀω points along the first axis, so the visible flakes
/// L y are those of cosine-distributed y around it. R is smooth and exists for a singular S; [SGGX15 §4.3] uses a
/// Cholesky factor there, which does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleNormals {
    /// Images of the three axes of y, the first being that of the cosine.
    columns: Mat3,
    /// What to answer where nothing is seen.
    direction: Vec3,
}

/// Two unit vectors across `w` that turn smoothly with it except at −Z, from where a coat is never seen: few sample
/// points turn with their frame, and a frame that jumps would show.
fn across(w: Vec3) -> [Vec3; 2] {
    if w.z < -0.9999 {
        let (e1, e2) = w.any_orthonormal_pair();
        return [e1, e2];
    }
    let a = -1.0 / (1.0 + w.z);
    let b = w.x * w.y * a;
    [Vec3::new(1.0 + w.x * w.x * a, b, -w.x), Vec3::new(b, 1.0 + w.y * w.y * a, -w.y)]
}

impl VisibleNormals {
    fn new(s: Symmetric3, w: Vec3) -> Self {
        let [e1, e2] = across(w);
        let (sw, s1, s2) = (s.mul_vec3(w), s.mul_vec3(e1), s.mul_vec3(e2));
        let [s11, s22, s12] = [e1.dot(s1), e2.dot(s2), e1.dot(s2)];
        let shown = w.dot(sw).max(0.0).sqrt();
        // |l|² ≤ s11 + s22 in exact arithmetic; near zero area only that bound is left of it.
        let bound = (s11 + s22).max(0.0).sqrt();
        let l = glam::Vec2::new(e1.dot(sw), e2.dot(sw));
        let l = if shown > 0.0 { (l / shown).clamp_length_max(bound) } else { glam::Vec2::ZERO };
        let (a, b, c) = ((s11 - l.x * l.x).max(0.0), s12 - l.x * l.y, (s22 - l.y * l.y).max(0.0));
        // √M = (M + √det M) / √(tr M + 2 √det M) for a 2×2 matrix.
        let root = (a * c - b * b).max(0.0).sqrt();
        let scale = (a + c + 2.0 * root).sqrt();
        let inverse = if scale > 0.0 { 1.0 / scale } else { 0.0 };
        let columns = Mat3::from_cols(
            w * shown + e1 * l.x + e2 * l.y,
            (e1 * (a + root) + e2 * b) * inverse,
            (e1 * b + e2 * (c + root)) * inverse,
        );
        Self { columns, direction: w }
    }

    /// The normal for `x` in `[0,1)²`: unit length, in the hemisphere of the direction, smooth in `x` within the
    /// disc that the two numbers stand for. Equal areas of `x` are equal shares of what is seen.
    #[inline]
    pub fn sample(&self, x: [f32; 2]) -> Vec3 {
        let radius = x[0].clamp(0.0, 1.0).sqrt();
        let (sin, cos) = (core::f32::consts::TAU * x[1]).sin_cos();
        let y = Vec3::new((1.0 - radius * radius).max(0.0).sqrt(), radius * cos, radius * sin);
        (self.columns * y).normalize_or(self.direction)
    }
}
