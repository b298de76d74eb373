//! Opacity of a voxel from its geometry: what fraction of parallel rays pass, direction by direction, and the
//! matrix Σ that says the same.
//!
//! In a direction d the rays that cross the region on lengths l should pass as often as they do:
//! mean exp(−σ_d l) = the fraction that hits nothing. That gives σ_d; Σ is the least-squares fit of
//! σ_d² = dᵀΣd over the directions [fidelity, builder 2–3].

use glam::Vec3;
use pelage_geom::Symmetric3;

use crate::raster::{Ray, Raster};
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sight {
    pub(crate) direction: Vec3,
    /// Extinction per voxel edge.
    pub(crate) sigma: f32,
    /// Mean colour of what is seen from both ends, times `weight`.
    pub(crate) color: Vec3,
    /// Area seen, in squares of the voxel's edge.
    pub(crate) weight: f32,
}

impl Sight {
    /// Looks along `direction` with `side`² rays; `None` where no ray crosses the region.
    pub(crate) fn new(
        raster: &mut Raster,
        region: &Region,
        triangles: &[[Vec3; 3]],
        colors: &[Vec3],
        direction: Vec3,
        side: usize,
    ) -> Option<Self> {
        raster.draw(region, triangles, direction, side);
        let rays = || raster.rays().iter().filter(|ray| ray.crosses());
        let count = rays().count();
        if count == 0 {
            return None;
        }
        let [mut missed, mut seen] = [0, 0];
        let mut color = Vec3::ZERO;
        for ray in rays() {
            if ray.hits() {
                seen += 1;
                color += 0.5 * (colors[ray.first.1 as usize] + colors[ray.last.1 as usize]);
            } else {
                missed += 1;
            }
        }
        // A fraction of 0 is known no better than to a part of a ray [fidelity, builder 3].
        let floor = 0.05 / count as f32;
        let fraction = (missed as f32 / count as f32).clamp(floor, 1.0);
        let footprint = raster.footprint();
        Some(Self {
            direction,
            sigma: extinction(rays(), count, fraction),
            color: color * footprint,
            weight: seen as f32 * footprint,
        })
    }
}

/// The σ at which `count` rays pass in the mean as often as `fraction`.
fn extinction<'a>(rays: impl Iterator<Item = &'a Ray> + Clone, count: usize, fraction: f32) -> f32 {
    let mean = rays.clone().map(Ray::length).sum::<f32>() / count as f32;
    let limit = 12.0 / mean;
    // By Jensen's inequality the mean length gives too small a σ; from below, Newton's method on this convex
    // function rises to the root without passing it.
    let mut sigma = -fraction.ln() / mean;
    for _ in 0..8 {
        let [mut value, mut slope] = [0.0, 0.0];
        for length in rays.clone().map(Ray::length) {
            let passed = (-sigma * length).exp();
            value += passed;
            slope += passed * length;
        }
        let step = (value - fraction * count as f32) / slope;
        if !(step > 1e-3 * sigma) || sigma >= limit {
            break;
        }
        sigma += step;
    }
    if sigma.is_finite() { sigma.clamp(0.0, limit) } else { 0.0 }
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
    // Directions that see nothing of the region leave Σ undetermined there: it then stays small.
    let ridge = 1e-6 * (0..6).map(|i| normal[i][i]).sum::<f64>();
    for (i, row) in normal.iter_mut().enumerate() {
        row[i] += ridge;
    }
    let [xx, yy, zz, xy, xz, yz] = solve(normal).map(|x| x as f32);
    let sigma = Symmetric3 { xx, yy, zz, xy, xz, yz };
    if sigma.is_finite() { sigma.clamped_positive() } else { Symmetric3::ZERO }
}

/// Gaussian elimination of a positive definite system: rows of a matrix with the right-hand side appended.
fn solve(mut rows: [[f64; 7]; 6]) -> [f64; 6] {
    for pivot in 0..6 {
        for below in pivot + 1..6 {
            let factor = rows[below][pivot] / rows[pivot][pivot];
            for column in pivot..7 {
                rows[below][column] -= factor * rows[pivot][column];
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
