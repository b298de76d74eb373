//! What carries texel content into one box: the lattice, then the trilinear map, and nothing else of it.

use std::ops::Range;

use glam::{DMat2, DMat3, DVec2, DVec3, Vec3, Vec3A};
use pelage_geom::{DTrilinear, Hexahedron};
use pelage_skin::Lattice;

use super::polygon::{Polygon, doubled_area};
use crate::variety::Tile;

/// Copies of the texel: columns in s, rows in t.
pub(super) type Copies = [Range<i32>; 2];

/// Carries triangles from texel coordinates into a box.
pub(super) struct Carrier {
    /// The middle of the box, in the scene: what its own frame is relative to.
    pub centre: DVec3,
    /// Half the diagonal of its bounds, in scene units.
    pub radius: f64,
    /// The trilinear map, in the box's own frame.
    map: DTrilinear,
    /// The same corners, for bounds.
    corners: [Vec3A; 8],
    prism: bool,
    lattice_origin: DVec2,
    /// From texel coordinates, less the origin, to box coordinates.
    to_box: DMat2,
    /// Back from them.
    to_texel: DMat2,
    /// Bounds of |∂²T/∂u∂v|, |∂²T/∂u∂w| and |∂²T/∂v∂w|, in scene units.
    bends: DVec3,
    /// How far a carried triangle may be from its curved image, in scene units.
    tolerance: f64,
    /// What bounds are widened by against the rounding of `f32`, in scene units.
    margin: Vec3A,
    /// Copies of the texel that reach into the patch.
    pub copies: Copies,
}

impl Carrier {
    /// Triangles are never cut finer than this part of the box's radius: below it nothing is seen, and a box around
    /// the eye would ask for any fineness.
    const FINEST: f64 = 1e-5;

    /// Halvings of a triangle at most: enough for [`Carrier::FINEST`] of any box, in both directions.
    const MOST_HALVINGS: u32 = 24;

