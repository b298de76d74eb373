//! A box against a ray: where the ray is inside, in the scene and in the box's own coordinates.
//!
//! All faces are asked on the ray-space images of the box's corners ([`crate::wall`]). Each crossing says whether it
//! goes in or out, and the crossings of a closed surface cancel exactly, so sorting them by distance and counting
//! gives the intervals inside, however often a bent box is entered and left.

use core::ops::Deref;

use glam::{DVec3, Vec3};

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
    map: DTrilinear,
    prism: bool,
    /// The canonical order of each face, see [`wall::Order`].
    orders: [Order; 6],
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

    #[inline]
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

const CUBOID_CORNERS: u8 = 0b1111_1111;
/// D and H only complete a prism's map.
const PRISM_CORNERS: u8 = 0b0111_0111;

/// A crossing of the box's surface.
#[derive(Clone, Copy, Default)]
struct Crossing {
    t: f64,
    u: DVec3,
    /// 1 into the box, −1 out of it (the other way round in a mirrored box).
    step: i8,
}

/// The crossings of one ray, twelve at most.
struct Crossings {
    list: [Crossing; 2 * MOST_PASSAGES],
    count: usize,
}

impl Crossings {
    #[inline]
    fn push(&mut self, crossing: Crossing) {
        if let Some(slot) = self.list.get_mut(self.count) {
            *slot = crossing;
            self.count += 1;
        }
    }
}

/// A box's corners in ray space, and on which side of the ray they are, a bit each.
struct Seen {
    corners: [DVec3; 8],
    left: u8,
    right: u8,
    below: u8,
}

impl Seen {
    #[inline]
    fn new(map: &DTrilinear, frame: &RayFrame) -> Self {
        let mut seen = Self { corners: [DVec3::ZERO; 8], left: 0, right: 0, below: 0 };
        for (i, (place, corner)) in seen.corners.iter_mut().zip(&map.corners).enumerate() {
            *place = frame.project(*corner);
            seen.left |= u8::from(place.x < 0.0) << i;
            seen.right |= u8::from(place.x > 0.0) << i;
            seen.below |= u8::from(place.y < 0.0) << i;
        }
        seen
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

    /// Whether some of the corners of `mask` may lie between the distances, and all corners are finite.
    #[inline]
    fn is_between(&self, mask: u8, t_min: f64, t_max: f64) -> bool {
        let (mut before, mut behind, mut sum) = (0_u8, 0_u8, DVec3::ZERO);
        for (i, corner) in self.corners.iter().enumerate() {
            before |= u8::from(corner.z < t_min) << i;
            behind |= u8::from(corner.z > t_max) << i;
            sum += *corner;
        }
        before & mask != mask && behind & mask != mask && sum.is_finite()
    }
}

impl Hexahedron {
    /// The whole of the box `map`.
    pub fn cuboid(map: Trilinear) -> Self {
        Self::with_orders(map.into(), false)
    }

    /// The box between the triangles `base` = A, B, C and `top` = E, F, G: the part u + v ≤ 1 of the map that is
    /// completed to parallelograms, D = B + C − A and H = F + G − E. It is linear in (u, v) at each w.
    pub fn prism(base: [Vec3; 3], top: [Vec3; 3]) -> Self {
        let [a, b, c] = base.map(|p| p.as_dvec3());
        let [e, f, g] = top.map(|p| p.as_dvec3());
        Self::with_orders(DTrilinear::new([a, b, c, b + c - a], [e, f, g, f + g - e]), true)
    }

    fn with_orders(map: DTrilinear, prism: bool) -> Self {
        let mut orders = [Order::default(); 6];
        let faces: &[Quad] = if prism { &PRISM } else { &CUBOID };
        for (order, face) in orders.iter_mut().zip(faces) {
            *order = Order::canonical(&face.corners.map(|i| map.corners[i]));
        }
        Self { map, prism, orders }
    }

    /// The trilinear map. Of a prism only the half u + v ≤ 1 is the box.
    #[inline]
    pub fn map(&self) -> &DTrilinear {
        &self.map
    }

    /// Whether the box stands on a triangle.
    #[inline]
    pub fn is_prism(&self) -> bool {
        self.prism
    }

    /// The smallest and largest coordinates of the box, in scene units.
    pub fn bounds(&self) -> [DVec3; 2] {
        let corners = self.map.corners;
        let first = corners[0];
        self.corner_indices().fold([first; 2], |[lo, hi], i| [lo.min(corners[i]), hi.max(corners[i])])
    }

