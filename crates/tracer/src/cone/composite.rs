//! Front to back: the trails of all boxes merged by distance and cut by what is opaque. [seed §6.2]

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::{BuildHasherDefault, Hasher};

use glam::Vec3;
use pelage_geom::{Cone, Ray};

use super::edges::{Corners, Glance, are_mixed};
use super::march::{Beam, march};
use super::passages::{self, BoxPassage};
use super::path::Chord;
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
    /// Distance of its mean visible point, in scene units.
    pub t: f32,
    /// That point, in texel coordinates.
    pub at: Vec3,
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
    /// How many rays it has been seen by.
    rays: u32,
    corners: Corners,
    passages: Vec<BoxPassage>,
    /// Of a ray beside.
    beside: Vec<BoxPassage>,
    trail: Trail,
    /// Pieces not yet composited, in order of distance: of boxes that the ray is in at the same time.
    pending: Vec<Piece>,
    /// Of each voxel seen, its place among them.
    places: HashMap<VoxelKey, u32, BuildHasherDefault<KeyHasher>>,
    /// The voxels' places by distance, each below the bits of its distance.
    order: Vec<u64>,
    chosen: Vec<SeenVoxel>,
}

impl View {
    /// Forgets the last pixel.
    pub fn clear(&mut self) {
        self.voxels.clear();
        self.surfaces.clear();
        self.rays = 0;
    }

    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.trail.counts)
    }

    /// Follows one ray of a pixel, of which it is the part `share`. Returns what gets through to the background.
    pub fn trace(&mut self, scene: &Scene, settings: &Settings, ray: &Ray, cone: &Cone, share: f32) -> f32 {
        let surface = find(scene, ray, &mut self.passages);
        self.follow(scene, Beam { ray, cone, settings }, surface, share)
    }

    /// Follows the only ray of a pixel, if one is enough. Returns what gets through to the background then. `through` gives
    /// the ray through a corner of the picture's pixels, `pixel` is the cone of this one.
    pub fn trace_alone(
        &mut self,
        scene: &Scene,
        beam: Beam,
        corners: [[u32; 2]; 4],
        through: impl Fn([u32; 2]) -> Ray,
        pixel: &Cone,
    ) -> Option<f32> {
        let Beam { ray, cone, settings } = beam;
        let surface = find(scene, ray, &mut self.passages);
        let middle = Glance::new(scene, surface, &self.passages);
        if !(middle.is_backed() && are_mixed(scene, settings, ray, cone, &self.passages)) {
            return None;
        }
        let Self { corners: known, beside, .. } = self;
        let without_edge = corners.into_iter().all(|corner| {
            let there = known.at(corner).unwrap_or_else(|| {
                let surface = find(scene, &through(corner), beside);
                known.keep(corner, Glance::new(scene, surface, beside))
            });
            middle.continues(&there, pixel.spread)
        });
        without_edge.then(|| self.follow(scene, beam, surface, 1.0))
    }

    /// Follows a ray through the boxes that were found, up to the surface.
    fn follow(&mut self, scene: &Scene, beam: Beam, surface: Option<SurfaceHit>, share: f32) -> f32 {
        let Beam { ray, cone, settings } = beam;
        self.rays += 1;
        let Self { voxels, surfaces, passages, trail, pending, .. } = self;
        trail.counts.rays += 1;
        trail.clear();
        pending.clear();
        let mut sight =
            Sight { voxels, settings, share, direction: ray.direction.as_vec3(), blend: Blend::START };
        for (i, passage) in passages.iter().enumerate() {
            // What lies before this box's entry can be overtaken by nothing more.
            let t = passage.t[0] as f32;
            let ready = pending.partition_point(|piece| piece.t < t);
            for piece in pending.drain(..ready) {
                sight.show(&trail.chords, &piece);
            }
            if sight.is_done() {
                break;
            }
            march(scene, beam, passage, sight.blend.transmittance(), settings.min_transmittance, trail);
            // Boxes that stand beside each other are gone through one after the other.
            let alone = passages.get(i + 1).is_none_or(|next| next.t[0] >= passage.t[1]);
            if alone && pending.is_empty() {
                for piece in trail.pieces() {
                    sight.show(&trail.chords, piece);
                }
            } else {
                pending.extend(trail.pieces());
                // Stable: of equal distances, the box that was entered first.
                pending.sort_by(|a, b| a.t.total_cmp(&b.t));
            }
        }
        for piece in pending.drain(..) {
            sight.show(&trail.chords, &piece);
        }

        let transmittance = sight.blend.transmittance();
        if transmittance < settings.min_transmittance {
            return 0.0;
        }
        let Some(hit) = surface else { return share * transmittance };
        let width = cone.width(hit.t) as f32;
        let (weight, reached) = (share * transmittance, transmittance);
        surfaces.push(SeenSurface { hit, weight, reached, direction: ray.direction.as_vec3(), width });
        0.0
    }

    /// Makes one of the pieces of each voxel, whichever rays they came from.
    pub fn merge(&mut self) {
        // One ray meets a voxel twice only where it comes back to it.
        if self.rays == 1 {
            return;
        }
        self.places.clear();
        let mut kept = 0;
        for i in 0..self.voxels.len() {
            let next = self.voxels[i];
            match self.places.entry(next.key) {
                Entry::Occupied(place) => self.voxels[*place.get() as usize].add(&next),
                Entry::Vacant(place) => {
                    place.insert(kept as u32);
                    self.voxels[kept] = next;
                    kept += 1;
                }
            }
        }
        self.voxels.truncate(kept);
    }

    /// The depth along `forward` at which half of what is visible, `alpha` in all, lies in front.
    pub fn median_depth(&mut self, forward: Vec3, alpha: f32) -> f32 {
        let depth = |t: f32, direction: Vec3| t * direction.dot(forward);
        self.order.clear();
        let voxels = self.voxels.iter().map(|v| depth(v.t, v.direction));
        let surfaces = self.surfaces.iter().map(|s| depth(s.hit.t as f32, s.direction));
        self.order.extend(voxels.chain(surfaces).enumerate().map(|(i, depth)| place_at(depth, i)));
        self.order.sort_unstable();
        let mut before = 0.0;
        for &entry in &self.order {
            let i = place_of(entry);
            before += match self.voxels.get(i) {
                Some(voxel) => voxel.weight,
                None => self.surfaces[i - self.voxels.len()].weight,
            };
            if before >= 0.5 * alpha {
                return f32::from_bits((entry >> 32) as u32);
            }
        }
        f32::INFINITY
    }

    /// Leaves at most `most` voxels (at least one), and gives them the weight of all: those that are heavier than
    /// their share stay as they are; of the others, in order of distance, every so much weight stands for its stretch.
    /// The heaviest alone would be the nearest, which more light reaches.
    pub fn choose(&mut self, most: usize) {
        let most = most.max(1);
        let Self { voxels, order, chosen, .. } = self;
        if voxels.len() <= most {
            return;
        }
        chosen.clear();
        let mut rest: f32 = voxels.iter().map(|v| v.weight).sum();
        // One place at least is kept for the rest.
        while chosen.len() + 1 < most {
            let Some(heaviest) = voxels.iter_mut().reduce(|a, b| if b.weight > a.weight { b } else { a })
            else {
                break;
            };
            if heaviest.weight * ((most - chosen.len()) as f32) < rest {
                break;
            }
            rest -= heaviest.weight;
            chosen.push(*heaviest);
            heaviest.weight = 0.0;
        }
        let left = most - chosen.len();
        let step = rest / left as f32;
        order.clear();
        order
            .extend(voxels.iter().enumerate().filter(|(_, v)| v.weight > 0.0).map(|(i, v)| place_at(v.t, i)));
        order.sort_unstable();
        let (mut next, mut before) = (0.5 * step, 0.0);
        for &entry in order.iter() {
            let voxel = &voxels[place_of(entry)];
            before += voxel.weight;
            // No lighter one is heavier than a step, so each stands for one at most.
            if next < before && chosen.len() < most {
                chosen.push(SeenVoxel { weight: step, ..*voxel });
                next += step;
            }
        }
        std::mem::swap(voxels, chosen);
    }
}