    /// Content may fill every copy that reaches into the patch, or only the copy (0, 0).
    pub(super) fn new(hexahedron: &Hexahedron, lattice: &Lattice, every_copy: bool, tolerance: f64) -> Self {
        let map = hexahedron.map();
        let own =
            if hexahedron.is_prism() { [0, 1, 2, 4, 5, 6].as_slice() } else { &[0, 1, 2, 3, 4, 5, 6, 7] };
        let [lo, hi] = own.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], &i| {
            [lo.min(map.corners[i]), hi.max(map.corners[i])]
        });
        let centre = 0.5 * (lo + hi);
        let radius = 0.5 * (hi - lo).length();
        let map = DTrilinear { corners: map.corners.map(|c| c - centre) };
        let c = &map.corners;
        let bend = |faces: [[usize; 4]; 2]| {
            faces.iter().map(|&[p, q, r, s]| (c[p] - c[q] - c[r] + c[s]).length()).fold(0.0, f64::max)
        };
        let bends = DVec3::new(
            bend([[0, 1, 2, 3], [4, 5, 6, 7]]),
            bend([[0, 1, 4, 5], [2, 3, 6, 7]]),
            bend([[0, 2, 4, 6], [1, 3, 5, 7]]),
        );
        let to_texel = DMat2::from_cols(lattice.u.as_dvec2(), lattice.v.as_dvec2());
        let lattice_origin = lattice.origin.as_dvec2();
        let ends: &[DVec2] = &[DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let reached = ends[..if hexahedron.is_prism() { 3 } else { 4 }]
            .iter()
            .map(|&uv| lattice_origin + to_texel * uv)
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[lo, hi], p| [lo.min(p), hi.max(p)]);
        let copies = [0, 1].map(|axis| {
            let whole = reached[0][axis].floor() as i32..reached[1][axis].ceil() as i32;
            if every_copy { whole } else { whole.start.max(0)..whole.end.min(1) }
        });
        Self {
            corners: map.corners.map(|c| c.as_vec3a()),
            // Sixteen units in the last place: the bounds' own rounding, and the triangles'.
            margin: Vec3A::splat((16.0 * f64::from(f32::EPSILON) * radius) as f32),
            tolerance: tolerance.max(Self::FINEST * radius),
            prism: hexahedron.is_prism(),
            to_box: to_texel.inverse(),
            to_texel,
            centre,
            radius,
            map,
            lattice_origin,
            bends,
            copies,
        }
    }

    /// T at box coordinates, in the box's own frame.
    pub(super) fn point(&self, u: DVec3) -> DVec3 {
        self.map.point(u)
    }

    /// Box coordinates of a point of a copy.
    pub(super) fn in_box(&self, tile: &Tile, p: DVec3) -> DVec3 {
        let p = tile.outside(p);
        (self.to_box * (p.truncate() - self.lattice_origin)).extend(p.z)
    }

    /// Texel coordinates of a point of the box, in a copy.
    pub(super) fn in_texel(&self, tile: &Tile, u: DVec3) -> DVec3 {
        tile.inside((self.to_texel * u.truncate() + self.lattice_origin).extend(u.z))
    }

    /// Whether box coordinates lie in the box.
    pub(super) fn holds(&self, u: DVec3) -> bool {
        let far = if self.prism { u.x + u.y } else { u.max_element() };
        u.cmpge(DVec3::ZERO).all() && far <= 1.0 && u.z <= 1.0
    }

    /// What a step along each axis of a copy's texel moves in the scene, at box coordinates: T is linear along each box
    /// coordinate, so differences from end to end are exact.
    pub(super) fn tangents(&self, tile: &Tile, u: DVec3) -> DMat3 {
        let [along_u, along_v, along_w] =
            [0, 1, 2].map(|axis| self.point(with(u, axis, 1.0)) - self.point(with(u, axis, 0.0)));
        let [s, t] = [self.to_box.x_axis, self.to_box.y_axis].map(|step| step.x * along_u + step.y * along_v);
        tile.carried(DMat3::from_cols(s, t, along_w))
    }

    /// The unit normal, either side, of the curved image of a triangle of a copy at box coordinates; `None` where the
    /// image has no area.
    ///
    /// Along the triangle's plane T is a cubic, whose tangents central differences give but for their third derivative.
    pub(super) fn normal(&self, at: DVec3, tile: &Tile, corners: &[DVec3; 3]) -> Option<Vec3> {
        // Texel units: differences lose a millionth to the cubic's curvature, and 10⁻¹² to rounding.
        const STEP: f64 = 1e-4;
        let [a, b, c] = corners.map(|p| self.in_box(tile, p));
        let tangent = |along: DVec3| {
            let step = STEP * along.normalize_or_zero();
            self.point(at + step) - self.point(at - step)
        };
        tangent(b - a).cross(tangent(c - a)).try_normalize().map(|n| n.as_vec3())
    }

    /// Bounds of what lies between the texel coordinates `lo` and `hi` of a copy and in the box.
    pub(super) fn bounds_in(&self, tile: &Tile, lo: DVec3, hi: DVec3) -> Option<[Vec3A; 2]> {
        let [a, b] = [lo, hi].map(|p| tile.outside(p));
        self.bounds_of_lattice(a.min(b), a.max(b))
    }

    /// Bounds, in the box's own frame, of what lies between the lattice coordinates `lo` and `hi` and in the box;
    /// `None` if nothing does.
    pub(super) fn bounds_of_lattice(&self, lo: DVec3, hi: DVec3) -> Option<[Vec3A; 2]> {
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let at = self.to_box * (middle.truncate() - self.lattice_origin);
        let reach = DMat2::from_cols(self.to_box.x_axis.abs(), self.to_box.y_axis.abs()) * half.truncate();
        self.bounds((at - reach).extend(lo.z), (at + reach).extend(hi.z))
    }

    /// Bounds of what lies between the box coordinates `lo` and `hi` and in the box.
    ///
    /// T of a box of coordinates is trilinear again: its corners bound it.
    fn bounds(&self, lo: DVec3, hi: DVec3) -> Option<[Vec3A; 2]> {
        // Rounding of the box coordinates, which are of the order of 1.
        const ROUNDING: f64 = 1e-9;
        let (lo, hi) = (lo.max(DVec3::ZERO) - ROUNDING, hi.min(DVec3::ONE) + ROUNDING);
        if lo.cmpgt(hi).any() || (self.prism && lo.x + lo.y > 1.0 + ROUNDING) {
            return None;
        }
        let (lo, hi) = (lo.as_vec3a(), hi.as_vec3a());
        let c = &self.corners;
        let mut bounds = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
        let along_u: [[Vec3A; 4]; 2] =
            [lo.x, hi.x].map(|u| [0, 2, 4, 6].map(|i| c[i] + u * (c[i + 1] - c[i])));
        for row in &along_u {
            for v in [lo.y, hi.y] {
                let (base, top) = (row[0] + v * (row[1] - row[0]), row[2] + v * (row[3] - row[2]));
                for w in [lo.z, hi.z] {
                    let p = base + w * (top - base);
                    bounds = [bounds[0].min(p), bounds[1].max(p)];
                }
            }
        }
        Some([bounds[0] - self.margin, bounds[1] + self.margin])
    }

    /// Bounds of the image of a triangle in box coordinates.
    pub(super) fn bounds_of(&self, [a, b, c]: &[DVec3; 3]) -> Option<[Vec3A; 2]> {
        self.bounds(a.min(*b).min(*c), a.max(*b).max(*c))
    }

    /// The parts of a triangle of a copy that lie in the box, in box coordinates.
    pub(super) fn clipped(&self, tile: &Tile, corners: &[DVec3; 3], mut part: impl FnMut([DVec3; 3])) {
        let corners = corners.map(|p| self.in_box(tile, p));
        let planes = [
            (DVec3::X, 0.0),
            (DVec3::Y, 0.0),
            (-DVec3::X, -1.0),
            (-DVec3::Y, -1.0),
            (DVec3::NEG_ONE.with_z(0.0), -1.0),
        ];
        let planes = if self.prism { &[planes[0], planes[1], planes[4]][..] } else { &planes[..4] };
        let crossed = |&&(normal, at): &&(DVec3, f64)| corners.iter().any(|p| normal.dot(*p) < at);
        if !planes.iter().any(|plane| crossed(&plane)) {
            return part(corners);
        }
        let mut polygon = Polygon::new(corners);
        for &(normal, at) in planes.iter().filter(crossed) {
            polygon = polygon.cut(normal, at);
        }
        // Slivers below a hundred-millionth of the patch are rounding.
        polygon.fan().filter(|t| doubled_area(t) > 1e-16).for_each(part);
    }

    /// The two halves of a triangle in box coordinates, if its plane image is not close enough to the curved one.
    ///
    /// Whether an edge is halved depends on the edge alone, so that neighbours agree and no gap opens between them.
    pub(super) fn halves(&self, corners: &[DVec3; 3], halvings: u32) -> Option<[[DVec3; 3]; 2]> {
        let (mut worst, mut deviation) = (0, 0.0);
        for i in 0..3 {
            let d = self.deviation(corners[i], corners[(i + 1) % 3]);
            if d > deviation {
                (worst, deviation) = (i, d);
            }
        }
        // Inside, a triangle bends by at most 4/3 of what its worst edge does: Σ λᵢλⱼ ≤ 1/3, at an edge 1/4.
        if deviation <= 0.75 * self.tolerance || halvings >= Self::MOST_HALVINGS {
            return None;
        }
        let [a, b, c] = [0, 1, 2].map(|i| corners[(worst + i) % 3]);
        let middle = 0.5 * (a + b);
        Some([[a, middle, c], [middle, b, c]])
    }

    /// A bound of how far the image of an edge is from straight: an eighth of the largest second derivative along it.
    fn deviation(&self, a: DVec3, b: DVec3) -> f64 {
        let d = (b - a).abs();
        0.25 * DVec3::new(d.x * d.y, d.x * d.z, d.y * d.z).dot(self.bends)
    }
}

