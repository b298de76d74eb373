//! Strands of an OBJ file: its `l` elements, which tobj takes for polygons.
//!
//! Segments of one material that share a vertex run on into each other, whether a line is one `l` of many vertices or
//! many of two. OBJ has no thickness.

use std::collections::BTreeMap;

use glam::{Vec3, Vec4};
use pelage_geom::MaterialId;

use crate::import::strand::{Strand, chains};

/// The vertices of a file, and the lines between them.
#[derive(Default)]
pub(super) struct Lines {
    /// In the file's own space and unit.
    pub(super) positions: Vec<Vec3>,
    /// One a position, or none at all.
    pub(super) colors: Vec<Vec3>,
    /// The material of the lines that follow; none yet.
    pub(super) material: Option<String>,
    segments: BTreeMap<Option<String>, Vec<[u32; 2]>>,
}

impl Lines {
    /// Adds the segments between vertices that follow each other, counted from 0; returns how many.
    pub(super) fn add(&mut self, vertices: &[u32]) -> usize {
        let segments = self.segments.entry(self.material.clone()).or_default();
        let before = segments.len();
        segments.extend(vertices.windows(2).filter(|pair| pair[0] != pair[1]).map(|pair| [pair[0], pair[1]]));
        segments.len() - before
    }

    /// The strands: each vertex brought into the scene by `place`, each material found by its name.
    pub(super) fn strands(
        self,
        place: impl Fn(Vec3) -> Vec3,
        material: impl Fn(Option<&str>) -> MaterialId,
    ) -> Vec<Strand> {
        let Self { positions, colors, segments, .. } = self;
        let of_material = |(name, segments): (Option<String>, Vec<[u32; 2]>)| {
            let material = material(name.as_deref());
            chains(&segments).into_iter().map(move |chain| (chain, material))
        };
        let strand = |(chain, material): (Vec<u32>, MaterialId)| {
            let at = || chain.iter().map(|&i| i as usize);
            let points = at().map(|i| place(positions[i])).collect();
            let colors =
                (!colors.is_empty()).then(|| at().map(|i| colors[i].extend(1.0)).collect::<Vec<Vec4>>());
            Strand { points, colors, material, ..Strand::default() }
        };
        segments.into_iter().flat_map(of_material).map(strand).collect()
    }
}
