//! Opacity of a voxel from its geometry: what fraction of parallel rays pass, direction by direction, and the
//! matrix Σ that says the same.
//!
//! In a direction d the rays that cross the region on lengths l should pass as often as they do:
//! mean exp(−σ_d l) = the fraction that hits nothing. That gives σ_d; Σ is the least-squares fit of
//! σ_d² = dᵀΣd over the directions.

use glam::Vec3;
use pelage_geom::Symmetric3;

use crate::flat;
use crate::grid::{Frame, larger, smaller};
use crate::raster::{Hits, Raster};
use crate::region::{Parts, Region};
use crate::silhouette::Silhouette;

/// Opposite vertices of the icosahedron: the six axes from which six numbers follow.
pub(crate) const ICOSAHEDRON: [Vec3; 6] = [
    Vec3::new(0.0, 0.525_731_1, 0.850_650_8),
    Vec3::new(0.0, 0.525_731_1, -0.850_650_8),
    Vec3::new(0.850_650_8, 0.0, 0.525_731_1),
    Vec3::new(-0.850_650_8, 0.0, 0.525_731_1),
    Vec3::new(0.525_731_1, 0.850_650_8, 0.0),
    Vec3::new(0.525_731_1, -0.850_650_8, 0.0),
];

/// The icosahedron's axes, then the dodecahedron's: its faces' centres.
pub(crate) const SIXTEEN: [Vec3; 16] = {
    const C: f32 = 0.577_350_26;
    const A: f32 = 0.356_822_1;
    const B: f32 = 0.934_172_4;
    let [a, b, c, d, e, f] = ICOSAHEDRON;
    [
        a,
        b,
        c,
        d,
        e,
        f,
        Vec3::new(C, C, C),
        Vec3::new(C, C, -C),
        Vec3::new(C, -C, C),
        Vec3::new(-C, C, C),
        Vec3::new(A, 0.0, B),
        Vec3::new(A, 0.0, -B),
        Vec3::new(0.0, B, A),
        Vec3::new(0.0, B, -A),
        Vec3::new(B, A, 0.0),
        Vec3::new(B, -A, 0.0),
    ]
};

/// What one direction says of a region.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sight {
    pub(crate) direction: Vec3,
    /// Extinction per voxel edge.
    pub(crate) sigma: f32,
    /// Mean colour of what is seen from both ends, times `weight`.
    pub(crate) color: Vec3,
    /// Area seen, in squares of the voxel's edge.
    pub(crate) weight: f32,
}

/// What is looked at: a voxel's matter, in its frame.
#[derive(Clone, Copy)]
pub(crate) struct Matter<'a> {
    pub(crate) region: &'a Region,
    pub(crate) parts: &'a Parts,
    pub(crate) triangles: &'a [[Vec3; 3]],
    pub(crate) colors: &'a [Vec3],
    /// The colour of all of it, if it has only one.
    pub(crate) color: Option<Vec3>,
}

/// What passes a sheet without holes, at least.
const SHEET: f32 = 5e-4;

/// Buffers that every look reuses.
#[derive(Default)]
pub(crate) struct View {
    silhouette: Silhouette,
    raster: Raster,
    lengths: Vec<f32>,
}

impl View {
    /// Looks at a planar region face on: exactly where its pieces lie side by side, with about `side`² rays elsewhere.
    pub(crate) fn look_face_on(&mut self, matter: Matter, side: usize) -> Option<Sight> {
        let Matter { region, parts, colors, .. } = matter;
        let frame = Frame::new(region.normal);
        let Some((covered, area)) = flat::cover(region, parts) else {
            return self.look(matter, frame, side);
        };
        let grid = &mut self.silhouette.grid;
        grid.aim(region, frame, side.min(Silhouette::SIDE));
        let (count, length) = grid.lengths(&mut self.lengths);
        if count == 0.0 {
            return None;
        }
        let sigma = extinction(&self.lengths, count, length, (1.0 - covered).max(SHEET));
        let pieces = parts.pieces().map(|(id, doubled, _)| colors[id as usize] * 0.5 * doubled.length());
        let sum: Vec3 = pieces.sum();
        let areas: f32 = parts.pieces().map(|(_, doubled, _)| 0.5 * doubled.length()).sum();
        Some(Sight { direction: frame.direction, sigma, color: sum * (area / areas), weight: area })
    }

