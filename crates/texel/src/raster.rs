//! A grid of parallel rays through a voxel's region, and what they hit: triangles drawn row by row.
//!
//! Tracing a grid of parallel rays against a list of triangles is drawing the triangles: each visits only the
//! rows it spans and in each only the rays between its two edges. Samples of successive rows are displaced by
//! the golden ratio, so that structures along a row (hairs) are not met all or nothing.
//!
//! This is the hot loop of the builder. What a ray needs is kept in one array a quantity, so that the compiler
//! can treat several rays at once; rounding goes through integers, because `floor` is a library call on plain
//! x86-64.

use glam::{Vec2, Vec3};

use crate::own_shadow::Seen;
use crate::region::Region;

/// What a ray met first and last: distance along the ray, and the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hits {
    pub(crate) first: (f32, u32),
    pub(crate) last: (f32, u32),
}

impl Hits {
    const NONE: Self = Self { first: (f32::INFINITY, 0), last: (f32::NEG_INFINITY, 0) };

    /// Whether there are any.
    pub(crate) fn any(&self) -> bool {
        self.first.0 < f32::INFINITY
    }
}

/// A square grid of parallel rays over the projection of a region's box.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raster {
    side: usize,
    direction: Vec3,
    across: [Vec3; 2],
    origin: Vec2,
    spacing: Vec2,
    /// Hits count this far before and behind the region.
    tolerance: f32,
    /// Where each ray enters the region, row by row; above `leave` if it misses it.
    enter: Vec<f32>,
    leave: Vec<f32>,
    hits: Vec<Hits>,
}

impl Raster {
    /// Draws the triangles, in the voxel's frame, along the unit vector `direction` with `side`² rays.
    pub(crate) fn draw(&mut self, region: &Region, triangles: &[[Vec3; 3]], direction: Vec3, side: usize) {
        self.aim(region, direction, side);
        if region.is_thin() {
            self.drop_cut_rays(region);
        }
        for (id, triangle) in triangles.iter().enumerate() {
            self.draw_triangle(triangle, id as u32);
        }
    }

    /// The rays that cross the region: their length in it, and what they hit there.
    pub(crate) fn crossing(&self) -> impl Iterator<Item = (f32, &Hits)> + Clone {
        let lengths = self.enter.iter().zip(&self.leave).map(|(enter, leave)| leave - enter);
        lengths.zip(&self.hits).filter(|(length, _)| *length > 0.0)
    }

