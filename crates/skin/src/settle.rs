//! Folded boxes are mended by turning the vectors of their vertices back and by shortening them, or left out, and
//! always named.

use glam::Vec3;
use pelage_geom::certify_map;
use rayon::prelude::*;

use crate::patch::map;
use crate::validate::fault;
use crate::{Fold, Folds, Mending, Outcome, Patch, Skin};

/// By how much a vector is shortened at a time.
const SHORTENING: f32 = 0.8;

/// In how many steps a vector is turned back to where it would stand upright.
const TURNS: u8 = 8;

/// In radians: nearer, an `f32` cannot tell two directions apart by their angle.
const UPRIGHT: f32 = 1e-3;

/// Where the boxes over some vertices are wanted, and where they would be safest.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Where they stand.
    pub base: &'a [Vec3],
    /// Where they are to reach.
    pub top: &'a [Vec3],
    /// By vertex the direction that folded boxes are turned back to, of any length; `None` never turns them.
    pub upright: Option<&'a [Vec3]>,
}

/// What became of the boxes over some vertices.
pub(crate) struct Settled {
    /// Where the boxes reach.
    pub top: Vec<Vec3>,
    /// Which patches stay.
    pub kept: Vec<bool>,
    /// The folded ones, in the order of the patches; an outcome names the patch before any is left out.
    pub folds: Vec<Fold>,
    /// How many vectors were shortened.
    pub mended_vertices: usize,
    /// The shortest of them, as a fraction of what was wanted.
    pub shortest: f32,
    /// How many vectors were turned back.
    pub turned_back: usize,
}

/// How far a vertex's vector is from what was wanted.
#[derive(Clone, Copy, PartialEq)]
struct Concession {
    /// Fraction of the length.
    scale: f32,
    /// Steps of [`TURNS`] towards upright.
    turns: u8,
}

impl Concession {
    const NONE: Self = Self { scale: 1.0, turns: 0 };
}

impl Wanted<'_> {
    /// Where the box reaches over vertex `i`, after a concession; what is not conceded keeps its bits.
    fn reach(&self, i: usize, by: Concession) -> Vec3 {
        let (base, top) = (self.base[i], self.top[i]);
        if by == Concession::NONE {
            return top;
        }
        let vector = match self.upright {
            Some(upright) if by.turns > 0 => turned_back(top - base, upright[i], by.turns),
            _ => top - base,
        };
        base + by.scale * vector
    }

    fn reach_all(&self, by: impl Fn(usize) -> Concession + Sync) -> Vec<Vec3> {
        (0..self.base.len()).into_par_iter().map(|i| self.reach(i, by(i))).collect()
    }
}

fn turned_back(vector: Vec3, upright: Vec3, turns: u8) -> Vec3 {
    if upright == Vec3::ZERO || vector == Vec3::ZERO {
        return vector;
    }
    let angle = vector.angle_between(upright);
    if angle < UPRIGHT {
        return vector;
    }
    vector.rotate_towards(upright, f32::from(turns) / f32::from(TURNS) * angle)
}

