//! Operations that look at one vertex at a time.

use glam::{DVec3, Vec2, Vec3};
use noise::{NoiseFn, Perlin};

use super::operation::{Comb, Field, Noise, Operation, Part, Plane, Swirl, Tilt, Turn, Wind};

/// A vertex of a skin, as an operation sees it.
#[derive(Clone, Copy)]
pub(super) struct Strand {
    /// Where it stands.
    pub foot: Vec3,
    /// The surface's unit normal there.
    pub normal: Vec3,
    /// From there to where it reaches.
    pub vector: Vec3,
    /// The direction on the surface that a field by texture coordinates has there.
    pub along_uv: Vec3,
    /// How much of the operation it gets, in (0, 1].
    pub weight: f32,
}

impl Strand {
    /// The part of a vector that lies in the surface.
    fn flat(&self, v: Vec3) -> Vec3 {
        v - v.dot(self.normal) * self.normal
    }

    /// Leant over by the part of `lean` that lies in the surface, as long as before.
    fn leant(&self, lean: Vec3) -> Vec3 {
        let length = self.vector.length();
        let upright = self.vector.normalize_or_zero();
        length * (upright + self.weight * self.flat(lean)).normalize_or(upright)
    }

    fn lengthened(&self, factor: f32) -> Vec3 {
        self.vector * (1.0 + self.weight * (factor - 1.0))
    }
}

/// Gives a vertex its new vector.
pub(super) type ByVertex<'a> = Box<dyn Fn(&Strand) -> Vec3 + Sync + 'a>;

/// What an operation does to each vertex; `shortest` is the least fraction of a length that is left. `None` for an
/// operation that looks at more than one vertex, or does not change vectors.
pub(super) fn by_vertex(operation: &Operation, shortest: f32) -> Option<ByVertex<'_>> {
    Some(match operation {
        Operation::Scale(factor) => Box::new(|s| s.lengthened(*factor)),
        &Operation::Height(height) => Box::new(move |s| {
            let length = s.vector.length();
            if length > 0.0 { s.lengthened(height / length) } else { s.weight * height * s.normal }
        }),
        Operation::Move(by) => Box::new(|s| s.vector + s.weight * *by),
        Operation::Gravity(strength) => Box::new(|s| s.leant(*strength * Vec3::NEG_Y)),
        Operation::Tilt(Tilt { towards, angle }) => {
            let (towards, angle) = (towards.normalize(), angle.to_radians());
            Box::new(move |s| s.vector.rotate_towards(towards, s.weight * angle))
        }
        Operation::Turn(Turn { axis, angle }) => {
            let (axis, angle) = (axis.normalize(), angle.to_radians());
            Box::new(move |s| s.vector.rotate_axis(axis, s.weight * angle))
        }
        Operation::Comb(comb) => Box::new(|s| combed(comb, s)),
        Operation::Part(part) => {
            let (across, tangent) = (part.across.normalize(), part.angle.to_radians().tan());
            Box::new(move |s| s.leant(tangent * parting(part, across, s.foot) * across))
        }
        Operation::Swirl(swirl) => {
            let axis = swirl.axis.normalize();
            Box::new(move |s| s.leant(whorl(swirl, axis, s.foot)))
        }
        Operation::Noise(noise) => {
            let fields = [0, 1, 2, 3].map(|i| Perlin::new(noise.seed.wrapping_mul(4).wrapping_add(i)));
            Box::new(move |s| disordered(noise, &fields, s))
        }
        Operation::Wind(wind) => {
            let (direction, gusts) = (wind.direction.normalize(), Perlin::new(wind.seed));
            Box::new(move |s| s.leant(blown(wind, direction, &gusts, s.foot) * direction))
        }
        Operation::Trim(plane) => {
            let normal = plane.normal.normalize();
            Box::new(move |s| s.lengthened(trimmed(plane, normal, shortest, s)))
        }
        Operation::Clump(_) | Operation::Smooth(_) | Operation::Density(_) => return None,
    })
}