    /// What rays of the region see from their two ends: one ray in `every`, from one end and the other in turn.
    pub(crate) fn seen(&self, every: usize) -> impl Iterator<Item = Seen> + '_ {
        let hits = self.hits.iter().enumerate().filter(|(_, hits)| hits.any());
        // From the middle of the first stretch, so that a few rays are not all from one border.
        hits.skip(every / 2).step_by(every).enumerate().map(|(i, (ray, hits))| {
            let front = i % 2 == 0;
            let (t, triangle) = if front { hits.first } else { hits.last };
            let viewer = if front { -self.direction } else { self.direction };
            let point = self.point(ray, t);
            Seen { point, triangle, viewer }
        })
    }

    /// Area that one ray stands for.
    pub(crate) fn footprint(&self) -> f32 {
        self.spacing.x * self.spacing.y
    }

    /// Lays out the rays and finds where they enter and leave the region.
    fn aim(&mut self, region: &Region, direction: Vec3, side: usize) {
        let (right, up) = direction.any_orthonormal_pair();
        // Turned by one radian, so that axis-aligned content does not run along rows.
        let (sin, cos) = 1.0_f32.sin_cos();
        self.across = [right * cos + up * sin, up * cos - right * sin];
        (self.side, self.direction) = (side, direction);
        let middle = self.project(0.5 * (region.lo + region.hi));
        let half = 0.5 * (region.hi - region.lo);
        let reach = Vec2::new(half.dot(self.across[0].abs()), half.dot(self.across[1].abs()));
        self.origin = middle - reach;
        self.spacing = 2.0 * reach / side as f32;
        let speed = region.normal.dot(direction).abs();
        let thickness = region.slab[1] - region.slab[0];
        // A ray may leave a thin slab through the voxel's side before it meets the sheet that fills it.
        self.tolerance = if region.is_thin() { (thickness / speed).min(0.3) } else { 1e-4 };

        // Each pair of planes n·p = a, b is met at (a − n·(x e₁ + y e₂))/(n·d).
        let slabs = [(Vec3::X, 0), (Vec3::Y, 1), (Vec3::Z, 2), (region.normal, 3)].map(|(normal, axis)| {
            let speed = normal.dot(direction);
            // Slower than this, the ray is parallel to the planes: they bound it a million edges away.
            let inverse = if speed.abs() < 1e-6 { 1e6 } else { speed.recip() };
            let [a, b] = if axis == 3 { region.slab } else { [region.lo[axis], region.hi[axis]] };
            let [a, b] = [a * inverse, b * inverse];
            (a.min(b), a.max(b), self.project(normal) * inverse)
        });
        let count = side * side;
        self.hits.clear();
        self.hits.resize(count, Hits::NONE);
        self.enter.clear();
        self.enter.resize(count, f32::NEG_INFINITY);
        self.leave.clear();
        self.leave.resize(count, f32::INFINITY);
        let rows = self.enter.chunks_exact_mut(side).zip(self.leave.chunks_exact_mut(side));
        for (row, (enter, leave)) in rows.enumerate() {
            let y = self.origin.y + self.spacing.y * (row as f32 + 0.5);
            let left = self.origin.x + self.spacing.x * offset(row);
            for (low, high, slope) in slabs {
                let [start, step] = [slope.y * y + slope.x * left, slope.x * self.spacing.x];
                for (column, (enter, leave)) in enter.iter_mut().zip(leave.iter_mut()).enumerate() {
                    let at = start + step * column as f32;
                    *enter = enter.max(low - at);
                    *leave = leave.min(high - at);
                }
            }
        }
    }

    /// Forgets the rays that leave a thin slab through the side of the voxel (not where the matter ends inside
    /// it): the sheet that they would meet lies in the neighbour, which stops them. Keeps all if it would none.
    fn drop_cut_rays(&mut self, region: &Region) {
        // Within 1e-3 of an edge from the voxel's side; as long as from plane to plane, to 2 % (the planes of a
        // sheet in the voxel's side are snapped to slightly outside it).
        const CLOSE: f32 = 1e-3;
        const WHOLE: f32 = 0.98;
        let across = (region.slab[1] - region.slab[0]) / region.normal.dot(self.direction).abs();
        let at_side = |p: Vec3| p.min_element() < CLOSE || p.max_element() > 1.0 - CLOSE;
        let is_kept = |(ray, (&enter, &leave)): (usize, (&f32, &f32))| {
            let length = leave - enter;
            length >= WHOLE * across
                || length > 0.0 && ![enter, leave].iter().any(|&t| at_side(self.point(ray, t)))
        };
        let kept: Vec<bool> = self.enter.iter().zip(&self.leave).enumerate().map(is_kept).collect();
        if kept.contains(&true) {
            for (leave, _) in self.leave.iter_mut().zip(kept).filter(|(_, kept)| !kept) {
                *leave = f32::NEG_INFINITY;
            }
        }
    }

    /// The point of a ray at distance `t`.
    fn point(&self, ray: usize, t: f32) -> Vec3 {
        let (row, column) = (ray / self.side, ray % self.side);
        let x = self.origin.x + self.spacing.x * (column as f32 + offset(row));
        let y = self.origin.y + self.spacing.y * (row as f32 + 0.5);
        self.across[0] * x + self.across[1] * y + self.direction * t
    }

    fn project(&self, p: Vec3) -> Vec2 {
        Vec2::new(self.across[0].dot(p), self.across[1].dot(p))
    }

    fn draw_triangle(&mut self, triangle: &[Vec3; 3], id: u32) {
        // In the grid's own frame: one unit a spacing, row r at y = r + ½.
        let scale = self.spacing.recip();
        let mut p = triangle.map(|v| (self.project(v) - self.origin) * scale);
        let [low, high] = [p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2])];
        let side = self.side as f32;
        if high.x < 0.0 || low.x > side || high.y < 0.5 || low.y > side - 0.5 {
            return;
        }
        let rows = [ceil(low.y.max(0.0) - 0.5), floor(high.y.min(side) - 0.5)];
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let speed = normal.dot(self.direction);
        if rows[0] > rows[1] || speed == 0.0 {
            return;
        }
        // Distance along the ray: (n·d) t = n·v − n·(x e₁ + y e₂).
        let slope = -self.project(normal) / speed;
        let base = normal.dot(triangle[0]) / speed + slope.dot(self.origin);
        let slope = slope * self.spacing;
        let t = triangle.map(|v| self.direction.dot(v));
        let [nearest, farthest] = [t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2])];
        // Edges run upwards whichever triangle they belong to, so that neighbours leave no gap between them.
        sort_upwards(&mut p);
        let run = |a: Vec2, b: Vec2| (b.x - a.x) / (b.y - a.y);
        let [lower, upper, long] = [run(p[0], p[1]), run(p[1], p[2]), run(p[0], p[2])];
        for row in rows[0]..=rows[1] {
            let y = row as f32 + 0.5;
            let (from, run) = if y < p[1].y { (p[0], lower) } else { (p[1], upper) };
            let offset = offset(row as usize);
            let [a, b] = [from.x + (y - from.y) * run, p[0].x + (y - p[0].y) * long];
            let left = ceil((a.min(b) - offset).max(0.0).min(side));
            let right = floor((a.max(b) - offset).min(side - 1.0).max(-1.0));
            let first = row as usize * self.side;
            for column in left..=right {
                let i = first + column as usize;
                let t = base + slope.x * (column as f32 + offset) + slope.y * y;
                let t = t.clamp(nearest, farthest);
                if t >= self.enter[i] - self.tolerance && t <= self.leave[i] + self.tolerance {
                    let hits = &mut self.hits[i];
                    if t < hits.first.0 {
                        hits.first = (t, id);
                    }
                    if t > hits.last.0 {
                        hits.last = (t, id);
                    }
                }
            }
        }
    }
}

/// Where the first sample of a row stands, in spacings.
fn offset(row: usize) -> f32 {
    // Multiples of the golden ratio, from the top bits of a wrapping product.
    (row as u32).wrapping_mul(0x9e37_79b9).wrapping_add(1 << 31) as f32 / (1_u64 << 32) as f32
}

fn sort_upwards(p: &mut [Vec2; 3]) {
    let above = |a: Vec2, b: Vec2| a.y > b.y || a.y == b.y && a.x > b.x;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if above(p[i], p[j]) {
            p.swap(i, j);
        }
    }
}

/// Rounds down numbers within ±2²².
fn floor(x: f32) -> i32 {
    let whole = nearest(x);
    whole - i32::from(whole as f32 > x)
}

/// Rounds up numbers within ±2²².
fn ceil(x: f32) -> i32 {
    let whole = nearest(x);
    whole + i32::from((whole as f32) < x)
}

/// The nearest integer, by the bits that remain when 1.5·2²³ is added.
fn nearest(x: f32) -> i32 {
    const ROUND: f32 = 12_582_912.0;
    (x + ROUND).to_bits().wrapping_sub(ROUND.to_bits()) as i32
}
