//! A box against a ray: where the ray is inside, in the scene and in the box's own coordinates.
//!
//! All faces are asked on the ray-space images of the box's corners ([`crate::wall`]), which most boxes that a ray
//! comes near leave nothing to be asked: they are beside it. The corners are kept in `f32`, by axis, so that the eight
//! go through registers together; in `f64` from there on. Each crossing says whether it
//! goes in or out, and the crossings of a closed surface cancel exactly, so sorting them by distance and counting
//! gives the intervals inside, however often a bent box is entered and left.

use core::ops::Deref;

use glam::{DVec3, Vec3};
use wide::f64x8;

use crate::wall::{self, Order, RayFrame};
use crate::{DTrilinear, Ray, Trilinear, WallHit};

/// A box on a patch: a trilinear cuboid, or the half of one that stands on a triangle.
///
/// ```
/// use pelage_geom::{Hexahedron, Ray, Trilinear, glam::DVec3};
///
/// let hexahedron = Hexahedron::cuboid(Trilinear::identity());
/// let ray = Ray { origin: DVec3::new(-1.0, 0.25, 0.5), direction: DVec3::X };
/// let passages = hexahedron.passages(&ray, 0.0, f64::INFINITY);
/// assert_eq!(passages[0].t, [1.0, 2.0]);
/// assert_eq!(passages[0].u[1], DVec3::new(1.0, 0.25, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hexahedron {
    /// By axis the coordinates of the corners A … H. Of a prism D is B again, and H is F, so that what holds for all
    /// eight holds for its own six.
    corners: [[f32; 8]; 3],
    /// The canonical order of each face, see [`wall::Order`].
    orders: [Order; 6],
    prism: bool,
}

/// One interval of a ray inside a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passage {
    /// Distances of entry and exit, in scene units, the first smaller.
    pub t: [f64; 2],
    /// Box coordinates there, in `[0,1]³`.
    pub u: [DVec3; 2],
}

/// The intervals of one ray in one box, by ascending distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passages {
    passages: [Passage; MOST_PASSAGES],
    count: usize,
}

/// Six faces are crossed at most twice each.
const MOST_PASSAGES: usize = 6;

impl Passages {
    const NONE: Self =
        Self { passages: [Passage { t: [0.0; 2], u: [DVec3::ZERO; 2] }; MOST_PASSAGES], count: 0 };

    fn push(&mut self, passage: Passage) {
        if let Some(slot) = self.passages.get_mut(self.count) {
            *slot = passage;
            self.count += 1;
        }
    }
}

impl Deref for Passages {
    type Target = [Passage];

    #[inline]
    fn deref(&self) -> &[Passage] {
        self.passages.get(..self.count).unwrap_or_default()
    }
}

/// A four-cornered face: corners P00, P10, P01, P11, and its place in the box.
struct Quad {
    corners: [usize; 4],
    /// The same corners as bits.
    mask: u8,
    place: Place,
    /// Whether ∂S/∂a × ∂S/∂b points out of the box.
    outward: bool,
}

impl Quad {
    const fn new(corners: [usize; 4], place: Place, outward: bool) -> Self {
        let [a, b, c, d] = corners;
        Self { corners, mask: 1 << a | 1 << b | 1 << c | 1 << d, place, outward }
    }
}

/// Where a face lies in box coordinates.
#[derive(Clone, Copy)]
enum Place {
    /// u_i = c, with (a, b) the next two coordinates in cyclic order.
    Axis(usize, f64),
    /// u + v = 1, with a = v and b = w.
    Diagonal,
}

impl Place {
    #[inline]
    fn coordinates(self, a: f64, b: f64) -> DVec3 {
        match self {
            Self::Axis(0, c) => DVec3::new(c, a, b),
            Self::Axis(1, c) => DVec3::new(b, c, a),
            Self::Axis(_, c) => DVec3::new(a, b, c),
            Self::Diagonal => DVec3::new(1.0 - a, a, b),
        }
    }
}

const U0: Quad = Quad::new([0, 2, 4, 6], Place::Axis(0, 0.0), false);
const U1: Quad = Quad::new([1, 3, 5, 7], Place::Axis(0, 1.0), true);
const V0: Quad = Quad::new([0, 4, 1, 5], Place::Axis(1, 0.0), false);
const V1: Quad = Quad::new([2, 6, 3, 7], Place::Axis(1, 1.0), true);
const W0: Quad = Quad::new([0, 1, 2, 3], Place::Axis(2, 0.0), false);
const W1: Quad = Quad::new([4, 5, 6, 7], Place::Axis(2, 1.0), true);
const DIAGONAL: Quad = Quad::new([1, 2, 5, 6], Place::Diagonal, true);

static CUBOID: [Quad; 6] = [U0, U1, V0, V1, W0, W1];
static PRISM: [Quad; 3] = [U0, V0, DIAGONAL];
/// Base and top of a prism.
const CAPS: [[usize; 3]; 2] = [[0, 1, 2], [4, 5, 6]];

