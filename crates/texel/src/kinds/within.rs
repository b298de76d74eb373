//! Keeps plants in the texel.

use glam::Vec3;

use crate::Geometry;

/// Adds a plant that grew out of `root` on the ground, no larger than fits below the texel's top; what would reach
/// below the ground lies on it.
pub(super) fn plant(geometry: &mut Geometry, mut plant: Geometry, root: Vec3) {
    /// Texel edges: a little below the top, where a deformed box may be folded.
    const TOP: f32 = 0.99;
    let top = plant.triangles.iter().flatten().map(|p| p.z).fold(f32::MIN_POSITIVE, f32::max);
    let scale = (TOP / top).min(1.0);
    for corner in plant.triangles.iter_mut().flatten() {
        *corner = root + (*corner - root) * scale;
        corner.z = corner.z.max(0.0);
    }
    geometry.triangles.append(&mut plant.triangles);
    geometry.colors.append(&mut plant.colors);
}
