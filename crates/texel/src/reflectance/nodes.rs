//! Directions at which functions on the sphere are known, and how they are interpolated between them.
//!
//! Each hemisphere is a square of 8 × 8 cells [Cigolle14], in the middle of each a node; between four of them functions are
//! bilinear. What is seen from just above the horizon has nothing to do with what is seen from below it: the squares do not
//! know of each other.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, vec2};

/// Nodes along each side of a square.
const SIDE: usize = 8;
/// Nodes of a hemisphere.
const HALF: usize = SIDE * SIDE;
/// Nodes of the sphere: the upper hemisphere's (z ≥ 0), then the lower's.
pub(crate) const NODES: usize = 2 * HALF;

/// Directions to each side of a square in which a function is asked for.
const FINE: usize = 2 * SIDE;
/// Directions of a hemisphere in which it is.
const SAMPLES: usize = FINE * FINE;

/// The four nodes around a unit vector, and their weights, whose sum is 1.
#[inline]
pub(super) fn around(d: Vec3) -> [(usize, f32); 4] {
    let first = if d.z < 0.0 { HALF } else { 0 };
    between(on_square(d)).map(|(node, weight)| (first + node, weight))
}

/// The four nodes around a point of the square `[−1, 1]²`.
#[inline]
fn between(at: Vec2) -> [(usize, f32); 4] {
    let at = ((at * 0.5 + 0.5) * SIDE as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat((SIDE - 1) as f32));
    let cell = at.floor().min(Vec2::splat((SIDE - 2) as f32));
    let part = at - cell;
    let node = SIDE * cell.y as usize + cell.x as usize;
    let rest = 1.0 - part;
    [
        (node, rest.x * rest.y),
        (node + 1, part.x * rest.y),
        (node + SIDE, rest.x * part.y),
        (node + SIDE + 1, part.x * part.y),
    ]
}

/// The direction of each node.
pub(super) fn node(i: usize) -> Vec3 {
    let at = vec2((i % SIDE) as f32, (i % HALF / SIDE) as f32) + 0.5;
    from_square(at * (2.0 / SIDE as f32) - 1.0, if i < HALF { 1.0 } else { -1.0 })
}

/// A function of the directions of a hemisphere by its values at nodes: of all those that the nodes can say, the one that
/// is nearest to it (least squares over the solid angle).
pub(super) struct Fit {
    /// Directions in which the function is asked for, of the upper hemisphere.
    samples: [Vec3; SAMPLES],
    /// What the value in each of them adds to each node.
    weights: Box<[[f32; HALF]; SAMPLES]>,
}

pub(super) static FIT: LazyLock<Fit> = LazyLock::new(Fit::new);

impl Fit {
    fn new() -> Self {
        let places: [Vec2; SAMPLES] = std::array::from_fn(|i| {
            (vec2((i % FINE) as f32, (i / FINE) as f32) + 0.5) * (2.0 / FINE as f32) - 1.0
        });
        // With the hats φ, the solid angles ω and a function's values f: (Σ ω φ φᵀ) x = Σ ω φ f, for one f after the other.
        let (mut normal, mut hats) = ([[0.0_f64; HALF]; HALF], Box::new([[0.0_f64; HALF]; SAMPLES]));
        for (place, hat) in places.iter().zip(hats.iter_mut()) {
            // That of a place on the octahedron, whose sides are as far as 1/√3 from its middle.
            let solid_angle = f64::from(octahedron(*place).length()).powi(-3);
            for (a, x) in between(*place) {
                hat[a] = solid_angle * f64::from(x);
                for (b, y) in between(*place) {
                    normal[a][b] += solid_angle * f64::from(x * y);
                }
            }
        }
        solve(&mut normal, &mut hats[..]);
        let mut weights = Box::new([[0.0; HALF]; SAMPLES]);
        for (weights, solved) in weights.iter_mut().zip(hats.iter()) {
            *weights = solved.map(|x| x as f32);
        }
        Self { samples: places.map(|place| from_square(place, 1.0)), weights }
    }