    /// Looks along a direction with about `side`² rays; `None` where no ray crosses the region.
    pub(crate) fn look(&mut self, matter: Matter, frame: Frame, side: usize) -> Option<Sight> {
        let Matter { region, parts, triangles, colors, color } = matter;
        let mean_color = |hits: &Hits| 0.5 * (colors[hits.first.1 as usize] + colors[hits.last.1 as usize]);
        let (count, length, seen, mean, footprint);
        if side <= Silhouette::SIDE {
            // Each direction's colour from this many rays, where the matter has several.
            const COLORS: usize = 4;
            self.silhouette.draw(region, parts, frame, side);
            (count, length) = self.silhouette.grid.lengths(&mut self.lengths);
            seen = self.silhouette.seen_count();
            let wanted = if color.is_some() { 0 } else { COLORS };
            let [mut sum, mut n] = [Vec3::ZERO, Vec3::ZERO];
            for hits in self.silhouette.hits(triangles, wanted as u32) {
                sum += mean_color(&hits);
                n += 1.0;
            }
            mean = color.unwrap_or(sum / n.max(Vec3::ONE));
            footprint = self.silhouette.grid.footprint();
        } else {
            self.raster.draw(region, triangles, frame, side);
            (count, length) = self.raster.grid.lengths(&mut self.lengths);
            let (sum, n) =
                self.raster.crossing().fold((Vec3::ZERO, 0), |(s, n), hits| (s + mean_color(hits), n + 1));
            (seen, mean) = (n, sum / n.max(1) as f32);
            footprint = self.raster.grid.footprint();
        }
        if count == 0.0 {
            return None;
        }
        // A fraction of 0 is known no better than to a part of a ray; a sheet's is 0.
        let least = if region.is_thin() { SHEET } else { 0.05 / count };
        let passed = ((count - seen as f32) / count).max(least);
        let weight = seen as f32 * footprint;
        let sigma = extinction(&self.lengths, count, length, passed);
        Some(Sight { direction: frame.direction, sigma, color: mean * weight, weight })
    }
}

/// The σ at which mean exp(−σ l) over the `count` lengths that are not missed, which are `mean` long, is `passed`.
pub(crate) fn extinction(lengths: &[f32], count: f32, mean: f32, passed: f32) -> f32 {
    let limit = 12.0 / mean;
    let wanted = passed.ln();
    // The root for lengths of a gamma distribution of shape 3, which those of a box resemble.
    let mut sigma = smaller(3.0 * (exp_minus(-wanted / 3.0).recip() - 1.0) / mean, limit);
    for _ in 0..6 {
        let [value, slope, curve] = transmittance(lengths, sigma);
        // Halley's method for f = ln mean exp(−σ l) − wanted.
        let f = (value / count).ln() - wanted;
        let speed = -slope / value;
        let bend = curve / value - speed * speed;
        let step = -2.0 * f * speed / (2.0 * speed * speed - f * bend);
        // NaN, where nothing passes at all, ends the search.
        if !step.is_finite() {
            break;
        }
        let before = sigma;
        sigma = (sigma + step).clamp(0.1 * sigma, limit);
        // The next step would be of the order of the cube of this one; at the limit there is none.
        if (sigma - before).abs() <= 0.08 * sigma {
            break;
        }
    }
    if sigma.is_finite() { sigma.clamp(0.0, limit) } else { 0.0 }
}

