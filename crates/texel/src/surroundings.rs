//! Rays in the geometry of a texel: whether and where they meet a triangle.
//!
//! The triangles are copied, cell by cell, into blocks of four that are tested at once; a ray goes from cell to cell of
//! one level.

use glam::{IVec3, Vec3};
use wide::f32x4;

use crate::bricks::Bricks;
use crate::voxelise::{Cells, Facet};
use crate::{Line, Walk};

const LANES: usize = 4;

/// Four triangles, lane by lane. What is missing has no area.
#[derive(Clone, Copy, Debug)]
struct Block {
    corner: [f32x4; 3],
    sides: [[f32x4; 3]; 2],
    ids: [u32; LANES],
}

impl Block {
    fn new(facets: &[Facet], ids: impl Iterator<Item = usize>) -> Self {
        let mut lanes = [[[0.0; LANES]; 3]; 3];
        let mut names = [u32::MAX; LANES];
        for (lane, id) in ids.take(LANES).enumerate() {
            let [a, b, c] = facets[id].corners;
            for (vector, of_lanes) in [a, b - a, c - a].into_iter().zip(&mut lanes) {
                for axis in 0..3 {
                    of_lanes[axis][lane] = vector[axis];
                }
            }
            names[lane] = id as u32;
        }
        let [corner, ab, ac] = lanes.map(|vector| vector.map(f32x4::from));
        Self { corner, sides: [ab, ac], ids: names }
    }

    /// Where the ray meets each triangle; infinite where it does not. [Möller97]
    #[inline]
    fn hits(&self, from: [f32x4; 3], d: [f32x4; 3]) -> f32x4 {
        let [ab, ac] = self.sides;
        let p = cross(d, ac);
        // Without area, the inverse is infinite and what follows is NaN, which is within no bounds.
        let inverse = f32x4::ONE / dot(ab, p);
        // Written out: `map` is a call of its own for each triangle.
        let [x, y, z] = self.corner;
        let s = [from[0] - x, from[1] - y, from[2] - z];
        let q = cross(s, ab);
        let [u, v] = [dot(s, p) * inverse, dot(d, q) * inverse];
        let inside = u.simd_ge(f32x4::ZERO) & v.simd_ge(f32x4::ZERO) & (u + v).simd_le(f32x4::ONE);
        inside.select(dot(ac, q) * inverse, f32x4::splat(f32::INFINITY))
    }
}

#[inline]
fn splat(v: Vec3) -> [f32x4; 3] {
    [f32x4::splat(v.x), f32x4::splat(v.y), f32x4::splat(v.z)]
}

#[inline]
fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The geometry, to be asked by rays.
pub(crate) struct Surroundings {
    /// The cells that hold something.
    bricks: Bricks,
    periodic: bool,
    blocks: Vec<Block>,
    /// Where each cell's blocks begin, and the end.
    starts: Vec<u32>,
}

impl Surroundings {
    /// The facets listed in the cells of a level of `resolution` cells a side.
    pub(crate) fn new(facets: &[Facet], cells: &Cells, resolution: u32, periodic: bool) -> Self {
        let mut blocks = Vec::new();
        let mut starts = Vec::with_capacity(cells.codes().len() + 1);
        for cell in 0..cells.codes().len() {
            starts.push(blocks.len() as u32);
            let mut ids = cells.facets(cell);
            while ids.len() > 0 {
                blocks.push(Block::new(facets, ids.by_ref().take(LANES)));
            }
        }
        starts.push(blocks.len() as u32);
        Self { bricks: Bricks::new(resolution, cells.codes()), periodic, blocks, starts }
    }

    /// Where a segment (texel units) first meets a facet, as a part of it; infinite if it meets none.
    pub(crate) fn first_hit(&self, from: Vec3, to: Vec3) -> f32 {
        self.meet(None, from, to - from, [0.0, 1.0], 0.0)
    }

    /// How far from a point of the facet `own` a ray in the unit direction `d` first meets another one, in texel units;
    /// infinite if it meets none within `far`. Which one it meets within `near` is of no interest.
    pub(crate) fn distance(&self, own: usize, at: Vec3, d: Vec3, near: f32, far: f32) -> f32 {
        /// What lies nearer than this part of the reach is the seam to a neighbour.
        const NEAREST: f32 = 1e-4;
        self.meet(Some(own as u32), at, d, [NEAREST * near, far], near)
    }

    /// The first hit in `range`, or any that is below `enough`; never with `own` itself, though with its copies.
    fn meet(&self, own: Option<u32>, from: Vec3, d: Vec3, range: [f32; 2], enough: f32) -> f32 {
        let size = self.bricks.resolution() as i32;
        let scale = size as f32;
        let log = size.trailing_zeros();
        let [near, far] = range;
        let along = splat(d);
        let mut first = far;
        let line = Line::new(from * scale, far * d * scale);
        for step in Walk::new(&self.bricks, self.periodic, &line, [0.0, 1.0]) {
            if first <= step.enter * far || first < enough {
                break;
            }
            // Of periodic content, the cell's copy inside the tile holds the list.
            let copy: IVec3 = step.cell >> log;
            let origin = splat(from - copy.as_vec3());
            let own = own.filter(|_| copy == IVec3::ZERO).unwrap_or(u32::MAX);
            let cell = step.voxel as usize;
            for block in &self.blocks[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
                let hits = block.hits(origin, along);
                if !(hits.simd_ge(f32x4::splat(near)) & hits.simd_lt(f32x4::splat(first))).any() {
                    continue;
                }
                for (hit, id) in hits.to_array().into_iter().zip(block.ids) {
                    if hit > near && hit < first && id != own {
                        first = hit;
                    }
                }
            }
        }
        if first < far { first } else { f32::INFINITY }
    }
}
