//! The curve that a straight ray is in texel space, in chords whose ends lie on it.
//!
//! Between two knots the curve is predicted by the cubic through both ends with their velocities J⁻¹D; its
//! largest second derivative bounds the bow of each chord, and so how many are needed. Knots are then put on the ray by
//! Newton's method, which takes one step, seldom two; between knots so near that the cubic is the curve, as good as,
//! chords end on the cubic. [seed §5.1, Ogaki23]

use glam::{DVec3, Mat3, Vec2, Vec3};
use pelage_geom::{Ray, Trilinear};
use pelage_skin::Lattice;

use super::passages::BoxPassage;

/// A chord never splits into more than this many: beyond, a fold or a singular corner is the reason, not a curve.
const MAX_CHORDS: usize = 256;

/// A piece is halved at most this often: its bow falls fourfold each time, unless it is no curve.
const MOST_HALVINGS: usize = 5;

/// A ray in the frame of one box: everything near zero, so that single precision is enough.
pub(crate) struct LocalRay {
    map: Trilinear,
    origin: DVec3,
    ray: Ray,
    direction: Vec3,
    lattice: Lattice,
    /// From texel steps to box steps.
    inverse_lattice: Mat3,
}

/// Where a ray enters or leaves a box.
pub(crate) struct End {
    knot: Knot,
    /// From box steps to scene steps.
    jacobian: Mat3,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Knot {
    /// Distance along the ray, in scene units.
    pub t: f64,
    /// Texel coordinates.
    pub at: Vec3,
    /// Box coordinates.
    u: Vec3,
    /// J⁻¹D: box units per scene unit.
    velocity: Vec3,
}

/// Newton's error is about the square of its last step: below this step, in box units, it is that of rounding.
const CONVERGED: f32 = 1e-3;

/// A cubic that is off by less than this part of the tolerance is the curve.
const OFF_CUBIC: f32 = 0.1;

/// A straight piece of the path, linear in t.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    pub t: [f64; 2],
    /// Texel coordinates of its ends.
    pub at: [Vec3; 2],
}

impl Chord {
    /// Distances at fractions of it, in scene units.
    pub fn distances(&self, range: [f32; 2]) -> [f64; 2] {
        let [a, b] = self.t;
        [a + (b - a) * f64::from(range[0]), a + (b - a) * f64::from(range[1])]
    }

    /// Texel coordinates at fractions of it.
    pub fn points(&self, range: [f32; 2]) -> [Vec3; 2] {
        let [a, b] = self.at;
        [a.lerp(b, range[0]), a.lerp(b, range[1])]
    }
}

impl LocalRay {
    /// The frame of the box whose corners are `map` (scene space), with the texel laid out by `lattice`.
    pub fn new(map: &pelage_geom::DTrilinear, lattice: Lattice, ray: &Ray) -> Self {
        let origin = map.corners[0];
        let mut local = Trilinear { corners: [Vec3::ZERO; 8] };
        for (near, far) in local.corners.iter_mut().zip(&map.corners) {
            *near = (far - origin).as_vec3();
        }
        let direction = ray.direction.as_vec3();
        Self { map: local, origin, ray: *ray, direction, lattice, inverse_lattice: lattice_inverse(&lattice) }
    }

    /// Where a passage begins (0) or ends (1).
    pub fn end(&self, passage: &BoxPassage, which: usize) -> End {
        let u = passage.u[which].as_vec3();
        let jacobian = self.map.jacobian(u);
        End { knot: self.knot(passage.t[which], u, jacobian.inverse()), jacobian }
    }

    /// The Jacobian from texel steps to scene steps.
    pub fn texel_jacobian(&self, end: &End) -> Mat3 {
        end.jacobian * self.inverse_lattice
    }

    /// Direction of the ray, scene space.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Splits a passage into chords that leave the curve by at most `tolerance` (texel units). They are appended to
    /// `out`, front to back.
    pub fn chords(&self, ends: &[End; 2], tolerance: f32, out: &mut Vec<Chord>) {
        let [first, last] = [ends[0].knot, ends[1].knot];
        let Some(bow) = self.bow(&first, &last) else {
            // A singular end has no velocity: the chord is all that can be known.
            out.push(chord(&first, &last));
            return;
        };
        let count = chords_needed(bow, tolerance);
        if count == 1 {
            out.push(chord(&first, &last));
            return;
        }
        let pieces = self.pieces_needed(&first, &last, count, tolerance);
        let (mut from, mut done) = (first, 0);
        for i in 1..=pieces {
            let next = i * count / pieces;
            let x = next as f32 / count as f32;
            let to = if i == pieces { last } else { self.between(&first, &last, x) };
            let each = next - done;
            // Unless its own ends say that it bows more than the whole passage's foretold.
            let as_foretold = |bow| bow <= 2.0 * tolerance * (each * each) as f32;
            if each > 1 && self.bow(&from, &to).is_some_and(as_foretold) {
                self.along_cubic(&from, &to, each, out);
            } else {
                self.refine(from, to, tolerance, out);
            }
            (from, done) = (to, next);
        }
    }

