//! The light that reaches a coat from below: as a rule none, for it stands on a surface.

use glam::{DVec3, Vec3};
use pelage_geom::{Cone, Ray};

use super::composite::SeenVoxel;
use super::path::{lattice_inverse, to_box};
use super::shade::SKY_SPREAD;
use super::shadow::{Correlation, ShadowBuffers, ShadowCone};
use crate::{Scene, Settings};

/// What of the light from below reaches each box that a pixel sees.
#[derive(Default)]
pub(super) struct Below {
    places: Vec<SeenPlace>,
}

/// The mean of what a pixel sees of one box.
struct SeenPlace {
    patch: u32,
    weight: f32,
    /// Texel coordinates.
    at: Vec3,
    /// The direction of its rays, scene space.
    direction: Vec3,
    /// The edge of its voxels, in texel units.
    edge: f32,
    /// What of the light from below reaches it, once it is known.
    below: Option<f32>,
}

impl SeenPlace {
    fn new(voxel: &SeenVoxel) -> Self {
        let SeenVoxel { key, weight, at, direction, .. } = *voxel;
        Self { patch: key.patch, weight, at, direction, edge: edge_of(voxel), below: None }
    }

    fn add(&mut self, voxel: &SeenVoxel) {
        self.weight += voxel.weight;
        let part = voxel.weight / self.weight.max(f32::MIN_POSITIVE);
        self.at = self.at.lerp(voxel.at, part);
        self.direction = self.direction.lerp(voxel.direction, part);
        self.edge += part * (edge_of(voxel) - self.edge);
    }
}

fn edge_of(voxel: &SeenVoxel) -> f32 {
    1.0 / (1_u32 << voxel.key.level) as f32
}

impl Below {
    /// Begins with the voxels of another pixel.
    pub fn begin(&mut self, voxels: &[SeenVoxel]) {
        self.places.clear();
        for voxel in voxels {
            match self.places.iter_mut().find(|place| place.patch == voxel.key.patch) {
                Some(place) => place.add(voxel),
                None => self.places.push(SeenPlace::new(voxel)),
            }
        }
    }

    /// What of the light from below reaches what the pixel sees of a box: it is a small part of all light, and much the
    /// same for all of that.
    pub fn of(&mut self, shadows: &mut ShadowBuffers, scene: &Scene, settings: &Settings, patch: u32) -> f32 {
        let Some(i) = self.places.iter().position(|place| place.patch == patch) else { return 0.0 };
        let &SeenPlace { at, direction, edge, below, .. } = &self.places[i];
        below.unwrap_or_else(|| {
            let (_, standing) = scene.patch(patch);
            let map = scene.hexahedron(patch).map();
            let u = to_box(&standing.lattice, at).as_dvec3();
            let jacobian = map.jacobian(u).as_mat3() * lattice_inverse(&standing.lattice);
            // Half-way between straight down, where upright strands hide nothing, and where what is seen faces.
            let up = jacobian.z_axis.normalize_or_zero();
            let down = (-direction.normalize_or_zero() - up).normalize_or_zero();
            let width = jacobian.determinant().abs().cbrt() * edge;
            let below = from_below(shadows, scene, settings, map.point(u), down, width);
            self.places[i].below = Some(below);
            below
        })
    }
}

/// What of the light from below reaches a point of a coat past what is near: nothing, where a surface lies under it.
fn from_below(
    shadows: &mut ShadowBuffers,
    scene: &Scene,
    settings: &Settings,
    origin: DVec3,
    down: Vec3,
    width: f32,
) -> f32 {
    let direction = down.as_dvec3();
    let reach = f64::from(2.0 * scene.reach);
    if direction == DVec3::ZERO || scene.surfaces.blocked(&Ray { origin, direction }, reach) {
        return 0.0;
    }
    let cone = Cone { width: f64::from(width), spread: f64::from(SKY_SPREAD) };
    let start = f64::from(2.0 * width);
    let shadow = ShadowCone { origin, direction, start, end: reach, cone, correlation: Correlation::NONE };
    shadows.through_coats(scene, settings, &shadow)
}
