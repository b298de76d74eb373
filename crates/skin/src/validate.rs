//! Every box is certified: det J > 0 throughout, proved by its Bernstein coefficients. [seed §4.3]

use glam::Vec3;
use pelage_geom::{Certificate, certify_map};
use rayon::prelude::*;

use crate::patch::map;
use crate::{Fold, Outcome, Patch, Skin, SkinError};

impl Skin {
    /// Checks everything that a renderer relies on: the lengths of the lists, indices, numbers, lattices, and
    /// that no box is folded, undecided ones being halved up to `certificate_depth` times.
    ///
    /// # Errors
    /// The first fault, with its vertex or patch.
    pub fn validate(&self, certificate_depth: u32) -> Result<(), SkinError> {
        self.check_shape()?;
        let folds = faults(&self.patches, &self.base, &self.top, certificate_depth);
        folds.first().map_or(Ok(()), |&fold| Err(SkinError::FoldedBox(fold)))
    }

    /// The same without the boxes' certificates.
    pub(crate) fn check_shape(&self) -> Result<(), SkinError> {
        let count = self.base.len();
        if self.top.len() != count {
            return Err(SkinError::Length { list: "top", length: self.top.len(), expected: count });
        }
        if let Some(uvs) = self.uvs.as_ref().filter(|uvs| uvs.len() != self.len()) {
            return Err(SkinError::Length { list: "uvs", length: uvs.len(), expected: self.len() });
        }
        if let Some(of) = self.attributes.iter().map(|a| a.values.len()).find(|&length| length != count) {
            return Err(SkinError::Length { list: "attributes", length: of, expected: count });
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
        Ok(())
    }
}

/// The folded boxes among `patches`, in their order.
pub(crate) fn faults(patches: &[Patch], base: &[Vec3], top: &[Vec3], depth: u32) -> Vec<Fold> {
    patches.par_iter().enumerate().filter_map(|(i, patch)| fault(i, patch, base, top, depth)).collect()
}

/// What is wrong with one box, if anything. One that stays undecided at `depth` counts as folded.
pub(crate) fn fault(index: usize, patch: &Patch, base: &[Vec3], top: &[Vec3], depth: u32) -> Option<Fold> {
    let map = map(&patch.vertices, base, top);
    let (at, determinant) = match certify_map(&map, patch.is_prism(), depth) {
        Certificate::Valid { .. } => return None,
        Certificate::Folded { at, determinant } => (at, determinant),
        Certificate::Undecided { at } => (at, map.determinant(at)),
    };
    Some(Fold {
        face: patch.face,
        at: at.as_vec3(),
        determinant: determinant as f32,
        outcome: Outcome::Found { patch: index as u32 },
    })
}
