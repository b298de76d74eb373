//! *Dressing*: polygons become patches, and every patch gets its place in the lattice of the texel.
//! [Neyret98 §3] [seed §3]
//!
//! A lattice is affine on a patch. A triangle's texture coordinates always are; a quad's are where they form a
//! parallelogram, and then the quad stays one box. Another quad becomes two prisms along one of its diagonals,
//! which leaves its outer walls as they were: its neighbours notice nothing.

use glam::{DVec2, DVec3, Vec2};
use pelage_geom::{Face, certify};
use rayon::prelude::*;

use crate::charts::{Charts, mean_density};
use crate::patch::hexahedron;
use crate::polygon::{Polygon, Surface};
use crate::quad;
use crate::{Anchor, Lattice, Layout, Patch, Report, SkinOptions};

/// Texel coordinates nearer than this to a whole number are that number, in copies of the texel: far less than a
/// voxel, and enough for the rounding of `f32` texture coordinates, so that borders between copies coincide with
/// edges instead of cutting slivers off the patches. A patch thinner than this has no area.
const SNAP: f64 = 1.0 / 65536.0;

/// Most copies of the texel along a side of a patch: beyond it, an `f32` no longer tells the voxels of a texel of
/// 128³ apart.
const MOST_COPIES: f64 = 65536.0;

/// Where texel coordinates come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Plan {
    /// Texture coordinates times `tiling`; `copy_width` (metres) serves where they are of no use.
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

/// A lattice before it is shifted and rounded.
#[derive(Clone, Copy)]
struct Affine {
    origin: DVec2,
    u: DVec2,
    v: DVec2,
}

impl Plan {
    /// Resolves layout and tiling for `surface`; `uvs` says whether the mesh has texture coordinates.
    pub fn new(surface: &Surface, uvs: bool, options: &SkinOptions) -> Self {
        let copies = f64::from(options.tiling.unwrap_or(1.0)).round().clamp(1.0, MOST_COPIES);
        if options.layout == Layout::PerPatch || (!uvs && options.layout != Layout::Conformal) {
            return Self::PerPatch { copies };
        }
        if options.layout == Layout::Conformal {
            let width = f64::from(options.aspect) * f64::from(options.height);
            let tiling = options.tiling.map_or(1.0 / width, f64::from);
            return Self::Uv { tiling, copy_width: 1.0 / tiling };
        }
        let density = mean_density(surface);
        if density == 0.0 && options.layout == Layout::Auto {
            return Self::PerPatch { copies };
        }
        Self::uv(density, options)
    }

    /// The plan for texture coordinates of a certain `density` (units per metre).
    fn uv(density: f64, options: &SkinOptions) -> Self {
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

    /// The same with `factor` times as many copies, where they come from texture coordinates.
    fn finer(self, factor: f64) -> Self {
        match self {
            Self::Uv { tiling, copy_width } => {
                Self::Uv { tiling: tiling * factor, copy_width: copy_width / factor }
            }
            Self::PerPatch { .. } => self,
        }
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
            Self::Uv { tiling, .. } => polygon.laid.map(|uv| (uv.as_dvec2() * tiling).map(snap)),
            Self::PerPatch { copies: n } => [(0.0, 0.0), (n, 0.0), (n, n), (0.0, n)].map(DVec2::from),
        }
    }

    /// Whether `lattice`, from texture coordinates `uvs` at A, B, C, can place a texel. Where it cannot, the result
    /// is the width of a copy, in metres, to go by instead.
    fn check(&self, lattice: Affine, uvs: [Vec2; 3]) -> Result<(), f64> {
        let Self::Uv { copy_width, .. } = *self else { return Ok(()) };
        let [a, b, c] = uvs.map(|uv| uv.as_dvec2());
        let (u, v) = (b - a, c - a);
        let largest = [a, b, c].map(|x| x.abs().max_element()).into_iter().fold(0.0, f64::max);
        let rounding = f64::from(f32::EPSILON) * largest * (u.length() + v.length());
        let longest = lattice.u.length().max(lattice.v.length());
        let usable = u.perp_dot(v).abs() > rounding
            && lattice.u.perp_dot(lattice.v).abs() > SNAP * longest
            && longest <= MOST_COPIES;
        if usable { Ok(()) } else { Err(copy_width) }
    }
}

