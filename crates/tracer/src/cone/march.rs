//! From chords to voxels: what a cone meets inside one box, at the levels that fit its width. [seed §6, Neyret98]
//!
//! The coarser level is walked cell by cell; inside each of its cells the eight children are asked for the finer
//! level, so that the two can be blended as transmittances, cell by cell.

use glam::{IVec3, Vec3};
use pelage_geom::{Cone, Ray};
use pelage_texel::{Crossing, Level, Line, Step, Texel};

use super::lod::{Band, lambda};
use super::passages::BoxPassage;
use super::path::{Chord, LocalRay};
use super::{Blend, Cell, Piece, Trail, VoxelKey};
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
    let mut walker = Walker {
        texel,
        patch: passage.patch,
        opacity: settings.opacity,
        open: None,
        transmittance: 1.0,
        trail,
    };
    for index in first..walker.trail.chords.len() {
        let chord = walker.trail.chords[index];
        let middle = ((0.5 * (chord.t[0] + chord.t[1]) - passage.t[0]) / span) as f32;
        let level = levels[0] + (levels[1] - levels[0]) * middle;
        walker.chord(index as u32, &chord, Band::of(level, texel.depth()), settings.min_transmittance);
        if walker.transmittance < settings.min_transmittance {
            break;
        }
    }
    walker.close();
    walker.transmittance
}

/// 1 − opacity of an optical depth.
#[inline]
pub(crate) fn through(opacity: Opacity, depth: f32) -> f32 {
    match opacity {
        Opacity::Exponential => (-depth).exp(),
        Opacity::Linear => (1.0 - depth).max(0.0),
    }
}

/// Walks the chords of one passage; a cell that two chords share is one cell.
struct Walker<'a> {
    texel: &'a Texel,
    patch: u32,
    opacity: Opacity,
    /// The cell being walked: which it is, and where its pieces begin.
    open: Option<(Band, IVec3, f32, u32)>,
    transmittance: f32,
    trail: &'a mut Trail,
}

impl Walker<'_> {
    fn chord(&mut self, index: u32, chord: &Chord, band: Band, least: f32) {
        let Some(level) = self.texel.levels().get(band.coarse as usize) else { return };
        let fine = if band.blend > 0.0 { self.texel.levels().get(band.coarse as usize + 1) } else { None };
        let [from, to] = chord.at.map(|at| at * level.resolution() as f32);
        let line = Line::new(from, to - from);
        let finer = line.finer();
        for Step { cell, voxel, enter, leave } in level.walk(from, to) {
            let same = self.open.is_some_and(|(b, open, ..)| b.same_levels(band) && open == cell);
            if !same {
                self.close();
                if self.transmittance < least {
                    return;
                }
                let [a, b] = chord.t;
                let t = (a + (b - a) * f64::from(enter)) as f32;
                self.open = Some((band, cell, t, self.trail.pieces.len() as u32));
            }
            if let Some(crossing) = level.cross(voxel, &line, cell, [enter, leave]) {
                let key = VoxelKey { patch: self.patch, level: band.coarse as u8, cell: cell.to_array() };
                self.piece(key, voxel, false, crossing, index);
            }
            if let Some(fine) = fine {
                self.children(fine, band.coarse as u8 + 1, cell, [enter, leave], &finer, index);
            }
        }
    }

    /// The up to four children of `cell` that the line goes through.
    fn children(&mut self, level: &Level, l: u8, cell: IVec3, range: [f32; 2], line: &Line, chord: u32) {
        let middle = (2 * cell + IVec3::ONE).as_vec3();
        let mut cuts = (middle - line.from) / line.step;
        // A component that never crosses its mid-plane cuts at the end, where no piece is left to begin.
        cuts = Vec3::select(cuts.is_nan_mask(), Vec3::splat(range[1]), cuts)
            .clamp(Vec3::splat(range[0]), Vec3::splat(range[1]));
        let mut cuts = [cuts.x, cuts.y, cuts.z, range[1]];
        cuts[..3].sort_unstable_by(f32::total_cmp);
        let mut enter = range[0];
        for leave in cuts {
            if leave > enter {
                let at = line.from + 0.5 * (enter + leave) * line.step;
                let upper = at.cmpge(middle);
                let child = 2 * cell + IVec3::new(upper.x.into(), upper.y.into(), upper.z.into());
                if let Some(voxel) = level.find(child)
                    && let Some(crossing) = level.cross(voxel, line, child, [enter, leave])
                {
                    let key = VoxelKey { patch: self.patch, level: l, cell: child.to_array() };
                    self.piece(key, voxel, true, crossing, chord);
                }
                enter = leave;
            }
        }
    }

    fn piece(&mut self, key: VoxelKey, voxel: u32, fine: bool, crossing: Crossing, chord: u32) {
        let Crossing { range, depth } = crossing;
        let through = through(self.opacity, depth);
        self.trail.pieces.push(Piece { key, voxel, fine, depth, through, chord, range });
    }

    /// Ends the cell being walked.
    fn close(&mut self) {
        let Some((band, _, t, begin)) = self.open.take() else { return };
        let end = self.trail.pieces.len() as u32;
        if end > begin {
            let cell = Cell { t, blend: band.blend, pieces: begin..end };
            let mut blend = Blend::new(&cell);
            for piece in self.trail.pieces_of(&cell) {
                blend.pass(piece.fine, piece.through);
            }
            self.transmittance *= blend.transmittance();
            self.trail.cells.push(cell);
        }
    }
}