    /// Whether the scene point `x` lies in the box or on its surface, up to 1e-9 of its size.
    pub fn contains(&self, x: DVec3) -> bool {
        const TOLERANCE: f64 = 1e-9;
        self.map.inverse(x, TOLERANCE).is_ok_and(|u| !self.prism || u.x + u.y <= 1.0 + TOLERANCE)
    }

    fn corner_indices(&self) -> impl Iterator<Item = usize> {
        let mask = if self.prism { PRISM_CORNERS } else { CUBOID_CORNERS };
        (0..8).filter(move |i| mask >> i & 1 != 0)
    }

    /// The intervals of `ray` inside the box, cut to distances between `t_min` and `t_max`.
    ///
    /// A camera in the box gets a passage that starts at `t_min`. Where a passage ends on the surface, its
    /// coordinates are those of the wall's closed form; where it is cut they are found by inversion. Two boxes that
    /// share a face give the same bits for the distance of a crossing there. A box without volume has passages as
    /// long as rounding makes them, or none; one with corners that are not finite has none.
    pub fn passages(&self, ray: &Ray, t_min: f64, t_max: f64) -> Passages {
        self.passages_in(&RayFrame::new(ray), t_min, t_max)
    }

    /// As [`passages`](Self::passages), for a ray that is asked of many boxes.
    pub fn passages_in(&self, frame: &RayFrame, t_min: f64, t_max: f64) -> Passages {
        let mut passages = Passages::NONE;
        let ray = frame.ray();
        let seen = Seen::new(&self.map, frame);
        let all = if self.prism { PRISM_CORNERS } else { CUBOID_CORNERS };
        if seen.aside(all) || !seen.is_between(all, t_min, t_max) {
            return passages;
        }
        let mut crossings = Crossings { list: [Crossing::default(); 2 * MOST_PASSAGES], count: 0 };
        self.cross(&seen, &mut crossings);
        let Some(list) = crossings.list.get_mut(..crossings.count) else { return passages };
        list.sort_unstable_by(|x, y| x.t.total_cmp(&y.t));
        let mut depth = 0;
        for pair in list.windows(2) {
            let [enter, exit] = [&pair[0], &pair[1]];
            depth += enter.step;
            // A mirrored box counts downwards.
            let t = [enter.t.max(t_min), exit.t.min(t_max)];
            if depth != 0 && t[0] < t[1] {
                let end = |t, end: &Crossing| if t == end.t { end.u } else { self.cut(ray, t, enter, exit) };
                passages.push(Passage { t, u: [end(t[0], enter), end(t[1], exit)] });
            }
        }
        passages
    }

    /// All crossings of the box's surface, face by face.
    #[inline]
    fn cross(&self, seen: &Seen, crossings: &mut Crossings) {
        let faces: &[Quad] = if self.prism { &PRISM } else { &CUBOID };
        for (face, order) in faces.iter().zip(self.orders) {
            if seen.aside(face.mask) {
                continue;
            }
            let [a, b, c, d] = order.arrange(&face.corners);
            let corners = [seen.corners[a], seen.corners[b], seen.corners[c], seen.corners[d]];
            for &hit in wall::crossings(&corners).iter() {
                let WallHit { t, a, b, side } = order.restore(hit);
                let step = if face.outward { -side } else { side };
                crossings.push(Crossing { t, u: face.place.coordinates(a, b), step });
            }
        }
        if self.prism {
            for (w, &[a, b, c]) in CAPS.iter().enumerate() {
                let corners = [seen.corners[a], seen.corners[b], seen.corners[c]];
                if let Some((t, weights, side)) = wall::triangle_crossing(corners) {
                    let step = if w == 0 { side } else { -side };
                    crossings.push(Crossing { t, u: DVec3::new(weights.y, weights.z, w as f64), step });
                }
            }
        }
    }

    /// Box coordinates where the ray is at `t`, between two crossings.
    fn cut(&self, ray: &Ray, t: f64, enter: &Crossing, exit: &Crossing) -> DVec3 {
        const TOLERANCE: f64 = 1e-12;
        let chord = enter.u.lerp(exit.u, (t - enter.t) / (exit.t - enter.t));
        // The point is inside, so the inverse exists; a box that is singular there keeps the chord.
        let found = self.map.inverse_extended(ray.at(t), chord, TOLERANCE);
        found.unwrap_or(chord).clamp(DVec3::ZERO, DVec3::ONE)
    }
}