impl Affine {
    /// Through three corners.
    fn triangle([a, b, c]: [DVec2; 3]) -> Self {
        Self { origin: a, u: b - a, v: c - a }
    }

    /// Through four corners in box order; where they are a little off a parallelogram, all share the error.
    fn parallelogram([a, b, c, d]: [DVec2; 4]) -> Self {
        if a + d == b + c {
            return Self::triangle([a, b, c]);
        }
        let (u, v) = (0.5 * (b - a + d - c), 0.5 * (c - a + d - b));
        Self { origin: 0.25 * (a + b + c + d) - 0.5 * (u + v), u, v }
    }

    /// Shifts by whole numbers, so that the point at box coordinates (`middle`, `middle`) comes to lie in `[0,1)²`,
    /// then rounds to `f32`. Also the shift.
    fn near_zero(self, middle: f64) -> (Lattice, [i32; 2]) {
        let shift = (self.origin + middle * (self.u + self.v)).floor();
        let lattice =
            Lattice { origin: (self.origin - shift).as_vec2(), u: self.u.as_vec2(), v: self.v.as_vec2() };
        (lattice, shift.to_array().map(|x| x as i32))
    }
}

/// Makes the patches of `surface`, in its order, and the texture coordinates of each in box order.
pub(crate) fn dress(
    surface: &Surface,
    plan: Plan,
    options: &SkinOptions,
    report: &mut Report,
) -> (Vec<Patch>, Vec<[Vec2; 4]>) {
    let charts = matches!(plan, Plan::Uv { .. }).then(|| Charts::new(surface));
    let sized = options.tiling.is_some() || options.layout == Layout::Conformal;
    let by_chart = charts.as_ref().filter(|_| !sized);
    let plan_of = |i: usize| match by_chart.map(|charts| (charts.density(i), charts.finer(i))) {
        Some((density, finer)) if density > 0.0 => Plan::uv(density, options).finer(finer),
        _ => plan,
    };
    let island_of = |i: usize| charts.as_ref().map_or(i as u32, |charts| charts.number(i));
    let dressed: Vec<Dressed> = (surface.polygons.par_iter().enumerate())
        .flat_map_iter(|(i, p)| {
            let island = island_of(i);
            dress_one(p, surface, plan_of(i), options).map(move |mut dressed| {
                // Where texture coordinates are of no use, the polygon has copies of its own.
                dressed.patch.anchor.island = if dressed.zero_area_uvs { i as u32 } else { island };
                dressed
            })
        })
        .collect();
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

/// The one or two patches of a polygon.
fn dress_one(
    polygon: &Polygon,
    surface: &Surface,
    plan: Plan,
    options: &SkinOptions,
) -> impl Iterator<Item = Dressed> + use<> {
    let points = polygon.points(&surface.positions);
    let corners = plan.corners(polygon);
    let [a, b, d, c] = corners;
    let triangle = polygon.vertices[3] == Face::NONE;
    let split = if triangle {
        None
    } else if quad::is_concave(points) && !is_box(polygon, surface, options) {
        Some(Split::Concave)
    } else if options.split_nonplanar.is_some_and(|limit| quad::nonplanarity(points) > f64::from(limit)) {
        Some(Split::Nonplanar)
    } else if (a + d - b - c).length() > f64::from(options.affine_tolerance) {
        Some(Split::Uvs)
    } else {
        None
    };
    let [first, second] = if triangle {
        [Some(prism(polygon, [0, 1, 2], points, corners, plan)), None]
    } else if split.is_none() {
        [Some(cuboid(polygon, points, corners, plan)), None]
    } else {
        let [first, second] = quad::halves(points).map(|pick| prism(polygon, pick, points, corners, plan));
        [Some(Dressed { split, ..first }), Some(second)]
    };
    first.into_iter().chain(second)
}

/// Whether a quad whose top is given is a box all the same: one that leans enough may be valid over a base that has a
/// concave corner.
fn is_box(polygon: &Polygon, surface: &Surface, options: &SkinOptions) -> bool {
    let [p0, p1, p2, p3] = polygon.vertices;
    let vertices = [p0, p1, p3, p2];
    surface.tops.as_ref().is_some_and(|tops| {
        certify(&hexahedron(&vertices, &surface.positions, tops), options.certificate_depth).is_valid()
    })
}

/// One box on a quad whose `corners` (around it) are affine.
fn cuboid(polygon: &Polygon, points: [DVec3; 4], corners: [DVec2; 4], plan: Plan) -> Dressed {
    let box_order = |[a, b, d, c]: [DVec2; 4]| [a, b, c, d];
    let [p0, p1, p2, p3] = polygon.vertices;
    let [t0, t1, t2, t3] = polygon.uvs;
    let [l0, l1, _, l3] = polygon.laid;
    let mut lattice = Affine::parallelogram(box_order(corners));
    let check = plan.check(lattice, [l0, l1, l3]);
    if let Err(copy_width) = check {
        lattice = Affine::parallelogram(box_order(whole_copies(points, copy_width)));
    }
    let (lattice, first) = lattice.near_zero(0.5);
    Dressed {
        patch: Patch {
            vertices: [p0, p1, p3, p2],
            face: polygon.face,
            material: polygon.material,
            lattice,
            anchor: Anchor { island: 0, first },
        },
        uvs: [t0, t1, t3, t2],
        zero_area_uvs: check.is_err(),
        split: None,
    }
}

/// A prism on the corners `pick` of a polygon.
fn prism(
    polygon: &Polygon,
    pick: [usize; 3],
    points: [DVec3; 4],
    corners: [DVec2; 4],
    plan: Plan,
) -> Dressed {
    let triangle = polygon.triangle(pick);
    let [a, b, c, _] = triangle.uvs;
    let mut lattice = Affine::triangle(pick.map(|i| corners[i]));
    let [la, lb, lc, _] = triangle.laid;
    let check = plan.check(lattice, [la, lb, lc]);
    if let Err(copy_width) = check {
        lattice = Affine::triangle(laid_flat(pick.map(|i| points[i]), copy_width));
    }
    let (lattice, first) = lattice.near_zero(1.0 / 3.0);
    Dressed {
        patch: Patch {
            vertices: triangle.vertices,
            face: polygon.face,
            material: polygon.material,
            lattice,
            anchor: Anchor { island: 0, first },
        },
        uvs: [a, b, c, b + c - a],
        zero_area_uvs: check.is_err(),
        split: None,
    }
}

fn snap(x: f64) -> f64 {
    if (x - x.round()).abs() < SNAP { x.round() } else { x }
}

/// A triangle laid flat, its first side along s, in copies `copy_width` metres wide (or [`MOST_COPIES`]).
fn laid_flat([a, b, c]: [DVec3; 3], copy_width: f64) -> [DVec2; 3] {
    let (side, across) = (b - a, c - a);
    let width = copy_width.max(side.length().max(across.length()) / MOST_COPIES);
    let along = side.normalize_or_zero();
    let s = across.dot(along);
    let t = (across - s * along).length();
    [DVec2::ZERO, DVec2::new(side.length(), 0.0) / width, DVec2::new(s, t) / width]
}

/// The whole numbers of copies that come nearest to `copy_width` metres each, around a quad.
fn whole_copies([a, b, d, c]: [DVec3; 4], copy_width: f64) -> [DVec2; 4] {
    let count =
        |p: DVec3, q: DVec3| (0.5 * (p.length() + q.length()) / copy_width).round().clamp(1.0, MOST_COPIES);
    let (n, m) = (count(b - a, d - c), count(c - a, d - b));
    [(0.0, 0.0), (n, 0.0), (n, m), (0.0, m)].map(DVec2::from)
}
