//! What a small grid of rays hits: silhouettes only, depths where they are asked for.
//!
//! The hot loop of the builder: at fine levels a voxel holds a few pieces of triangles, and there are hundreds
//! of thousands of voxels. Pieces are clipped to the voxel beforehand, so covering a ray is being hit by it, and
//! are convex: a ray is inside where all edge functions are positive, so the least of them over the
//! edges of a piece, and of that the greatest over the pieces, says for every ray whether it hits. No branch
//! depends on the content. Which piece is first or last is found for the few rays that colours are measured at.

use glam::{Vec2, Vec3};

use crate::grid::{Frame, Grid, LANE, LANES, larger, offset, smaller};
use crate::raster::Hits;
use crate::region::{Parts, Region};

/// Pieces drawn on a grid of at most 8² rays.
#[derive(Clone, Debug, Default)]
pub(crate) struct Silhouette {
    pub(crate) grid: Grid,
    /// The edge functions of all pieces, over grid coordinates: one unit a spacing, row r at y = r + ½.
    edges: Vec<Edge>,
    drawn: Vec<Drawn>,
    /// The rays that hit something: bit 8·row + column.
    covered: u64,
}

/// x·a + y·b + c, positive inside.
#[derive(Clone, Copy, Debug)]
struct Edge {
    slope: Vec2,
    base: f32,
}

/// A piece that is not seen edge-on.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    triangle: u32,
    /// Where its edges end.
    end: u32,
}

impl Silhouette {
    /// Rays a side, at most.
    pub(crate) const SIDE: usize = LANES;

    /// Draws the parts with about `side`² rays.
    pub(crate) fn draw(&mut self, region: &Region, parts: &Parts, frame: Frame, side: usize) {
        self.grid.aim(region, frame, side.min(Self::SIDE));
        let scale = self.grid.spacing.recip();
        let axes = [frame.across[0] * scale.x, frame.across[1] * scale.y];
        let origin = self.grid.origin * scale;
        let project = |v: Vec3| Vec2::new(axes[0].dot(v), axes[1].dot(v)) - origin;
        let mut inside = [[-1.0_f32; LANES]; Self::SIDE];
        let inside = &mut inside[..self.grid.rows.min(Self::SIDE)];
        self.edges.clear();
        self.drawn.clear();
        for (triangle, normal, vertices) in parts.pieces() {
            let start = self.edges.len();
            let facing = normal.dot(frame.direction);
            let Some(&last) = vertices.last().filter(|_| facing != 0.0) else {
                continue;
            };
            let turn = facing.signum();
            let mut a = project(last);
            let [mut low, mut high] = [a.y; 2];
            self.edges.extend(vertices.iter().map(|&vertex| {
                let b = project(vertex);
                let slope = turn * Vec2::new(a.y - b.y, b.x - a.x);
                let base = -slope.dot(a);
                (low, high) = (smaller(b.y, low), larger(b.y, high));
                a = b;
                Edge { slope, base }
            }));
            self.drawn.push(Drawn { triangle, end: self.edges.len() as u32 });
            let edges = &self.edges[start..];
            // The rows whose middles it spans; conversion rounds towards 0 and stops there.
            let rows = (low + 0.5) as usize..((high + 0.5) as usize).min(inside.len());
            for row in rows {
                let mut least = [f32::INFINITY; LANES];
                let from = Vec2::new(OFFSETS[row], row as f32 + 0.5);
                for edge in edges {
                    let first = edge.slope.dot(from) + edge.base;
                    for lane in 0..LANES {
                        least[lane] = smaller(first + edge.slope.x * LANE[lane], least[lane]);
                    }
                }
                let inside = &mut inside[row];
                for lane in 0..LANES {
                    inside[lane] = larger(least[lane], inside[lane]);
                }
            }
        }
        self.covered = mask(inside.iter().flatten().map(|&inside| inside >= 0.0));
        if region.is_thin() {
            let rays = self.grid.enter.iter().zip(&self.grid.leave);
            self.covered &= mask(rays.map(|(enter, leave)| leave > enter));
        }
    }

    /// How many rays of the region hit something.
    pub(crate) fn seen_count(&self) -> u32 {
        self.covered.count_ones()
    }

    /// What up to `count` of the rays that hit something hit, spread over them.
    pub(crate) fn hits<'a>(
        &'a self,
        triangles: &'a [[Vec3; 3]],
        count: u32,
    ) -> impl Iterator<Item = Hits> + 'a {
        let every = (self.seen_count() / count.max(1)).max(1);
        // From the middle of the first stretch, so that a few rays are not all from one border.
        let rays =
            set_bits(self.covered).skip(every as usize / 2).step_by(every as usize).take(count as usize);
        rays.map(|ray| {
            let [row, column] = [ray / LANES, ray % LANES];
            self.hits_of(triangles, Vec2::new(column as f32 + offset(row), row as f32 + 0.5))
        })
        .filter(Hits::any)
    }

    /// What the ray at a point of the grid hits.
    fn hits_of(&self, triangles: &[[Vec3; 3]], at: Vec2) -> Hits {
        let mut hits = Hits::NONE;
        let mut start = 0;
        for piece in &self.drawn {
            let edges = &self.edges[start..piece.end as usize];
            start = piece.end as usize;
            // As far beyond an edge as rounding may have put the ray, in spacings × length.
            let least = edges.iter().fold(0.0, |least, edge| smaller(edge.slope.dot(at) + edge.base, least));
            if least < -1e-5 {
                continue;
            }
            let triangle = &triangles[piece.triangle as usize];
            if let Some((base, slope)) = self.grid.plane(triangle) {
                let t = triangle.map(|v| self.grid.frame.direction.dot(v));
                let [near, far] = [t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2])];
                hits.add((base + slope.dot(at)).clamp(near, far), piece.triangle);
            }
        }
        hits
    }
}

/// Up to 64 truths as bits.
fn mask(truths: impl Iterator<Item = bool>) -> u64 {
    truths.zip(0..64_u32).fold(0, |mask, (truth, bit)| mask | u64::from(truth) << bit)
}

/// The places of the bits that are set, ascending.
fn set_bits(mut mask: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// [`offset`] of the first rows.
const OFFSETS: [f32; Silhouette::SIDE] = {
    let mut offsets = [0.0; Silhouette::SIDE];
    let mut row = 0;
    while row < offsets.len() {
        offsets[row] = offset(row);
        row += 1;
    }
    offsets
};
