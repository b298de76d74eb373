//! What the rays of a large grid hit first and last: triangles drawn row by row, with their depths.
//!
//! Tracing a grid of parallel rays against a list of triangles is drawing the triangles: each visits only the
//! rows it spans and in each only the rays between its two edges. For the coarse levels, where a voxel holds
//! thousands of triangles; see [`silhouette`](crate::silhouette) for the fine ones.

use glam::{Vec2, Vec3};

use crate::grid::{Frame, Grid, ceil, floor, offset};
use crate::region::Region;

/// What a ray met first and last: distance along the ray, and the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hits {
    pub(crate) first: (f32, u32),
    pub(crate) last: (f32, u32),
}

impl Hits {
    pub(crate) const NONE: Self = Self { first: (f32::INFINITY, 0), last: (f32::NEG_INFINITY, 0) };

    /// Whether there are any.
    pub(crate) fn any(&self) -> bool {
        self.first.0 < f32::INFINITY
    }

    /// One more.
    #[inline]
    pub(crate) fn add(&mut self, t: f32, id: u32) {
        if t < self.first.0 {
            self.first = (t, id);
        }
        if t > self.last.0 {
            self.last = (t, id);
        }
    }
}

/// Hits of a grid of rays.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raster {
    pub(crate) grid: Grid,
    /// Hits count this far before and behind the region.
    tolerance: f32,
    hits: Vec<Hits>,
}

impl Raster {
    /// Draws the triangles, in the voxel's frame, with about `side`² rays.
    pub(crate) fn draw(&mut self, region: &Region, triangles: &[[Vec3; 3]], frame: Frame, side: usize) {
        self.grid.aim(region, frame, side);
        let speed = region.normal.dot(frame.direction).abs();
        let thickness = region.slab[1] - region.slab[0];
        // A ray may leave a thin slab through the voxel's side before it meets the sheet that fills it.
        self.tolerance = if region.is_thin() { (thickness / speed).min(0.3) } else { 1e-4 };
        self.hits.clear();
        self.hits.resize(self.grid.enter.len(), Hits::NONE);
        for (id, triangle) in triangles.iter().enumerate() {
            self.draw_triangle(triangle, id as u32);
        }
    }

    /// What the rays that cross the region hit there.
    pub(crate) fn crossing(&self) -> impl Iterator<Item = &Hits> {
        let crosses = self.grid.enter.iter().zip(&self.grid.leave).map(|(enter, leave)| leave > enter);
        self.hits.iter().zip(crosses).filter(|(hits, crosses)| *crosses && hits.any()).map(|(hits, _)| hits)
    }

    fn draw_triangle(&mut self, triangle: &[Vec3; 3], id: u32) {
        let grid = &self.grid;
        // In the grid's own frame: one unit a spacing, row r at y = r + ½.
        let scale = grid.spacing.recip();
        let mut p = triangle.map(|v| (grid.frame.project(v) - grid.origin) * scale);
        let [low, high] = [p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2])];
        let [columns, rows] = [grid.columns as f32, grid.rows as f32];
        if high.x < 0.0 || low.x > columns || high.y < 0.5 || low.y > rows - 0.5 {
            return;
        }
        let rows = [ceil(low.y.max(0.0) - 0.5), floor(high.y.min(rows) - 0.5)];
        if rows[0] > rows[1] {
            return;
        }
        let Some((base, slope)) = grid.plane(triangle) else {
            return;
        };
        let t = triangle.map(|v| grid.frame.direction.dot(v));
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
            let left = ceil((a.min(b) - offset).max(0.0).min(columns));
            let right = floor((a.max(b) - offset).min(columns - 1.0).max(-1.0));
            let first = row as usize * grid.columns;
            for column in left..=right {
                let i = first + column as usize;
                let t = base + slope.x * (column as f32 + offset) + slope.y * y;
                let t = t.clamp(nearest, farthest);
                if t >= grid.enter[i] - self.tolerance && t <= grid.leave[i] + self.tolerance {
                    self.hits[i].add(t, id);
                }
            }
        }
    }
}

fn sort_upwards(p: &mut [Vec2; 3]) {
    let above = |a: Vec2, b: Vec2| a.y > b.y || a.y == b.y && a.x > b.x;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if above(p[i], p[j]) {
            p.swap(i, j);
        }
    }
}
