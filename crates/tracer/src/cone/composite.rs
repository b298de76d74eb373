//! Front to back: the trails of all boxes merged by distance and cut by what is opaque. [seed §6.2]

use glam::Vec3;
use pelage_geom::{Cone, Ray};

use super::march::{Beam, march};
use super::passages::{self, BoxPassage};
use super::{Blend, Piece, Trail, VoxelKey};
use crate::surface::SurfaceHit;
use crate::{Counts, Scene, Settings};

/// A voxel as a pixel sees it: the mean of its pieces over the pixel's rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenVoxel {
    pub key: VoxelKey,
    /// Index of the voxel in its level.
    pub voxel: u32,
    /// How much of the pixel it covers, after what is before it.
    pub weight: f32,
    /// Optical depth along the ray.
    pub depth: f32,
    /// Distance of its mean visible point, in scene units.
    pub t: f32,
    /// Where the ray enters and leaves it, in texel coordinates.
    pub at: [Vec3; 2],
    /// The direction of the ray, scene space.
    pub direction: Vec3,
}

/// A point of an opaque surface as a pixel sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenSurface {
    pub hit: SurfaceHit,
    /// How much of the pixel it covers.
    pub weight: f32,
    /// How much of its ray reaches it.
    pub reached: f32,
    /// The direction of the ray, scene space.
    pub direction: Vec3,
    /// How wide the cone is there, in scene units.
    pub width: f32,
}

/// Everything that a pixel sees, and the buffers to find it, reused from pixel to pixel.
#[derive(Default)]
pub(crate) struct View {
    pub voxels: Vec<SeenVoxel>,
    pub surfaces: Vec<SeenSurface>,
    passages: Vec<BoxPassage>,
    trail: Trail,
    /// Pieces not yet composited, in order of distance: of the boxes that the ray is in at the same time.
    pending: Vec<Piece>,
}

impl View {
    /// Forgets the last pixel.
    pub fn clear(&mut self) {
        self.voxels.clear();
        self.surfaces.clear();
    }

    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.trail.counts)
    }

    /// Follows one ray of a pixel, of which it is the part `share`. Returns what gets through to the background.
    pub fn trace(&mut self, scene: &Scene, settings: &Settings, ray: &Ray, cone: &Cone, share: f32) -> f32 {
        let surface = scene.surfaces.closest(ray, f64::INFINITY);
        let end = surface.map_or(f64::INFINITY, |hit| hit.t);
        let beam = Beam { ray, cone, settings };
        let direction = ray.direction.as_vec3();
        let mut blend = Blend::START;
        self.trail.counts.rays += 1;

        passages::collect(scene, ray, 0.0, end, &mut self.passages);
        self.trail.clear();
        self.pending.clear();
        for passage in &self.passages {
            // What lies before this box's entry can be overtaken by nothing more.
            let t = passage.t[0] as f32;
            let ready = self.pending.partition_point(|piece| piece.t < t);
            for piece in self.pending.drain(..ready) {
                show(&mut self.voxels, &self.trail, &piece, settings, share, direction, &mut blend);
            }
            if blend.transmittance() < settings.min_transmittance {
                break;
            }
            let before = self.trail.pieces.len();
            march(scene, beam, passage, &mut self.trail);
            self.pending.extend(self.trail.pieces.drain(before..));
            // Stable: of equal distances, the box that was entered first.
            self.pending.sort_by(|a, b| a.t.total_cmp(&b.t));
        }
        for piece in self.pending.drain(..) {
            show(&mut self.voxels, &self.trail, &piece, settings, share, direction, &mut blend);
        }

        let transmittance = blend.transmittance();
        if transmittance < settings.min_transmittance {
            return 0.0;
        }
        let Some(hit) = surface else { return share * transmittance };
        let width = cone.width(hit.t) as f32;
        let (weight, reached) = (share * transmittance, transmittance);
        self.surfaces.push(SeenSurface { hit, weight, reached, direction, width });
        0.0
    }

    /// Makes one of the pieces of each voxel, whichever rays they came from.
    pub fn merge(&mut self) {
        self.voxels.sort_by_key(|v| v.key);
        let mut kept = 0;
        for i in 0..self.voxels.len() {
            let next = self.voxels[i];
            if kept > 0 && self.voxels[kept - 1].key == next.key {
                let seen = &mut self.voxels[kept - 1];
                let weight = seen.weight + next.weight;
                let part = next.weight / weight;
                seen.depth += part * (next.depth - seen.depth);
                seen.t += part * (next.t - seen.t);
                seen.at = [0, 1].map(|i| seen.at[i].lerp(next.at[i], part));
                seen.direction = seen.direction.lerp(next.direction, part);
                seen.weight = weight;
            } else {
                self.voxels[kept] = next;
                kept += 1;
            }
        }
        self.voxels.truncate(kept);
    }

    /// Leaves at most `most` voxels (at least one), and gives them the weight of all: those that are heavier than
    /// their share stay as they are; of the others, in order of distance, every so much weight stands for its stretch.
    /// The heaviest alone would be the nearest, which more light reaches.
    pub fn choose(&mut self, most: usize) {
        let most = most.max(1);
        if self.voxels.len() <= most {
            return;
        }
        self.voxels.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.key.cmp(&b.key)));
        let mut rest: f32 = self.voxels.iter().map(|v| v.weight).sum();
        let mut heavy = 0;
        // One place at least is kept for the rest.
        while heavy + 1 < most && self.voxels[heavy].weight * (most - heavy) as f32 >= rest {
            rest -= self.voxels[heavy].weight;
            heavy += 1;
        }
        let step = rest / (most - heavy) as f32;
        let light = &mut self.voxels[heavy..];
        light.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.key.cmp(&b.key)));
        let (mut next, mut before, mut kept) = (0.5 * step, 0.0, heavy);
        for i in heavy..self.voxels.len() {
            let one = self.voxels[i];
            before += one.weight;
            // No lighter one is heavier than a step, so each stands for one at most.
            if next < before && kept < most {
                self.voxels[kept] = SeenVoxel { weight: step, ..one };
                next += step;
                kept += 1;
            }
        }
        self.voxels.truncate(kept);
    }
}

