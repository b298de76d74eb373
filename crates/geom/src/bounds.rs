//! Proof that a box is not folded: Bernstein bounds of det J. [seed §5]
//!
//! det J is a polynomial of degree 2 in each coordinate, so it lies between the smallest and largest of its 27
//! Bernstein coefficients. All positive is a proof; where some are not, the box is halved until it is decided. In a
//! prism det J is linear in the barycentric coordinates and quadratic in w: it is least over one of the three
//! vertical edges, where its exact minimum is known.

use glam::DVec3;

use crate::{DTrilinear, Hexahedron};

/// What is known of det J over a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Certificate {
    /// The map is bijective on the box: det J > 0 everywhere.
    Valid {
        /// A lower bound of det J, in scene volume per box volume.
        min_determinant: f64,
    },
    /// The box is folded, mirrored, or has no volume somewhere.
    Folded {
        /// Box coordinates of a witness.
        at: DVec3,
        /// det J there: zero up to rounding, or negative.
        determinant: f64,
    },
    /// Neither was proved within the depth asked for.
    Undecided {
        /// Box coordinates near which it is undecided.
        at: DVec3,
    },
}

impl Certificate {
    /// Whether the box is proved to be bijective.
    pub fn is_valid(&self) -> bool {
        matches!(self, Self::Valid { .. })
    }
}

/// Decides whether det J is positive everywhere in the box, halving it up to `max_depth` times in each direction.
///
/// Most boxes are decided at once. A determinant within rounding of zero counts as zero: a flat or collapsed box is
/// [`Certificate::Folded`], as is one with corners that are not finite.
pub fn certify(hexahedron: &Hexahedron, max_depth: u32) -> Certificate {
    certify_map(&hexahedron.map(), hexahedron.is_prism(), max_depth)
}

/// The same for the map alone, where no hexahedron is at hand; `prism` says that only its half under u + v ≤ 1 counts.
pub fn certify_map(map: &DTrilinear, prism: bool, max_depth: u32) -> Certificate {
    if !map.corners.iter().all(|c| c.is_finite()) {
        return Certificate::Folded { at: DVec3::splat(0.5), determinant: f64::NAN };
    }
    if prism { certify_prism(map) } else { certify_cuboid(map, max_depth) }
}

/// Bounds the rounding of a coefficient, relative to the longest edges: some forty roundings, with margin.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Bernstein coefficients of det J over a part of the box, index 9 k + 3 j + i for degrees (i, j, k) in (u, v, w).
type Coefficients = [f64; 27];

struct Part {
    coefficients: Coefficients,
    lo: DVec3,
    size: f64,
    depth: u32,
}

fn certify_cuboid(map: &DTrilinear, max_depth: u32) -> Certificate {
    let (coefficients, rounding) = cuboid_coefficients(map);
    let least = minimum(&coefficients);
    if least > rounding {
        return Certificate::Valid { min_determinant: least - rounding };
    }
    let mut bound = f64::INFINITY;
    let mut undecided = None;
    let mut parts = vec![Part { coefficients, lo: DVec3::ZERO, size: 1.0, depth: 0 }];
    while let Some(part) = parts.pop() {
        // The coefficients at the corners are det J itself.
        for corner in 0..8 {
            let bits = DVec3::new((corner & 1) as f64, (corner >> 1 & 1) as f64, (corner >> 2 & 1) as f64);
            let determinant =
                part.coefficients[2 * (corner & 1) + 6 * (corner >> 1 & 1) + 18 * (corner >> 2 & 1)];
            if determinant <= rounding {
                return Certificate::Folded { at: part.lo + part.size * bits, determinant };
            }
        }
        let least = minimum(&part.coefficients);
        if least > rounding {
            bound = bound.min(least - rounding);
        } else if part.depth == max_depth {
            undecided = Some(part.lo + 0.5 * part.size);
        } else {
            split(&part, &mut parts);
        }
    }
    match undecided {
        Some(at) => Certificate::Undecided { at },
        None => Certificate::Valid { min_determinant: bound },
    }
}

