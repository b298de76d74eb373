//! Variants: contents that differ inside of a copy and are the same where they go on in the next.

use glam::Vec3;

use crate::Geometry;

/// The seed of a variant's own elements.
pub(super) fn seed_of(seed: u64, variant: u32) -> u64 {
    seed.wrapping_add(u64::from(variant).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Adds the elements `0..count` to `geometry`: of variant 0, those that `common` grows; of another, those of `common` that
/// cross a border of the copy, and those that `own` grows of which none does. Both are as dense, so the whole is.
pub(super) fn elements(
    mut geometry: Geometry,
    count: u32,
    variant: u32,
    common: impl Fn(u32, &mut Geometry),
    own: impl Fn(u32, &mut Geometry),
) -> Geometry {
    let mut add = |grow: &dyn Fn(u32, &mut Geometry), is_wanted: &dyn Fn(&[[Vec3; 3]]) -> bool| {
        for i in 0..count {
            let before = geometry.triangles.len();
            grow(i, &mut geometry);
            if !is_wanted(&geometry.triangles[before..]) {
                geometry.triangles.truncate(before);
                geometry.colors.truncate(before);
            }
        }
    };
    if variant == 0 {
        add(&common, &|_| true);
    } else {
        add(&common, &cross_a_border);
        add(&own, &|triangles| !cross_a_border(triangles));
    }
    geometry
}

/// Whether any corner lies outside of the copy that holds the first.
fn cross_a_border(triangles: &[[Vec3; 3]]) -> bool {
    let mut corners = triangles.iter().flatten().map(|p| p.truncate().floor());
    let first = corners.next();
    corners.any(|copy| Some(copy) != first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::{Fur, Grass, Moss, Needles, Pile};
    use crate::{Procedure, kinds::Foliage};

    /// The triangles that lie across a border, in their order, and how many there are in all.
    fn crossing(geometry: &Geometry) -> (Vec<[Vec3; 3]>, usize) {
        let all = &geometry.triangles;
        (all.iter().filter(|t| cross_a_border(&[**t])).copied().collect(), all.len())
    }

    #[test]
    fn variants_go_on_in_each_other_and_differ_inside() {
        let check = |name: &str, of: &dyn Fn(u32) -> Geometry| {
            let [(a, all_a), (b, all_b), (c, _)] = [0, 1, 2].map(|v| crossing(&of(v)));
            assert!(!a.is_empty() && a == b && b == c, "{name}: {} {} {}", a.len(), b.len(), c.len());
            // As dense, but for chance: of n elements that are inside with the probability p, √(2np(1 − p)) more or
            // fewer, which for the hundred plants of the smallest is 7 %; three times that.
            assert!(all_a.abs_diff(all_b) as f32 <= 0.21 * all_a as f32, "{name}: {all_a} {all_b}");
            assert_ne!(of(0).triangles, of(1).triangles, "{name}");
            assert_ne!(of(1).triangles, of(2).triangles, "{name}");
        };
        check("fur", &|variant| Fur { variant, ..Fur::default() }.geometry());
        check("grass", &|variant| Grass { variant, ..Grass::default() }.geometry());
        check("moss", &|variant| Moss { variant, ..Moss::default() }.geometry());
        check("pile", &|variant| Pile { variant, ..Pile::default() }.geometry());
        check("foliage", &|variant| Foliage { variant, ..Foliage::default() }.geometry());
        check("needles", &|variant| Needles { variant, ..Needles::default() }.geometry());
    }
}
