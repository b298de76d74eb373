//! What each voxel shows of its surface: its surfels, measured in the geometry.
//!
//! Points are spread evenly over both sides of the triangles in a voxel. From each, rays through the mask's cells ask
//! whether a triangle lies within [`Surfel::reach`]; what is seen from nowhere (the inside of a tube) is dropped.
//! Beyond that distance the shadow cone sees what the voxels hold.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::Level;
use crate::random::Random;
use crate::region::Parts;
use crate::surfel::{Surfel, Surfels, direction};
use crate::voxelise::{Cells, Facet};

/// A level's points: how many a voxel, how they are looked around from, and how many are kept.
#[derive(Clone, Copy)]
struct Sampling {
    /// Points tried on each side.
    points: usize,
    /// Cells of the mask along one ray's side: 1 asks each, 2 one of four.
    stride: usize,
    /// Of normals whose cosine is above this, one is kept; above 1, all.
    alike: f32,
    /// Surfels kept at most.
    most: usize,
}

impl Sampling {
    /// Of a level, where `points` are tried in level 0.
    fn of(level: usize, points: u32) -> Self {
        let points = points as usize >> (2 * level).min(31);
        match level {
            0..5 => Self { points: points.max(24), stride: 1, alike: 2.0, most: (points / 2).clamp(16, 512) },
            5 => Self { points: points.max(16), stride: 2, alike: 2.0, most: 8 },
            _ => Self { points: 8, stride: 2, alike: 0.97, most: 4 },
        }
    }
}

/// The surfels of every level.
pub(crate) fn measure(facets: &[Facet], lists: &[Cells], levels: &[Level], points: u32) -> Vec<Surfels> {
    let finest = levels.len().saturating_sub(1);
    (0..levels.len())
        .map(|l| {
            // Cells an eighth of a voxel wide, but neither more nor fewer than pays.
            let grid = (l + 3).clamp(5, 6).min(finest);
            let scene = Surroundings::new(facets, &lists[grid], &levels[grid]);
            let edge = 1.0 / (1 << l) as f32;
            let cells = &lists[l];
            let each = (0..cells.codes().len()).into_par_iter().map_init(Default::default, |scratch, i| {
                let random = Random::new((l as u64) << 32 | i as u64, 0x50f3);
                let voxel =
                    Matter { facets: cells.facets(i).collect(), corner: cells.cell(i).as_vec3(), edge };
                surfels(&scene, &voxel, Sampling::of(l, points), scratch, random)
            });
            Surfels::new(each.collect())
        })
        .collect()
}

/// A voxel's facets, its lower corner in voxel edges, and its edge in texel units.
struct Matter {
    facets: Vec<usize>,
    corner: Vec3,
    edge: f32,
}

#[derive(Default)]
struct Scratch {
    triangles: Vec<[Vec3; 3]>,
    parts: Parts,
    /// Fans of the parts: triangle, corners and area, summed up so far.
    fans: Vec<(u32, [Vec3; 3], f32)>,
    found: Vec<Found>,
}

/// A point that is seen from somewhere.
#[derive(Clone, Copy)]
struct Found {
    normal: Vec3,
    color: Vec3,
    open: u64,
    /// In equal parts of the surface.
    weight: f32,
}

fn surfels(
    scene: &Surroundings,
    voxel: &Matter,
    sampling: Sampling,
    scratch: &mut Scratch,
    mut random: Random,
) -> Vec<Surfel> {
    let Scratch { triangles, parts, fans, found } = scratch;
    triangles.clear();
    triangles.extend(
        voxel.facets.iter().map(|&id| scene.facets[id].corners.map(|p| p / voxel.edge - voxel.corner)),
    );
    parts.clip(triangles);
    fans.clear();
    let mut area = 0.0;
    for (id, _, vertices) in parts.pieces() {
        for pair in vertices.get(1..).unwrap_or(&[]).windows(2) {
            let corners = [vertices[0], pair[0], pair[1]];
            area += (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            fans.push((id, corners, area));
        }
    }
    found.clear();
    if fans.is_empty() || area.is_nan() || area == 0.0 {
        return Vec::new();
    }
    for point in 0..2 * sampling.points {
        let wanted = area * ((point / 2) as f32 + random.unit()) / sampling.points as f32;
        let fan = fans.partition_point(|fan| fan.2 <= wanted).min(fans.len() - 1);
        let (id, [a, b, c], _) = fans[fan];
        let root = random.unit().sqrt();
        let at = a + (1.0 - root) * (b - a) + root * random.unit() * (c - a);
        let facet = voxel.facets[id as usize];
        let [p, q, r] = triangles[id as usize];
        // Both sides in turn.
        let turn = if point % 2 == 0 { 1.0 } else { -1.0 };
        let Some(normal) = (turn * (q - p).cross(r - p)).try_normalize() else { continue };
        let normal = crate::packed::snapped_normal(normal);
        let at = (at + voxel.corner) * voxel.edge;
        let reach = Surfel::reach(voxel.edge);
        // Of those that look hidden, one in four is looked at closely, and counts for four.
        let hidden = (0..4).all(|_| {
            scene.is_blocked(facet, at, direction(normal, [random.signed(), random.signed()]), reach)
        });
        if hidden && random.unit() >= 0.25 {
            continue;
        }
        let open = scene.mask(facet, at, normal, reach, sampling.stride, &mut random);
        if open != 0 {
            found.push(Found {
                normal,
                color: scene.facets[facet].color,
                open,
                weight: if hidden { 4.0 } else { 1.0 },
            });
        }
    }
    if sampling.alike < 1.0 {
        merge(found, sampling.alike, &mut random);
    }
    thin_out(found, sampling.most, &mut random);
    let largest = found.iter().fold(f32::MIN_POSITIVE, |largest, found| found.weight.max(largest));
    found.iter().map(|f| Surfel::new(f.normal, f.color, f.weight / largest, f.open)).collect()
}

/// Of points whose normals' cosine is above `alike`, one stands for all: any of them, by its part.
fn merge(found: &mut Vec<Found>, alike: f32, random: &mut Random) {
    let mut kept = 0;
    for i in 0..found.len() {
        let next = found[i];
        match found[..kept].iter_mut().find(|f| f.normal.dot(next.normal) > alike) {
            Some(f) => {
                let weight = f.weight + next.weight;
                let color = f.color.lerp(next.color, next.weight / weight);
                if random.unit() * weight < next.weight {
                    *f = next;
                }
                (f.weight, f.color) = (weight, color);
            }
            None => {
                found[kept] = next;
                kept += 1;
            }
        }
    }
    found.truncate(kept);
}

/// Keeps at most `most`, those seen from more directions rather, each weighted for those it stands for.
fn thin_out(found: &mut Vec<Found>, most: usize, random: &mut Random) {
    // Those that are hardly seen are not so rare that one of them would count for very many.
    let importance = |f: &Found| f.weight * (f.open.count_ones() + 8) as f32;
    if found.len() <= most {
        return;
    }
    let step = found.iter().map(importance).sum::<f32>() / most as f32;
    let mut next = step * random.unit();
    let mut sum = 0.0;
    let mut kept = 0;
    for i in 0..found.len() {
        let one = found[i];
        let share = importance(&one);
        let mut times = 0;
        sum += share;
        while next < sum && kept + times < most {
            next += step;
            times += 1;
        }
        if times > 0 {
            found[kept] = Found { weight: one.weight * times as f32 * step / share, ..one };
            kept += 1;
        }
    }
    found.truncate(kept);
}

/// The geometry around, to be asked by rays.
pub(crate) struct Surroundings<'a> {
    facets: &'a [Facet],
    cells: &'a Cells,
    /// Of the same resolution, for its walk.
    level: &'a Level,
}

