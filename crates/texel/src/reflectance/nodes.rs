//! Directions at which functions on the sphere are known, and how they are interpolated between them.
//!
//! Each hemisphere is a square of cells [Cigolle14], in the middle of each a node; between four of them functions are
//! bilinear. What is seen from just above the horizon has nothing to do with what is seen from below it: the squares do not
//! know of each other.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, vec2};

use crate::random::Random;

/// Nodes along each side of the squares of the upper hemisphere (z ≥ 0) and of the lower: from below little is seen, and
/// as little lit.
const SIDES: [usize; 2] = [10, 5];
/// Nodes of the upper hemisphere.
pub(crate) const UPPER: usize = SIDES[0] * SIDES[0];
/// Nodes of the sphere: the upper hemisphere's, then the lower's.
pub(crate) const NODES: usize = UPPER + SIDES[1] * SIDES[1];

/// The four nodes around a unit vector, and their weights, whose sum is 1.
#[inline]
pub(crate) fn around(d: Vec3) -> [(usize, f32); 4] {
    let (side, first) = if d.z < 0.0 { (SIDES[1], UPPER) } else { (SIDES[0], 0) };
    between(on_square(d), side).map(|(node, weight)| (first + node, weight))
}

/// For each of the nodes around the eye, in the order of [`around`], the four nodes around what is as far from it as the light is
/// from the eye, and their weights; `None` where a hemisphere does not hold both.
#[inline]
pub(super) fn aside(eye: Vec3, light: Vec3) -> Option<[[(usize, f32); 4]; 4]> {
    if (eye.z < 0.0) != (light.z < 0.0) {
        return None;
    }
    let (side, first) = if eye.z < 0.0 { (SIDES[1], UPPER) } else { (SIDES[0], 0) };
    let [from, to] = [eye, light].map(|d| in_cells(on_square(d), side));
    let (step, last) = (to - from, (side - 1) as f32);
    let corner = from.floor().min(Vec2::splat(last - 1.0)) + step.floor();
    let part = step - step.floor();
    let rest = 1.0 - part;
    let node = |x: f32, y: f32| {
        let at = (corner + vec2(x, y)).clamp(Vec2::ZERO, Vec2::splat(last));
        first + side * at.y as usize + at.x as usize
    };
    Some([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        [
            (node(x, y), rest.x * rest.y),
            (node(x + 1.0, y), part.x * rest.y),
            (node(x, y + 1.0), rest.x * part.y),
            (node(x + 1.0, y + 1.0), part.x * part.y),
        ]
    }))
}

/// A point of the square in cells, from the first node on to the last.
#[inline]
fn in_cells(at: Vec2, side: usize) -> Vec2 {
    ((at * 0.5 + 0.5) * side as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat((side - 1) as f32))
}

