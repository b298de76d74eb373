//! Opacity of a voxel from its geometry: what fraction of parallel rays pass, direction by direction, and the
//! matrix Σ that says the same.
//!
//! In a direction d the rays that cross the region on lengths l should pass as often as they do:
//! mean exp(−σ_d l) = the fraction that hits nothing. That gives σ_d; Σ is the least-squares fit of
//! σ_d² = dᵀΣd over the directions.

use glam::Vec3;
use pelage_geom::Symmetric3;

use crate::own_shadow::Seen;
use crate::raster::Raster;
use crate::region::Region;

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
    /// A few of the points seen.
    pub(crate) points: Vec<Seen>,
}

impl Sight {
    /// Looks along `direction` with `side`² rays and keeps up to `points` of what it sees; `None` where no
    /// ray crosses the region.
    pub(crate) fn new(
        raster: &mut Raster,
        lengths: &mut Vec<f32>,
        region: &Region,
        triangles: &[[Vec3; 3]],
        colors: &[Vec3],
        direction: Vec3,
        side: usize,
        points: usize,
    ) -> Option<Self> {
        raster.draw(region, triangles, direction, side);
        lengths.clear();
        let (mut seen, mut color) = (0, Vec3::ZERO);
        for (length, hits) in raster.crossing() {
            lengths.push(length);
            if hits.any() {
                seen += 1;
                color += 0.5 * (colors[hits.first.1 as usize] + colors[hits.last.1 as usize]);
            }
        }
        if lengths.is_empty() {
            return None;
        }
        let count = lengths.len() as f32;
        // A fraction of 0 is known no better than to a part of a ray; a sheet's is 0.
        let least = if region.is_thin() { 5e-4 } else { 0.05 / count };
        let passed = ((count - seen as f32) / count).max(least);
        let footprint = raster.footprint();
        Some(Self {
            direction,
            sigma: extinction(lengths, passed),
            color: color * footprint,
            weight: seen as f32 * footprint,
            points: raster.seen((seen / points).max(1)).take(points).collect(),
        })
    }
}

/// The σ at which mean exp(−σ l) over the lengths is `passed`.
fn extinction(lengths: &[f32], passed: f32) -> f32 {
    let count = lengths.len() as f32;
    let mean = lengths.iter().sum::<f32>() / count;
    let limit = 12.0 / mean;
    // −ln mean exp(−σ l) is concave in σ and starts with slope `mean`: from below, Newton's method rises to
    // the root without passing it.
    let wanted = passed.ln();
    let mut sigma = -wanted / mean;
    for _ in 0..6 {
        let [value, slope] = transmittance(lengths, sigma);
        let step = ((value / count).ln() - wanted) * value / slope;
        // NaN, where nothing passes at all, ends the search too.
        let goes_on = step > 2e-3 * sigma && sigma < limit;
        if !goes_on {
            break;
        }
        sigma += step;
    }
    if sigma.is_finite() { sigma.clamp(0.0, limit) } else { 0.0 }
}

/// Σ exp(−σ l) over the lengths, and Σ l exp(−σ l).
fn transmittance(lengths: &[f32], sigma: f32) -> [f32; 2] {
    const LANES: usize = 8;
    let [mut values, mut slopes] = [[0.0_f32; LANES]; 2];
    let mut chunks = lengths.chunks_exact(LANES);
    for chunk in &mut chunks {
        for lane in 0..LANES {
            let value = exp_minus(sigma * chunk[lane]);
            values[lane] += value;
            slopes[lane] += value * chunk[lane];
        }
    }
    for (lane, &length) in chunks.remainder().iter().enumerate() {
        let value = exp_minus(sigma * length);
        values[lane] += value;
        slopes[lane] += value * length;
    }
    [values.iter().sum(), slopes.iter().sum()]
}

/// exp(−x) for x ≥ 0, to a relative 3e-6; at least 2⁻¹²⁰. Written so that the compiler can do several at once.
#[inline]
fn exp_minus(x: f32) -> f32 {
    // Adding 1.5·2²³ leaves the nearest integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let z = (-core::f32::consts::LOG2_E * x).max(-120.0);
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
