//! What one voxel of one level holds.
//!
//! | field | is | unit |
//! |---|---|---|
//! | Σ | opacity: a step d inside the region has optical depth sqrt(dᵀΣd) | voxel edge⁻² |
//! | box, slab | where the matter lies; only there is a voxel traversed | voxel edge |
//! | albedo | mean colour of what is visible in it | linear, `[0, 1]` |
//!
//! The region decides the picture more than anything else: a voxel is not a cube of fog.

use glam::Vec3;
use pelage_geom::{Ellipsoid, Symmetric3};

/// A voxel, in its own frame: `[0, 1]³` spans its cell, axes are the texel's (s, t, w).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voxel {
    /// Positive semi-definite, in units of the level's voxel edge: a step `d` inside the region has optical
    /// depth sqrt(dᵀΣd) [seed §6.1].
    pub sigma: Symmetric3,
    /// Lower corner of the tight box.
    pub lo: Vec3,
    /// Upper corner of the tight box; above `lo` on every axis.
    pub hi: Vec3,
    /// Unit normal of the slab: the dominant normal of the matter.
    pub slab_normal: Vec3,
    /// The slab: points with `slab_normal · p` between the two.
    pub slab: [f32; 2],
    /// Mean linear colour of what is visible.
    pub albedo: Vec3,
}

impl Voxel {
    /// The region (box ∩ slab) is at least this thick in every direction that bounds it, in voxel edges: a
    /// sheet stays a thing that rays spend a length in.
    pub const MIN_THICKNESS: f32 = 0.02;

    /// What stands where a part of a triangle was too small to be measured: all of the cell, transparent.
    pub(crate) fn clear() -> Self {
        Self {
            sigma: Symmetric3::ZERO,
            lo: Vec3::ZERO,
            hi: Vec3::ONE,
            slab_normal: Vec3::Z,
            slab: [0.0, 1.0],
            albedo: Vec3::ZERO,
        }
    }

    /// The part of `range` where the line `p + x d` is inside the region.
    ///
    /// `p` and `d` in the voxel's frame; `None` where nothing is left, or where a number is NaN.
    #[inline]
    pub fn clip(&self, p: Vec3, d: Vec3, range: [f32; 2]) -> Option<[f32; 2]> {
        let normal = self.slab_normal;
        let near = self.lo - p;
        let far = self.hi - p;
        let height = normal.dot(p);
        let mut interval = range;
        for axis in 0..3 {
            interval = clip_slab(interval, near[axis], far[axis], d[axis]);
        }
        interval = clip_slab(interval, self.slab[0] - height, self.slab[1] - height, normal.dot(d));
        (interval[0] < interval[1]).then_some(interval)
    }

    /// The first field that is out of its domain, if any.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let unit = |v: f32| (0.0..=1.0).contains(&v);
        let all = |v: Vec3| v.to_array().into_iter().all(unit);
        let checks = [
            ("sigma", self.sigma.is_finite() && is_positive(self.sigma)),
            ("lo", all(self.lo)),
            ("hi", all(self.hi) && self.lo.cmplt(self.hi).all()),
            ("slab_normal", (self.slab_normal.length() - 1.0).abs() < 1e-3),
            ("slab", self.slab[0] < self.slab[1] && self.slab[1].is_finite() && self.slab[0].is_finite()),
            ("albedo", all(self.albedo)),
        ];
        checks.into_iter().find(|(_, sound)| !sound).map(|(field, _)| field)
    }

    /// The distribution of its normals, up to a factor.
    ///
    /// Σ is one where matter fills a volume. Of a thin slab it says how much is covered, measured along few
    /// directions, while the slab's own normal says exactly how the matter lies.
    pub fn normals(&self) -> Ellipsoid {
        let [thin, thick] = Self::THIN;
        let volume = ((self.slab[1] - self.slab[0] - thin) / (thick - thin)).clamp(0.0, 1.0);
        if volume == 1.0 {
            return Ellipsoid(self.sigma);
        }
        let trace = self.sigma.trace().max(f32::MIN_POSITIVE);
        let flake = Ellipsoid::flake(self.slab_normal).0;
        Ellipsoid(flake * (1.0 - volume) + self.sigma * (volume / trace))
    }

    /// Slabs up to the first thickness (voxel edges) have the normals of a flake, from the second on those of Σ.
    const THIN: [f32; 2] = [0.08, 0.25];

    /// Optical depth of a step `d` (voxel edges) inside the region, by Σ alone: [`Level::cross`](crate::Level::cross) knows
    /// what else its level says of the direction.
    #[inline]
    pub fn depth_per_step(&self, d: Vec3) -> f32 {
        self.sigma.quadratic(d).max(0.0).sqrt()
    }
}

/// The part of `range` where `x·speed` lies in `[near, far]`; empty as a reversed interval.
#[inline]
fn clip_slab(range: [f32; 2], near: f32, far: f32, speed: f32) -> [f32; 2] {
    // Slower than this the line stays on its side of both planes over any voxel: 1e-12 of an edge a step.
    if speed.abs() < 1e-12 {
        let inside = near <= 0.0 && 0.0 <= far;
        return if inside { range } else { [f32::INFINITY, f32::NEG_INFINITY] };
    }
    let inverse = speed.recip();
    let [a, b] = [near * inverse, far * inverse];
    [range[0].max(a.min(b)), range[1].min(a.max(b))]
}

/// Whether no eigenvalue is negative, beyond the rounding of the largest: 1/1000 of the trace.
fn is_positive(sigma: Symmetric3) -> bool {
    let rounding = 1e-3 * f64::from(sigma.trace());
    let Symmetric3 { xx, yy, zz, xy, xz, yz } = sigma;
    let [xx, yy, zz] = [xx, yy, zz].map(|entry| f64::from(entry) + rounding);
    let [xy, xz, yz] = [xy, xz, yz].map(f64::from);
    // By Sylvester’s criterion, the leading minors; all of them are 0 where nothing is.
    let last = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    xx >= 0.0 && xx * yy - xy * xy >= 0.0 && last >= 0.0
}