/// A crossing of the box's surface.
#[derive(Clone, Copy, Default)]
struct Crossing {
    t: f64,
    u: DVec3,
    /// 1 into the box, −1 out of it (the other way round in a mirrored box).
    step: i8,
}

/// The crossings of one ray by ascending distance, twelve at most.
struct Crossings {
    list: [Crossing; 2 * MOST_PASSAGES],
    count: usize,
}

impl Crossings {
    const NONE: Self =
        Self { list: [Crossing { t: 0.0, u: DVec3::ZERO, step: 0 }; 2 * MOST_PASSAGES], count: 0 };

    /// Inserts a crossing where its distance puts it: there are hardly ever more than two.
    #[inline]
    fn insert(&mut self, crossing: Crossing) {
        let mut place = self.count.min(self.list.len() - 1);
        self.count = place + 1;
        while place > 0 && crossing.t < self.list[place - 1].t {
            self.list[place] = self.list[place - 1];
            place -= 1;
        }
        self.list[place] = crossing;
    }
}

/// Every corner of a box, a bit each.
const ALL: u8 = 0xff;

/// A box's corners in ray space, by coordinate, and on which side of the ray they are, a bit each.
struct Seen {
    x: f64x8,
    y: f64x8,
    z: f64x8,
    left: u8,
    right: u8,
    below: u8,
}

impl Seen {
    /// The corners, unless all of the box is beside the ray, before `t_min` or behind `t_max`, or some of it is not
    /// finite.
    #[inline]
    fn new(corners: &[[f32; 8]; 3], frame: &RayFrame, t_min: f64, t_max: f64) -> Option<Self> {
        let (origin, [x, y, z]) = (frame.ray().origin, corners);
        let from = |o: f64, list: &[f32; 8]| f64x8::new(widened(list)) - f64x8::splat(o);
        let (px, py, pz) = (from(origin.x, x), from(origin.y, y), from(origin.z, z));
        let along = |e: DVec3| f64x8::splat(e.x) * px + f64x8::splat(e.y) * py + f64x8::splat(e.z) * pz;
        let bits = |mask: f64x8| mask.to_bitmask() as u8;
        let [across_x, across_y, forward] = frame.axes();
        let (x, y) = (along(across_x), along(across_y));
        let (left, right) = (bits(x.simd_lt(f64x8::ZERO)), bits(x.simd_gt(f64x8::ZERO)));
        let below = bits(y.simd_lt(f64x8::ZERO));
        if left == ALL || right == ALL || below == ALL || below == 0 {
            return None;
        }
        let z = along(forward);
        let (before, behind) = (bits(z.simd_lt(f64x8::splat(t_min))), bits(z.simd_gt(f64x8::splat(t_max))));
        let meets = before != ALL && behind != ALL && z.reduce_add().is_finite();
        meets.then_some(Self { x, y, z, left, right, below })
    }

    /// Whether the corners of `mask` are all on one side, so that they cannot surround the ray: every winding number
    /// of theirs is exactly zero then.
    #[inline]
    fn aside(&self, mask: u8) -> bool {
        self.left & mask == mask
            || self.right & mask == mask
            || self.below & mask == mask
            || self.below & mask == 0
    }
}

#[inline]
fn widened(list: &[f32; 8]) -> [f64; 8] {
    let mut wide = [0.0; 8];
    for (to, from) in wide.iter_mut().zip(list) {
        *to = f64::from(*from);
    }
    wide
}

impl Hexahedron {
    /// The whole of the box `map`.
    pub fn cuboid(map: Trilinear) -> Self {
        Self::with_faces(map.corners, &CUBOID)
    }

    /// The box between the triangles `base` = A, B, C and `top` = E, F, G: the part u + v ≤ 1 of the map that is
    /// completed to parallelograms, D = B + C − A and H = F + G − E. It is linear in (u, v) at each w.
    pub fn prism([a, b, c]: [Vec3; 3], [e, f, g]: [Vec3; 3]) -> Self {
        Self { prism: true, ..Self::with_faces([a, b, c, b, e, f, g, f], &PRISM) }
    }

    fn with_faces(points: [Vec3; 8], faces: &[Quad]) -> Self {
        let mut orders = [Order::default(); 6];
        for (order, face) in orders.iter_mut().zip(faces) {
            *order = Order::canonical(&face.corners.map(|i| points[i].to_array()));
        }
        let mut corners = [[0.0; 8]; 3];
        for (i, point) in points.iter().enumerate() {
            (corners[0][i], corners[1][i], corners[2][i]) = (point.x, point.y, point.z);
        }
        Self { corners, orders, prism: false }
    }

