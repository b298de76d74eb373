//! A grid of parallel rays over the projection of a region's box, and where they cross the region.
//!
//! Samples of successive rows are displaced by the golden ratio, so that structures along a row (hairs) are not
//! met all or nothing.

use glam::{Vec2, Vec3};

use crate::region::Region;

/// What rays that miss the region count as long: nothing passes them at any extinction.
pub(crate) const MISSED: f32 = 1e9;

/// A direction to look along, and the axes of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Frame {
    pub(crate) direction: Vec3,
    pub(crate) across: [Vec3; 2],
}

impl Frame {
    /// Looks along a unit vector.
    pub(crate) fn new(direction: Vec3) -> Self {
        let (right, up) = direction.any_orthonormal_pair();
        // Turned by one radian, so that axis-aligned content does not run along rows.
        let (sin, cos) = 1.0_f32.sin_cos();
        Self { direction, across: [right * cos + up * sin, up * cos - right * sin] }
    }

    pub(crate) fn project(&self, p: Vec3) -> Vec2 {
        Vec2::new(self.across[0].dot(p), self.across[1].dot(p))
    }
}

/// The rays.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    pub(crate) frame: Frame,
    /// Rays in a row: whole vectors of lanes.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Picture coordinates of the grid's low corner, and between neighbours.
    pub(crate) origin: Vec2,
    pub(crate) spacing: Vec2,
    /// Where each ray enters the region, row by row; above `leave` if it misses it.
    pub(crate) enter: Vec<f32>,
    pub(crate) leave: Vec<f32>,
}

/// Rays that are treated at once: written so that the compiler can.
pub(crate) const LANES: usize = 8;

/// The numbers of the lanes.
pub(crate) const LANE: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

impl Grid {
    /// Lays out about `side`² rays over the region and finds where they enter and leave it.
    pub(crate) fn aim(&mut self, region: &Region, frame: Frame, side: usize) {
        self.frame = frame;
        self.columns = side.next_multiple_of(LANES);
        self.rows = (side * side).div_ceil(self.columns);
        let middle = frame.project(0.5 * (region.lo + region.hi));
        let half = 0.5 * (region.hi - region.lo);
        let reach = Vec2::new(half.dot(frame.across[0].abs()), half.dot(frame.across[1].abs()));
        self.origin = middle - reach;
        self.spacing = 2.0 * reach / Vec2::new(self.columns as f32, self.rows as f32);
        // Each pair of planes n·p = a, b is met at (a − n·(x e₁ + y e₂))/(n·d).
        let slabs = [(Vec3::X, 0), (Vec3::Y, 1), (Vec3::Z, 2), (region.normal, 3)].map(|(normal, axis)| {
            let speed = normal.dot(frame.direction);
            // Slower than this, the ray is parallel to the planes: they bound it a million edges away.
            let inverse = if speed.abs() < 1e-6 { 1e6 } else { speed.recip() };
            let [a, b] = if axis == 3 { region.slab } else { [region.lo[axis], region.hi[axis]] };
            let [a, b] = [a * inverse, b * inverse];
            (smaller(a, b), larger(a, b), frame.project(normal) * inverse)
        });
        self.enter.clear();
        self.leave.clear();
        for row in 0..self.rows {
            let y = self.origin.y + self.spacing.y * (row as f32 + 0.5);
            let left = self.origin.x + self.spacing.x * offset(row);
            for first in (0..self.columns).step_by(LANES) {
                let left = left + self.spacing.x * first as f32;
                let [mut enter, mut leave] = [f32::NEG_INFINITY, f32::INFINITY].map(|t| [t; LANES]);
                for (low, high, slope) in slabs {
                    let [start, step] = [slope.y * y + slope.x * left, slope.x * self.spacing.x];
                    for lane in 0..LANES {
                        let at = start + step * LANE[lane];
                        enter[lane] = larger(low - at, enter[lane]);
                        leave[lane] = smaller(high - at, leave[lane]);
                    }
                }
                self.enter.extend_from_slice(&enter);
                self.leave.extend_from_slice(&leave);
            }
        }
        if region.is_thin() {
            self.drop_cut_rays(region);
        }
    }

