//! A grid of parallel rays through a voxel's region, and what they hit: triangles drawn row by row.
//!
//! Tracing a grid of parallel rays against a list of triangles is drawing the triangles: each visits only the
//! rows it spans and in each only the rays between its two edges. Samples of successive rows are displaced by
//! the golden ratio, so that structures along a row (hairs) are not met all or nothing.

use core::f32::consts::FRAC_2_SQRT_PI;

use glam::{Vec2, Vec3};

use crate::region::Region;

/// What one ray meets in the region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    /// Where the ray is in the region; reversed if it misses it.
    pub(crate) chord: [f32; 2],
    /// Distance and triangle of the first hit; infinite if there is none.
    pub(crate) first: (f32, u32),
    /// Distance and triangle of the last hit; minus infinity if there is none.
    pub(crate) last: (f32, u32),
}

impl Ray {
    /// Whether it crosses the region.
    pub(crate) fn crosses(&self) -> bool {
        self.chord[0] < self.chord[1]
    }

    /// Length in the region.
    pub(crate) fn length(&self) -> f32 {
        self.chord[1] - self.chord[0]
    }

    /// Whether it hits anything.
    pub(crate) fn hits(&self) -> bool {
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
    rays: Vec<Ray>,
    tolerance: f32,
}

impl Raster {
    /// Draws the triangles, in the voxel's frame, along the unit vector `direction` with `side`² rays.
    pub(crate) fn draw(&mut self, region: &Region, triangles: &[[Vec3; 3]], direction: Vec3, side: usize) {
        self.aim(region, direction, side);
        for (id, triangle) in triangles.iter().enumerate() {
            self.draw_triangle(triangle, id as u32);
        }
    }

    /// The rays, those that miss the region among them.
    pub(crate) fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// Area that one ray stands for.
    pub(crate) fn footprint(&self) -> f32 {
        self.spacing.x * self.spacing.y
    }

    /// Lays out the rays and finds their chords.
    fn aim(&mut self, region: &Region, direction: Vec3, side: usize) {
        let (right, up) = direction.any_orthonormal_pair();
        // Turned away from the frame's axes, so that axis-aligned content does not run along rows.
        let (sin, cos) = FRAC_2_SQRT_PI.sin_cos();
        self.across = [right * cos + up * sin, up * cos - right * sin];
        (self.side, self.direction) = (side, direction);
        let [mut low, mut high] = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { region.lo[axis] } else { region.hi[axis] };
            let p = self.project(Vec3::new(pick(0), pick(1), pick(2)));
            (low, high) = (low.min(p), high.max(p));
        }
        self.origin = low;
        self.spacing = (high - low) / side as f32;
        let speed = region.normal.dot(direction).abs();
        let thickness = region.slab[1] - region.slab[0];
        // A ray may leave a thin slab through the voxel's side before it meets the sheet that fills it.
        self.tolerance = if region.is_thin() { (thickness / speed).min(0.3) } else { 1e-4 };
        self.rays.clear();
        for row in 0..side {
            for column in 0..side {
                let at = self.sample(row, column);
                let p = self.across[0] * at.x + self.across[1] * at.y;
                let [a, b] = region.intervals(p, direction);
                let chord = [a[0].max(b[0]), a[1].min(b[1])];
                self.rays.push(Ray { chord, first: (f32::INFINITY, 0), last: (f32::NEG_INFINITY, 0) });
            }
        }
    }

    fn project(&self, p: Vec3) -> Vec2 {
        Vec2::new(self.across[0].dot(p), self.across[1].dot(p))
    }

    /// Where the first sample of a row stands, in spacings.
    fn offset(row: usize) -> f32 {
        const GOLDEN: f32 = 0.618_034;
        (row as f32 * GOLDEN + 0.5).fract()
    }

    fn sample(&self, row: usize, column: usize) -> Vec2 {
        self.origin + self.spacing * Vec2::new(column as f32 + Self::offset(row), row as f32 + 0.5)
    }

    fn draw_triangle(&mut self, triangle: &[Vec3; 3], id: u32) {
        let mut p = triangle.map(|v| self.project(v));
        let [low, high] = [p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2])];
        // In spacings, row r stands at r + ½.
        let first = ((low.y - self.origin.y) / self.spacing.y - 0.5).ceil().max(0.0);
        let last = ((high.y - self.origin.y) / self.spacing.y - 0.5).floor().min(self.side as f32 - 1.0);
        let columns = (Vec2::new(low.x, high.x) - self.origin.x) / self.spacing.x;
        if first > last || columns.x > self.side as f32 || columns.y < 0.0 {
            return;
        }
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let speed = normal.dot(self.direction);
        if speed == 0.0 {
            return;
        }
        // Distance along the ray: d·n t = n·v − n·(x e₁ + y e₂).
        let slope = -self.project(normal) / speed;
        let base = normal.dot(triangle[0]) / speed;
        let t = triangle.map(|v| self.direction.dot(v));
        let [nearest, farthest] = [t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2])];
        // Edges run upwards whichever triangle they belong to, so that neighbours leave no gap between them.
        p.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
        let edges = [(p[0], p[1]), (p[1], p[2]), (p[0], p[2])];
        let slopes = edges.map(|(a, b)| (b.x - a.x) / (b.y - a.y));
        for row in first as usize..=last as usize {
            let y = self.origin.y + self.spacing.y * (row as f32 + 0.5);
            let upper = usize::from(y >= p[1].y);
            let ends = [upper, 2].map(|edge| edges[edge].0.x + (y - edges[edge].0.y) * slopes[edge]);
            let offset = Self::offset(row);
            let columns = ends.map(|x| (x - self.origin.x) / self.spacing.x - offset);
            let left = columns[0].min(columns[1]).ceil().max(0.0);
            let right = columns[0].max(columns[1]).floor().min(self.side as f32 - 1.0);
            if !(left <= right) {
                continue;
            }
            for column in left as usize..=right as usize {
                let x = self.origin.x + self.spacing.x * (column as f32 + offset);
                let t = (base + slope.x * x + slope.y * y).clamp(nearest, farthest);
                let ray = &mut self.rays[row * self.side + column];
                if t >= ray.chord[0] - self.tolerance && t <= ray.chord[1] + self.tolerance {
                    if t < ray.first.0 {
                        ray.first = (t, id);
                    }
                    if t > ray.last.0 {
                        ray.last = (t, id);
                    }
                }
            }
        }
    }
}
