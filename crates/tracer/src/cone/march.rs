//! From chords to voxels: what a cone meets inside one box, at the two levels that fit its width. [seed §6, Neyret98]

use pelage_geom::{Cone, Ray};
use pelage_texel::{Crossing, Line, Step, Texel};

use super::lod::{Band, lambda};
use super::passages::BoxPassage;
use super::path::{Chord, LocalRay};
use super::{Blend, Piece, Trail, VoxelKey};
use crate::{Opacity, Path, Scene, Settings};

/// Two chords may differ by this much of a level before one level for both would show.
const LEVELS_PER_CHORD: f32 = 0.25;

/// A ray with its width and what the user chose.
#[derive(Clone, Copy)]
pub(crate) struct Beam<'a> {
    pub ray: &'a Ray,
    pub cone: &'a Cone,
    pub settings: &'a Settings,
}

/// Follows the beam through one box and appends what it meets to `trail`. Stops where less than
/// `settings.min_transmittance` gets through. Returns what gets through this box.
pub(crate) fn march(scene: &Scene, beam: Beam, passage: &BoxPassage, trail: &mut Trail) -> f32 {
    let Beam { ray, cone, settings } = beam;
    let (coat, patch) = scene.patch(passage.patch);
    let texel = &coat.texel;
    let local = LocalRay::new(scene.hexahedron(passage.patch).map(), patch.lattice, ray);

    let level_at = |end: usize| {
        let jacobian = local.texel_jacobian(passage.u[end].as_vec3());
        lambda(settings.lod, &jacobian, local.direction(), cone, passage.t[end])
            .clamp(0.0, texel.depth() as f32)
    };
    let levels = [level_at(0), level_at(1)];
    let finest = Band::of(levels[0].max(levels[1]), texel.depth()).finest();
    let least = ((levels[1] - levels[0]).abs() / LEVELS_PER_CHORD).ceil() as usize;

    let first = trail.chords.len();
    match settings.path {
        Path::Curved => {
            let tolerance = settings.path_tolerance / (1_u32 << finest) as f32;
            local.chords(passage, tolerance, least, &mut trail.chords);
        }
        Path::Straight => local.straight(passage, least, &mut trail.chords),
    }

    let span = (passage.t[1] - passage.t[0]).max(f64::MIN_POSITIVE);
    let mut blend = Blend::START;
    let begin = trail.pieces.len();
    for index in first..trail.chords.len() {
        let chord = trail.chords[index];
        let middle = ((0.5 * (chord.t[0] + chord.t[1]) - passage.t[0]) / span) as f32;
        let band = Band::of(levels[0] + (levels[1] - levels[0]) * middle, texel.depth());
        for (l, weight) in band.levels() {
            let walker = Walker {
                texel,
                patch: passage.patch,
                opacity: settings.opacity,
                level: l,
                even: if l % 2 == 0 { weight } else { 1.0 - weight },
            };
            walker.walk(index as u32, &chord, settings.min_transmittance, &mut blend, &mut trail.pieces);
        }
        if blend.transmittance() < settings.min_transmittance {
            break;
        }
    }
    // Stable: at equal distances, the coarser level first.
    trail.pieces[begin..].sort_by(|a, b| a.t.total_cmp(&b.t));
    blend.transmittance()
}

/// 1 − opacity of an optical depth.
#[inline]
pub(crate) fn through(opacity: Opacity, depth: f32) -> f32 {
    match opacity {
        Opacity::Exponential => (-depth).exp(),
        Opacity::Linear => (1.0 - depth).max(0.0),
    }
}

/// Walks the chords of one passage at one level.
struct Walker<'a> {
    texel: &'a Texel,
    patch: u32,
    opacity: Opacity,
    level: u32,
    /// Weight of the even level in use.
    even: f32,
}

impl Walker<'_> {
    fn walk(&self, index: u32, chord: &Chord, least: f32, blend: &mut Blend, pieces: &mut Vec<Piece>) {
        let Some(level) = self.texel.levels().get(self.level as usize) else { return };
        let [from, to] = chord.at.map(|at| at * level.resolution() as f32);
        let line = Line::new(from, to - from);
        let [a, b] = chord.t;
        let l = self.level as u8;
        for Step { cell, voxel, enter, leave } in level.walk(from, to) {
            let Some(Crossing { range, depth }) = level.cross(voxel, &line, cell, [enter, leave]) else {
                continue;
            };
            let through = through(self.opacity, depth);
            let key = VoxelKey { patch: self.patch, level: l, cell: cell.to_array() };
            let t = (a + (b - a) * f64::from(range[0])) as f32;
            pieces.push(Piece { key, voxel, even: self.even, depth, through, t, chord: index, range });
            blend.pass(l, self.even, through);
            if blend.left(l) < least {
                break;
            }
        }
    }
}
