//! Every box is certified: det J > 0 throughout, proved by its Bernstein coefficients. What fails is mended by
//! shortening the vectors of its vertices, or left out, and always named. [seed §4.3]

use glam::Vec3;
use pelage_geom::{Certificate, certify};
use rayon::prelude::*;

use crate::patch::hexahedron;
use crate::{Fold, Folds, Outcome, Patch, Skin, SkinError, SkinOptions};

/// By how much a vector is shortened at a time.
const SHORTENING: f32 = 0.8;

impl Skin {
    /// Checks everything that a renderer relies on: the lengths of the lists, indices, numbers, lattices, and
    /// that no box is folded, undecided ones being halved up to `certificate_depth` times.
    ///
    /// # Errors
    /// The first fault, with its vertex or patch.
    pub fn validate(&self, certificate_depth: u32) -> Result<(), SkinError> {
        let count = self.base.len();
        if self.top.len() != count {
            return Err(SkinError::Length { list: "top", length: self.top.len(), expected: count });
        }
        if let Some(uvs) = self.uvs.as_ref().filter(|uvs| uvs.len() != self.len()) {
            return Err(SkinError::Length { list: "uvs", length: uvs.len(), expected: self.len() });
        }
        let finite = |(base, top): (&Vec3, &Vec3)| base.is_finite() && top.is_finite();
        if let Some(vertex) = self.base.iter().zip(&self.top).position(|points| !finite(points)) {
            return Err(SkinError::NonFinite { vertex });
        }
        for (patch, p) in self.patches.iter().enumerate() {
            if let Some(&index) = p.corners().iter().find(|&&i| i as usize >= count) {
                return Err(SkinError::IndexOutOfRange { patch, index, count });
            }
            let determinant = p.lattice.determinant();
            if !(p.lattice.origin.is_finite() && determinant.is_finite() && determinant != 0.0) {
                return Err(SkinError::Lattice { patch });
            }
        }
        let folds = faults(&self.patches, &self.base, &self.top, certificate_depth);
        folds.first().map_or(Ok(()), |&fold| Err(SkinError::FoldedBox(fold)))
    }
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
    /// The shortest of them, as a fraction of the height.
    pub shortest: f32,
}

/// Erects the boxes from `base` to `full`, and deals with those that are folded.
///
/// Mending shortens all the vectors of a folded box by a factor and checks every box that shares one of them, until
/// none is folded. A box that would be folded even at the shortest height allowed is left out at once, so
/// that its neighbours are not shortened for nothing. Every round shortens a vector or leaves out a box, and a box
/// whose vectors are all at their shortest is either valid or left out, so the rounds end.
pub(crate) fn settle(base: &[Vec3], full: &[Vec3], patches: &[Patch], options: &SkinOptions) -> Settled {
    let reach = |scale: &[f32]| -> Vec<Vec3> {
        let vertices = base.par_iter().zip(full).zip(scale);
        // What is not shortened keeps its bits.
        vertices.map(|((b, f), &s)| if s == 1.0 { *f } else { *b + s * (*f - *b) }).collect()
    };
    let depth = options.certificate_depth;
    let mut scale = vec![1.0; base.len()];
    let mut settled = Settled {
        top: full.to_vec(),
        kept: vec![true; patches.len()],
        folds: Vec::new(),
        mended_vertices: 0,
        shortest: 1.0,
    };
    let found = faults(patches, base, &settled.top, depth);
    if found.is_empty() || options.folds == Folds::Refuse {
        return Settled { folds: found, ..settled };
    }
    let lowest = reach(&vec![options.shortest; base.len()]);
    let judge = |(i, fold): (usize, Fold)| {
        let mendable = options.folds == Folds::Mend && fault(i, &patches[i], base, &lowest, depth).is_none();
        let outcome = if mendable { Outcome::Mended { patch: i as u32 } } else { Outcome::LeftOut };
        (i, Fold { outcome, ..fold })
    };
    let mut folds = vec![None; patches.len()];
    let mut changed = vec![true; base.len()];
    loop {
        // What was changed in the last round, and the first time everything.
        let folded: Vec<(usize, Fold)> = (0..patches.len())
            .into_par_iter()
            .filter(|&i| settled.kept[i] && patches[i].corners().iter().any(|&v| changed[v as usize]))
            .filter_map(|i| fault(i, &patches[i], base, &settled.top, depth).map(|fold| (i, fold)))
            .map(judge)
            .collect();
        if folded.is_empty() {
            break;
        }
        changed.fill(false);
        for (i, fold) in folded {
            settled.kept[i] = fold.outcome != Outcome::LeftOut;
            // The first finding stands, at full height; the last outcome.
            folds[i].get_or_insert(fold).outcome = fold.outcome;
            for &v in patches[i].corners().iter().filter(|_| settled.kept[i]) {
                changed[v as usize] = true;
            }
        }
        for (s, _) in scale.iter_mut().zip(&changed).filter(|(_, c)| **c) {
            *s = (*s * SHORTENING).max(options.shortest);
        }
        settled.top = reach(&scale);
    }
    settled.folds = folds.into_iter().flatten().collect();
    settled.mended_vertices = scale.iter().filter(|&&s| s < 1.0).count();
    settled.shortest = scale.iter().copied().fold(1.0, f32::min);
    settled
}

/// The folded boxes among `patches`, in their order.
fn faults(patches: &[Patch], base: &[Vec3], top: &[Vec3], depth: u32) -> Vec<Fold> {
    patches.par_iter().enumerate().filter_map(|(i, patch)| fault(i, patch, base, top, depth)).collect()
}

/// What is wrong with one box, if anything. One that stays undecided at `depth` counts as folded.
fn fault(index: usize, patch: &Patch, base: &[Vec3], top: &[Vec3], depth: u32) -> Option<Fold> {
    let hexahedron = hexahedron(&patch.vertices, base, top);
    let (at, determinant) = match certify(&hexahedron, depth) {
        Certificate::Valid { .. } => return None,
        Certificate::Folded { at, determinant } => (at, determinant),
        Certificate::Undecided { at } => (at, hexahedron.map().determinant(at)),
    };
    Some(Fold {
        face: patch.face,
        at: at.as_vec3(),
        determinant: determinant as f32,
        outcome: Outcome::Found { patch: index as u32 },
    })
}
