//! *Dressing*: polygons become patches, and every patch gets its place in the lattice of the texel.
//! [Neyret98 §3] [seed §3]
//!
//! A lattice is affine on a patch. A triangle's texture coordinates always are; a quad's are where they form a
//! parallelogram, and then the quad stays one box. Another quad becomes two prisms along one of its diagonals,
//! which leaves its outer walls as they were: its neighbours notice nothing.

use glam::{DVec2, DVec3, Vec2};
use pelage_geom::Face;
use rayon::prelude::*;

use crate::polygon::{Polygon, Surface};
use crate::{Lattice, Layout, Patch, Report, SkinOptions};

/// Texel coordinates nearer than this to a whole number are that number, in copies of the texel: far less than a
/// voxel, and enough for the rounding of `f32` texture coordinates, so that borders between copies coincide with
/// edges instead of cutting slivers off the patches.
const SNAP: f64 = 1.0 / 65536.0;

/// Corners whose sine is below this have no angle: the map of a box would be singular there.
const SMALLEST_SINE: f64 = 1e-3;

/// Where a corner's texel coordinates come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Plan {
    /// Texture coordinates times `tiling`; `copy_width` (metres) serves patches whose coordinates have no area.
    Uv { tiling: f64, copy_width: f64 },
    /// `copies` along each side of a quad.
    PerPatch { copies: f64 },
}

/// Why a quad became two prisms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Split {
    Concave,
    Nonplanar,
    Uvs,
}

/// A patch and what there is to say about it.
struct Dressed {
    patch: Patch,
    uvs: [Vec2; 4],
    zero_area_uvs: bool,
    /// Set on the first of a split quad's two patches.
    split: Option<Split>,
}

impl Plan {
    /// Resolves layout and tiling for `surface`; `uvs` says whether the mesh has texture coordinates.
    pub fn new(surface: &Surface, uvs: bool, options: &SkinOptions) -> Self {
        let copies = f64::from(options.tiling.unwrap_or(1.0)).round().max(1.0);
        if !uvs || options.layout == Layout::PerPatch {
            return Self::PerPatch { copies };
        }
        let density = uv_density(surface);
        if density == 0.0 && options.layout == Layout::Auto {
            return Self::PerPatch { copies };
        }
        let wanted_width = f64::from(options.aspect) * f64::from(options.height);
        let tiling = match options.tiling {
            Some(tiling) => f64::from(tiling),
            None if density == 0.0 => 1.0,
            None => {
                let tiling = 1.0 / (density * wanted_width);
                if tiling > 1.0 { tiling.round() } else { tiling }
            }
        };
        let copy_width = if density == 0.0 { wanted_width } else { 1.0 / (tiling * density) };
        Self::Uv { tiling, copy_width }
    }

    /// Copies of the texel per unit of texture coordinates, or per patch side.
    pub fn tiling(&self) -> f64 {
        match *self {
            Self::Uv { tiling, .. } => tiling,
            Self::PerPatch { copies } => copies,
        }
    }

    /// (s, t) at the corners of `polygon`, around it.
    fn corners(&self, polygon: &Polygon) -> [DVec2; 4] {
        match *self {
            Self::Uv { tiling, .. } => polygon.uvs.map(|uv| (uv.as_dvec2() * tiling).map(snap)),
            Self::PerPatch { copies: n } => [(0.0, 0.0), (n, 0.0), (n, n), (0.0, n)].map(DVec2::from),
        }
    }

    /// Whether texture coordinates at three corners span no area beyond the rounding of their `f32`s.
    fn no_area(&self, uvs: [Vec2; 3]) -> bool {
        if matches!(self, Self::PerPatch { .. }) {
            return false;
        }
        let [a, b, c] = uvs.map(|uv| uv.as_dvec2());
        let (u, v) = (b - a, c - a);
        let size = [a, b, c].map(|x| x.abs().max_element()).into_iter().fold(0.0, f64::max);
        u.perp_dot(v).abs() <= f64::from(f32::EPSILON) * size * (u.length() + v.length())
    }
}