fn combed(comb: &Comb, s: &Strand) -> Vec3 {
    let field = match &comb.along {
        Field::Vector(v) => v.normalize(),
        Field::Curve(points) => along_curve(points, s.foot),
        Field::Uv(_) => s.along_uv,
        Field::AwayFrom(p) => (s.foot - *p).normalize_or_zero(),
    };
    let target = s.normal + comb.angle.to_radians().tan() * s.flat(field);
    if target == Vec3::ZERO || s.vector == Vec3::ZERO {
        return s.vector;
    }
    s.vector.rotate_towards(target.normalize(), s.weight * s.vector.angle_between(target))
}

/// The direction of a curve where it is nearest to a point. Within a piece it changes evenly from the mean at its
/// first end to that at its last, so that strands do not part at the bends.
fn along_curve(points: &[Vec3], at: Vec3) -> Vec3 {
    let piece = |i: usize| (points[i + 1] - points[i]).normalize_or_zero();
    let last = points.len() - 2;
    let mut nearest = (f32::INFINITY, Vec3::ZERO);
    for (i, ends) in points.windows(2).enumerate() {
        let side = ends[1] - ends[0];
        if side == Vec3::ZERO {
            continue;
        }
        let x = ((at - ends[0]).dot(side) / side.length_squared()).clamp(0.0, 1.0);
        let distance = at.distance_squared(ends[0] + x * side);
        if distance < nearest.0 {
            let before = if i > 0 { piece(i - 1) } else { piece(i) };
            let after = if i < last { piece(i + 1) } else { piece(i) };
            let ends = [piece(i) + before, piece(i) + after].map(Vec3::normalize_or_zero);
            nearest = (distance, ends[0].lerp(ends[1], x).normalize_or(piece(i)));
        }
    }
    nearest.1
}

/// From −1 to 1: on which side of a parting, and how near.
fn parting(part: &Part, across: Vec3, at: Vec3) -> f32 {
    let x = (at - part.point).dot(across);
    let beyond = ((x.abs() - part.width) / (part.reach - part.width)).clamp(0.0, 1.0);
    smooth_step((x.abs() / part.width).min(1.0)) * smooth_step(1.0 - beyond) * x.signum()
}

/// The lean of a whorl: none in its centre, full at half its radius, none beyond it.
fn whorl(swirl: &Swirl, axis: Vec3, at: Vec3) -> Vec3 {
    let arm = at - swirl.centre;
    let outwards = arm - arm.dot(axis) * axis;
    let x = 2.0 * outwards.length() / swirl.radius;
    let outwards = outwards.normalize_or_zero();
    let strength = smooth_step(if x < 1.0 { x } else { (2.0 - x).max(0.0) });
    let turn = Vec2::from_angle(swirl.pitch.to_radians());
    swirl.angle.to_radians().tan() * strength * (turn.x * outwards + turn.y * axis.cross(outwards))
}

fn disordered(noise: &Noise, fields: &[Perlin; 4], s: &Strand) -> Vec3 {
    let at = (s.foot.as_dvec3() / f64::from(noise.size)).to_array();
    let [length, x, y, z] = fields.each_ref().map(|field| field.get(at) as f32);
    let vector = s.leant(noise.tilt.to_radians().tan() * Vec3::new(x, y, z));
    vector * (1.0 + s.weight * noise.height * length)
}

/// The strength of the wind at a place: gusts are a pattern that it carries along.
fn blown(wind: &Wind, direction: Vec3, gusts: &Perlin, at: Vec3) -> f32 {
    let carried: DVec3 = f64::from(wind.speed) * f64::from(wind.time) * direction.as_dvec3();
    let place = (at.as_dvec3() - carried) / f64::from(wind.size);
    wind.strength * (1.0 + wind.gust * gusts.get(place.to_array()) as f32).max(0.0)
}

/// The part of a strand that is left by a cut.
fn trimmed(plane: &Plane, normal: Vec3, shortest: f32, s: &Strand) -> f32 {
    let below = (plane.point - s.foot).dot(normal);
    let rise = s.vector.dot(normal);
    if rise <= below {
        return 1.0;
    }
    // Beyond the plane with its foot, or nearly so: as little as a box needs.
    if rise > 0.0 { (below / rise).max(shortest) } else { shortest }
}

fn smooth_step(x: f32) -> f32 {
    x * x * (3.0 - 2.0 * x)
}
