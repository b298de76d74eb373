//! Where the matter of a voxel lies: its tight box, cut by the slab along its dominant normal.

use glam::Vec3;
use pelage_geom::Symmetric3;

use crate::Voxel;
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
    pub(crate) fn new(triangles: &[[Vec3; 3]], parts: &mut Vec<Vec3>) -> Option<Self> {
        parts.clear();
        let mut areas = Symmetric3::ZERO;
        for &triangle in triangles {
            if let Some(polygon) = Polygon::new(triangle).clipped_to_unit_cube() {
                let doubled = polygon.doubled_area();
                areas += Symmetric3::outer(doubled) * doubled.length().recip().min(f32::MAX);
                parts.extend_from_slice(polygon.vertices());
            }
        }
        let (&first, rest) = parts.split_first()?;
        let normal = snapped_normal(if areas.is_finite() { areas.eigen().1.x_axis } else { Vec3::Z });
        let mut region = Self { lo: first, hi: first, normal, slab: [normal.dot(first); 2] };
        for &p in rest {
            let height = normal.dot(p);
            region.lo = region.lo.min(p);
            region.hi = region.hi.max(p);
            region.slab = [region.slab[0].min(height), region.slab[1].max(height)];
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
}