    /// How many pieces of the curve are cubics, as good as, if it is to be cut into `count` chords.
    fn pieces_needed(&self, first: &Knot, last: &Knot, count: usize, tolerance: f32) -> usize {
        if count < 3 {
            return count;
        }
        // Where a cubic is off as a rule, whether the curve bends more in its middle or towards an end.
        let x = 1.0 / 3.0;
        let foretold = cubic(first, last, x);
        let off = self.on_ray(distance(first, last, x), foretold).u - foretold;
        let off = to_texel_step(&self.lattice, off).length();
        // n pieces are off n⁴ times less than one.
        let pieces = (off / (OFF_CUBIC * tolerance)).sqrt().sqrt().ceil() as usize;
        if 2 * pieces > count { count } else { pieces.max(1) }
    }

    /// Splits a piece that is a cubic, as good as, into chords.
    fn along_cubic(&self, a: &Knot, b: &Knot, count: usize, out: &mut Vec<Chord>) {
        let mut from = (a.t, a.at);
        for i in 1..count {
            let x = i as f32 / count as f32;
            let u = cubic(a, b, x).clamp(Vec3::ZERO, Vec3::ONE);
            let to = (distance(a, b, x), to_texel(&self.lattice, u));
            out.push(Chord { t: [from.0, to.0], at: [from.1, to.1] });
            from = to;
        }
        out.push(Chord { t: [from.0, b.t], at: [from.1, b.at] });
    }

    /// The straight line from entry to exit: the paper's *parcours linéaire*.
    pub fn straight(&self, [first, last]: &[End; 2]) -> Chord {
        chord(&first.knot, &last.knot)
    }

    /// Halves the piece, at most [`MOST_HALVINGS`] times, while its own ends say that it bows more than the whole
    /// passage's ends foretold.
    fn refine(&self, from: Knot, to: Knot, tolerance: f32, out: &mut Vec<Chord>) {
        // The ends of pieces still to come, nearest last, and how often each piece has been halved.
        let mut pending = [(to, 0); MOST_HALVINGS + 1];
        let (mut from, mut last) = (from, 0);
        loop {
            let (to, halved) = pending[last];
            // Twice the tolerance: the first count is a bound and seldom far off; near misses are not worth a knot.
            let bends = halved < MOST_HALVINGS && self.bow(&from, &to).is_some_and(|b| b > 2.0 * tolerance);
            if bends {
                pending[last].1 = halved + 1;
                last += 1;
                pending[last] = (self.between(&from, &to, 0.5), halved + 1);
                continue;
            }
            out.push(chord(&from, &to));
            from = to;
            if last == 0 {
                return;
            }
            last -= 1;
        }
    }

    /// The point of the curve at the fraction `x` between two knots.
    fn between(&self, a: &Knot, b: &Knot, x: f32) -> Knot {
        self.on_ray(distance(a, b, x), cubic(a, b, x))
    }

    /// The knot at a distance along the ray, found from a guess.
    fn on_ray(&self, t: f64, guess: Vec3) -> Knot {
        let target = (self.ray.origin - self.origin + t * self.ray.direction).as_vec3();
        let mut u = guess;
        let mut inverse = Mat3::ZERO;
        for _ in 0..3 {
            inverse = self.map.jacobian(u).inverse();
            let step = inverse * (target - self.map.point(u));
            if !step.is_finite() {
                break;
            }
            u += step;
            if step.abs().max_element() < CONVERGED {
                break;
            }
        }
        // The inverse is that of a step before: near enough for a velocity, which only predicts.
        self.knot(t, u.clamp(Vec3::ZERO, Vec3::ONE), inverse)
    }

    fn knot(&self, t: f64, u: Vec3, inverse: Mat3) -> Knot {
        Knot { t, at: to_texel(&self.lattice, u), u, velocity: inverse * self.direction }
    }

    /// How far the chord between two knots leaves the curve at most, in texel units: an eighth of the largest
    /// second derivative of Hermite's cubic over the unit interval, which lies at one of its ends.
    fn bow(&self, a: &Knot, b: &Knot) -> Option<f32> {
        let span = (b.t - a.t) as f32;
        let (va, vb, d) = (span * a.velocity, span * b.velocity, b.u - a.u);
        let [at_a, at_b] = [6.0 * d - 4.0 * va - 2.0 * vb, 2.0 * va + 4.0 * vb - 6.0 * d];
        let length = |x: Vec3| to_texel_step(&self.lattice, x).length_squared();
        let largest = length(at_a).max(length(at_b)).sqrt();
        largest.is_finite().then_some(largest / 8.0)
    }
}

/// The distance at the fraction `x` between two knots.
fn distance(a: &Knot, b: &Knot, x: f32) -> f64 {
    a.t + (b.t - a.t) * f64::from(x)
}

/// The point there, in box coordinates, on Hermite's cubic: exact where the curve is one, and close enough to start from.
fn cubic(a: &Knot, b: &Knot, x: f32) -> Vec3 {
    let span = (b.t - a.t) as f32;
    let (va, vb) = (span * a.velocity, span * b.velocity);
    let (y, z) = (1.0 - x, x * x * (3.0 - 2.0 * x));
    let guess = a.u.lerp(b.u, z) + x * y * (y * va - x * vb);
    if guess.is_finite() { guess } else { a.u.lerp(b.u, x) }
}

