//! From chords to voxels: what a cone meets inside one box, at the two levels that fit its width. [seed §6, Neyret98]

use glam::{IVec2, IVec3, Mat3, Vec3};
use pelage_geom::{Cone, Ray};
use pelage_texel::{Crossing, Line, Step, Texel};

use super::border;
use super::lod::{Levels, lambda};
use super::passages::BoxPassage;
use super::path::{Chord, LocalRay};
use super::stretch::Stretches;
use super::{Piece, Trail, VoxelKey};
use crate::variety::Tile;
use crate::{Counts, Opacity, Path, Scene, Settings};

/// A ray with its width and what the user chose.
#[derive(Clone, Copy)]
pub(crate) struct Beam<'a> {
    pub ray: &'a Ray,
    pub cone: &'a Cone,
    pub settings: &'a Settings,
}

/// Follows the beam through one box: `trail` has the pieces of this box then. Of the beam, `entering` has come so far;
/// it is not followed where less than `least` of it would get through.
pub(crate) fn march(
    scene: &Scene,
    beam: Beam,
    passage: &BoxPassage,
    entering: f32,
    least: f32,
    trail: &mut Trail,
) {
    let Beam { ray, cone, settings } = beam;
    let (coat, patch) = scene.patch(passage.patch);
    let texels = &coat.texels;
    let local = LocalRay::new(&scene.hexahedron(passage.patch).map(), patch.lattice, ray);

    let ends = [local.end(passage, 0), local.end(passage, 1)];
    let jacobians = [local.texel_jacobian(&ends[0]), local.texel_jacobian(&ends[1])];
    let coarsest = border::coarsest(scene, settings.lod, passage, patch);
    // From end to end, for a texel of this height.
    let levels_of = |height: f32, depth: u32| {
        let end = |end: usize| {
            let Mat3 { x_axis, y_axis, z_axis } = jacobians[end];
            let jacobian = Mat3 { x_axis, y_axis, z_axis: height * z_axis };
            lambda(settings.lod, &jacobian, local.direction(), cone, passage.t[end]).max(coarsest[end])
        };
        Levels::new([end(0), end(1)], depth)
    };
    let levels = levels_of(1.0, texels.depth());

    let Trail { runs, chords, counts } = trail;
    let first = chords.len();
    match settings.path {
        Path::Curved => {
            let tolerance = settings.path_tolerance / (1_u32 << levels.finest()) as f32;
            local.chords(&ends, tolerance, chords);
        }
        Path::Straight => chords.push(local.straight(&ends)),
    }
    counts.passages += 1;
    counts.chords += (chords.len() - first) as u64;

    let span = (passage.t[1] - passage.t[0]).max(f64::MIN_POSITIVE);
    let fraction = |t: f64| ((t - passage.t[0]) / span) as f32;
    let fractions = |[a, b]: [f64; 2]| [fraction(a), fraction(b)];
    runs.iter_mut().for_each(Vec::clear);
    let mut walker = Walker { settings, patch: passage.patch, left: [entering; 2], least, runs, counts };
    for (index, chord) in chords.iter().enumerate().skip(first) {
        if let Some(texel) = texels.plain() {
            let levels = levels.part(fractions(chord.t));
            walker.walk(
                index as u32,
                chord,
                &Filled { texel, tile: None, range: [0.0, 1.0], at: chord.at, levels },
            );
        } else {
            for stretch in Stretches::of(chord) {
                let tile = texels.tile(&patch.anchor, stretch.copy);
                let texel = texels.of(&tile);
                let [from, to] = chord.points(stretch.range);
                let at = [tile.within(from), tile.within(to)];
                let levels =
                    levels_of(tile.height, texel.depth()).part(fractions(chord.distances(stretch.range)));
                walker.walk(
                    index as u32,
                    chord,
                    &Filled { texel, tile: Some(&tile), range: stretch.range, at, levels },
                );
            }
        }
        if walker.is_done() {
            break;
        }
    }
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
    /// The levels along it.
    levels: Levels,
}

/// Walks along the chords of one passage.
struct Walker<'a> {
    settings: &'a Settings,
    patch: u32,
    /// What gets through the even levels, and through the odd ones.
    left: [f32; 2],
    /// What is too little to follow.
    least: f32,
    runs: &'a mut [Vec<Piece>; 2],
    counts: &'a mut Counts,
}

impl Walker<'_> {
    fn is_done(&self) -> bool {
        self.left[0].max(self.left[1]) < self.least
    }

    /// Along a part of a chord, at each level in use.
    fn walk(&mut self, index: u32, chord: &Chord, part: &Filled) {
        if let Some(level) = part.levels.only() {
            return self.walk_at(level, [0.0, 1.0], index, chord, part);
        }
        for (level, range) in part.levels.in_use() {
            self.walk_at(level, range, index, chord, part);
        }
    }

    /// At level `l`, between two fractions of the part.
    fn walk_at(&mut self, l: u32, range: [f32; 2], index: u32, chord: &Chord, part: &Filled) {
        let parity = l as usize % 2;
        let mut left = self.left[parity];
        let Some(level) = part.texel.levels().get(l as usize).filter(|_| left >= self.least) else { return };
        let scale = level.resolution() as f32;
        let line = Line::new(scale * part.at[0], scale * (part.at[1] - part.at[0]));
        let [a, b] = chord.t;
        let [begin, end] = part.range;
        let (steps, before) = match part.tile {
            None => (level.walk_along(&line, range), IVec3::ZERO),
            Some(tile) => (level.walk_alone(&line, range), IVec2::from(tile.copy).extend(0) << l),
        };
        let run = &mut self.runs[parity];
        let mut cells = 0;
        for step in steps {
            cells += 1;
            let Some(Crossing { range, depth }) = level.cross(&line, &step) else { continue };
            let Step { cell, voxel, .. } = step;
            let even = part.levels.even(0.5 * (range[0] + range[1]));
            let range = [begin + (end - begin) * range[0], begin + (end - begin) * range[1]];
            let through = through(self.settings.opacity, depth);
            let key = VoxelKey { patch: self.patch, level: l as u8, cell: (cell + before).to_array() };
            let t = (a + (b - a) * f64::from(range[0])) as f32;
            run.push(Piece { key, voxel, even, depth, through, t, chord: index, range });
            left *= through;
            if left < self.least {
                break;
            }
        }
        self.left[parity] = left;
        self.counts.walks += 1;
        self.counts.cells += cells;
    }
}
