//! Where a skin ends.

use rayon::prelude::*;

use crate::Skin;

impl Skin {
    /// For each patch, whether it has an edge that no other patch shares: beside it, its box has an open wall.
    pub fn at_border(&self) -> Vec<bool> {
        let edges = |patch: usize| {
            let outline = self.patches[patch].outline();
            let count = self.patches[patch].corners().len();
            (0..count).map(move |i| {
                let [a, b] = [outline[i], outline[(i + 1) % count]];
                u64::from(a.min(b)) << 32 | u64::from(a.max(b))
            })
        };
        let mut all: Vec<(u64, u32)> = (0..self.patches.len())
            .into_par_iter()
            .flat_map_iter(|patch| edges(patch).map(move |edge| (edge, patch as u32)))
            .collect();
        all.par_sort_unstable();
        let mut at_border = vec![false; self.patches.len()];
        for same in all.chunk_by(|(edge, _), (other, _)| edge == other) {
            if let [(_, patch)] = same {
                at_border[*patch as usize] = true;
            }
        }
        at_border
    }
}

#[cfg(test)]
mod tests {
    use crate::{SkinOptions, extrude, surface};

    #[test]
    fn the_rim_of_a_sheet_is_its_border_and_a_ring_has_none() {
        let skin = |mesh| extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).expect("it extrudes");
        // 5 × 4 patches, of which 3 × 2 lie inside.
        let sheet = skin(surface::plane(5.0, 5, 4));
        assert_eq!(sheet.at_border().iter().filter(|b| **b).count(), 20 - 6);
        let ring = skin(surface::torus(1.0, 0.4, 12, 8));
        assert!(!ring.at_border().contains(&true));
    }
}
