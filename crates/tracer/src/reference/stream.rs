//! Many rays at once through all boxes.
//!
//! The rays of a part of the picture descend the trees together: first the tree over the boxes, then, in each box that
//! some of them meet, the tree over one tile of its texel. A node of that tree is carried into the box by T once for
//! all rays that are there, and only where some are; so nothing of a box is ever stored, boxes far away cost no more
//! than the rays that meet them, and a scene may have any number of boxes.

use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};
use pelage_geom::Ray;

use super::carrier::{Carrier, Copies};
use super::content::{Content, Filling};
use super::medium::{Cell, Image, Medium, Random};
use super::world::{Filled, World};
use crate::surface::intersect;
use crate::variety::Tile;

/// A ray, how far it goes, and what it has met first.
pub(super) struct Query {
    pub ray: Ray,
    /// In scene units; anything beyond is not asked for.
    pub end: f64,
    /// What its free flight through densities is drawn from.
    pub flight: u64,
    pub hit: Option<Hit>,
}

/// Where a ray meets the content of a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance along the ray, in scene units.
    pub t: f64,
    pub patch: u32,
    pub copy: [i32; 2],
    /// Where, in box coordinates.
    pub at: DVec3,
    pub met: Met,
}

/// What of the content a ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) enum Met {
    Triangle {
        /// Which piece of the texel's content.
        piece: u32,
        /// Across the triangle, in the scene; any length, either side.
        flat: Vec3,
    },
    Density,
}

impl Hit {
    /// Of several at one distance the first by this counts, whatever the order in which they were found.
    fn order(&self) -> (u32, [i32; 2], u32) {
        let piece = match self.met {
            Met::Triangle { piece, .. } => piece,
            Met::Density => 0,
        };
        (self.patch, self.copy, piece)
    }
}

/// A ray as bounds ask it: in `f32`, near what is asked.
#[derive(Clone, Copy)]
struct Slab {
    origin: Vec3A,
    inverse: Vec3A,
    end: f32,
}

impl Slab {
    /// `start` is how far along the ray its origin has moved.
    fn new(ray: &Ray, frame: DVec3, start: f64, end: f64) -> Self {
        // A finite inverse, so that no product with it is NaN.
        let inverse = |d: f64| (if d.abs() > 1e-18 { d } else { 1e-18_f64.copysign(d) }).recip() as f32;
        let d = ray.direction;
        Self {
            origin: (ray.at(start) - frame).as_vec3a(),
            inverse: Vec3A::new(inverse(d.x), inverse(d.y), inverse(d.z)),
            end: Self::rounded_up(end - start),
        }
    }

    fn rounded_up(distance: f64) -> f32 {
        (distance as f32).next_up()
    }

    #[inline(always)]
    fn meets(&self, [lo, hi]: &[Vec3A; 2]) -> bool {
        let (a, b) = ((*lo - self.origin) * self.inverse, (*hi - self.origin) * self.inverse);
        let near = a.min(b).max_element().max(0.0);
        // Some units in the last place, for the roundings of the three products.
        let far = a.max(b).min_element() * (1.0 + 8.0 * f32::EPSILON);
        near <= far.min(self.end)
    }

    /// From where to where the ray is in bounds that it meets, at most.
    fn span(&self, [lo, hi]: &[Vec3A; 2]) -> [f64; 2] {
        let (a, b) = ((*lo - self.origin) * self.inverse, (*hi - self.origin) * self.inverse);
        let near = a.min(b).max_element() * (1.0 - 8.0 * f32::EPSILON);
        let far = a.max(b).min_element() * (1.0 + 8.0 * f32::EPSILON);
        [f64::from(near.max(0.0)), f64::from(far.min(self.end))]
    }
}

/// A ray in a box.
struct Inside {
    /// Relative to the middle of the box, from `start` on.
    ray: Ray,
    start: f64,
    query: u32,
}

