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
    /// Which of its sides: the one that begins with the vertex of that number.
    number: u8,
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
                Self {
                    edge: [a.min(b), a.max(b)],
                    polygon: polygon as u32,
                    number: i as u8,
                    backwards: a > b,
                }
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
    /// For each patch, in the order of its [`outline`](crate::Patch::outline), which sides no other patch shares: there its
    /// box has an open wall.
    pub fn open_sides(&self) -> Vec<[bool; 4]> {
        let outline = |i: usize| (self.patches[i].outline(), self.patches[i].corners().len());
        let mut open = vec![[false; 4]; self.patches.len()];
        for same in Side::by_edge(&Side::all(self.patches.len(), outline)) {
            if let [side] = same {
                open[side.polygon as usize][side.number as usize] = true;
            }
        }
        open
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{SkinOptions, extrude, surface};

    #[test]
    fn the_rim_of_a_sheet_is_its_border_and_a_ring_has_none() {
        let skin = |mesh| extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).expect("it extrudes");
        // 5 × 4 patches, of which 3 × 2 lie inside.
        let sheet = skin(surface::plane(5.0, 5, 4));
        let open = sheet.open_sides();
        assert_eq!(open.iter().filter(|sides| sides.contains(&true)).count(), 20 - 6);
        // As many as the rim is long, and each where the rim is: no vertex of it lies further in.
        assert_eq!(open.as_flattened().iter().filter(|open| **open).count(), 2 * (5 + 4));
        let rim = sheet.base.iter().fold(Vec3::ZERO, |most, p| most.max(p.abs()));
        for (patch, sides) in sheet.patches.iter().zip(open) {
            let outline = patch.outline();
            for i in (0..4).filter(|i| sides[*i]) {
                let ends = [outline[i], outline[(i + 1) % 4]].map(|v| sheet.base[v as usize].abs());
                let least = ends[0].min(ends[1]);
                assert!((0..3).any(|axis| rim[axis] > 0.0 && least[axis] > rim[axis] - 1e-4), "{ends:?}");
            }
        }
        let ring = skin(surface::torus(1.0, 0.4, 12, 8));
        assert!(!ring.open_sides().as_flattened().contains(&true));
    }
}
