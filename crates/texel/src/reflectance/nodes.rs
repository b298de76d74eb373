//! Directions at which functions on the sphere are known, and how they are interpolated between them.
//!
//! Each hemisphere is a square of cells [Cigolle14], in the middle of each a node; between four of them functions are
//! bilinear. What is seen from just above the horizon has nothing to do with what is seen from below it: the squares do not
//! know of each other.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, vec2};

/// Nodes along each side of the squares of the upper hemisphere (z ≥ 0) and of the lower: from below little is seen, and
/// as little lit.
const SIDES: [usize; 2] = [10, 5];
/// Nodes of the upper hemisphere.
const UPPER: usize = SIDES[0] * SIDES[0];
/// Nodes of the sphere: the upper hemisphere's, then the lower's.
pub(crate) const NODES: usize = UPPER + SIDES[1] * SIDES[1];

/// The four nodes around a unit vector, and their weights, whose sum is 1.
#[inline]
pub(super) fn around(d: Vec3) -> [(usize, f32); 4] {
    let (side, first) = if d.z < 0.0 { (SIDES[1], UPPER) } else { (SIDES[0], 0) };
    between(on_square(d), side).map(|(node, weight)| (first + node, weight))
}

/// The four nodes around a point of the square `[−1, 1]²` with so many on each side.
#[inline]
fn between(at: Vec2, side: usize) -> [(usize, f32); 4] {
    let at = ((at * 0.5 + 0.5) * side as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat((side - 1) as f32));
    let cell = at.floor().min(Vec2::splat((side - 2) as f32));
    let part = at - cell;
    let node = side * cell.y as usize + cell.x as usize;
    let rest = 1.0 - part;
    [
        (node, rest.x * rest.y),
        (node + 1, part.x * rest.y),
        (node + side, rest.x * part.y),
        (node + side + 1, part.x * part.y),
    ]
}

/// The direction of each node.
pub(super) fn node(i: usize) -> Vec3 {
    let (i, side, up) = if i < UPPER { (i, SIDES[0], 1.0) } else { (i - UPPER, SIDES[1], -1.0) };
    from_square(cell_of_square(i, side), up)
}

/// The middle of a cell of the square `[−1, 1]²`, of so many on each side.
fn cell_of_square(i: usize, side: usize) -> Vec2 {
    (vec2((i % side) as f32, (i / side) as f32) + 0.5) * (2.0 / side as f32) - 1.0
}

/// A function of directions by its values at nodes: of all those that the nodes can say, the one that is nearest to it
/// (least squares over the solid angle).
pub(super) struct Fit {
    halves: [HalfFit; 2],
}

/// The same for the directions of one hemisphere.
struct HalfFit {
    /// Directions in which the function is asked for, and what the value in each of them adds to each node.
    samples: Vec<(Vec3, Vec<f32>)>,
}

pub(super) static FIT: LazyLock<Fit> =
    LazyLock::new(|| Fit { halves: [HalfFit::new(SIDES[0], 1.0), HalfFit::new(SIDES[1], -1.0)] });

impl HalfFit {
    fn new(side: usize, up: f32) -> Self {
        let (nodes, fine) = (side * side, 2 * side);
        let places: Vec<Vec2> = (0..fine * fine).map(|i| cell_of_square(i, fine)).collect();
        // With the hats φ, the solid angles ω and a function's values f: (Σ ω φ φᵀ) x = Σ ω φ f, for one f after the other.
        let (mut normal, mut hats) =
            (vec![vec![0.0_f64; nodes]; nodes], vec![vec![0.0_f64; nodes]; places.len()]);
        for (place, hat) in places.iter().zip(&mut hats) {
            // That of a place on the octahedron, whose sides are as far as 1/√3 from its middle.
            let solid_angle = f64::from(octahedron(*place).length()).powi(-3);
            for (a, x) in between(*place, side) {
                hat[a] = solid_angle * f64::from(x);
                for (b, y) in between(*place, side) {
                    normal[a][b] += solid_angle * f64::from(x * y);
                }
            }
        }
        solve(&mut normal, &mut hats);
        let weights = hats.iter().map(|hat| hat.iter().map(|x| *x as f32).collect());
        Self { samples: places.iter().map(|place| from_square(*place, up)).zip(weights).collect() }
    }
}

impl Fit {
    /// The values at the nodes of a function on the sphere.
    pub(super) fn of(&self, function: impl Fn(Vec3) -> f32) -> [f32; NODES] {
        let [values] = self.of_each(|d| [function(d)]);
        values
    }

    /// The same of several functions.
    pub(super) fn of_each<const N: usize>(&self, functions: impl Fn(Vec3) -> [f32; N]) -> [[f32; NODES]; N] {
        let mut each = [[0.0; NODES]; N];
        for (half, first) in self.halves.iter().zip([0, UPPER]) {
            for (sample, weights) in &half.samples {
                let values = functions(*sample);
                for (sums, value) in each.iter_mut().zip(values).filter(|(_, value)| *value != 0.0) {
                    let sums = &mut sums[first..][..weights.len()];
                    sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += value * weight);
                }
            }
        }
        each
    }
}

/// Solves `matrix` x = y for each y of `columns`, which become x; the matrix, symmetric and positive, is used up.
fn solve(matrix: &mut [Vec<f64>], columns: &mut [Vec<f64>]) {
    for pivot in 0..matrix.len() {
        let row = matrix[pivot].clone();
        for other in (0..matrix.len()).filter(|other| *other != pivot) {
            let factor = matrix[other][pivot] / row[pivot];
            matrix[other].iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
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
            for (up, most) in [(1.0, 0.025), (-1.0, 0.065)] {
                let mut sums = [0.0_f64; 3];
                for _ in 0..20_000 {
                    let d = random.direction();
                    let d = Vec3 { z: up * d.z.abs(), ..d };
                    let exact = n.dot(d).max(0.0);
                    let found: f32 = around(d).iter().map(|(node, weight)| weight * fitted[*node]).sum();
                    sums[0] += f64::from(exact);
                    sums[1] += f64::from(found);
                    sums[2] += f64::from((found - exact).powi(2));
                }
                let error = (sums[2] / 20_000.0).sqrt();
                let off = (sums[1] - sums[0]) / 20_000.0;
                assert!(off.abs() < 0.003 && error < most, "{up}: {off} {error}");
            }
        }
    }
}
