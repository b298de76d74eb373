//! Every face of n corners becomes n quads, by the midpoints of its edges and its centre (one step of
//! Catmull–Clark's topology, on flat faces). [CatmullClark78]
//!
//! It is applied to a whole surface or not at all: a split face next to one that is not would put a vertex in
//! the middle of its neighbour's wall, and the two boxes would no longer share it.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};

use crate::polygon::{Polygon, Surface};
use crate::quad;

/// Splits all polygons; quads that are not convex, whose centre may lie outside, become two triangles first.
/// Bystanders are split too: they must have the same edges.
pub(crate) fn refine(surface: &Surface) -> Surface {
    let mut positions = surface.positions.clone();
    let mut midpoints = HashMap::with_capacity(2 * (surface.polygons.len() + surface.bystanders.len()));
    let mut split = |polygons: &[Polygon]| {
        let mut quads = Vec::with_capacity(4 * polygons.len());
        for polygon in polygons {
            let points = polygon.points(&positions);
            if polygon.corners().len() == 4 && quad::is_concave(points) {
                for pick in quad::halves(points) {
                    quads.extend(split_one(polygon.triangle(pick), &mut positions, &mut midpoints));
                }
            } else {
                quads.extend(split_one(*polygon, &mut positions, &mut midpoints));
            }
        }
        quads
    };
    let polygons = split(&surface.polygons);
    let bystanders = split(&surface.bystanders);
    Surface { positions, polygons, bystanders }
}

/// One quad at each corner of `polygon`: the corner, the midpoint after it, the centre, the midpoint before it.
fn split_one(
    polygon: Polygon,
    positions: &mut Vec<Vec3>,
    midpoints: &mut HashMap<(u32, u32), u32>,
) -> impl Iterator<Item = Polygon> + use<> {
    let n = polygon.corners().len();
    let corners = polygon.vertices;
    let mut middle = [0; 4];
    for k in 0..n {
        let (a, b) = (corners[k], corners[(k + 1) % n]);
        middle[k] = *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
            // The smaller index first: the same bits from both sides.
            let (p, q) = (positions[a.min(b) as usize], positions[a.max(b) as usize]);
            positions.push((0.5 * (p.as_dvec3() + q.as_dvec3())).as_vec3());
            (positions.len() - 1) as u32
        });
    }
    let sum = corners[..n].iter().map(|&i| positions[i as usize].as_dvec3()).sum::<DVec3>();
    positions.push((sum / n as f64).as_vec3());
    let centre = (positions.len() - 1) as u32;
    let uv_centre = polygon.uvs[..n].iter().copied().sum::<Vec2>() / n as f32;
    let uv_middle = move |k: usize| 0.5 * (polygon.uvs[k] + polygon.uvs[(k + 1) % n]);
    (0..n).map(move |k| {
        let before = (k + n - 1) % n;
        Polygon {
            vertices: [corners[k], middle[k], centre, middle[before]],
            uvs: [polygon.uvs[k], uv_middle(k), uv_centre, uv_middle(before)],
            ..polygon
        }
    })
}

/// Whether any face of the surface is a triangle, so that it needs splitting. Bystanders count: a skin on them must
/// come to the same answer.
pub(crate) fn has_triangles(surface: &Surface) -> bool {
    surface.polygons.iter().chain(&surface.bystanders).any(|p| p.corners().len() == 3)
}