/// Makes the patches of `surface`, in its order, and the texture coordinates of each in box order.
pub(crate) fn dress(
    surface: &Surface,
    plan: Plan,
    options: &SkinOptions,
    report: &mut Report,
) -> (Vec<Patch>, Vec<[Vec2; 4]>) {
    let dressed: Vec<Dressed> =
        surface.polygons.par_iter().flat_map_iter(|p| dress_one(p, surface, plan, options)).collect();
    for d in &dressed {
        report.mirrored += usize::from(d.patch.lattice.determinant() < 0.0);
        report.zero_area_uvs += usize::from(d.zero_area_uvs);
        match d.split {
            Some(Split::Concave) => report.split_concave += 1,
            Some(Split::Nonplanar) => report.split_nonplanar += 1,
            Some(Split::Uvs) => report.split_by_uvs += 1,
            None => {}
        }
    }
    report.tiling = plan.tiling() as f32;
    dressed.into_iter().map(|d| (d.patch, d.uvs)).unzip()
}

fn dress_one(
    polygon: &Polygon,
    surface: &Surface,
    plan: Plan,
    options: &SkinOptions,
) -> impl Iterator<Item = Dressed> + use<> {
    let points = polygon.points(&surface.positions);
    if polygon.vertices[3] == Face::NONE {
        return [Some(prism(polygon, [0, 1, 2], points, plan, None)), None].into_iter().flatten();
    }
    let corners = plan.corners(polygon);
    let [a, b, d, c] = corners;
    let affine = (a + d - b - c).length() <= f64::from(options.affine_tolerance);
    let split = if concave(points) {
        Some(Split::Concave)
    } else if options.split_nonplanar.is_some_and(|limit| nonplanarity(points) > f64::from(limit)) {
        Some(Split::Nonplanar)
    } else if !affine {
        Some(Split::Uvs)
    } else {
        None
    };
    if split.is_none() {
        return [Some(cuboid(polygon, corners, points, plan)), None].into_iter().flatten();
    }
    let [first, second] =
        if first_diagonal(points) { [[0, 1, 2], [0, 2, 3]] } else { [[1, 2, 3], [1, 3, 0]] };
    [Some(prism(polygon, first, points, plan, split)), Some(prism(polygon, second, points, plan, None))]
        .into_iter()
        .flatten()
}

/// One box on a quad whose `corners` (around it) are affine.
fn cuboid(polygon: &Polygon, corners: [DVec2; 4], points: [DVec3; 4], plan: Plan) -> Dressed {
    let [p0, p1, p2, p3] = polygon.vertices;
    let [t0, t1, t2, t3] = polygon.uvs;
    let zero_area_uvs = plan.no_area([t0, t1, t2]) && plan.no_area([t0, t2, t3]);
    let [a, b, d, c] = match plan {
        Plan::Uv { copy_width, .. } if zero_area_uvs => whole_copies(points, copy_width),
        _ => corners,
    };
    Dressed {
        patch: Patch {
            vertices: [p0, p1, p3, p2],
            face: polygon.face,
            material: polygon.material,
            lattice: parallelogram(a, b, c, d),
        },
        uvs: [t0, t1, t3, t2],
        zero_area_uvs,
        split: None,
    }
}

/// A prism on the corners `pick` of a polygon.
fn prism(
    polygon: &Polygon,
    pick: [usize; 3],
    points: [DVec3; 4],
    plan: Plan,
    split: Option<Split>,
) -> Dressed {
    let corners = plan.corners(polygon);
    let [a, b, c] = pick.map(|i| polygon.vertices[i]);
    let [ta, tb, tc] = pick.map(|i| polygon.uvs[i]);
    let zero_area_uvs = plan.no_area([ta, tb, tc]);
    let [sa, sb, sc] = match plan {
        Plan::Uv { copy_width, .. } if zero_area_uvs => flattened(pick.map(|i| points[i]), copy_width),
        _ => pick.map(|i| corners[i]),
    };
    Dressed {
        patch: Patch {
            vertices: [a, b, c, Face::NONE],
            face: polygon.face,
            material: polygon.material,
            lattice: near_zero(sa, sb - sa, sc - sa, (sa + sb + sc) / 3.0),
        },
        uvs: [ta, tb, tc, tb + tc - ta],
        zero_area_uvs,
        split,
    }
}

