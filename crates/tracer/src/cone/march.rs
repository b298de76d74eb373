//! From chords to voxels: what a cone meets inside one box, at the two levels that fit its width. [seed §6, Neyret98]

use glam::{IVec2, IVec3, Mat3, Vec3};
use pelage_geom::{Cone, Ray};
use pelage_texel::{Crossing, Line, Step, Texel};

use super::lod::{Band, lambda};
use super::passages::BoxPassage;
use super::path::{Chord, LocalRay};
use super::stretch::Stretches;
use super::{Blend, Piece, Trail, VoxelKey};
use crate::variety::Tile;
use crate::{Counts, Opacity, Path, Scene, Settings};

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
    let texels = &coat.texels;
    let local = LocalRay::new(scene.hexahedron(passage.patch).map(), patch.lattice, ray);

    let jacobians = passage.u.map(|u| local.texel_jacobian(u.as_vec3()));
    // At both ends, for a texel of this height.
    let levels_of = |height: f32| {
        [0, 1].map(|end| {
            let Mat3 { x_axis, y_axis, z_axis } = jacobians[end];
            let jacobian = Mat3 { x_axis, y_axis, z_axis: height * z_axis };
            lambda(settings.lod, &jacobian, local.direction(), cone, passage.t[end])
                .clamp(0.0, texels.depth() as f32)
        })
    };
    let levels = levels_of(1.0);
    let finest = Band::of(levels[0].max(levels[1]), texels.depth()).finest();
    let least = ((levels[1] - levels[0]).abs() / LEVELS_PER_CHORD).ceil() as usize;

    let Trail { pieces, chords, counts } = trail;
    let first = chords.len();
    match settings.path {
        Path::Curved => {
            let tolerance = settings.path_tolerance / (1_u32 << finest) as f32;
            local.chords(passage, tolerance, least, chords);
        }
        Path::Straight => local.straight(passage, least, chords),
    }

    let span = (passage.t[1] - passage.t[0]).max(f64::MIN_POSITIVE);
    let level_between = |levels: [f32; 2], t: [f64; 2]| {
        let middle = ((0.5 * (t[0] + t[1]) - passage.t[0]) / span) as f32;
        levels[0] + (levels[1] - levels[0]) * middle
    };
    counts.passages += 1;
    counts.chords += (chords.len() - first) as u64;
    let begin = pieces.len();
    let mut walker = Walker { settings, patch: passage.patch, blend: Blend::START, pieces, counts };
    for (index, chord) in chords.iter().enumerate().skip(first) {
        if let Some(texel) = texels.plain() {
            let whole = Filled { texel, tile: None, range: [0.0, 1.0], at: chord.at };
            walker.walk(index as u32, chord, &whole, level_between(levels, chord.t));
        } else {
            for stretch in Stretches::of(chord) {
                let tile = texels.tile(&patch.anchor, stretch.copy);
                let levels = if tile.height == 1.0 { levels } else { levels_of(tile.height) };
                let at = chord.points(stretch.range).map(|p| tile.within(p));
                let part = Filled { texel: texels.of(&tile), tile: Some(&tile), range: stretch.range, at };
                let t = chord.distances(stretch.range);
                walker.walk(index as u32, chord, &part, level_between(levels, t));
                if walker.is_done() {
                    break;
                }
            }
        }
        if walker.is_done() {
            break;
        }
    }
    let Walker { blend, pieces, .. } = walker;
    // Stable: at equal distances, the coarser level first.
    pieces[begin..].sort_by(|a, b| a.t.total_cmp(&b.t));
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

/// A part of a chord, and the texel that it goes through.
struct Filled<'a> {
    texel: &'a Texel,
    /// How the texel stands in the copy that the part ends with; `None` where all copies are alike.
    tile: Option<&'a Tile>,
    /// Which part of the chord.
    range: [f32; 2],
    /// Its ends, in the texel's own coordinates.
    at: [Vec3; 2],
}

/// Walks along the chords of one passage.
struct Walker<'a> {
    settings: &'a Settings,
    patch: u32,
    blend: Blend,
    pieces: &'a mut Vec<Piece>,
    counts: &'a mut Counts,
}

impl Walker<'_> {
    fn is_done(&self) -> bool {
        self.blend.transmittance() < self.settings.min_transmittance
    }

    /// Along a part of a chord, at the two levels around the continuous level `lambda`.
    fn walk(&mut self, index: u32, chord: &Chord, part: &Filled, lambda: f32) {
        for (l, weight) in Band::of(lambda, part.texel.depth()).levels() {
            self.walk_at(l, if l % 2 == 0 { weight } else { 1.0 - weight }, index, chord, part);
        }
    }

    /// At one level, where `even` is the weight of the even one in use.
    fn walk_at(&mut self, l: u32, even: f32, index: u32, chord: &Chord, part: &Filled) {
        let Some(level) = part.texel.levels().get(l as usize) else { return };
        let [from, to] = part.at.map(|at| at * level.resolution() as f32);
        let line = Line::new(from, to - from);
        let [a, b] = chord.t;
        let [begin, end] = part.range;
        let (steps, before) = match part.tile {
            None => (level.walk(from, to), IVec3::ZERO),
            Some(tile) => (level.walk_alone(from, to), IVec2::from(tile.copy).extend(0) << l),
        };
        self.counts.walks += 1;
        for Step { cell, voxel, enter, leave } in steps {
            self.counts.cells += 1;
            let Some(Crossing { range, depth }) = level.cross(voxel, &line, cell, [enter, leave]) else {
                continue;
            };
            let range = range.map(|x| begin + (end - begin) * x);
            let through = through(self.settings.opacity, depth);
            let key = VoxelKey { patch: self.patch, level: l as u8, cell: (cell + before).to_array() };
            let t = (a + (b - a) * f64::from(range[0])) as f32;
            self.pieces.push(Piece { key, voxel, even, depth, through, t, chord: index, range });
            self.blend.pass(l as u8, even, through);
            if self.blend.left(l as u8) < self.settings.min_transmittance {
                break;
            }
        }
    }
}
