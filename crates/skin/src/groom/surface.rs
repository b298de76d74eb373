//! What operations ask of the surface below: normals, and directions along texture coordinates.

use glam::{DVec3, Vec2, Vec3};

use crate::{Skin, normals};

/// The surface that a skin stands on, by vertex.
pub(super) struct Ground {
    /// Unit length; zero where a vertex has no patch.
    pub normal: Vec<Vec3>,
}

impl Ground {
    pub fn new(skin: &Skin) -> Self {
        Self { normal: normals::vectors(&skin.base, &skin.patches, &[]).unit }
    }
}

/// By vertex the unit direction on the surface in which texture coordinates change along `uv`: the mean of its
/// patches', by area; zero where they cancel. `None` without texture coordinates.
pub(super) fn along_uv(skin: &Skin, uv: Vec2) -> Option<Vec<Vec3>> {
    let mut sums = vec![DVec3::ZERO; skin.base.len()];
    for (patch, uvs) in skin.patches.iter().zip(skin.uvs.as_ref()?) {
        let [a, b, c] = [0, 1, 2].map(|i| skin.base[patch.vertices[i] as usize].as_dvec3());
        let (side_u, side_v) = (b - a, c - a);
        let [ta, tb, tc] = [0, 1, 2].map(|i| uvs[i].as_dvec2());
        let (uv_u, uv_v, wanted) = (tb - ta, tc - ta, uv.as_dvec2());
        // x · uv_u + y · uv_v = wanted, times the determinant, whose sign alone matters for the direction.
        let mirrored = uv_u.perp_dot(uv_v).signum();
        let (x, y) = (mirrored * wanted.perp_dot(uv_v), mirrored * uv_u.perp_dot(wanted));
        let direction = (x * side_u + y * side_v).normalize_or_zero();
        let area = side_u.cross(side_v).length();
        for &v in patch.corners() {
            sums[v as usize] += area * direction;
        }
    }
    Some(sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3()).collect())
}
