//! Where surfaces end: the edges that only one polygon has.

use rayon::prelude::*;

use crate::Skin;

/// A side of a polygon. In order, those along one edge stand beside each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// The edge: its smaller and its larger vertex.
    edge: [u32; 2],
    /// Which polygon.
    pub(crate) polygon: u32,
    /// Whether it runs from the larger vertex to the smaller.
    pub(crate) backwards: bool,
}

impl Side {
    /// The sides of `count` polygons, in order; `outline` gives the vertices around each, the first so many of four.
    pub(crate) fn all(count: usize, outline: impl Fn(usize) -> ([u32; 4], usize) + Sync) -> Vec<Self> {
        let of = |polygon: usize| {
            let (vertices, corners) = outline(polygon);
            (0..corners).map(move |i| {
                let [a, b] = [vertices[i], vertices[(i + 1) % corners]];
                Self { edge: [a.min(b), a.max(b)], polygon: polygon as u32, backwards: a > b }
            })
        };
        let mut all: Vec<Self> = (0..count).into_par_iter().flat_map_iter(of).collect();
        all.par_sort_unstable();
        all
    }

    /// Those along the same edge, edge by edge.
    pub(crate) fn by_edge(sides: &[Self]) -> impl Iterator<Item = &[Self]> {
        sides.chunk_by(|a, b| a.edge == b.edge)
    }
}

impl Skin {
    /// For each patch, whether it has an edge that no other patch shares: beside it, its box has an open wall.
    pub fn at_border(&self) -> Vec<bool> {
        let outline = |i: usize| (self.patches[i].outline(), self.patches[i].corners().len());
        let mut at_border = vec![false; self.patches.len()];
        for same in Side::by_edge(&Side::all(self.patches.len(), outline)) {
            if let [side] = same {
                at_border[side.polygon as usize] = true;
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
