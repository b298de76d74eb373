//! Boxes left out by chance, as many as a density says.

use pelage_geom::hash::{STEP, finish};
use rayon::prelude::*;

use crate::{Patch, Skin};

/// The part of the boxes that stay, by vertex.
pub(super) struct Density(Option<Vec<f32>>);

impl Density {
    /// All of them.
    pub const FULL: Self = Self(None);

    /// Multiplies it by `factor`, as far as the weights of the vertices go.
    pub fn thin(&mut self, factor: f32, weights: &[f32]) {
        let density = self.0.get_or_insert_with(|| vec![1.0; weights.len()]);
        density.par_iter_mut().zip(weights).for_each(|(d, w)| *d *= 1.0 + w * (factor - 1.0));
    }

    /// Leaves out boxes of `skin`, each by a number of its own: a lower density leaves a part of those that a higher
    /// one does. Tells by patch which stay, and nothing where all do.
    pub fn apply(self, skin: &mut Skin) -> Option<Vec<bool>> {
        let density = self.0?;
        let stays = |(i, patch): (usize, &Patch)| {
            let corners = patch.corners();
            let mean = corners.iter().map(|&v| density[v as usize]).sum::<f32>() / corners.len() as f32;
            drawn(i as u32) < mean
        };
        let kept: Vec<bool> = skin.patches.par_iter().enumerate().map(stays).collect();
        skin.report.thinned = kept.iter().filter(|stays| !**stays).count();
        retain(&mut skin.patches, &kept);
        if let Some(uvs) = &mut skin.uvs {
            retain(uvs, &kept);
        }
        Some(kept)
    }
}

/// Keeps what `kept` says.
pub(super) fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut stays = kept.iter();
    list.retain(|_| stays.next() == Some(&true));
}

/// Uniform in [0, 1), by the number of a box alone. \[Steele14\]
fn drawn(number: u32) -> f32 {
    (finish((u64::from(number) + 1).wrapping_mul(STEP)) >> 40) as f32 / (1 << 24) as f32
}
