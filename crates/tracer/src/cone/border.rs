//! Where a skin ends: its last copies have an open wall, and are looked at more closely.
//!
//! A voxel of the coarsest levels is as wide as much of the texel. Side by side with its copies it hides what they hide;
//! at the end of the skin its own outline is seen, a box, and what it shows takes for granted that copies stand beside it.

use glam::{DVec2, Vec2};
use pelage_skin::Patch;

use super::passages::BoxPassage;
use crate::{Lod, Scene};

/// The coarsest level for the last copies: the first whose voxels know of no more than what is near them.
const ALONE: f32 = 3.0;

/// The coarsest level that a cone may read where a passage begins and where it ends.
#[inline]
pub(super) fn coarsest(scene: &Scene, lod: Lod, passage: &BoxPassage, patch: &Patch) -> [f32; 2] {
    let any = [f32::NEG_INFINITY; 2];
    let (Lod::Footprint(_), Some(open)) = (lod, scene.open_sides(passage.patch)) else { return any };
    passage.u.map(|u| if copies_within(patch, open, u.truncate()) < 1.0 { ALONE } else { f32::NEG_INFINITY })
}

/// How far within the open sides of a patch a point (box coordinates) is, in copies of the texel.
fn copies_within(patch: &Patch, open: [bool; 4], at: DVec2) -> f32 {
    let (lattice, at) = (patch.lattice, at.as_vec2());
    // Each side's way along the lattice, and the part of the patch between it and the point.
    let sides: [(Vec2, f32); 4] = if patch.is_prism() {
        let slant = (lattice.v - lattice.u, 1.0 - at.x - at.y);
        [(lattice.u, at.y), slant, (lattice.v, at.x), (lattice.v, f32::INFINITY)]
    } else {
        [(lattice.u, at.y), (lattice.v, 1.0 - at.x), (lattice.u, 1.0 - at.y), (lattice.v, at.x)]
    };
    let area = lattice.determinant().abs();
    let within = |((along, part), _): ((Vec2, f32), bool)| part * area / along.length();
    sides.into_iter().zip(open).filter(|(_, open)| *open).map(within).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use pelage_skin::{Anchor, Lattice};

    use super::*;

    fn patch(vertices: [u32; 4], u: Vec2, v: Vec2) -> Patch {
        let lattice = Lattice { origin: Vec2::ZERO, u, v };
        Patch { vertices, face: 0, material: Default::default(), lattice, anchor: Anchor::default() }
    }

    #[test]
    fn copies_are_counted_from_the_open_sides() {
        // Six copies by three, slanted: a row of copies is as deep as they are, however long the side.
        let quad = patch([0, 1, 2, 3], Vec2::new(6.0, 0.0), Vec2::new(2.0, 3.0));
        let at = DVec2::new(0.25, 0.125);
        let within = |side: usize| copies_within(&quad, std::array::from_fn(|i| i == side), at);
        assert!((within(0) - 0.375).abs() < 1e-5);
        assert!((within(2) - 2.625).abs() < 1e-5);
        // Across, copies are met along the normal of the slanted sides: 18 / √13 in all.
        let all = 18.0 / 13.0_f32.sqrt();
        assert!((within(1) - 0.75 * all).abs() < 1e-4 && (within(3) - 0.25 * all).abs() < 1e-4);
        assert!((copies_within(&quad, [true; 4], at) - 0.375).abs() < 1e-5);
        assert!(copies_within(&quad, [false; 4], at) == f32::INFINITY);
        // Of a prism the second side is the slant.
        let prism = patch([0, 1, 2, pelage_geom::Face::NONE], 4.0 * Vec2::X, 4.0 * Vec2::Y);
        let slant = copies_within(&prism, [false, true, false, false], at);
        assert!((slant - (1.0 - 0.375) * 4.0 / 2.0_f32.sqrt()).abs() < 1e-4);
    }
}