    /// The lengths of the rays in the region, in their order, [`MISSED`] where there is none; how many cross, and
    /// their mean length.
    pub(crate) fn lengths(&self, lengths: &mut Vec<f32>) -> (f32, f32) {
        lengths.clear();
        let [mut counts, mut sums] = [[0.0_f32; LANES]; 2];
        for (enter, leave) in self.enter.chunks_exact(LANES).zip(self.leave.chunks_exact(LANES)) {
            let mut row = [0.0; LANES];
            for lane in 0..LANES {
                let length = leave[lane] - enter[lane];
                let crosses = length > 0.0;
                row[lane] = if crosses { length } else { MISSED };
                counts[lane] += if crosses { 1.0 } else { 0.0 };
                sums[lane] += if crosses { length } else { 0.0 };
            }
            lengths.extend_from_slice(&row);
        }
        let [count, sum] = [counts, sums].map(|lanes| lanes.iter().sum::<f32>());
        (count, sum / count)
    }

    /// Area that one ray stands for.
    pub(crate) fn footprint(&self) -> f32 {
        self.spacing.x * self.spacing.y
    }

    /// The point of a ray at distance `t`.
    pub(crate) fn point(&self, row: usize, column: usize, t: f32) -> Vec3 {
        let x = self.origin.x + self.spacing.x * (column as f32 + offset(row));
        let y = self.origin.y + self.spacing.y * (row as f32 + 0.5);
        self.frame.across[0] * x + self.frame.across[1] * y + self.frame.direction * t
    }

    /// Distance along the rays to the plane of a triangle, over grid coordinates (x, y): constant, and per unit of
    /// each. `None` where the plane is seen edge-on.
    pub(crate) fn plane(&self, triangle: &[Vec3; 3]) -> Option<(f32, Vec2)> {
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let speed = normal.dot(self.frame.direction);
        // (n·d) t = n·v − n·(x e₁ + y e₂).
        let slope = -self.frame.project(normal) / speed;
        let base = normal.dot(triangle[0]) / speed + slope.dot(self.origin);
        (speed != 0.0).then_some((base, slope * self.spacing))
    }

    /// Forgets the rays that leave a thin slab through the side of the voxel (not where the matter ends inside
    /// it): the sheet that they would meet lies in the neighbour, which stops them. Keeps all if it would none.
    fn drop_cut_rays(&mut self, region: &Region) {
        // Within 1e-3 of an edge from the voxel's side; as long as from plane to plane, to 2 % (the planes of a
        // sheet in the voxel's side are snapped to slightly outside it).
        const CLOSE: f32 = 1e-3;
        const WHOLE: f32 = 0.98;
        let across = (region.slab[1] - region.slab[0]) / region.normal.dot(self.frame.direction).abs();
        let at_side = |p: Vec3| p.min_element() < CLOSE || p.max_element() > 1.0 - CLOSE;
        let is_kept = |(ray, (&enter, &leave)): (usize, (&f32, &f32))| {
            let length = leave - enter;
            let at = |t| self.point(ray / self.columns, ray % self.columns, t);
            length >= WHOLE * across || length > 0.0 && ![enter, leave].iter().any(|&t| at_side(at(t)))
        };
        let kept: Vec<bool> = self.enter.iter().zip(&self.leave).enumerate().map(is_kept).collect();
        if kept.contains(&true) {
            for (leave, _) in self.leave.iter_mut().zip(kept).filter(|(_, kept)| !kept) {
                *leave = f32::NEG_INFINITY;
            }
        }
    }
}

/// Where the first sample of a row stands, in spacings.
pub(crate) const fn offset(row: usize) -> f32 {
    // Multiples of the golden ratio, from the top bits of a wrapping product.
    (row as u32).wrapping_mul(0x9e37_79b9).wrapping_add(1 << 31) as f32 / (1_u64 << 32) as f32
}

/// The larger of two numbers that are not NaN, in one instruction.
#[inline]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers that are not NaN, in one instruction.
#[inline]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Rounds down numbers within ±2²². (The standard `floor` is a library call on plain x86-64.)
#[inline]
pub(crate) fn floor(x: f32) -> i32 {
    let whole = nearest(x);
    whole - i32::from(whole as f32 > x)
}

/// Rounds up numbers within ±2²².
#[inline]
pub(crate) fn ceil(x: f32) -> i32 {
    let whole = nearest(x);
    whole + i32::from((whole as f32) < x)
}

/// The nearest integer, by the bits that remain when 1.5·2²³ is added.
#[inline]
fn nearest(x: f32) -> i32 {
    const ROUND: f32 = 12_582_912.0;
    (x + ROUND).to_bits().wrapping_sub(ROUND.to_bits()) as i32
}
