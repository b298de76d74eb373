//! A disk laid flat: first with its angles kept as well as may be, then with its lengths.
//!
//! Least-squares conformal maps [LévyEtAl02] minimise the Dirichlet energy minus the area: a conformal map has none to
//! spare. They have no other parameter, cannot fold a triangle that need not be, but shrink what sticks out of the
//! plane. From there, steps *as rigid as possible* [LiuEtAl08] give triangles back their size: each is fitted by a
//! rotation, and then all are put together by least squares.

use glam::{DMat2, DVec2, DVec3};

use super::sheet::{Opened, Sheet};
use super::sparse::{Entry, Factor};

/// The least sine of an angle that a cotangent is taken of: beyond, a triangle is a needle, and would outweigh all
/// others.
const LEAST_SINE: f64 = 1e-5;

/// Most steps towards rigidity, which near the end gain little each.
const STEPS: usize = 30;

/// Steps end where the energy falls by less than this part of itself.
const STILL: f64 = 1e-3;

/// A triangle of an opened sheet.
pub(super) struct Triangle {
    pub vertices: [usize; 3],
    /// Its corners in a plane of their own, counter-clockwise; metres.
    pub flat: [DVec2; 3],
    /// The cotangents of its angles.
    cotangents: [f64; 3],
}

impl Triangle {
    fn new(vertices: [usize; 3], [a, b, c]: [DVec3; 3]) -> Self {
        let (side, across) = (b - a, c - a);
        let length = side.length().max(f64::MIN_POSITIVE);
        let along = across.dot(side) / length;
        let away = side.cross(across).length() / length;
        let flat = [DVec2::ZERO, DVec2::new(length, 0.0), DVec2::new(along, away)];
        let cotangents = [0, 1, 2].map(|k| {
            let (u, v) = (flat[(k + 1) % 3] - flat[k], flat[(k + 2) % 3] - flat[k]);
            u.dot(v) / u.perp_dot(v).max(LEAST_SINE * u.length() * v.length()).max(f64::MIN_POSITIVE)
        });
        Self { vertices, flat, cotangents }
    }

    pub fn area(&self) -> f64 {
        0.5 * self.flat[1].x * self.flat[2].y
    }

    /// The derivative of where it is laid by its own plane; the identity without area.
    pub fn jacobian(&self, laid: &[DVec2]) -> DMat2 {
        if self.area() <= 0.0 {
            return DMat2::IDENTITY;
        }
        let [a, b, c] = self.vertices.map(|v| laid[v]);
        let [fa, fb, fc] = self.flat;
        DMat2::from_cols(b - a, c - a) * DMat2::from_cols(fb - fa, fc - fa).inverse()
    }

    /// Its edges, each opposite the corner whose cotangent is its weight: two vertices, how they differ in its plane,
    /// the weight.
    fn edges(&self) -> [(usize, usize, DVec2, f64); 3] {
        [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (self.vertices[i], self.vertices[j], self.flat[j] - self.flat[i], 0.5 * self.cotangents[k])
        })
    }
}

/// The triangles of a sheet by the vertices of `opened`.
pub(super) fn triangles(sheet: &Sheet, opened: &Opened) -> Vec<Triangle> {
    let triangle = |corners: [usize; 3]| {
        let points = corners.map(|c| sheet.positions[sheet.vertices[c] as usize]);
        Triangle::new(corners.map(|c| opened.vertices[c] as usize), points)
    };
    sheet.triangles().into_iter().map(triangle).collect()
}

/// By vertex of a disk where it lies in the plane, in metres; `None` where numbers run out.
pub(super) fn flatten(sheet: &Sheet, opened: &Opened, triangles: &[Triangle]) -> Option<Vec<DVec2>> {
    let laid = conformal(sheet, opened, triangles)?;
    let laid = rigid(triangles, laid)?;
    laid.iter().all(|p| p.is_finite()).then_some(laid)
}