fn minimum(coefficients: &Coefficients) -> f64 {
    coefficients.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The 27 coefficients, and a bound of the rounding in each.
///
/// A column of J along one coordinate is bilinear in the two others, with the four edges as its coefficients.
/// Products of degree-1 coefficients add up to degree 2: those that meet at index 1 are halved.
fn cuboid_coefficients(map: &DTrilinear) -> (Coefficients, f64) {
    let c = &map.corners;
    // edges[axis][m]: the edge along `axis` at bits m of the next two coordinates in cyclic order.
    let edges: [[DVec3; 4]; 3] = core::array::from_fn(|axis| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        core::array::from_fn(|m| {
            let start = (m & 1) << p | (m >> 1) << q;
            c[start | 1 << axis] - c[start]
        })
    });
    let [us, vs, ws] = &edges;
    let mut coefficients = [0.0; 27];
    for (m, u) in us.iter().enumerate() {
        for (n, v) in vs.iter().enumerate() {
            let normal = u.cross(*v);
            for (o, w) in ws.iter().enumerate() {
                // u is over (v, w), v over (w, u), w over (u, v).
                let i = (n >> 1) + (o & 1);
                let j = (m & 1) + (o >> 1);
                let k = (m >> 1) + (n & 1);
                coefficients[i + 3 * j + 9 * k] += normal.dot(*w);
            }
        }
    }
    const SHARE: [f64; 3] = [1.0, 0.5, 1.0];
    for (index, x) in coefficients.iter_mut().enumerate() {
        *x *= SHARE[index % 3] * SHARE[index / 3 % 3] * SHARE[index / 9];
    }
    let longest = |edges: &[DVec3; 4]| edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max).sqrt();
    (coefficients, ROUNDING * longest(us) * longest(vs) * longest(ws))
}

/// Pushes the eight halves of `part`, by de Casteljau along each axis.
fn split(part: &Part, parts: &mut Vec<Part>) {
    let mut halves = vec![part.coefficients];
    for stride in [1, 3, 9] {
        halves = halves.iter().flat_map(|c| halve(c, stride)).collect();
    }
    let size = 0.5 * part.size;
    for (index, coefficients) in halves.into_iter().enumerate() {
        // The first axis was split first, so it is the slowest bit.
        let offset = DVec3::new((index >> 2 & 1) as f64, (index >> 1 & 1) as f64, (index & 1) as f64);
        parts.push(Part { coefficients, lo: part.lo + size * offset, size, depth: part.depth + 1 });
    }
}

fn halve(c: &Coefficients, stride: usize) -> [Coefficients; 2] {
    let (mut lower, mut upper) = (*c, *c);
    for first in (0..27).filter(|i| (i / stride).is_multiple_of(3)) {
        let [a, b, d] = [c[first], c[first + stride], c[first + 2 * stride]];
        let (ab, bd) = (0.5 * (a + b), 0.5 * (b + d));
        let middle = 0.5 * (ab + bd);
        (lower[first + stride], lower[first + 2 * stride]) = (ab, middle);
        (upper[first], upper[first + stride]) = (middle, bd);
    }
    [lower, upper]
}

fn certify_prism(map: &DTrilinear) -> Certificate {
    let (edges, rounding) = prism_coefficients(map);
    let mut bound = f64::INFINITY;
    for (edge, &c) in edges.iter().enumerate() {
        let (w, determinant) = quadratic_minimum(c);
        if determinant <= rounding {
            let [u, v] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][edge];
            return Certificate::Folded { at: DVec3::new(u, v, w), determinant };
        }
        bound = bound.min(determinant - rounding);
    }
    Certificate::Valid { min_determinant: bound }
}

/// For each vertical edge the three coefficients in w, and a bound of the rounding in each.
///
/// ∂T/∂u runs from AB to EF and ∂T/∂v from AC to EG with w; ∂T/∂w is the barycentric mean of AE, BF and CG.
fn prism_coefficients(map: &DTrilinear) -> ([[f64; 3]; 3], f64) {
    let [a, b, c, _, e, f, g, _] = map.corners;
    let (u, v) = ([b - a, f - e], [c - a, g - e]);
    let normals = [u[0].cross(v[0]), 0.5 * (u[0].cross(v[1]) + u[1].cross(v[0])), u[1].cross(v[1])];
    let uprights = [e - a, f - b, g - c];
    let longest = |edges: &[DVec3]| edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max).sqrt();
    let rounding = ROUNDING * longest(&u) * longest(&v) * longest(&uprights);
    (uprights.map(|up| normals.map(|n| n.dot(up))), rounding)
}

/// Where in `[0,1]` the quadratic with Bernstein coefficients `c` is least, and its value there.
fn quadratic_minimum(c: [f64; 3]) -> (f64, f64) {
    let [first, middle, last] = c;
    let ends = if first <= last { (0.0, first) } else { (1.0, last) };
    if middle >= ends.1 {
        return ends;
    }
    // Convex, with its vertex between the ends.
    let (fall, rise) = (first - middle, last - middle);
    let w = fall / (fall + rise);
    (w, first + w * (middle - first) * 2.0 + w * w * (rise + fall))
}
