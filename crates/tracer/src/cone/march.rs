//! From chords to voxels: what a cone meets inside one box, at the levels that fit its width. [seed §6, Neyret98]
//!
//! The coarser level is walked cell by cell; inside each of its cells the eight children are asked for the finer
//! level, so that the two can be blended as transmittances, cell by cell.

use glam::{IVec3, Vec3};
use pelage_geom::{Cone, Ray};
use pelage_texel::{Level, Texel};

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
pub(crate) fn march(
    scene: &Scene,
    beam: Beam,
    passage: &BoxPassage,
    chords: &mut Vec<Chord>,
    trail: &mut Trail,
) -> f32 {
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

    chords.clear();
    match settings.path {
        Path::Curved => {
            let tolerance = settings.path_tolerance / (1_u32 << finest) as f32;
            local.chords(passage, tolerance, least, chords);
        }
        Path::Straight => local.straight(passage, least, chords),
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
    for chord in chords.iter() {
        let middle = ((0.5 * (chord.t[0] + chord.t[1]) - passage.t[0]) / span) as f32;
        let level = levels[0] + (levels[1] - levels[0]) * middle;
        walker.chord(chord, Band::of(level, texel.depth()), settings.min_transmittance);
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
    fn chord(&mut self, chord: &Chord, band: Band, least: f32) {
        let Some(level) = self.texel.levels().get(band.coarse as usize) else { return };
        let scale = level.resolution() as f32;
        let (from, to) = (chord.at[0] * scale, chord.at[1] * scale);
        let segment = Segment { chord, from, step: to - from };
        for step in level.walk(from, to) {
            let same = self.open.is_some_and(|(b, cell, ..)| b.coarse == band.coarse && cell == step.cell);
            if !same {
                self.close();
                if self.transmittance < least {
                    return;
                }
                let begin = self.trail.pieces.len() as u32;
                self.open = Some((band, step.cell, segment.distance(step.enter), begin));
            }
            self.piece(level, band.coarse, false, step.voxel, step.cell, [step.enter, step.leave], &segment);
            if band.blend > 0.0 {
                self.children(band.coarse + 1, step.cell, [step.enter, step.leave], &segment);
            }
        }
    }

    /// The up to four children of `cell` that the segment goes through.
    fn children(&mut self, fine: u32, cell: IVec3, range: [f32; 2], segment: &Segment) {
        let Some(level) = self.texel.levels().get(fine as usize) else { return };
        let segment = segment.doubled();
        let middle = (2 * cell + IVec3::ONE).as_vec3();
        let mut cuts = (middle - segment.from) / segment.step;
        // A component that never crosses its mid-plane cuts at the end, where no piece is left to begin.
        cuts = Vec3::select(cuts.is_nan_mask(), Vec3::splat(range[1]), cuts)
            .clamp(Vec3::splat(range[0]), Vec3::splat(range[1]));
        let mut cuts = [cuts.x, cuts.y, cuts.z, range[1]];
        cuts[..3].sort_unstable_by(f32::total_cmp);
        let mut enter = range[0];
        for leave in cuts {
            if leave > enter {
                let at = segment.from + 0.5 * (enter + leave) * segment.step;
                let upper = at.cmpge(middle);
                let child = 2 * cell + IVec3::new(upper.x.into(), upper.y.into(), upper.z.into());
                if let Some(voxel) = level.find(child) {
                    self.piece(level, fine, true, voxel, child, [enter, leave], &segment);
                }
                enter = leave;
            }
        }
    }

    /// The part of a voxel's matter that the segment goes through.
    fn piece(
        &mut self,
        level: &Level,
        l: u32,
        fine: bool,
        voxel: u32,
        cell: IVec3,
        range: [f32; 2],
        segment: &Segment,
    ) {
        let matter = level.voxel(voxel);
        let Some([enter, leave]) = matter.clip(segment.from - cell.as_vec3(), segment.step, range) else {
            return;
        };
        let depth = matter.depth_per_step(segment.step) * (leave - enter);
        if depth > 0.0 {
            self.trail.pieces.push(Piece {
                key: VoxelKey { patch: self.patch, level: l as u8, cell: cell.to_array() },
                voxel,
                fine,
                depth,
                through: through(self.opacity, depth),
                t: [segment.distance(enter), segment.distance(leave)],
                at: [segment.texel_at(enter), segment.texel_at(leave)],
            });
        }
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

/// A chord in the voxel units of one level, by a parameter in `[0, 1]`.
struct Segment<'a> {
    chord: &'a Chord,
    from: Vec3,
    step: Vec3,
}

impl Segment<'_> {
    /// The same chord in the units of the next finer level.
    fn doubled(&self) -> Self {
        Self { chord: self.chord, from: 2.0 * self.from, step: 2.0 * self.step }
    }

    fn distance(&self, x: f32) -> f32 {
        let [a, b] = self.chord.t;
        (a + (b - a) * f64::from(x)) as f32
    }

    fn texel_at(&self, x: f32) -> Vec3 {
        self.chord.at[0].lerp(self.chord.at[1], x)
    }
}