/// The buffers of a descent, reused.
#[derive(Default)]
pub(super) struct Stream {
    /// By query.
    slabs: Vec<Slab>,
    starts: Vec<f64>,
    /// Rays by node of the way down, as a stack.
    lists: Vec<u32>,
    /// Rays in the box, and the same for its own way down.
    inside: Vec<Inside>,
    inside_slabs: Vec<Slab>,
    inside_lists: Vec<u32>,
}

impl Stream {
    /// Finds what each ray meets first; with `any`, whether it meets anything.
    pub(super) fn trace(&mut self, world: &World, queries: &mut [Query], any: bool) {
        if queries.is_empty() || world.boxes.nodes.is_empty() {
            return;
        }
        self.slabs.clear();
        self.starts.clear();
        self.lists.clear();
        for query in &*queries {
            let start = start(&query.ray, world.centre, world.radius);
            self.slabs.push(Slab::new(&query.ray, world.centre, start, query.end));
            self.starts.push(start);
        }
        self.lists.extend(0..queries.len() as u32);
        let root = 0..self.lists.len();
        self.node(world, queries, any, 0, root);
    }

    fn node(&mut self, world: &World, queries: &mut [Query], any: bool, node: u32, list: Range<usize>) {
        let node = &world.boxes.nodes[node as usize];
        let Some(children) = world.boxes.children(node) else {
            for &patch in world.boxes.members_of(node) {
                self.enter(world, queries, any, patch, list.clone());
            }
            return;
        };
        let bounds = children.map(|child| world.boxes.nodes[child as usize].bounds);
        let along = self.lists[list.start] as usize;
        for i in near_first(&bounds, queries[along].ray.direction) {
            let kept = keep(&self.slabs, &mut self.lists, list.clone(), &bounds[i]);
            if !kept.is_empty() {
                self.node(world, queries, any, children[i], kept.clone());
            }
            self.lists.truncate(kept.start);
        }
    }

    /// Sends the rays of `list` through a box.
    fn enter(&mut self, world: &World, queries: &mut [Query], any: bool, patch: u32, list: Range<usize>) {
        let filled = world.filled(patch);
        if filled.is_empty() {
            return;
        }
        let carrier = &filled.carrier;
        self.inside.clear();
        self.inside_slabs.clear();
        self.inside_lists.clear();
        for &i in &self.lists[list.clone()] {
            let query = &queries[i as usize];
            let start = start(&query.ray, carrier.centre, carrier.radius);
            if start > query.end || (any && query.hit.is_some()) {
                continue;
            }
            self.inside_slabs.push(Slab::new(&query.ray, carrier.centre, start, query.end));
            let ray = Ray { origin: query.ray.at(start) - carrier.centre, ..query.ray };
            self.inside.push(Inside { ray, start, query: i });
        }
        self.inside_lists.extend(0..self.inside.len() as u32);
        let mut box_ = InBox {
            filled: &filled,
            carrier,
            patch,
            any,
            queries,
            inside: &self.inside,
            slabs: &mut self.inside_slabs,
            lists: &mut self.inside_lists,
        };
        box_.copies(&carrier.copies, 0..self.inside.len());
        for &i in &self.lists[list] {
            let i = i as usize;
            let end = if any && queries[i].hit.is_some() { -1.0 } else { queries[i].end - self.starts[i] };
            self.slabs[i].end = Slab::rounded_up(end);
        }
    }
}

/// The rays in one box, on their way down the tree of its texel.
struct InBox<'a> {
    filled: &'a Filled<'a>,
    carrier: &'a Carrier,
    patch: u32,
    any: bool,
    queries: &'a mut [Query],
    inside: &'a [Inside],
    slabs: &'a mut [Slab],
    lists: &'a mut Vec<u32>,
}