impl<'a> Surroundings<'a> {
    /// The facets listed in the cells of one level, and that level.
    pub(crate) fn new(facets: &'a [Facet], cells: &'a Cells, level: &'a Level) -> Self {
        Self { facets, cells, level }
    }

    /// Where a segment (texel units) first meets a facet, as a part of it; infinite if it meets none.
    pub(crate) fn first_hit(&self, from: Vec3, to: Vec3) -> f32 {
        let size = self.level.resolution() as i32;
        let mut first = f32::INFINITY;
        for step in self.level.walk(from * size as f32, to * size as f32) {
            if first <= step.enter {
                break;
            }
            let copy: IVec3 = step.cell.div_euclid(IVec3::splat(size));
            let origin = from - copy.as_vec3();
            for id in self.cells.facets(step.voxel as usize) {
                if let Some(t) = hit(&self.facets[id].corners, origin, to - from, 0.0, first) {
                    first = t;
                }
            }
        }
        first
    }

    /// In which cells of the mask nothing is within `reach` (texel units) of a point of a facet.
    fn mask(
        &self,
        own: usize,
        at: Vec3,
        normal: Vec3,
        reach: f32,
        stride: usize,
        random: &mut Random,
    ) -> u64 {
        let mut mask = 0;
        for row in (0..Surfel::SIDE).step_by(stride) {
            for column in (0..Surfel::SIDE).step_by(stride) {
                let cells = (row..row + stride).flat_map(|r| (column..column + stride).map(move |c| (c, r)));
                let bits = cells.fold(0_u64, |m, (c, r)| m | 1 << (8 * r + c));
                let mut within = |i: usize| 0.25 * (i as f32 + stride as f32 * random.unit()) - 1.0;
                let d = direction(normal, [within(column), within(row)]);
                if !self.is_blocked(own, at, d, reach) {
                    mask |= bits;
                }
            }
        }
        mask
    }

    fn is_blocked(&self, own: usize, at: Vec3, d: Vec3, reach: f32) -> bool {
        let size = self.level.resolution() as i32;
        let scale = size as f32;
        for step in self.level.walk(at * scale, (at + reach * d) * scale) {
            // Of periodic content, the cell's copy inside the tile holds the list.
            let copy: IVec3 = step.cell.div_euclid(IVec3::splat(size));
            let from = at - copy.as_vec3();
            let mut facets = self.cells.facets(step.voxel as usize);
            if facets.any(|id| {
                (id != own || copy != IVec3::ZERO)
                    && hit(&self.facets[id].corners, from, d, NEAREST * reach, reach).is_some()
            }) {
                return true;
            }
        }
        false
    }
}

/// What lies nearer than this part of the reach is the seam to a neighbour.
const NEAREST: f32 = 1e-4;

/// Where a ray meets a triangle between two parameters. [Möller97]
fn hit(&[a, b, c]: &[Vec3; 3], from: Vec3, d: Vec3, near: f32, far: f32) -> Option<f32> {
    let [ab, ac] = [b - a, c - a];
    let p = d.cross(ac);
    let det = ab.dot(p);
    let s = (from - a) * det.signum();
    let (det, u) = (det.abs(), s.dot(p));
    if u < 0.0 || u > det {
        return None;
    }
    let q = s.cross(ab);
    let (v, t) = (d.dot(q), ac.dot(q));
    (v >= 0.0 && u + v <= det && t > near * det && t < far * det).then(|| t / det)
}