    /// The trilinear map. Of a prism only the half u + v ≤ 1 is the box.
    #[inline]
    pub fn map(&self) -> DTrilinear {
        let [x, y, z] = &self.corners;
        let (x, y, z) = (widened(x), widened(y), widened(z));
        let mut corners = [DVec3::ZERO; 8];
        for (i, corner) in corners.iter_mut().enumerate() {
            *corner = DVec3::new(x[i], y[i], z[i]);
        }
        if self.prism {
            let [a, b, c, _, e, f, g, _] = corners;
            (corners[3], corners[7]) = (b + c - a, f + g - e);
        }
        DTrilinear { corners }
    }

    /// Whether the box stands on a triangle.
    #[inline]
    pub fn is_prism(&self) -> bool {
        self.prism
    }

    /// The smallest and largest coordinates of the box, in scene units.
    pub fn bounds(&self) -> [DVec3; 2] {
        [f32::min, f32::max].map(|pick| {
            DVec3::from_array(self.corners.map(|list| list.into_iter().reduce(pick).map_or(0.0, f64::from)))
        })
    }

    /// Whether the scene point `x` lies in the box or on its surface, up to 1e-9 of its size.
    pub fn contains(&self, x: DVec3) -> bool {
        const TOLERANCE: f64 = 1e-9;
        self.map().inverse(x, TOLERANCE).is_ok_and(|u| !self.prism || u.x + u.y <= 1.0 + TOLERANCE)
    }

    /// The intervals of `ray` inside the box, cut to distances between `t_min` and `t_max`.
    ///
    /// A camera in the box gets a passage that starts at `t_min`. Where a passage ends on the surface, its
    /// coordinates are those of the wall's closed form; where it is cut they are found by inversion. Two boxes that
    /// share a face give the same bits for the distance of a crossing there. A box without volume has passages as
    /// long as rounding makes them, or none; one with corners that are not finite has none.
    pub fn passages(&self, ray: &Ray, t_min: f64, t_max: f64) -> Passages {
        let mut passages = Passages::NONE;
        self.passages_in(&RayFrame::new(ray), t_min, t_max, |passage| passages.push(passage));
        passages
    }

    /// As [`passages`](Self::passages), for a ray that is asked of many boxes: calls `visit` for one passage after the
    /// other.
    #[inline]
    pub fn passages_in(&self, frame: &RayFrame, t_min: f64, t_max: f64, mut visit: impl FnMut(Passage)) {
        let Some(seen) = Seen::new(&self.corners, frame, t_min, t_max) else { return };
        let mut crossings = Crossings::NONE;
        self.cross(&seen, &mut crossings);
        let mut depth = 0;
        for pair in crossings.list[..crossings.count].windows(2) {
            let [enter, exit] = [&pair[0], &pair[1]];
            depth += enter.step;
            // A mirrored box counts downwards.
            let t = [enter.t.max(t_min), exit.t.min(t_max)];
            if depth != 0 && t[0] < t[1] {
                let end = |t, end: &Crossing| {
                    if t == end.t { end.u } else { self.cut(frame.ray(), t, enter, exit) }
                };
                visit(Passage { t, u: [end(t[0], enter), end(t[1], exit)] });
            }
        }
    }

    /// All crossings of the box's surface, face by face.
    #[inline]
    fn cross(&self, seen: &Seen, crossings: &mut Crossings) {
        let (x, y, z) = (seen.x.to_array(), seen.y.to_array(), seen.z.to_array());
        let corner = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let faces: &[Quad] = if self.prism { &PRISM } else { &CUBOID };
        for (face, order) in faces.iter().zip(self.orders) {
            if seen.aside(face.mask) {
                continue;
            }
            let [a, b, c, d] = order.arrange(&face.corners);
            wall::crossings(&[corner(a), corner(b), corner(c), corner(d)], |hit| {
                let WallHit { t, a, b, side } = order.restore(hit);
                let step = if face.outward { -side } else { side };
                crossings.insert(Crossing { t, u: face.place.coordinates(a, b), step });
            });
        }
        if self.prism {
            for (w, &[a, b, c]) in CAPS.iter().enumerate() {
                if let Some((t, weights, side)) = wall::triangle_crossing([corner(a), corner(b), corner(c)]) {
                    let step = if w == 0 { side } else { -side };
                    crossings.insert(Crossing { t, u: DVec3::new(weights.y, weights.z, w as f64), step });
                }
            }
        }
    }

    /// Box coordinates where the ray is at `t`, between two crossings.
    fn cut(&self, ray: &Ray, t: f64, enter: &Crossing, exit: &Crossing) -> DVec3 {
        // The last step squares what is left.
        const TOLERANCE: f64 = 1e-6;
        let chord = enter.u.lerp(exit.u, (t - enter.t) / (exit.t - enter.t));
        // The point is inside, so the inverse exists; a box that is singular there keeps the chord.
        let found = self.map().inverse_extended(ray.at(t), chord, TOLERANCE);
        found.unwrap_or(chord).clamp(DVec3::ZERO, DVec3::ONE)
    }
}
