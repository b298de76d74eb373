//! Triangles to cells: which triangles have area in which cells of a level.
//!
//! Triangles are sliced, not tested: by the planes of x, then y, then z, so that a triangle is listed exactly
//! where a part of it lies. Cells are half-open (a triangle in the plane between two cells belongs to the upper
//! one), so nothing is listed twice. Only non-empty cells take memory. A coarser level's lists are the unions of
//! its children's, which makes a cell occupied exactly where one of its children is.

use std::collections::HashSet;
use std::ops::Range;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::bricks::{demorton, morton};
use crate::grid::{larger, smaller};

/// Parts of triangles below this area, in squares of the finest voxel's edge, are dropped.
const MIN_AREA: f32 = 1e-10;

/// A triangle of the tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facet {
    /// Corners, in texel coordinates.
    pub(crate) corners: [Vec3; 3],
    /// Linear albedo.
    pub(crate) color: Vec3,
}

/// The facets that reach into the tile `[0, 1]³`, each once; of periodic geometry, every copy that does.
pub(crate) fn tile(triangles: &[[Vec3; 3]], colors: &[Vec3], periodic: bool) -> Vec<Facet> {
    let mut facets = Vec::with_capacity(triangles.len());
    let mut known = HashSet::with_capacity(triangles.len());
    for (&corners, &color) in triangles.iter().zip(colors) {
        let [a, b, c] = corners;
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
        if low.z > 1.0 || high.z < 0.0 || (b - a).cross(c - a) == Vec3::ZERO {
            continue;
        }
        // What is there twice hides no more than once.
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        if !known.insert((corners.map(bits), bits(color))) {
            continue;
        }
        if !periodic {
            facets.push(Facet { corners, color });
            continue;
        }
        let copies = |axis: usize| {
            let first = low[axis].floor();
            let last = if low[axis] == high[axis] { first } else { high[axis].ceil() - 1.0 };
            first as i32..=last as i32
        };
        for t in copies(1) {
            for s in copies(0) {
                let shift = Vec3::new(s as f32, t as f32, 0.0);
                facets.push(Facet { corners: corners.map(|p| p - shift), color });
            }
        }
    }
    facets
}

/// Which facets have area in which cells of one level.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cells {
    /// Morton code of the cell, then the facet: sorted, distinct.
    entries: Vec<u64>,
    /// Morton codes of the occupied cells, ascending.
    codes: Vec<u32>,
    /// Where each cell's entries begin, and the end.
    starts: Vec<u32>,
}

impl Cells {
    /// Slices the facets into the cells of a level of `resolution` cells a side.
    pub(crate) fn new(facets: &[Facet], resolution: u32) -> Self {
        let parts: Vec<Vec<u64>> = facets
            .par_chunks(256)
            .enumerate()
            .map(|(chunk, facets)| {
                let mut entries = Vec::new();
                for (i, facet) in facets.iter().enumerate() {
                    let id = (chunk * 256 + i) as u64;
                    slice_to_cells(facet.corners.map(|p| p * resolution as f32), resolution, |cell| {
                        entries.push(u64::from(morton(cell)) << 32 | id);
                    });
                }
                entries
            })
            .collect();
        let mut entries = parts.concat();
        entries.par_sort_unstable();
        Self::from_sorted(entries)
    }

    /// The level above: every cell lists what its children list.
    pub(crate) fn parents(&self) -> Self {
        const FACET: u64 = u32::MAX as u64;
        let mut entries: Vec<u64> = self.entries.iter().map(|e| e >> 35 << 32 | e & FACET).collect();
        entries.par_sort_unstable();
        entries.dedup();
        Self::from_sorted(entries)
    }

    fn from_sorted(entries: Vec<u64>) -> Self {
        let [mut codes, mut starts] = [Vec::new(), Vec::new()];
        for (at, entry) in entries.iter().enumerate() {
            let code = (entry >> 32) as u32;
            if codes.last() != Some(&code) {
                codes.push(code);
                starts.push(at as u32);
            }
        }
        starts.push(entries.len() as u32);
        Self { entries, codes, starts }
    }

    /// Morton codes of the occupied cells, ascending.
    pub(crate) fn codes(&self) -> &[u32] {
        &self.codes
    }

    /// How many pairs of cell and facet there are.
    pub(crate) fn entry_count(&self) -> usize {
        self.entries.len()
    }

    /// How many facets an occupied cell lists on the mean; 0 without any.
    pub(crate) fn facets_a_cell(&self) -> f32 {
        self.entries.len() as f32 / self.codes.len().max(1) as f32
    }

    /// For each cell, which of the cells of a `finer` level lie in it, `bits` being three for each level between.
    pub(crate) fn descendants(&self, finer: &Self, bits: u32) -> Vec<Range<usize>> {
        let first = |code: u64| finer.codes.partition_point(|&c| u64::from(c) < code << bits);
        self.codes.iter().map(|&c| first(u64::from(c))..first(u64::from(c) + 1)).collect()
    }

    /// Where the `i`-th cell stands.
    pub(crate) fn cell(&self, i: usize) -> IVec3 {
        IVec3::from_array(demorton(self.codes[i]).map(|c| c as i32))
    }

