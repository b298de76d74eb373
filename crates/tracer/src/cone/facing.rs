//! What the eye sees of a voxel: the points of its surface, its lobes, the points of its density, or normals of its
//! ellipsoid.

use glam::{Mat3, Vec3};
use pelage_texel::{Level, Scatterers, Surfel, Voxel};

/// A part of what the eye sees of a voxel.
pub(super) struct Visible {
    /// Unit normal on the seen side, scene space.
    pub normal: Vec3,
    pub color: Vec3,
    /// How much of what is seen, up to a factor common to all.
    pub weight: f32,
    /// Which part of the voxel it is, if one.
    pub point: Option<Point>,
}

/// What a voxel holds, by its number.
#[derive(Clone, Copy)]
pub(super) enum Point {
    Surfel(u32),
    Lobe(u32),
    Scatterer(u32),
}

/// How a voxel is looked at.
pub(super) struct Facing {
    /// Unit vector to the eye, texel space.
    pub view: Vec3,
    /// J⁻ᵀ: carries normals into the scene.
    pub cofactor: Mat3,
    /// Multiplies its colours.
    pub tint: Vec3,
}

impl Facing {
    /// The surfels that the eye sees.
    pub fn collect(&self, surfels: &[Surfel], visible: &mut Vec<Visible>) {
        visible.clear();
        let one = |(i, surfel): (usize, &Surfel)| {
            let normal = surfel.normal();
            Visible {
                normal: (self.cofactor * normal).normalize_or_zero(),
                color: surfel.color() * self.tint,
                weight: surfel.weight() * normal.dot(self.view),
                point: Some(Point::Surfel(i as u32)),
            }
        };
        visible.extend(surfels.iter().enumerate().filter(|(_, s)| s.sees(self.view)).map(one));
        // Seen through a gap that the masks are too coarse for.
        if visible.is_empty() {
            let faces = |(_, s): &(usize, &Surfel)| s.normal().dot(self.view) > 0.0;
            visible.extend(surfels.iter().enumerate().filter(faces).map(one));
        }
    }

    /// The lobes that are seen from here.
    pub fn collect_lobes(&self, level: &Level, voxel: u32, visible: &mut Vec<Visible>) {
        for (share, lobes) in level.lobes(voxel, self.view) {
            let whole: f32 = lobes.clone().map(|i| level.lobe(i).weight()).sum();
            visible.extend(lobes.map(|i| {
                let lobe = level.lobe(i);
                Visible {
                    normal: (self.cofactor * lobe.normal()).normalize_or_zero(),
                    color: lobe.color() * self.tint,
                    weight: share * lobe.weight() / whole,
                    point: Some(Point::Lobe(i)),
                }
            }));
        }
    }

    /// The scatterers, by how much of each passes to the eye.
    pub fn collect_scatterers(&self, scatterers: Scatterers, visible: &mut Vec<Visible>) {
        visible.extend(scatterers.points().iter().enumerate().map(|(i, point)| Visible {
            normal: (self.cofactor * point.normal()).normalize_or_zero(),
            color: point.color() * self.tint,
            // Where hardly anything passes, all count alike.
            weight: point.weight() * scatterers.transmittance(i, self.view).max(1e-4),
            point: Some(Point::Scatterer(i as u32)),
        }));
    }

    /// `count` normals (1 to 16) of the visible half of the voxel's ellipsoid, equal parts of what is seen.
    pub fn collect_ellipsoid(&self, voxel: &Voxel, count: u32, visible: &mut Vec<Visible>) {
        visible.clear();
        let seen = voxel.normals().visible(if self.view == Vec3::ZERO { Vec3::Z } else { self.view });
        let count = count.clamp(1, 16);
        for i in 0..count {
            // The first `count` points of Hammersley's set, centred in their strata.
            let x = (i as f32 + 0.5) / count as f32;
            let y = (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32 + 0.5 / count as f32;
            visible.push(Visible {
                normal: (self.cofactor * seen.sample([x, y.fract()])).normalize_or_zero(),
                color: voxel.albedo * self.tint,
                weight: 1.0,
                point: None,
            });
        }
    }
}
