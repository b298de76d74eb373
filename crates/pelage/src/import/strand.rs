//! Curves with a thickness: what lines in a file stand for.

use std::collections::BTreeMap;

use glam::{Mat4, Vec2, Vec3, Vec4};
use pelage_geom::MaterialId;

/// A hair, a fibre, a blade: a polyline that something thin runs along. Its lists are as long as its points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strand {
    /// Two points at least, in scene space, metres.
    pub points: Vec<Vec3>,
    /// Half its thickness at each point, in metres, where the file says so (glTF: the attribute `_RADIUS`).
    pub radii: Option<Vec<f32>>,
    /// Texture coordinates, v upwards.
    pub uvs: Option<Vec<Vec2>>,
    /// Linear colours and alpha, which multiply the material's.
    pub colors: Option<Vec<Vec4>>,
    /// What it wears.
    pub material: MaterialId,
}

impl Strand {
    /// Moves it by `transform`. Radii grow as the cube root of volumes does: alike in all directions.
    pub fn transform(&mut self, transform: Mat4) {
        for point in &mut self.points {
            *point = transform.transform_point3(*point);
        }
        let scale = glam::Mat3::from_mat4(transform).determinant().abs().cbrt();
        for radius in self.radii.iter_mut().flatten() {
            *radius *= scale;
        }
    }
}

/// The polylines that line segments between vertices make: each runs on through vertices in which two segments meet,
/// and ends where one, three or more do, or where it began. Open ones first, each begun where its first segment does.
pub(super) fn chains(segments: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut meeting: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, segment) in segments.iter().enumerate() {
        for &end in segment {
            meeting.entry(end).or_default().push(i);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    // What has no end is a ring, and may begin anywhere.
    for begin_anywhere in [false, true] {
        for (i, &[a, b]) in segments.iter().enumerate() {
            for from in [a, b] {
                if used[i] || (meeting[&from].len() == 2 && !begin_anywhere) {
                    continue;
                }
                let mut chain = vec![from];
                let (mut next, mut at) = (Some(i), from);
                while let Some(segment) = next {
                    used[segment] = true;
                    let [a, b] = segments[segment];
                    at = if a == at { b } else { a };
                    chain.push(at);
                    let beyond = meeting.get(&at).filter(|meeting| meeting.len() == 2);
                    next = beyond.and_then(|meeting| meeting.iter().copied().find(|&s| !used[s]));
                }
                chains.push(chain);
            }
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_join_where_two_meet() {
        // A path given in disorder, a ring, and three that meet in a fork.
        assert_eq!(chains(&[[1, 2], [0, 1], [3, 2]]), [[0, 1, 2, 3].to_vec()]);
        assert_eq!(chains(&[[5, 6], [6, 7], [7, 5]]), [[5, 6, 7, 5].to_vec()]);
        assert_eq!(
            chains(&[[0, 1], [1, 2], [1, 3], [3, 4]]),
            [[0, 1].to_vec(), [1, 2].to_vec(), [1, 3, 4].to_vec()]
        );
        assert!(chains(&[]).is_empty());
    }

    #[test]
    fn radii_grow_with_the_strand() {
        let mut strand =
            Strand { points: vec![Vec3::ZERO, Vec3::X], radii: Some(vec![0.1, 0.2]), ..Strand::default() };
        strand.transform(Mat4::from_scale(Vec3::splat(-3.0)) * Mat4::from_translation(Vec3::X));
        assert_eq!(strand.points, [-3.0 * Vec3::X, -6.0 * Vec3::X]);
        assert!(strand.radii.is_some_and(|r| (r[0] - 0.3).abs() + (r[1] - 0.6).abs() < 1e-6));
    }
}