impl InBox<'_> {
    /// Sends the rays of `list` through some copies of the texel, halving their number until one is left.
    fn copies(&mut self, copies: &Copies, list: Range<usize>) {
        let counts = copies.each_ref().map(|range| range.len());
        if counts.contains(&0) {
            return;
        }
        let ends = |f: fn(&Range<i32>) -> i32| copies.each_ref().map(|range| f64::from(f(range)));
        let (first, last) = (ends(|range| range.start), ends(|range| range.end));
        let Some(bounds) = self
            .carrier
            .bounds_of_lattice(DVec3::new(first[0], first[1], 0.0), DVec3::new(last[0], last[1], 1.0))
        else {
            return;
        };
        let kept = keep(self.slabs, self.lists, list, &bounds);
        if !kept.is_empty() {
            if counts == [1, 1] {
                let (filling, tile) = self.filled.tile([copies[0].start, copies[1].start]);
                match filling {
                    Filling::Triangles(content) if content.tree.nodes.is_empty() => {}
                    Filling::Triangles(content) => self.node(content, &tile, 0, kept.clone()),
                    Filling::Density(medium) => self.cell(medium, &tile, Cell::ROOT, kept.clone()),
                }
            } else {
                let axis = usize::from(counts[1] > counts[0]);
                let Range { start, end } = copies[axis];
                let middle = start + (end - start) / 2;
                for half in [start..middle, middle..end] {
                    let mut part = copies.clone();
                    part[axis] = half;
                    self.copies(&part, kept.clone());
                }
            }
        }
        self.lists.truncate(kept.start);
    }

    fn node(&mut self, content: &Content, tile: &Tile, node: u32, list: Range<usize>) {
        let tree = &content.tree;
        let node = &tree.nodes[node as usize];
        let Some(children) = tree.children(node) else {
            for &piece in tree.members_of(node) {
                let corners = content.pieces[piece as usize].corners;
                let carrier = self.carrier;
                carrier.clipped(tile, &corners, |part| self.triangle(tile, piece, &part, 0, list.clone()));
            }
            return;
        };
        let bounds = children.map(|child| {
            let [lo, hi] = tree.nodes[child as usize].bounds;
            self.carrier.bounds_in(tile, lo.as_dvec3(), hi.as_dvec3())
        });
        let direction = self.inside[self.lists[list.start] as usize].ray.direction;
        let order = match &bounds {
            [Some(a), Some(b)] => near_first(&[*a, *b], direction),
            _ => [0, 1],
        };
        for i in order {
            let Some(bounds) = &bounds[i] else { continue };
            let kept = keep(self.slabs, self.lists, list.clone(), bounds);
            if !kept.is_empty() {
                self.node(content, tile, children[i], kept.clone());
            }
            self.lists.truncate(kept.start);
        }
    }

    /// Asks the rays of `list` for a triangle in box coordinates, halved until it is as curved as its image.
    fn triangle(&mut self, tile: &Tile, piece: u32, corners: &[DVec3; 3], halvings: u32, list: Range<usize>) {
        let Some(halves) = self.carrier.halves(corners, halvings) else {
            return self.meet(tile.copy, piece, corners, list);
        };
        for half in &halves {
            let Some(bounds) = self.carrier.bounds_of(half) else { continue };
            let kept = keep(self.slabs, self.lists, list.clone(), &bounds);
            if !kept.is_empty() {
                self.triangle(tile, piece, half, halvings + 1, kept.clone());
            }
            self.lists.truncate(kept.start);
        }
    }

    fn meet(&mut self, copy: [i32; 2], piece: u32, corners: &[DVec3; 3], list: Range<usize>) {
        let carried = corners.map(|u| self.carrier.point(u).as_vec3());
        let flat = (carried[1] - carried[0]).cross(carried[2] - carried[0]);
        let inside = self.inside;
        for at in list {
            let i = self.lists[at] as usize;
            let Inside { ray, start, query } = &inside[i];
            let query = &self.queries[*query as usize];
            if self.any && query.hit.is_some() {
                continue;
            }
            // Equal distances are let through, so that the order of the trees decides nothing.
            let Some((t, weights)) = intersect(&carried, ray, (query.end - start).next_up()) else {
                continue;
            };
            let w = weights.as_dvec3();
            let at = w.x * corners[0] + w.y * corners[1] + w.z * corners[2];
            let met = Met::Triangle { piece, flat };
            self.note(i, Hit { t: t + start, patch: self.patch, copy, at, met });
        }
    }

    /// Sends the rays of `list` through a cell of a density, the nearer half of its children first.
    fn cell(&mut self, medium: &Medium, tile: &Tile, cell: Cell, list: Range<usize>) {
        let (lo, edge) = cell.place();
        let carrier = self.carrier;
        let Some(bounds) = carrier.bounds_in(tile, lo, lo + edge).filter(|_| medium.most(cell) > 0.0) else {
            return;
        };
        let kept = keep(self.slabs, self.lists, list, &bounds);
        if kept.is_empty() {
            return;
        }
        if cell.level == Medium::DEPTH {
            let image = Image::new(medium, carrier, tile, cell);
            for at in kept.clone() {
                let i = self.lists[at] as usize;
                self.fly(&image, &bounds, tile.copy, cell, i);
            }
        } else {
            let along = self.inside[self.lists[kept.start] as usize].ray.direction;
            // In the texel, by the signs of the steps along its axes.
            let tangents = carrier.tangents(tile, carrier.in_box(tile, lo + 0.5 * edge));
            let near = [tangents.x_axis, tangents.y_axis, tangents.z_axis].map(|axis| axis.dot(along) < 0.0);
            let first = usize::from(near[0]) | usize::from(near[1]) << 1 | usize::from(near[2]) << 2;
            for child in 0..8 {
                self.cell(medium, tile, cell.child(child ^ first), kept.clone());
            }
        }
        self.lists.truncate(kept.start);
    }

    /// Sends one ray through a cell of a density.
    fn fly(&mut self, image: &Image, bounds: &[Vec3A; 2], copy: [i32; 2], cell: Cell, i: usize) {
        let Inside { ray, start, query } = &self.inside[i];
        let known = &self.queries[*query as usize];
        if self.any && known.hit.is_some() {
            return;
        }
        let [from, to] = self.slabs[i].span(bounds);
        let random = Random::new(known.flight, self.patch, copy, cell);
        if let Some((t, at)) = image.flight(ray.origin, ray.direction, [from, to], random) {
            self.note(i, Hit { t: t + start, patch: self.patch, copy, at, met: Met::Density });
        }
    }

    /// Keeps a hit of a ray if it is the first.
    fn note(&mut self, i: usize, hit: Hit) {
        let Inside { start, query, .. } = &self.inside[i];
        let query = &mut self.queries[*query as usize];
        let first = query
            .hit
            .is_none_or(|known| hit.t < known.t || (hit.t == known.t && hit.order() < known.order()));
        if first && hit.t <= query.end {
            query.end = hit.t;
            query.hit = Some(hit);
            self.slabs[i].end = if self.any { -1.0 } else { Slab::rounded_up(hit.t - start) };
        }
    }
}

/// How far along a ray a sphere begins, at least: moved there, its origin is exact enough in `f32`.
fn start(ray: &Ray, centre: DVec3, radius: f64) -> f64 {
    ((centre - ray.origin).dot(ray.direction) - 1.001 * radius).max(0.0)
}

/// Pushes those rays of `list` that meet the bounds, and says where.
fn keep(slabs: &[Slab], lists: &mut Vec<u32>, list: Range<usize>, bounds: &[Vec3A; 2]) -> Range<usize> {
    let begin = lists.len();
    for at in list {
        let i = lists[at];
        if slabs[i as usize].meets(bounds) {
            lists.push(i);
        }
    }
    begin..lists.len()
}

/// The order of two bounds along a direction.
fn near_first(bounds: &[[Vec3A; 2]; 2], direction: DVec3) -> [usize; 2] {
    let [a, b] = bounds.map(|[lo, hi]| (lo + hi).dot(direction.as_vec3a()));
    if a <= b { [0, 1] } else { [1, 0] }
}