/// The lattice with (s, t) = `a`, `b`, `c`, `d` at the corners, in box order; where they are a little off a
/// parallelogram, the error is shared by all four.
fn parallelogram(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Lattice {
    let centre = (a + b + c + d) / 4.0;
    if a + d == b + c {
        return near_zero(a, b - a, c - a, centre);
    }
    let (u, v) = (0.5 * (b - a + d - c), 0.5 * (c - a + d - b));
    near_zero(centre - 0.5 * (u + v), u, v, centre)
}

/// Shifts a lattice by whole numbers so that `centre` comes to lie in `[0, 1)²`, before it is rounded to `f32`.
fn near_zero(origin: DVec2, u: DVec2, v: DVec2, centre: DVec2) -> Lattice {
    Lattice { origin: (origin - centre.floor()).as_vec2(), u: u.as_vec2(), v: v.as_vec2() }
}

fn snap(x: f64) -> f64 {
    if (x - x.round()).abs() < SNAP { x.round() } else { x }
}

/// A triangle laid flat, its first side along s, in copies `copy_width` metres wide.
fn flattened([a, b, c]: [DVec3; 3], copy_width: f64) -> [DVec2; 3] {
    let along = (b - a).normalize_or_zero();
    let s = (c - a).dot(along);
    let t = (c - a - s * along).length();
    [DVec2::ZERO, DVec2::new((b - a).length(), 0.0) / copy_width, DVec2::new(s, t) / copy_width]
}

/// The whole numbers of copies that come nearest to `copy_width` metres each, around a quad.
fn whole_copies([a, b, d, c]: [DVec3; 4], copy_width: f64) -> [DVec2; 4] {
    let count = |p: DVec3, q: DVec3| (0.5 * (p.length() + q.length()) / copy_width).round().max(1.0);
    let (n, m) = (count(b - a, d - c), count(c - a, d - b));
    [(0.0, 0.0), (n, 0.0), (n, m), (0.0, m)].map(DVec2::from)
}

/// Whether a corner of the quad turns the wrong way, or hardly at all.
fn concave(p: [DVec3; 4]) -> bool {
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    (0..4).any(|i| {
        let (before, after) = (p[i] - p[(i + 3) % 4], p[(i + 1) % 4] - p[i]);
        before.cross(after).dot(normal) <= SMALLEST_SINE * before.length() * after.length()
    })
}

/// Distance between the diagonals, over the square root of the area: 0 for a planar quad.
fn nonplanarity(p: [DVec3; 4]) -> f64 {
    let area = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]);
    (p[1] - p[0]).dot(area).abs() / area.length().powf(1.5)
}

/// Whether a quad is cut from corner 0 to corner 2 (else from 1 to 3): the shorter diagonal, unless a triangle
/// would be left without area or face the other way.
fn first_diagonal(p: [DVec3; 4]) -> bool {
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let area = |i: usize, j: usize, k: usize| (p[j] - p[i]).cross(p[k] - p[i]).dot(normal);
    let first = area(0, 1, 2).min(area(0, 2, 3));
    let second = area(1, 2, 3).min(area(1, 3, 0));
    let least = SMALLEST_SINE * (first + second).abs();
    if first > least && second > least {
        (p[2] - p[0]).length_squared() <= (p[3] - p[1]).length_squared()
    } else {
        first >= second
    }
}

/// Mean units of texture coordinates per metre; 0 where no face has any area in them.
fn uv_density(surface: &Surface) -> f64 {
    let (mut uv_area, mut area) = (0.0, 0.0);
    for polygon in &surface.polygons {
        let n = polygon.corners().len();
        let uv = |i: usize| polygon.uvs[i].as_dvec2() - polygon.uvs[0].as_dvec2();
        // Each half on its own: the halves of a quad may be mirrored against each other.
        let here = (1..n - 1).map(|i| 0.5 * uv(i).perp_dot(uv(i + 1)).abs()).sum::<f64>();
        if here > 0.0 {
            uv_area += here;
            area += polygon.area_vector(&surface.positions).length();
        }
    }
    if area > 0.0 { (uv_area / area).sqrt() } else { 0.0 }
}