/// A point with one coordinate set.
fn with(mut u: DVec3, axis: usize, value: f64) -> DVec3 {
    u[axis] = value;
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use pelage_geom::Trilinear;

    fn bent() -> Hexahedron {
        let mut map = Trilinear::identity();
        map.corners[7] += Vec3::new(0.4, 0.3, -0.2);
        map.corners[4] += Vec3::new(-0.3, 0.1, 0.2);
        Hexahedron::cuboid(map)
    }

    #[test]
    fn the_copies_of_a_turned_lattice_cover_the_patch_once() {
        // One texel-filling square, carried by a lattice that is turned by 30° and has 2.3 copies a side: the clipped
        // parts of all copies are the patch, whose area in box coordinates is 1, or ½ for a prism.
        let (sin, cos) = 30_f32.to_radians().sin_cos();
        let lattice = Lattice {
            origin: Vec2::new(0.2, -0.7),
            u: 2.3 * Vec2::new(cos, sin),
            v: 2.3 * Vec2::new(-sin, cos),
        };
        let corner = |s: f64, t: f64| DVec3::new(s, t, 0.5);
        let halves = [
            [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
            [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        ];
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let prism = Hexahedron::prism(triangle, triangle.map(|p| p + Vec3::Z));
        for (hexahedron, expected) in [(bent(), 1.0), (prism, 0.5)] {
            let carrier = Carrier::new(&hexahedron, &lattice, true, 1.0);
            let mut area = 0.0;
            for s in carrier.copies[0].clone() {
                for t in carrier.copies[1].clone() {
                    for half in &halves {
                        carrier
                            .clipped(&Tile::upright([s, t]), half, |part| area += 0.5 * doubled_area(&part));
                    }
                }
            }
            assert!((area - expected).abs() < 1e-9, "{area} for {expected}");
        }
    }

    #[test]
    fn halving_ends_within_the_tolerance() {
        // Every point of every final triangle, carried by T, is within the tolerance of the flat triangle.
        let tolerance = 1e-3;
        let carrier = Carrier::new(&bent(), &Lattice::UNIT, true, tolerance);
        let mut open = vec![([DVec3::ZERO, DVec3::new(1.0, 0.2, 0.9), DVec3::new(0.1, 1.0, 0.4)], 0)];
        let (mut count, mut worst) = (0, 0.0_f64);
        while let Some((triangle, halvings)) = open.pop() {
            if let Some(halves) = carrier.halves(&triangle, halvings) {
                open.extend(halves.map(|half| (half, halvings + 1)));
                continue;
            }
            count += 1;
            let flat = triangle.map(|u| carrier.point(u));
            for (i, j) in [(0.5, 0.5), (0.5, 0.0), (0.0, 0.5), (0.33, 0.33), (0.2, 0.6)] {
                let mix = |[a, b, c]: [DVec3; 3]| (1.0 - i - j) * a + i * b + j * c;
                worst = worst.max(carrier.point(mix(triangle)).distance(mix(flat)));
            }
        }
        println!("{count} triangles, {worst:.2e} of {tolerance:.0e}");
        assert!(worst <= tolerance && count > 10);
    }

    #[test]
    fn bounds_hold_what_they_should() {
        let carrier = Carrier::new(
            &bent(),
            &Lattice { origin: Vec2::new(0.3, 0.1), u: Vec2::new(1.1, 0.6), v: Vec2::new(-0.5, 0.9) },
            true,
            1.0,
        );
        let (lo, hi) = (DVec3::new(0.4, 0.3, 0.2), DVec3::new(0.7, 0.8, 0.6));
        let [a, b] = carrier.bounds_of_lattice(lo, hi).expect("it meets the box");
        for i in 0..1000 {
            let f = |k: u32| f64::from(i * k % 101) / 100.0;
            let p = carrier.in_box(&Tile::upright([0, 0]), lo + DVec3::new(f(1), f(7), f(31)) * (hi - lo));
            if p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all() {
                let q = carrier.point(p).as_vec3a();
                assert!(q.cmpge(a).all() && q.cmple(b).all());
            }
        }
        assert!(carrier.bounds_of_lattice(DVec3::splat(9.0), DVec3::splat(9.5)).is_none());
    }
}