    /// The facets of the `i`-th cell.
    pub(crate) fn facets(&self, i: usize) -> impl ExactSizeIterator<Item = usize> + '_ {
        let range = self.starts[i] as usize..self.starts[i + 1] as usize;
        self.entries[range].iter().map(|&entry| entry as u32 as usize)
    }
}

/// A convex polygon: a triangle cut by at most six planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    vertices: [Vec3; 9],
    len: usize,
}

impl Polygon {
    pub(crate) fn new(triangle: [Vec3; 3]) -> Self {
        let mut vertices = [Vec3::ZERO; 9];
        vertices[..3].copy_from_slice(&triangle);
        Self { vertices, len: 3 }
    }

    fn empty() -> Self {
        Self { vertices: [Vec3::ZERO; 9], len: 0 }
    }

    fn push(&mut self, vertex: Vec3) {
        // A plane adds at most one vertex to a convex polygon; rounding could only make it less convex.
        if self.len < self.vertices.len() {
            self.vertices[self.len] = vertex;
            self.len += 1;
        }
    }

    pub(crate) fn vertices(&self) -> &[Vec3] {
        &self.vertices[..self.len]
    }

    /// Twice the vector area.
    pub(crate) fn doubled_area(&self) -> Vec3 {
        let v = self.vertices();
        (2..v.len()).map(|i| (v[i - 1] - v[0]).cross(v[i] - v[0])).sum()
    }

    /// Bounds along an axis.
    fn extent(&self, axis: usize) -> [f32; 2] {
        let v = self.vertices().iter().map(|v| v[axis]);
        v.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], v| [smaller(v, low), larger(v, high)])
    }

    /// The parts below and above the plane `axis = at`.
    fn split(&self, axis: usize, at: f32) -> [Self; 2] {
        let [mut below, mut above] = [Self::empty(), Self::empty()];
        let v = self.vertices();
        for (i, &b) in v.iter().enumerate() {
            let a = v[if i == 0 { v.len() - 1 } else { i - 1 }];
            let [da, db] = [a[axis] - at, b[axis] - at];
            if (da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0) {
                let mut cut = a + (b - a) * (da / (da - db));
                cut[axis] = at;
                below.push(cut);
                above.push(cut);
            }
            if db <= 0.0 {
                below.push(b);
            }
            if db >= 0.0 {
                above.push(b);
            }
        }
        [below, above]
    }

    /// The part of the polygon where `sign · (coordinate − at) ≥ 0`, `sign` being 1 or −1.
    pub(crate) fn cut(&self, axis: usize, at: f32, sign: f32) -> Self {
        let mut kept = Self::empty();
        let v = self.vertices();
        let Some(mut a) = v.last() else {
            return kept;
        };
        let mut da = sign * (a[axis] - at);
        for b in v {
            let db = sign * (b[axis] - at);
            if da * db < 0.0 {
                let mut cut = *a + (*b - *a) * (da / (da - db));
                cut[axis] = at;
                kept.push(cut);
            }
            if db >= 0.0 {
                kept.push(*b);
            }
            (a, da) = (b, db);
        }
        kept
    }

    /// The part inside the unit cube, if it has any.
    pub(crate) fn clipped_to_unit_cube(mut self) -> Option<Self> {
        for axis in 0..3 {
            let [low, high] = self.extent(axis);
            if low > 1.0 || high < 0.0 {
                return None;
            }
            if low < 0.0 {
                self = self.cut(axis, 0.0, 1.0);
            }
            if high > 1.0 {
                self = self.cut(axis, 1.0, -1.0);
            }
            if self.len < 3 {
                return None;
            }
        }
        Some(self)
    }

    /// Cuts the polygon at whole coordinates of an axis and passes each part on with its slice, `0..resolution`.
    fn slices(mut self, axis: usize, resolution: u32, mut part: impl FnMut(u32, Self)) {
        let [low, high] = self.extent(axis);
        let top = resolution as i32 - 1;
        if high < 0.0 || low > resolution as f32 {
            return;
        }
        let first = low.floor() as i32;
        let last = if low == high { first } else { high.ceil() as i32 - 1 };
        if first < 0 {
            self = self.split(axis, 0.0)[1];
        }
        let [first, last] = [first.clamp(0, top), last.clamp(0, top)];
        for slice in first..=last {
            let reaches_beyond = slice < last || high > resolution as f32;
            let mut here = self;
            if reaches_beyond {
                [here, self] = self.split(axis, (slice + 1) as f32);
            }
            if here.len >= 3 {
                part(slice as u32, here);
            }
        }
    }
}

/// Passes on every cell in which the triangle (in cells) has area.
fn slice_to_cells(triangle: [Vec3; 3], resolution: u32, mut cell: impl FnMut([u32; 3])) {
    Polygon::new(triangle).slices(0, resolution, |x, polygon| {
        polygon.slices(1, resolution, |y, polygon| {
            polygon.slices(2, resolution, |z, polygon| {
                if polygon.doubled_area().length() > 2.0 * MIN_AREA {
                    cell([x, y, z]);
                }
            });
        });
    });
}