/// Finds the surface that ends a ray, if one does, and the boxes before it.
fn find(scene: &Scene, ray: &Ray, passages: &mut Vec<BoxPassage>) -> Option<SurfaceHit> {
    let surface = scene.surfaces.closest(ray, f64::INFINITY);
    let end = surface.map_or(f64::INFINITY, |hit| hit.t);
    passages::collect(scene, ray, 0.0, end, passages);
    surface
}

/// A place in a list below the bits of a distance, which is not negative: numbers that sort as the distances do.
fn place_at(distance: f32, place: usize) -> u64 {
    u64::from(distance.max(0.0).to_bits()) << 32 | place as u64
}

fn place_of(entry: u64) -> usize {
    (entry & 0xffff_ffff) as usize
}

impl SeenVoxel {
    /// Makes it the mean of itself and another piece of the same voxel.
    fn add(&mut self, other: &Self) {
        let weight = self.weight + other.weight;
        let part = other.weight / weight;
        self.t += part * (other.t - self.t);
        self.at = self.at.lerp(other.at, part);
        self.direction = self.direction.lerp(other.direction, part);
        self.weight = weight;
    }
}

/// Mixes the numbers of a key.
#[derive(Default)]
pub(super) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = (self.0.rotate_left(23) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

/// What one ray sees, front to back.
struct Sight<'a> {
    voxels: &'a mut Vec<SeenVoxel>,
    settings: &'a Settings,
    share: f32,
    direction: Vec3,
    blend: Blend,
}

impl Sight<'_> {
    /// Nothing behind may add: the loss is at most `min_transmittance`.
    fn is_done(&self) -> bool {
        self.blend.transmittance() < self.settings.min_transmittance
    }

    /// Lays one piece behind what has been seen.
    #[inline]
    fn show(&mut self, chords: &[Chord], piece: &Piece) {
        if self.is_done() {
            return;
        }
        let weight = self.share * self.blend.pass(piece.key.level, piece.even, piece.through);
        if weight > 0.0 {
            let chord = &chords[piece.chord as usize];
            let visible = mean_visible(piece.depth);
            let x = piece.range[0] + (piece.range[1] - piece.range[0]) * visible;
            let t = (chord.t[0] + (chord.t[1] - chord.t[0]) * f64::from(x)) as f32;
            let at = chord.at[0].lerp(chord.at[1], x);
            let Piece { key, voxel, .. } = *piece;
            self.voxels.push(SeenVoxel { key, voxel, weight, t, at, direction: self.direction });
        }
    }
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