/// Erects the boxes as wanted, and deals with those that are folded.
///
/// Mending gives way step by step at all the vertices of a folded box and checks every box that shares one of
/// them, until none is folded. Where the box would stand if its vectors were upright, its tilt is to blame, and they
/// are turned back one step; otherwise they are shortened. A box that would be folded even when it is upright and at
/// its shortest is left out at once, so that its neighbours are not mended for nothing. Every round changes a
/// vector or leaves out a box, and a box whose vectors have given way altogether is valid or left out: so it ends.
///
/// The boxes over patches that `are_valid` where they are wanted are not asked for it again.
pub(crate) fn settle(
    wanted: Wanted,
    patches: &[Patch],
    are_valid: impl Fn(usize) -> bool + Sync,
    mending: &Mending,
) -> Settled {
    let Wanted { base, top: full, upright } = wanted;
    let depth = mending.certificate_depth;
    let mut settled = Settled::as_wanted(full.to_vec(), patches.len());
    let found: Vec<Fold> = (0..patches.len())
        .into_par_iter()
        .filter(|&i| !are_valid(i))
        .filter_map(|i| fault(i, &patches[i], base, full, depth))
        .collect();
    if found.is_empty() || matches!(mending.folds, Folds::Refuse | Folds::Keep) {
        return Settled { folds: found, ..settled };
    }
    let most_turns = if upright.is_some() { TURNS } else { 0 };
    let most = Concession { scale: mending.shortest, turns: most_turns };
    let lowest = wanted.reach_all(|_| most);
    let mut conceded = vec![Concession::NONE; base.len()];
    let judge = |(i, fold): (usize, Fold)| {
        let mendable = mending.folds == Folds::Mend && fault(i, &patches[i], base, &lowest, depth).is_none();
        let outcome = if mendable { Outcome::Mended { patch: i as u32 } } else { Outcome::LeftOut };
        (i, Fold { outcome, ..fold })
    };
    // Whether the box over a patch would be valid with its vectors as long as they are, but upright.
    let stands_upright = |patch: &Patch, conceded: &[Concession]| {
        let reach = |i: u32| {
            let by = Concession { turns: TURNS, ..conceded[i as usize] };
            (base[i as usize], wanted.reach(i as usize, by))
        };
        let points: Vec<(Vec3, Vec3)> = patch.corners().iter().map(|&i| reach(i)).collect();
        let (base, top): (Vec<Vec3>, Vec<Vec3>) = points.into_iter().unzip();
        let vertices = if patch.is_prism() { [0, 1, 2, patch.vertices[3]] } else { [0, 1, 2, 3] };
        certify_map(&map(&vertices, &base, &top), patch.is_prism(), depth).is_valid()
    };
    let mut folds = vec![None; patches.len()];
    // What was changed in the last round, and the first time what is folded.
    let mut changed = vec![false; base.len()];
    for fold in &found {
        if let Outcome::Found { patch } = fold.outcome {
            patches[patch as usize].corners().iter().for_each(|&v| changed[v as usize] = true);
        }
    }
    loop {
        let folded: Vec<(usize, Fold, bool)> = (0..patches.len())
            .into_par_iter()
            .filter(|&i| settled.kept[i] && patches[i].corners().iter().any(|&v| changed[v as usize]))
            .filter_map(|i| fault(i, &patches[i], base, &settled.top, depth).map(|fold| (i, fold)))
            .map(judge)
            .map(|(i, fold)| (i, fold, upright.is_some() && stands_upright(&patches[i], &conceded)))
            .collect();
        if folded.is_empty() {
            break;
        }
        let mut shorten = vec![false; base.len()];
        let mut turn = vec![false; base.len()];
        for (i, fold, tilt_is_to_blame) in folded {
            settled.kept[i] = fold.outcome != Outcome::LeftOut;
            // The first finding stands, as it was wanted; the last outcome.
            folds[i].get_or_insert(fold).outcome = fold.outcome;
            let gives_way = if tilt_is_to_blame { &mut turn } else { &mut shorten };
            for &v in patches[i].corners().iter().filter(|_| settled.kept[i]) {
                gives_way[v as usize] = true;
            }
        }
        let before = conceded.clone();
        for (v, by) in conceded.iter_mut().enumerate() {
            if shorten[v] {
                by.scale = (by.scale * SHORTENING).max(mending.shortest);
            }
            if turn[v] {
                by.turns = (by.turns + 1).min(most_turns);
            }
        }
        if turn.contains(&true) {
            even_out(&mut conceded, patches);
        }
        for (v, by) in conceded.iter().enumerate() {
            changed[v] = *by != before[v];
            if changed[v] {
                settled.top[v] = wanted.reach(v, *by);
            }
        }
    }
    settled.folds = folds.into_iter().flatten().collect();
    settled.mended_vertices = conceded.iter().filter(|by| by.scale < 1.0).count();
    settled.shortest = conceded.iter().map(|by| by.scale).fold(1.0, f32::min);
    let turned = |(v, by): (usize, &Concession)| {
        by.turns > 0 && wanted.reach(v, Concession { scale: 1.0, ..*by }) != full[v]
    };
    settled.turned_back = conceded.iter().enumerate().filter(|&c| turned(c)).count();
    settled
}

/// Turns back what is around vertices that were, to within one step of them: a single upright vector among leaning
/// ones would fold the boxes before it.
fn even_out(conceded: &mut [Concession], patches: &[Patch]) {
    // A step less each time, so that it is done after as many rounds as there are steps.
    for _ in 0..TURNS {
        for patch in patches {
            let most = patch.corners().iter().map(|&v| conceded[v as usize].turns).max().unwrap_or(0);
            for &v in patch.corners() {
                let turns = &mut conceded[v as usize].turns;
                *turns = (*turns).max(most.saturating_sub(1));
            }
        }
    }
}

impl Settled {
    /// So many boxes, all of which are known to be valid.
    pub fn as_wanted(top: Vec<Vec3>, patches: usize) -> Self {
        let kept = vec![true; patches];
        Self { top, kept, folds: Vec::new(), mended_vertices: 0, shortest: 1.0, turned_back: 0 }
    }

    /// Moves the tops of `skin`, whose patches these were, drops the patches that do not stay, and reports it.
    pub fn apply(self, skin: &mut Skin) {
        let Self { top, kept, mut folds, mended_vertices, shortest, turned_back } = self;
        let renumbered: Vec<u32> = (kept.iter())
            .scan(0, |next, &stays| {
                let number = *next;
                *next += u32::from(stays);
                Some(number)
            })
            .collect();
        for fold in &mut folds {
            if let Outcome::Mended { patch } = &mut fold.outcome {
                *patch = renumbered[*patch as usize];
            }
        }
        skin.top = top;
        let mut stays = kept.iter();
        skin.patches.retain(|_| stays.next() == Some(&true));
        if let Some(uvs) = &mut skin.uvs {
            let mut stays = kept.iter();
            uvs.retain(|_| stays.next() == Some(&true));
        }
        let report = &mut skin.report;
        report.prisms = skin.patches.iter().filter(|p| p.is_prism()).count();
        report.boxes = skin.patches.len() - report.prisms;
        (report.folds, report.mended_vertices, report.shortest) = (folds, mended_vertices, shortest);
        report.turned_back = turned_back;
    }
}