/// Lays one piece behind what has been seen.
fn show(
    voxels: &mut Vec<SeenVoxel>,
    trail: &Trail,
    piece: &Piece,
    settings: &Settings,
    share: f32,
    direction: Vec3,
    blend: &mut Blend,
) {
    // Nothing behind may add: the loss is at most `min_transmittance`.
    if blend.transmittance() < settings.min_transmittance {
        return;
    }
    let weight = share * blend.pass(piece.key.level, piece.even, piece.through);
    if weight > 0.0 {
        voxels.push(seen(trail, piece, weight, direction));
    }
}

fn seen(trail: &Trail, piece: &Piece, weight: f32, direction: Vec3) -> SeenVoxel {
    let Piece { key, voxel, depth, .. } = *piece;
    let [near, far] = trail.distances(piece);
    let t = near + (far - near) * mean_visible(depth);
    SeenVoxel { key, voxel, weight, depth, t, at: trail.points(piece), direction }
}

/// Where in a homogeneous stretch of optical depth τ the light that is seen comes from, as a fraction of its
/// length: 1/τ − 1/(e^τ − 1), the mean of x over the density e^−τx.
pub(crate) fn mean_visible(depth: f32) -> f32 {
    // The closed form loses its digits near zero; the series is good to 1e-6 below 0.1.
    if depth < 0.1 { 0.5 - depth / 12.0 } else { 1.0 / depth - 1.0 / depth.exp_m1() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_visible_point() {
        // τ = 0: the middle; τ large: 1/τ behind the entry; the two branches meet.
        assert!((mean_visible(0.0) - 0.5).abs() < 1e-6);
        assert!((mean_visible(50.0) - 0.02).abs() < 1e-6);
        assert!((mean_visible(0.0999) - mean_visible(0.1001)).abs() < 1e-4);
        // Against the integral ∫ x e^−τx dx / ∫ e^−τx dx for τ = 2, by the midpoint rule.
        let n = 10_000;
        let (mut top, mut bottom) = (0.0, 0.0);
        for i in 0..n {
            let x = (f64::from(i) + 0.5) / f64::from(n);
            top += x * (-2.0 * x).exp();
            bottom += (-2.0 * x).exp();
        }
        assert!((f64::from(mean_visible(2.0)) - top / bottom).abs() < 1e-6);
    }
}
