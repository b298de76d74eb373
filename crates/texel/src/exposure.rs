//! What each voxel shows of its surface: its surfels, measured in the geometry.
//!
//! Points are spread evenly over both sides of the triangles in the voxels of one level. From each, rays through the
//! mask's cells ask how far it is to the next triangle: which cells are open at one level's [`Surfel::reach`] and
//! which at another's then follows, so that a voxel of any coarser level chooses among the points of its descendants. What is
//! seen from nowhere (the inside of a tube) is dropped. Beyond its reach the shadow cone sees what the voxels hold. The
//! coarsest levels, of which tables are made, have points of their own, which look further and in more directions.
//!
//! The rays cost nearly all of the time: hence few from sides of triangles that look dark, and, in fine voxels, from one
//! point for all that face alike.

use std::ops::{Range, RangeInclusive};

use glam::Vec3;
use rayon::prelude::*;

use crate::dark::{dark_sides, normal_of, point_of};
use crate::random::Random;
use crate::reflectance::{Outlook, Reflectances, TABLED, Tally};
use crate::region::Parts;
use crate::sample::snapped_normal;
use crate::surfel::{Surfel, Surfels, direction};
use crate::surroundings::Surroundings;
use crate::thinning::{Found, merge_alike, thin_out};
use crate::voxelise::{Cells, Facet};

/// The levels up to this one take their points from it, with a ray for each cell of the mask; the finer ones from the
/// finest of all, with a ray for each four.
const COARSE: usize = 4;

/// How the voxels of one level are looked around from.
#[derive(Clone, Copy)]
struct Sampling {
    /// Points tried on each side.
    points: usize,
    /// Cells of the mask along one ray's side: 1 asks each, 2 one of four.
    stride: usize,
    /// Of normals whose cosine is above this, one is looked around from; above 1, all.
    alike: f32,
    /// Edges of the voxels of the first and the last level that the points are for, in texel units.
    edges: [f32; 2],
}

/// What the voxels of a level show.
pub(crate) enum Shown {
    /// To any direction.
    Surfels(Surfels),
    /// Of light from any direction to any other.
    Reflectances(Reflectances),
}

/// What the voxels of every level show. `points` are tried in each voxel of level 4 on each side.
/// `report` is told of the [`work`] done.
pub(crate) fn measure(
    facets: &[Facet],
    lists: &[Cells],
    scene: &Surroundings,
    points: u32,
    report: &(dyn Fn(usize) + Sync),
) -> Vec<Shown> {
    let finest = lists.len().saturating_sub(1);
    let edge = |level: usize| 1.0 / (1 << level) as f32;
    let dark = dark_sides(facets, scene, Surfel::reach(edge(finest)));
    let content = Content { facets, scene, dark: &dark };
    let coarse = COARSE.min(finest);
    let coarsely = || report(COARSE_WORK);
    let mut all = content.reflectances(lists, coarse, POINTS_OF_TABLES * points as usize, &coarsely);
    if finest >= TABLED {
        let sampling =
            Sampling { points: points as usize, stride: 1, alike: 2.0, edges: [edge(TABLED), edge(coarse)] };
        let points = content.points(&lists[coarse], &sampling, &coarsely);
        all.extend(choose(lists, TABLED..=coarse, &points, &sampling));
    }
    if finest > coarse {
        let sampling =
            Sampling { points: 8, stride: 2, alike: 0.97, edges: [edge(coarse + 1), edge(finest)] };
        let points = content.points(&lists[finest], &sampling, &|| report(1));
        all.extend(choose(lists, coarse + 1..=finest, &points, &sampling));
    }
    all
}

/// Points of tables are tried so many times as often as others: of those seen from one direction few are lit from another.
const POINTS_OF_TABLES: usize = 4;

/// What a cell of level [`COARSE`] costs of one of the finest.
const COARSE_WORK: usize = 16;

/// How much there is to measure, about as long for each unit.
pub(crate) fn work(lists: &[Cells]) -> usize {
    let finest = lists.len().saturating_sub(1);
    let cells = |level: usize| lists.get(level).map_or(0, |cells| cells.codes().len());
    let fine = if finest > COARSE { cells(finest) } else { 0 };
    let passes = 1 + usize::from(finest >= TABLED);
    passes * COARSE_WORK * cells(COARSE.min(finest)) + fine
}

/// Surfels in a voxel of a level at most.
fn most_surfels(level: usize) -> usize {
    match level {
        0..=3 => 64,
        4 => 16,
        5 => 8,
        _ => 4,
    }
}

