//! A skin that moves: new positions or new vectors for the same patches, frame after frame. The patches, their
//! numbers and their lattices stay, so that what fills the boxes need not be looked at again.

use glam::{Mat3, Vec3};
use pelage_geom::Face;
use rayon::prelude::*;

use crate::normals;
use crate::settle::{Wanted, settle};
use crate::{Folds, Mending, Report, Skin, SkinError};

/// What moves, by vertex of the skin; metres.
#[derive(Clone, Copy, Debug)]
pub enum Motion<'a> {
    /// Where the boxes stand. Their vectors turn with the surface.
    Surface(&'a [Vec3]),
    /// The vectors from where they stand to where they reach.
    Vectors(&'a [Vec3]),
    /// Both.
    Both {
        /// Where the boxes stand.
        base: &'a [Vec3],
        /// From there to where they reach.
        vectors: &'a [Vec3],
    },
}

impl Skin {
    /// Moves the skin and certifies its boxes; the report's account of folded boxes is that of this call.
    ///
    /// Under [`Folds::Mend`], vectors of folded boxes are turned back to what they were before (carried along with
    /// the surface) and then shortened; no patch is ever left out. [`Folds::LeaveOut`] is [`Folds::Refuse`] here.
    /// After an error the skin is what it was.
    ///
    /// # Errors
    /// Lists of the wrong length, numbers that are not finite, and [`SkinError::StillFolded`].
    pub fn update(&mut self, motion: Motion, mending: &Mending) -> Result<&Report, SkinError> {
        mending.validate()?;
        let count = self.base.len();
        let fits = |list: &[Vec3], name: &'static str| match list.len() {
            length if length != count => Err(SkinError::Length { list: name, length, expected: count }),
            _ => list
                .iter()
                .position(|p| !p.is_finite())
                .map_or(Ok(()), |vertex| Err(SkinError::NonFinite { vertex })),
        };
        let (base, wanted) = match motion {
            Motion::Surface(base) => (Some(base), None),
            Motion::Vectors(vectors) => (None, Some(vectors)),
            Motion::Both { base, vectors } => (Some(base), Some(vectors)),
        };
        base.map_or(Ok(()), |list| fits(list, "base"))?;
        wanted.map_or(Ok(()), |list| fits(list, "vectors"))?;

        let before: Vec<Vec3> = self.top.par_iter().zip(&self.base).map(|(t, b)| *t - *b).collect();
        let carried = match base {
            Some(base) => self.carried(base, &before),
            None => before,
        };
        let base = base.unwrap_or(&self.base);
        let vectors = wanted.unwrap_or(&carried);
        let top: Vec<Vec3> = base.par_iter().zip(vectors).map(|(b, v)| *b + *v).collect();
        let folds = if mending.folds == Folds::LeaveOut { Folds::Refuse } else { mending.folds };
        let mending = Mending { folds, ..*mending };
        let settled =
            settle(Wanted { base, top: &top, upright: Some(&carried) }, &self.patches, |_| false, &mending);
        let unmended = settled.kept.contains(&false) || folds == Folds::Refuse;
        if let (true, Some(&first)) = (unmended, settled.folds.first()) {
            return Err(SkinError::StillFolded { count: settled.folds.len(), first });
        }
        self.base = base.to_vec();
        settled.apply(self);
        Ok(&self.report)
    }

    /// The vectors, turned as the surface turns at their feet.
    fn carried(&self, base: &[Vec3], vectors: &[Vec3]) -> Vec<Vec3> {
        let neighbours = self.first_neighbours();
        let [before, after] =
            [&self.base[..], base].map(|points| normals::vectors(points, &self.patches, &[]).unit);
        let frame = |points: &[Vec3], normal: Vec3, i: usize| {
            let side = points[neighbours[i] as usize] - points[i];
            let along = (side - side.dot(normal) * normal).normalize_or_zero();
            Mat3::from_cols(along, normal, along.cross(normal))
        };
        (0..base.len())
            .into_par_iter()
            .map(|i| {
                if neighbours[i] == Face::NONE {
                    return vectors[i];
                }
                let (old, new) = (frame(&self.base, before[i], i), frame(base, after[i], i));
                if old == new { vectors[i] } else { new * (old.transpose() * vectors[i]) }
            })
            .collect()
    }

    /// By vertex the next one around its first patch; [`Face::NONE`] without a patch.
    fn first_neighbours(&self) -> Vec<u32> {
        let mut neighbours = vec![Face::NONE; self.base.len()];
        for patch in &self.patches {
            let (outline, n) = (patch.outline(), patch.corners().len());
            for k in 0..n {
                let neighbour = &mut neighbours[outline[k] as usize];
                if *neighbour == Face::NONE {
                    *neighbour = outline[(k + 1) % n];
                }
            }
        }
        neighbours
    }
}