/// Σ exp(−σ l) over the lengths, Σ l exp(−σ l) and Σ l² exp(−σ l). As many lengths as make whole vectors.
fn transmittance(lengths: &[f32], sigma: f32) -> [f32; 3] {
    const LANES: usize = 8;
    let [mut values, mut slopes, mut curves] = [[0.0_f32; LANES]; 3];
    for chunk in lengths.chunks_exact(LANES) {
        for lane in 0..LANES {
            let value = exp_minus(sigma * chunk[lane]);
            let slope = value * chunk[lane];
            values[lane] += value;
            slopes[lane] += slope;
            curves[lane] += slope * chunk[lane];
        }
    }
    [values, slopes, curves].map(|sums| sums.iter().sum())
}

/// exp(−x) for x ≥ 0, to a relative 3e-6; at least 2⁻¹²⁰. Written so that the compiler can do several at once.
#[inline]
fn exp_minus(x: f32) -> f32 {
    // Adding 1.5·2²³ leaves the nearest integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let z = larger(-core::f32::consts::LOG2_E * x, -120.0);
    let shifted = z + ROUND;
    let f = z - (shifted - ROUND);
    // 2^f on [−½, ½]: its Taylor series in f ln 2.
    let p = 1.333_356e-3_f32;
    let p = p * f + 9.618_129e-3;
    let p = p * f + 5.550_411e-2;
    let p = p * f + 2.402_265e-1;
    let p = p * f + 6.931_472e-1;
    let p = p * f + 1.0;
    f32::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << 23))
}

/// Σ from what the directions say: weighted least squares of σ_d² = dᵀΣd, negative eigenvalues clamped.
pub(crate) fn fit(sights: &[Sight]) -> Symmetric3 {
    let mut normal = [[0.0_f64; 7]; 6];
    for sight in sights {
        let [x, y, z] = sight.direction.as_dvec3().to_array();
        let row = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z];
        let sigma = f64::from(sight.sigma);
        let weight = (0.3 + sigma).powi(-2);
        for i in 0..6 {
            for j in 0..6 {
                normal[i][j] += weight * row[i] * row[j];
            }
            normal[i][6] += weight * row[i] * sigma * sigma;
        }
    }
    // Where the directions leave Σ undetermined it stays small. Relative to each entry: the weights of a
    // sheet's directions differ by a million.
    let least = 1e-12 * (0..6).map(|i| normal[i][i]).sum::<f64>();
    for (i, row) in normal.iter_mut().enumerate() {
        row[i] += 1e-6 * row[i] + least;
    }
    let [xx, yy, zz, xy, xz, yz] = solve(normal).map(|x| x as f32);
    let sigma = Symmetric3 { xx, yy, zz, xy, xz, yz };
    if !sigma.is_finite() {
        return Symmetric3::ZERO;
    }
    if is_positive(sigma) { sigma } else { sigma.clamped_positive() }
}

/// Whether all leading minors are positive (Sylvester's criterion): spares most matrices their eigenvalues.
fn is_positive(s: Symmetric3) -> bool {
    let minor = s.xx * s.yy - s.xy * s.xy;
    s.xx > 0.0 && minor > 0.0 && s.to_mat3().determinant() > 0.0
}

/// Gaussian elimination of a positive definite system: rows of a matrix with the right-hand side appended.
fn solve(mut rows: [[f64; 7]; 6]) -> [f64; 6] {
    for pivot in 0..6 {
        let above = rows[pivot];
        for row in &mut rows[pivot + 1..] {
            let factor = row[pivot] / above[pivot];
            for (entry, above) in row.iter_mut().zip(above).skip(pivot) {
                *entry -= factor * above;
            }
        }
    }
    let mut x = [0.0; 6];
    for i in (0..6).rev() {
        let known: f64 = (i + 1..6).map(|j| rows[i][j] * x[j]).sum();
        x[i] = (rows[i][6] - known) / rows[i][i];
    }
    x
}
