//! Where the matter of a voxel lies: its tight box, cut by the slab along its dominant normal.

use glam::Vec3;
use pelage_geom::Symmetric3;

use crate::Voxel;
use crate::grid::{larger, smaller};
use crate::packed::{snapped_box, snapped_normal, snapped_slab};
use crate::voxelise::Polygon;

/// Box ∩ slab, in the voxel's frame, snapped to what a voxel can store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Region {
    pub(crate) lo: Vec3,
    pub(crate) hi: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) slab: [f32; 2],
}

impl Region {
    /// The region of the parts of triangles (voxel's frame) inside the voxel; `None` if no part is.
    pub(crate) fn new(parts: &Parts) -> Option<Self> {
        let (&first, rest) = parts.vertices.split_first()?;
        let normal = snapped_normal(parts.normal());
        let mut region = Self { lo: first, hi: first, normal, slab: [normal.dot(first); 2] };
        for &p in rest {
            let height = normal.dot(p);
            region.lo = region.lo.min(p);
            region.hi = region.hi.max(p);
            region.slab = [smaller(height, region.slab[0]), larger(height, region.slab[1])];
        }
        Some(region.thickened(Voxel::MIN_THICKNESS))
    }

    /// At least `thickness` in each direction, the box still inside the voxel.
    fn thickened(mut self, thickness: f32) -> Self {
        let [mut lo, mut hi] = [self.lo.clamp(Vec3::ZERO, Vec3::ONE), self.hi.clamp(Vec3::ZERO, Vec3::ONE)];
        for axis in 0..3 {
            let missing = 0.5 * (thickness - (hi[axis] - lo[axis]));
            if missing > 0.0 {
                let low = (lo[axis] - missing).clamp(0.0, 1.0 - thickness);
                (lo[axis], hi[axis]) = (low, low + thickness);
            }
        }
        let [lo, hi] = snapped_box(lo, hi);
        (self.lo, self.hi) = (lo, hi);
        let missing = 0.5 * (thickness - (self.slab[1] - self.slab[0])).max(0.0);
        let [low, high] = [self.slab[0] - missing, self.slab[1] + missing];
        // A sheet in the voxel's side thickens inwards only, as the box does.
        let middle = self.normal.dot(0.5 * (lo + hi));
        let reach = self.normal.abs().dot(0.5 * (hi - lo));
        let shift = (middle - reach - low).max(0.0) - (high - middle - reach).max(0.0);
        self.slab = snapped_slab([low + shift, high + shift]);
        self
    }

    /// Whether the matter is thin along its normal: rays through it cross it from plane to plane.
    pub(crate) fn is_thin(&self) -> bool {
        //: slabs under .08 of an edge behave as sheets.
        self.slab[1] - self.slab[0] < 0.08
    }
    /// Whether it is no thicker than it has to be: all the matter lies in one plane.
    pub(crate) fn is_planar(&self) -> bool {
        // Rounding what is stored outwards takes under 2e-4 of an edge.
        self.slab[1] - self.slab[0] < Voxel::MIN_THICKNESS + 5e-4
    }
}

/// The parts of triangles inside a voxel, in its frame: convex polygons.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    vertices: Vec<Vec3>,
    /// The triangle of each part, its vector area, and where its vertices end.
    ends: Vec<(u32, Vec3, u32)>,
    /// Σ area · n nᵀ.
    areas: Symmetric3,
}

impl Parts {
    /// Clips triangles to the unit cube.
    pub(crate) fn clip(&mut self, triangles: &[[Vec3; 3]]) {
        self.vertices.clear();
        self.ends.clear();
        self.areas = Symmetric3::ZERO;
        for (id, &triangle) in (0..).zip(triangles) {
            if let Some(polygon) = Polygon::new(triangle).clipped_to_unit_cube() {
                let doubled = polygon.doubled_area();
                self.areas += Symmetric3::outer(doubled) * doubled.length().recip().min(f32::MAX);
                self.vertices.extend_from_slice(polygon.vertices());
                self.ends.push((id, doubled, self.vertices.len() as u32));
            }
        }
    }

    /// Each part's triangle, twice its vector area, and its vertices.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = (u32, Vec3, &[Vec3])> {
        let mut start = 0;
        self.ends.iter().map(move |&(id, doubled, end)| {
            let vertices = &self.vertices[start..end as usize];
            start = end as usize;
            (id, doubled, vertices)
        })
    }

    /// The dominant normal: the eigenvector of the largest eigenvalue of Σ area · n nᵀ, by squaring the matrix. Where
    /// the two largest are so close (2 %) that 2⁸ do not part them, neither is dominant.
    fn normal(&self) -> Vec3 {
        let mut power = self.areas;
        for _ in 0..8 {
            power = power * power.trace().recip();
            let Symmetric3 { xx, yy, zz, xy, xz, yz } = power;
            power = Symmetric3 {
                xx: xx * xx + xy * xy + xz * xz,
                yy: xy * xy + yy * yy + yz * yz,
                zz: xz * xz + yz * yz + zz * zz,
                xy: xx * xy + xy * yy + xz * yz,
                xz: xx * xz + xy * yz + xz * zz,
                yz: xy * xz + yy * yz + yz * zz,
            };
        }
        let columns = power.to_mat3();
        let columns = [columns.x_axis, columns.y_axis, columns.z_axis];
        let longest = columns
            .into_iter()
            .fold(Vec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
        longest.try_normalize().unwrap_or(Vec3::Z)
    }
}