/// What the voxels of `levels` show, chosen among the points of the voxels of the last of them.
fn choose(
    lists: &[Cells],
    levels: RangeInclusive<usize>,
    points: &[Vec<Point>],
    sampling: &Sampling,
) -> Vec<Shown> {
    let last = *levels.end();
    let choose_level = |level: usize| {
        let reach = Surfel::reach(1.0 / (1 << level) as f32);
        let ranges = lists[level].descendants(&lists[last], 3 * (last - level) as u32);
        let found = |range: Range<usize>| {
            points[range].iter().flatten().filter_map(|p| p.seen(reach, sampling)).collect::<Vec<_>>()
        };
        let each = ranges.into_par_iter().enumerate().map(|(i, range)| {
            let mut found = found(range);
            let random = &mut Random::new((level as u64) << 32 | i as u64, 0x50f3);
            thin_out(&mut found, most_surfels(level), random);
            // Coarse voxels are few: there it would save little, and their light is all that is seen of the texel.
            if level > COARSE {
                merge_alike(&mut found);
            }
            let largest = found.iter().fold(f32::MIN_POSITIVE, |largest, found| found.weight.max(largest));
            found.iter().map(|f| Surfel::new(f.normal, f.color, f.weight / largest, f.open)).collect()
        });
        Shown::Surfels(Surfels::new(each.collect()))
    };
    levels.map(choose_level).collect()
}

/// A point that is seen from somewhere.
#[derive(Clone, Debug)]
struct Point {
    normal: Vec3,
    color: Vec3,
    /// The surface that it stands for: an area in texel units.
    weight: f32,
    /// How far it is to the next triangle through each cell that was asked, row after row, as a part of the longest reach.
    distances: [u8; 64],
}

impl Point {
    /// With the mask for `reach`; `None` if nothing is open.
    fn seen(&self, reach: f32, sampling: &Sampling) -> Option<Found> {
        let Sampling { stride, .. } = *sampling;
        let threshold = sampling.code(reach);
        let mut open = 0_u64;
        let side = Surfel::SIDE / stride;
        let block = if stride == 2 { 0x0303_u64 } else { 1 };
        for cell in 0..side * side {
            if self.distances[cell] >= threshold {
                open |= block << (stride * (cell % side) + Surfel::SIDE * stride * (cell / side));
            }
        }
        (open != 0).then_some(Found { normal: self.normal, color: self.color, open, weight: self.weight })
    }
}

impl Sampling {
    /// A distance as a byte: 0 below the shortest reach, 255 from the longest on; logarithmic between.
    fn code(&self, distance: f32) -> u8 {
        let [far, near] = self.edges.map(Surfel::reach);
        if distance >= far {
            255
        } else if distance < near {
            0
        } else {
            1 + (253.0 * (distance / near).log2() / (far / near).log2()) as u8
        }
    }
}

/// What points are spread over.
struct Content<'a> {
    facets: &'a [Facet],
    scene: &'a Surroundings,
    dark: &'a [[bool; 2]],
}

#[derive(Default)]
struct Scratch {
    triangles: Vec<[Vec3; 3]>,
    parts: Parts,
    /// Fans of the parts: triangle, corners and area, summed up so far.
    fans: Vec<(u32, [Vec3; 3], f32)>,
    tried: Vec<Tried>,
}

/// A point that may be seen.
#[derive(Clone, Copy)]
struct Tried {
    facet: usize,
    /// Texel coordinates.
    at: Vec3,
    normal: Vec3,
    color: Vec3,
    weight: f32,
}