    /// The values at the nodes of a function on the sphere.
    pub(super) fn of(&self, function: impl Fn(Vec3) -> f32) -> [f32; NODES] {
        let [values] = self.of_each(|d| [function(d)]);
        values
    }

    /// The same of several functions.
    pub(super) fn of_each<const N: usize>(&self, functions: impl Fn(Vec3) -> [f32; N]) -> [[f32; NODES]; N] {
        let mut each = [[0.0; NODES]; N];
        for (half, side) in [1.0, -1.0].into_iter().enumerate() {
            for (sample, weights) in self.samples.iter().zip(self.weights.iter()) {
                let values = functions(Vec3 { z: side * sample.z, ..*sample });
                for (sums, value) in each.iter_mut().zip(values).filter(|(_, value)| *value != 0.0) {
                    let sums = &mut sums[HALF * half..][..HALF];
                    sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += value * weight);
                }
            }
        }
        each
    }
}

/// Solves `matrix` x = y for each y of `columns`, which become x; the matrix, symmetric and positive, is used up.
fn solve(matrix: &mut [[f64; HALF]; HALF], columns: &mut [[f64; HALF]]) {
    for pivot in 0..HALF {
        let row = matrix[pivot];
        for other in (0..HALF).filter(|other| *other != pivot) {
            let factor = matrix[other][pivot] / row[pivot];
            matrix[other].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
            columns.iter_mut().for_each(|column| column[other] -= factor * column[pivot]);
        }
    }
    for column in columns {
        column.iter_mut().enumerate().for_each(|(i, x)| *x /= matrix[i][i]);
    }
}

/// Where a direction lies on the square of its hemisphere, whose border is the horizon.
#[inline]
fn on_square(d: Vec3) -> Vec2 {
    let p = d.truncate() / d.abs().element_sum().max(f32::MIN_POSITIVE);
    vec2(p.x + p.y, p.x - p.y)
}

/// The point of the upper half of the octahedron |x| + |y| + |z| = 1 that belongs to one of the square.
fn octahedron(at: Vec2) -> Vec3 {
    let p = 0.5 * vec2(at.x + at.y, at.x - at.y);
    p.extend(1.0 - p.x.abs() - p.y.abs())
}

/// The direction at a point of the square, on a side of the surface (1 or −1).
fn from_square(at: Vec2, side: f32) -> Vec3 {
    let p = octahedron(at);
    Vec3 { z: side * p.z, ..p }.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_map_of_directions_returns() {
        let random = &mut Random::new(3, 0);
        for _ in 0..1000 {
            let d = random.direction();
            assert!((from_square(on_square(d), d.z.signum()) - d).length() < 1e-5);
        }
        for i in 0..NODES {
            let weight: f32 = around(node(i)).iter().filter(|(node, _)| *node == i).map(|(_, w)| w).sum();
            assert!((weight - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn what_nodes_can_say_is_kept() {
        let random = &mut Random::new(4, 0);
        let values: [f32; NODES] = std::array::from_fn(|_| 0.1 + random.unit());
        let fitted = FIT.of(|d| around(d).iter().map(|(node, weight)| weight * values[*node]).sum());
        for (a, b) in values.iter().zip(fitted) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }

    #[test]
    fn a_cosine_is_hardly_off_and_right_on_the_mean() {
        let random = &mut Random::new(5, 0);
        for _ in 0..20 {
            let n = random.direction();
            let fitted = FIT.of(|d| n.dot(d).max(0.0));
            let mut sums = [0.0_f64; 3];
            for _ in 0..20_000 {
                let d = random.direction();
                let exact = n.dot(d).max(0.0);
                let found: f32 = around(d).iter().map(|(node, weight)| weight * fitted[*node]).sum();
                sums[0] += f64::from(exact);
                sums[1] += f64::from(found);
                sums[2] += f64::from((found - exact).powi(2));
            }
            let error = (sums[2] / 20_000.0).sqrt();
            assert!((sums[1] / sums[0] - 1.0).abs() < 0.003 && error < 0.035, "{sums:?} {error}");
        }
    }
}