fn chord(a: &Knot, b: &Knot) -> Chord {
    Chord { t: [a.t, b.t], at: [a.at, b.at] }
}

/// k chords bow k² times less than one.
fn chords_needed(bow: f32, tolerance: f32) -> usize {
    (bow / tolerance.max(f32::MIN_POSITIVE)).sqrt().ceil().clamp(1.0, MAX_CHORDS as f32) as usize
}

/// Texel coordinates (s, t, w) of box coordinates.
#[inline]
pub(crate) fn to_texel(lattice: &Lattice, u: Vec3) -> Vec3 {
    (lattice.origin + u.x * lattice.u + u.y * lattice.v).extend(u.z)
}

#[inline]
fn to_texel_step(lattice: &Lattice, d: Vec3) -> Vec3 {
    (d.x * lattice.u + d.y * lattice.v).extend(d.z)
}

/// Box coordinates of texel coordinates.
pub(crate) fn to_box(lattice: &Lattice, at: Vec3) -> Vec3 {
    let d = at.truncate() - lattice.origin;
    let area = lattice.u.perp_dot(lattice.v);
    let solve = |a: Vec2, b: Vec2| if area == 0.0 { 0.0 } else { a.perp_dot(b) / area };
    Vec3::new(solve(d, lattice.v), solve(lattice.u, d), at.z)
}

/// The matrix from texel steps to box steps.
pub(crate) fn lattice_inverse(lattice: &Lattice) -> Mat3 {
    Mat3::from_cols(lattice.u.extend(0.0), lattice.v.extend(0.0), Vec3::Z).inverse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_geom::{Hexahedron, Ray};

    fn chords_of(map: Trilinear, ray: &Ray, tolerance: f32) -> Vec<Chord> {
        let hexahedron = Hexahedron::cuboid(map);
        let local = LocalRay::new(&hexahedron.map(), Lattice::UNIT, ray);
        let mut out = vec![];
        for passage in hexahedron.passages(ray, 0.0, f64::INFINITY).iter() {
            let passage = BoxPassage { patch: 0, t: passage.t, u: passage.u };
            local.chords(&[local.end(&passage, 0), local.end(&passage, 1)], tolerance, &mut out);
        }
        out
    }

    fn random(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1 << 24) as f32
    }

    #[test]
    fn chords_abut_and_keep_to_the_curve() {
        // The unit cube with each corner pulled by up to 0.2: points of a chord, mapped back to the scene, must lie
        // as near to the ray as the tolerance says, in units of the box (its sides are about 1).
        let state = &mut 3;
        for _ in 0..500 {
            let mut map = Trilinear::identity();
            for corner in &mut map.corners {
                *corner += 0.4 * (Vec3::new(random(state), random(state), random(state)) - 0.5);
            }
            let target = DVec3::new(random(state).into(), random(state).into(), random(state).into());
            let away = DVec3::new(random(state).into(), random(state).into(), random(state).into()) - 0.5;
            let ray = Ray { origin: target + 4.0 * away.normalize(), direction: -away.normalize() };
            let tolerance = 0.002;
            let chords = chords_of(map, &ray, tolerance);
            for pair in chords.windows(2) {
                assert!(pair[0].t[1] <= pair[1].t[0]);
            }
            for chord in &chords {
                for x in [0.0, 0.25, 0.5, 0.75, 1.0] {
                    let t = chord.t[0] + (chord.t[1] - chord.t[0]) * f64::from(x);
                    let at = map.point(chord.at[0].lerp(chord.at[1], x));
                    let off = (at.as_dvec3() - ray.at(t)).length() as f32;
                    assert!(off < 3.0 * tolerance, "{off} off the ray");
                }
            }
        }
    }

    #[test]
    fn boxes_that_are_no_curve_end() {
        // Collapsed, folded and nearly flat boxes: a bounded number of chords, all finite, whatever they are worth.
        let state = &mut 11;
        let mut most = 0;
        for i in 0..20_000 {
            let mut map = Trilinear::identity();
            let flat = [0.0, 1e-7, 1e-3, 1.0][i % 4];
            for corner in &mut map.corners {
                *corner += 1.6 * (Vec3::new(random(state), random(state), random(state)) - 0.5);
                corner.z *= flat;
            }
            if i % 3 == 0 {
                map.corners[7] = map.corners[6];
            }
            let target = 0.5 * (map.corners[0] + map.corners[7]);
            let away = DVec3::new(random(state).into(), random(state).into(), random(state).into()) - 0.5;
            let ray =
                Ray { origin: target.as_dvec3() + 4.0 * away.normalize(), direction: -away.normalize() };
            let chords = chords_of(map, &ray, 1e-4);
            assert!(chords.iter().all(|c| c.at.iter().all(|p| p.is_finite())));
            most = most.max(chords.len());
        }
        assert!(most <= (6 * MAX_CHORDS) << MOST_HALVINGS);
    }
}