impl Content<'_> {
    /// The reflectances of the levels that have them, of points in the cells of level `last`.
    fn reflectances(
        &self,
        lists: &[Cells],
        last: usize,
        points: usize,
        done: &(dyn Fn() + Sync),
    ) -> Vec<Shown> {
        // Points are many, and each is needed once: for the tallies of its voxel of the finest of these levels, as each level sees it.
        let finest = last.min(TABLED - 1);
        let sampling = Sampling { points, stride: 1, alike: 2.0, edges: [1.0 / (1 << last) as f32; 2] };
        let ranges = lists[finest].descendants(&lists[last], 3 * (last - finest) as u32);
        let voxels = ranges.into_par_iter().map_init(Scratch::default, |scratch, range| {
            let mut tallies: Vec<Tally> = (0..=finest).map(|_| Tally::new()).collect();
            for cell in range {
                self.look_around(&lists[last], cell, &sampling, scratch, |point| {
                    tallies.iter_mut().enumerate().for_each(|(level, tally)| tally.add(level, &point));
                });
                done();
            }
            tallies
        });
        let voxels: Vec<Vec<Tally>> = voxels.collect();
        let of_level = |level: usize| {
            let ranges = lists[level].descendants(&lists[finest], 3 * (finest - level) as u32);
            let each = ranges.into_par_iter().map(|range| {
                let mut all = Tally::new();
                voxels[range].iter().for_each(|tallies| all.add_all(&tallies[level]));
                all.measured()
            });
            Shown::Reflectances(Reflectances::new(each.collect()))
        };
        (0..=finest).map(of_level).collect()
    }

    /// What points of a cell see of their surroundings.
    fn look_around(
        &self,
        cells: &Cells,
        cell: usize,
        sampling: &Sampling,
        scratch: &mut Scratch,
        each: impl FnMut(Outlook),
    ) {
        let random = &mut Random::new(u64::from(cells.codes()[cell]), 0x0a11);
        let facets: Vec<usize> = cells.facets(cell).collect();
        self.try_points(&facets, cells.cell(cell).as_vec3(), sampling, scratch, random);
        let look = |t: &Tried| {
            let distance = |d: Vec3, [near, far]: [f32; 2]| self.scene.distance(t.facet, t.at, d, near, far);
            Outlook::new(t.normal, t.color, t.weight, random, distance)
        };
        scratch.tried.iter().filter_map(look).for_each(each);
    }

    /// The points of each of `cells`.
    fn points(&self, cells: &Cells, sampling: &Sampling, done: &(dyn Fn() + Sync)) -> Vec<Vec<Point>> {
        let edge = sampling.edges[1];
        (0..cells.codes().len())
            .into_par_iter()
            .map_init(Scratch::default, |scratch, i| {
                let random = &mut Random::new(u64::from(cells.codes()[i]), edge.to_bits().into());
                let facets: Vec<usize> = cells.facets(i).collect();
                self.try_points(&facets, cells.cell(i).as_vec3(), sampling, scratch, random);
                let points = if sampling.alike < 1.0 {
                    self.look_alike(&mut scratch.tried, sampling, random)
                } else {
                    let one = |t: &Tried| self.look(t, sampling, random);
                    scratch.tried.iter().filter_map(one).collect()
                };
                done();
                points
            })
            .collect()
    }

    /// Spreads points over what `facets` have in the cell whose lower `corner` is given in edges.
    fn try_points(
        &self,
        facets: &[usize],
        corner: Vec3,
        sampling: &Sampling,
        scratch: &mut Scratch,
        random: &mut Random,
    ) {
        let Scratch { triangles, parts, fans, tried } = scratch;
        let edge = sampling.edges[1];
        triangles.clear();
        triangles.extend(facets.iter().map(|&id| self.facets[id].corners.map(|p| p / edge - corner)));
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
        tried.clear();
        if fans.is_empty() || area.is_nan() || area == 0.0 {
            return;
        }
        let weight = 0.5 * area * edge * edge / sampling.points as f32;
        for point in 0..2 * sampling.points {
            let wanted = area * ((point / 2) as f32 + random.unit()) / sampling.points as f32;
            let fan = fans.partition_point(|fan| fan.2 <= wanted).min(fans.len() - 1);
            let (id, corners, _) = fans[fan];
            let at = (point_of(corners, random) + corner) * edge;
            let facet = facets[id as usize];
            // Both sides in turn; of those that look dark, one point in four counts for four.
            let side = point % 2;
            let dark = self.dark[facet][side];
            if dark && random.unit() >= 0.25 {
                continue;
            }
            let Some(normal) = normal_of(triangles[id as usize], side) else { continue };
            let weight = if dark { 4.0 * weight } else { weight };
            let normal = snapped_normal(normal);
            tried.push(Tried { facet, at, normal, color: self.facets[facet].color, weight });
        }
    }

    /// Looks around from a point; `None` if it sees nothing.
    fn look(&self, point: &Tried, sampling: &Sampling, random: &mut Random) -> Option<Point> {
        const SOME: usize = 6;
        let Sampling { stride, edges, .. } = *sampling;
        let [far, near] = edges.map(Surfel::reach);
        let side = Surfel::SIDE / stride;
        let mut weight = point.weight;
        let mut distances = [0; 64];
        let mut is_seen = false;
        for i in 0..side * side {
            // All over the disk first. Of points that look hidden after some rays, one in four is looked at closely,
            // and counts for four.
            if i == SOME && !is_seen {
                if random.unit() >= 0.25 {
                    return None;
                }
                weight *= 4.0;
            }
            let cell = 29 * i % (side * side);
            let mut within = |i: usize| 0.25 * stride as f32 * (i as f32 + random.unit()) - 1.0;
            let [x, y] = [within(cell % side), within(cell / side)];
            let d = direction(point.normal, [x, y]);
            distances[cell] = sampling.code(self.scene.distance(point.facet, point.at, d, near, far));
            is_seen |= distances[cell] > 0;
        }
        is_seen.then_some(Point { normal: point.normal, color: point.color, weight, distances })
    }

    /// Of points that face alike, one stands for all that are seen: the first that is when they are looked at in the
    /// order in which they come, for as many in proportion as it took.
    fn look_alike(&self, tried: &mut [Tried], sampling: &Sampling, random: &mut Random) -> Vec<Point> {
        /// Points looked at before all are taken for hidden.
        const TRIES: usize = 3;
        let mut points = Vec::new();
        let mut rest = tried;
        while let Some(&Tried { normal, .. }) = rest.first() {
            // Those alike to the front, in their order; the rest may change its.
            let mut end = 1;
            for i in 1..rest.len() {
                if rest[i].normal.dot(normal) > sampling.alike {
                    rest.swap(end, i);
                    end += 1;
                }
            }
            let (group, others) = rest.split_at_mut(end);
            let weight: f32 = group.iter().map(|t| t.weight).sum();
            let color = group.iter().map(|t| t.weight * t.color).sum::<Vec3>() / weight;
            let mut looked_at = 0.0;
            for t in group.iter().take(TRIES) {
                looked_at += t.weight;
                if let Some(point) = self.look(t, sampling, random) {
                    points.push(Point { weight: weight * t.weight / looked_at, color, ..point });
                    break;
                }
            }
            rest = others;
        }
        points
    }
}