/// The least-squares conformal map with two far vertices of the rim held.
fn conformal(sheet: &Sheet, opened: &Opened, triangles: &[Triangle]) -> Option<Vec<DVec2>> {
    let n = opened.corners.len();
    let position = |v: usize| sheet.positions[sheet.vertices[opened.corners[v] as usize] as usize];
    let mut rim: Vec<usize> = sheet
        .half_edges()
        .filter(|&h| sheet.is_open(h))
        .flat_map(|h| [opened.vertices[h] as usize, opened.vertices[sheet.next(h)] as usize])
        .collect();
    rim.sort_unstable();
    rim.dedup();
    let farthest = |from: usize| {
        let far = |&&v: &&usize| position(v).distance_squared(position(from));
        rim.iter().filter(|&&v| v != from).max_by(|a, b| far(a).total_cmp(&far(b))).copied()
    };
    let one = farthest(*rim.first()?)?;
    let other = farthest(one)?;
    let held = [(one, DVec2::ZERO), (other, DVec2::new(position(one).distance(position(other)), 0.0))];

    // x of vertex v is unknown 2v, y is 2v + 1; those held go to the right-hand side.
    let mut known = vec![None; 2 * n];
    for (v, at) in held {
        (known[2 * v], known[2 * v + 1]) = (Some(at.x), Some(at.y));
    }
    let mut number = vec![usize::MAX; 2 * n];
    let mut count = 0;
    for i in (0..2 * n).filter(|&i| known[i].is_none()) {
        number[i] = count;
        count += 1;
    }
    let mut entries: Vec<Entry> = Vec::with_capacity(36 * triangles.len());
    let mut right = vec![0.0; count];
    let mut add = |i: usize, j: usize, value: f64| match (known[i], known[j]) {
        (None, None) => entries.push((number[i], number[j], value)),
        (None, Some(x)) => right[number[i]] -= value * x,
        _ => {}
    };
    for t in triangles {
        for (a, b, _, weight) in t.edges() {
            for axis in 0..2 {
                let (i, j) = (2 * a + axis, 2 * b + axis);
                for (i, j, value) in [(i, i, weight), (j, j, weight), (i, j, -weight), (j, i, -weight)] {
                    add(i, j, value);
                }
            }
            // Minus the area, ½ Σ (x_a y_b − x_b y_a).
            let (xa, ya, xb, yb) = (2 * a, 2 * a + 1, 2 * b, 2 * b + 1);
            for (i, j, value) in [(xa, yb, -0.5), (yb, xa, -0.5), (xb, ya, 0.5), (ya, xb, 0.5)] {
                add(i, j, value);
            }
        }
    }
    let found = Factor::new(count, entries)?.solve(&right);
    let value = |i: usize| known[i].unwrap_or_else(|| found[number[i]]);
    Some((0..n).map(|v| DVec2::new(value(2 * v), value(2 * v + 1))).collect())
}

/// Steps as rigid as possible from where everything is `laid`.
fn rigid(triangles: &[Triangle], mut laid: Vec<DVec2>) -> Option<Vec<DVec2>> {
    // The first vertex is held.
    let n = laid.len() - 1;
    let mut entries: Vec<Entry> = Vec::with_capacity(12 * triangles.len());
    for (a, b, _, weight) in triangles.iter().flat_map(Triangle::edges) {
        for (i, j, value) in [(a, a, weight), (b, b, weight), (a, b, -weight), (b, a, -weight)] {
            if i > 0 && j > 0 {
                entries.push((i - 1, j - 1, value));
            }
        }
    }
    let factor = Factor::new(n, entries)?;
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        let first = laid[0];
        laid.iter_mut().for_each(|p| *p -= first);
        let mut right = [vec![0.0; n], vec![0.0; n]];
        let mut energy = 0.0;
        for t in triangles {
            let edges = t.edges();
            // The rotation whose images of the edges are nearest: the argument of a sum of complex numbers.
            let sum: DVec2 = edges
                .iter()
                .map(|&(a, b, flat, weight)| {
                    let side = laid[b] - laid[a];
                    weight * DVec2::new(flat.dot(side), flat.perp_dot(side))
                })
                .sum();
            let turn = sum.try_normalize().unwrap_or(DVec2::X);
            for (a, b, flat, weight) in edges {
                let wanted = turn.rotate(flat);
                energy += weight * (laid[b] - laid[a] - wanted).length_squared();
                for (v, sign) in [(a, -weight), (b, weight)] {
                    if v > 0 {
                        right[0][v - 1] += sign * wanted.x;
                        right[1][v - 1] += sign * wanted.y;
                    }
                }
            }
        }
        if energy > (1.0 - STILL) * before {
            break;
        }
        before = energy;
        let [x, y] = right.map(|right| factor.solve(&right));
        for v in 0..n {
            laid[v + 1] = DVec2::new(x[v], y[v]);
        }
    }
    Some(laid)
}
