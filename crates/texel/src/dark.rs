//! Sides of triangles that nothing is seen of: few points are tried on them.

use glam::Vec3;
use rayon::prelude::*;

use crate::random::Random;
use crate::surfel::direction;
use crate::surroundings::Surroundings;
use crate::voxelise::Facet;

/// Which sides of the facets, front and back, nothing is seen of within `reach` (texel units): the insides of tubes, as
/// far as a few rays tell.
pub(crate) fn dark_sides(facets: &[Facet], scene: &Surroundings, reach: f32) -> Vec<[bool; 2]> {
    const POINTS: usize = 6;
    const RAYS: usize = 4;
    let is_dark = |facet: usize, side: usize, random: &mut Random| {
        let Some(normal) = normal_of(facets[facet].corners, side) else { return true };
        (0..POINTS).all(|_| {
            let at = point_of(facets[facet].corners, random);
            (0..RAYS).all(|_| {
                let d = direction(normal, [random.signed(), random.signed()]);
                scene.distance(facet, at, d, reach, reach).is_finite()
            })
        })
    };
    (0..facets.len())
        .into_par_iter()
        .map(|facet| {
            let random = &mut Random::new(facet as u64, 0xda4c);
            [0, 1].map(|side| is_dark(facet, side, random))
        })
        .collect()
}

/// A point of a triangle, all alike.
pub(crate) fn point_of([a, b, c]: [Vec3; 3], random: &mut Random) -> Vec3 {
    let root = random.unit().sqrt();
    a + (1.0 - root) * (b - a) + root * random.unit() * (c - a)
}

/// The unit normal of a triangle's front (0) or back (1).
pub(crate) fn normal_of([a, b, c]: [Vec3; 3], side: usize) -> Option<Vec3> {
    let turn = if side == 0 { 1.0 } else { -1.0 };
    (turn * (b - a).cross(c - a)).try_normalize()
}
