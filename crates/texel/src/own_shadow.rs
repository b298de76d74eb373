//! κ: how much of a voxel's own depth shadows what is seen of it, apart from any light.
//!
//! A voxel must not shadow itself by its full depth: on a sheet, what the viewer sees is on the light's side
//! and all lit. κ scales the own depth so that, over what is seen of the voxel and over light directions, the
//! shader's own shadow lets as much light to it as the geometry does:
//!
//! ```text
//! Σ (n·l) own(κ) = Σ (n·l) [unblocked inside the voxel]
//! own = e^−τ_A φ(τ + τ_B − τ_A)/φ(τ),  φ(x) = (1 − e^−x)/x,  τ_A,B = κ sqrt(lᵀΣl) · chord_A,B · F_A,B
//! F = 1 − φ(q·chord),  q = |l − v|/A,  A = .02 + .2 h
//! ```
//!
//! with τ the voxel's depth along the view, chord_A and chord_B the lengths in the region towards the light
//! from where the view enters and leaves, h the voxel's edge in texel units; q and A in texel units.

use glam::Vec3;

use crate::Voxel;
use crate::random::Random;

/// A visible point of the voxel's matter, in the voxel's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// The point.
    pub(crate) point: Vec3,
    /// Its triangle.
    pub(crate) triangle: u32,
    /// Unit vector to the viewer.
    pub(crate) viewer: Vec3,
}

/// One light for one visible point.
struct Lit {
    cosine: f32,
    cosine_over_phi: f32,
    /// Depth along the view, and unscaled depths towards the light where the view enters and leaves.
    view: f32,
    enter: f32,
    leave: f32,
}

/// κ of a voxel of edge `edge` (texel units) with these triangles, from points seen of it.
pub(crate) fn kappa(voxel: &Voxel, triangles: &[[Vec3; 3]], seen: &[Seen], edge: f32, seed: u64) -> f32 {
    let random = &mut Random::new(seed, 0x5ad0);
    let mut lights = Vec::with_capacity(seen.len());
    let [mut all, mut unblocked] = [0.0_f32; 2];
    for &Seen { point, triangle, viewer } in seen {
        let [a, b, c] = triangles[triangle as usize];
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normal = if normal.dot(viewer) < 0.0 { -normal } else { normal };
        // Uniform over the sphere, turned to the lit side.
        let z = random.signed();
        let around = glam::Vec2::from_angle(core::f32::consts::PI * random.signed()) * (1.0 - z * z).sqrt();
        let light = around.extend(z);
        let light = if light.dot(normal) < 0.0 { -light } else { light };
        let cosine = normal.dot(light);
        lights.push((light, cosine));
        all += cosine;
        if !is_blocked(triangles, triangle, point, light) {
            unblocked += cosine;
        }
    }
    // Hardly any shadow measured: none.
    if unblocked >= 0.995 * all {
        return 0.0;
    }
    let each = seen.iter().zip(lights);
    let lit: Vec<Lit> =
        each.filter_map(|(seen, (light, cosine))| Lit::new(voxel, seen, light, cosine, edge)).collect();
    let received = |kappa: f32| lit.iter().map(|lit| lit.received(kappa)).sum::<f32>();
    // In small voxels κ over 1 would stand for noise.
    let mut range = [0.0, if edge < 0.05 { 1.0 } else { 3.0_f32 }];
    if received(range[1]) >= unblocked {
        return range[1];
    }
    // False position; an end that stays twice weighs half as much (Illinois).
    let mut moved = None;
    let mut off = [all, received(range[1])].map(|received| received - unblocked);
    for _ in 0..4 {
        let kappa = (range[0] * off[1] - range[1] * off[0]) / (off[1] - off[0]);
        let here = received(kappa) - unblocked;
        let side = usize::from(here < 0.0);
        (range[side], off[side]) = (kappa, here);
        if moved == Some(side) {
            off[1 - side] *= 0.5;
        }
        moved = Some(side);
    }
    let kappa = (range[0] * off[1] - range[1] * off[0]) / (off[1] - off[0]);
    if kappa.is_finite() { kappa.clamp(range[0], range[1]) } else { range[0] }
}

impl Lit {
    /// `None` where rounding puts the point outside the region.
    fn new(voxel: &Voxel, seen: &Seen, light: Vec3, cosine: f32, edge: f32) -> Option<Self> {
        let Seen { point, viewer, .. } = *seen;
        let line = [f32::NEG_INFINITY, f32::INFINITY];
        let [near, far] = voxel.clip(point, -viewer, line)?;
        let density = voxel.depth_per_step(light);
        let q = (light - viewer).length() / (0.02 + 0.2 * edge);
        let depth_from = |along: f32| {
            let from = point - viewer * along;
            let chord = voxel.clip(from, light, line).map_or(0.0, |[_, end]| end.max(0.0));
            density * chord * (1.0 - phi(q * chord * edge))
        };
        let view = voxel.depth_per_step(viewer) * (far - near);
        let cosine_over_phi = cosine / phi(view);
        Some(Self { cosine, cosine_over_phi, view, enter: depth_from(near), leave: depth_from(far) })
    }

    /// cosine · own(κ)
    fn received(&self, kappa: f32) -> f32 {
        let [enter, leave] = [kappa * self.enter, kappa * self.leave];
        // φ(x) grows without bound for negative x, but only as fast as e^−τ_A falls.
        ((-enter).exp() * phi(self.view + leave - enter) * self.cosine_over_phi).min(self.cosine)
    }
}

/// (1 − e^−x)/x.
fn phi(x: f32) -> f32 {
    // Below this its Taylor series is exact to an f32.
    if x.abs() < 1e-3 { 1.0 - 0.5 * x } else { -(-x).exp_m1() / x }
}

/// Whether something else in the voxel lies between a point of a triangle and the light.
fn is_blocked(triangles: &[[Vec3; 3]], own: u32, point: Vec3, light: Vec3) -> bool {
    // What lies nearer than this, in voxel edges, is the seam to the triangle's neighbour.
    const NEAREST: f32 = 1e-4;
    let inverse = light.recip();
    // Where the ray leaves the voxel.
    let reach = ((Vec3::ZERO - point) * inverse).max((Vec3::ONE - point) * inverse).min_element();
    (0..).zip(triangles).any(|(id, &[a, b, c])| {
        let [ab, ac] = [b - a, c - a];
        let p = light.cross(ac);
        let det = ab.dot(p);
        let s = (point - a) * det.signum();
        let [det, u] = [det.abs(), s.dot(p)];
        if u < 0.0 || u > det {
            return false;
        }
        let q = s.cross(ab);
        let [v, t] = [light.dot(q), ac.dot(q)];
        id != own && v >= 0.0 && u + v <= det && t > NEAREST * det && t < reach * det
    })
}