/// The four nodes around a point of the square `[−1, 1]²` with so many on each side.
#[inline]
fn between(at: Vec2, side: usize) -> [(usize, f32); 4] {
    let at = in_cells(at, side);
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

/// The middle of a cell of the square `[−1, 1]²`, of so many on each side.
fn cell_of_square(i: usize, side: usize) -> Vec2 {
    (vec2((i % side) as f32, (i / side) as f32) + 0.5) * (2.0 / side as f32) - 1.0
}

/// Functions of directions, nowhere negative, by their values at nodes.
///
/// Known are means over the cells. Taken for the values at the nodes they would be too low where the function is high, and
/// too high around it; what exactly has these means swings below nothing where the means are noisy. A few rounds of what is
/// told apart by products, from the first towards the second, do neither. [Richardson72]
pub(super) struct Fit {
    /// The mean over each cell, as a sum over nodes.
    means: Weights,
    /// The same the other way round: the cells that a node counts in.
    nodes: Weights,
}

/// Sums over nodes, for each node or cell: which, and how much of each.
type Weights = Vec<Vec<(usize, f32)>>;

/// Rounds in which values at nodes are made to have the means that they should.
const ROUNDS: usize = 2;

pub(super) static FIT: LazyLock<Fit> = LazyLock::new(|| {
    let mut parts = vec![[0.0; NODES]; NODES];
    for (row, (up, side, cell)) in parts.iter_mut().zip(cells()) {
        // Bilinear in each quarter, whose middle has its mean.
        for place in quarters(cell, side) {
            around(from_square(place, up)).iter().for_each(|(node, weight)| row[*node] += 0.25 * weight);
        }
    }
    let sparse = |rows: &[[f32; NODES]]| -> Weights {
        let sparse = |row: &[f32; NODES]| row.iter().copied().enumerate().filter(|(_, x)| *x > 0.0).collect();
        rows.iter().map(sparse).collect()
    };
    Fit { means: sparse(&parts), nodes: sparse(&transposed(&parts)) }
});

impl Fit {
    /// The values at the nodes of a function on the sphere.
    pub(super) fn of(&self, function: impl Fn(Vec3) -> f32) -> [f32; NODES] {
        let mut means = [0.0; NODES];
        for (mean, (up, side, cell)) in means.iter_mut().zip(cells()) {
            *mean = quarters(cell, side).iter().map(|at| 0.25 * function(from_square(*at, up))).sum();
        }
        self.of_means(&means)
    }

    /// The same from its mean over each cell.
    pub(super) fn of_means(&self, means: &[f32; NODES]) -> [f32; NODES] {
        let sums = |weights: &Weights, of: &[f32; NODES]| -> [f32; NODES] {
            std::array::from_fn(|i| weights[i].iter().map(|(j, weight)| weight * of[*j]).sum())
        };
        let mut values = *means;
        for _ in 0..ROUNDS {
            let mut parts = sums(&self.means, &values);
            parts.iter_mut().zip(means).for_each(|(part, mean)| *part = ratio(*mean, *part));
            values.iter_mut().zip(sums(&self.nodes, &parts)).for_each(|(value, part)| *value *= part);
        }
        values
    }

    /// The same of a function of two directions, from its mean over each two cells: for each node of one, those of the other.
    pub(super) fn of_pairs(&self, means: &[[f32; NODES]]) -> Vec<[f32; NODES]> {
        let mut values = means.to_vec();
        for _ in 0..ROUNDS {
            let mut parts = of_both(&self.means, &values);
            let pairs = parts.as_flattened_mut().iter_mut().zip(means.as_flattened());
            pairs.for_each(|(part, mean)| *part = ratio(*mean, *part));
            let parts = of_both(&self.nodes, &parts);
            let pairs = values.as_flattened_mut().iter_mut().zip(parts.as_flattened());
            pairs.for_each(|(value, part)| *value *= part);
        }
        values
    }
}

/// Sums of a function of two directions over either.
fn of_both(weights: &Weights, of: &[[f32; NODES]]) -> Vec<[f32; NODES]> {
    let sums_of_rows = |of: &[[f32; NODES]]| -> Vec<[f32; NODES]> {
        let sum = |row: &Vec<(usize, f32)>| {
            let mut sum = [0.0; NODES];
            for (j, weight) in row {
                sum.iter_mut().zip(&of[*j]).for_each(|(sum, x)| *sum += weight * x);
            }
            sum
        };
        weights.iter().map(sum).collect()
    };
    transposed(&sums_of_rows(&transposed(&sums_of_rows(of))))
}

fn transposed(table: &[[f32; NODES]]) -> Vec<[f32; NODES]> {
    (0..NODES).map(|i| std::array::from_fn(|j| table[j][i])).collect()
}

/// What is wanted as a part of what there is.
fn ratio(wanted: f32, there: f32) -> f32 {
    if there > 0.0 { wanted / there } else { 0.0 }
}

/// The cells, each with the side of the surface that its hemisphere is on, how many are on each side of that, and its number there.
fn cells() -> impl Iterator<Item = (f32, usize, usize)> {
    SIDES.iter().zip([1.0, -1.0]).flat_map(|(&side, up)| (0..side * side).map(move |cell| (up, side, cell)))
}

/// The middles of a cell's quarters, on a square of so many cells on each side.
fn quarters(cell: usize, side: usize) -> [Vec2; 4] {
    let middle = cell_of_square(cell, side);
    [vec2(-0.5, -0.5), vec2(0.5, -0.5), vec2(-0.5, 0.5), vec2(0.5, 0.5)].map(|to| middle + to / side as f32)
}

/// A direction of each cell, anywhere in it.
pub(super) fn draw(random: &mut Random) -> [Vec3; NODES] {
    let mut directions = [Vec3::ZERO; NODES];
    for (direction, (up, side, cell)) in directions.iter_mut().zip(cells()) {
        *direction = from_square(within(cell, side, random), up);
    }
    directions
}

/// A direction of a cell of the upper hemisphere, anywhere in it.
pub(crate) fn direction_above(cell: usize, random: &mut Random) -> Vec3 {
    from_square(within(cell, SIDES[0], random), 1.0)
}

/// A point of a cell of the square, of so many on each side.
fn within(cell: usize, side: usize, random: &mut Random) -> Vec2 {
    cell_of_square(cell, side) + vec2(random.signed(), random.signed()) / side as f32
}

/// The solid angle of the cell that holds a direction.
pub(super) fn solid_angle(d: Vec3) -> f32 {
    let side = if d.z < 0.0 { SIDES[1] } else { SIDES[0] };
    // That of a place on the octahedron, whose sides are as far as 1/√3 from its middle: the square is twice as large as what lies below it.
    0.5 * (2.0 / side as f32).powi(2) * d.abs().element_sum().powi(3)
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

    /// The direction of each node.
    fn node(i: usize) -> Vec3 {
        let (i, side, up) = if i < UPPER { (i, SIDES[0], 1.0) } else { (i - UPPER, SIDES[1], -1.0) };
        from_square(cell_of_square(i, side), up)
    }

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
    fn what_is_aside_is_as_far_from_each_node_as_the_light_from_the_eye() {
        let random = &mut Random::new(6, 0);
        for _ in 0..1000 {
            // Far enough from the horizon for all nodes to be there.
            let mut place = || vec2(random.signed(), random.signed());
            let (at, step) = (0.5 * place(), 0.2 * place());
            let [eye, light] = [at, at + step].map(|at| from_square(at, 1.0));
            let each = aside(eye, light).expect("one hemisphere");
            for ((node, _), around) in around(eye).into_iter().zip(each) {
                let mean: Vec2 =
                    around.iter().map(|(i, weight)| *weight * cell_of_square(*i, SIDES[0])).sum();
                assert!((mean - cell_of_square(node, SIDES[0]) - step).length() < 1e-4);
            }
            // Where both are one, so are the nodes.
            let same = aside(eye, eye).expect("one hemisphere");
            for ((node, _), around) in around(eye).into_iter().zip(same) {
                assert!(around[0].0 == node && around[0].1 > 0.999);
            }
            assert!(aside(eye, -light).is_none());
        }
    }

    /// The root mean square difference.
    fn apart(a: &[f32], b: &[f32]) -> f32 {
        let sum: f32 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
        (sum / a.len() as f32).sqrt()
    }

    #[test]
    fn nothing_becomes_negative_and_means_come_nearer() {
        let random = &mut Random::new(4, 0);
        let values: [f32; NODES] = std::array::from_fn(|_| random.unit().powi(4));
        let means_of = |values: &[f32; NODES]| -> [f32; NODES] {
            std::array::from_fn(|i| FIT.means[i].iter().map(|(j, weight)| weight * values[*j]).sum())
        };
        let means = means_of(&values);
        let found = FIT.of_means(&means);
        assert!(found.iter().all(|x| *x >= 0.0));
        // Means taken for values are off by what a cell's mean has of its neighbours.
        assert!(apart(&means_of(&found), &means) < 0.7 * apart(&means_of(&means), &means));
        assert!(apart(&found, &values) < 0.9 * apart(&means, &values));
        // A constant is known at once, and what is a product of two functions stays one.
        assert!(apart(&FIT.of_means(&[2.0; NODES]), &[2.0; NODES]) < 1e-5);
        let cosine = |d: Vec3| Vec3::new(0.6, 0.0, 0.8).dot(d).max(0.0);
        let mut of_cosine = cells().map(|(up, side, cell)| {
            quarters(cell, side).iter().map(|at| 0.25 * cosine(from_square(*at, up))).sum::<f32>()
        });
        let of_cosine: [f32; NODES] = std::array::from_fn(|_| of_cosine.next().unwrap_or_default());
        let pairs = means.map(|a| of_cosine.map(|b| a * b));
        let (pairs, other) = (FIT.of_pairs(&pairs), FIT.of(cosine));
        for (row, a) in pairs.iter().zip(found) {
            assert!(apart(row, &other.map(|b| a * b)) < 1e-4);
        }
    }

    #[test]
    fn a_cosine_is_hardly_off_and_right_on_the_mean() {
        let random = &mut Random::new(5, 0);
        for _ in 0..20 {
            let n = random.direction();
            let fitted = FIT.of(|d| n.dot(d).max(0.0));
            for (up, most_off, most) in [(1.0, 0.003, 0.025), (-1.0, 0.006, 0.065)] {
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
                assert!(off.abs() < most_off && error < most, "{up}: {off} {error}");
            }
        }
    }
}
