//! Every face of n corners becomes n quads, by the midpoints of its edges and its centre (one step of
//! Catmull–Clark's topology, on flat faces). [CatmullClark78]
//!
//! It is applied to a whole surface or not at all: a split face next to one that is not would put a vertex in
//! the middle of its neighbour's wall, and the two boxes would no longer share it.

use std::collections::HashMap;

use glam::Vec2;

use crate::polygon::{Polygon, Surface};
use crate::quad;

/// Splits all polygons; quads that are not convex, whose centre may lie outside, become two triangles first.
/// Bystanders are split too: they must have the same edges.
pub(crate) fn refine(mut surface: Surface) -> Surface {
    let polygons = std::mem::take(&mut surface.polygons);
    let bystanders = std::mem::take(&mut surface.bystanders);
    let mut midpoints = HashMap::with_capacity(2 * (polygons.len() + bystanders.len()));
    let mut split = |polygons: Vec<Polygon>| {
        let mut quads = Vec::with_capacity(4 * polygons.len());
        for polygon in polygons {
            let points = polygon.points(&surface.positions);
            if polygon.corners().len() == 4 && quad::is_concave(points) {
                for pick in quad::halves(points) {
                    quads.extend(split_one(polygon.triangle(pick), &mut surface, &mut midpoints));
                }
            } else {
                quads.extend(split_one(polygon, &mut surface, &mut midpoints));
            }
        }
        quads
    };
    let (polygons, bystanders) = (split(polygons), split(bystanders));
    Surface { polygons, bystanders, ..surface }
}

/// One quad at each corner of `polygon`: the corner, the midpoint after it, the centre, the midpoint before it.
fn split_one(
    polygon: Polygon,
    surface: &mut Surface,
    midpoints: &mut HashMap<(u32, u32), u32>,
) -> impl Iterator<Item = Polygon> + use<> {
    let n = polygon.corners().len();
    let corners = polygon.vertices;
    let mut middle = [0; 4];
    for k in 0..n {
        let (a, b) = (corners[k], corners[(k + 1) % n]);
        middle[k] = *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| surface.middle(&[a, b]));
    }
    let centre = surface.middle(&corners[..n]);
    let uv_centre = polygon.uvs[..n].iter().copied().sum::<Vec2>() / n as f32;
    let uv_middle = move |k: usize| 0.5 * (polygon.uvs[k] + polygon.uvs[(k + 1) % n]);
    (0..n).map(move |k| {
        let before = (k + n - 1) % n;
        Polygon {
            vertices: [corners[k], middle[k], centre, middle[before]],
            uvs: [polygon.uvs[k], uv_middle(k), uv_centre, uv_middle(before)],
            // Copies go by faces here.
            laid: [Vec2::ZERO; 4],
            ..polygon
        }
    })
}

/// Whether any face of the surface is a triangle, so that it needs splitting. Bystanders count: a skin on them must
/// come to the same answer.
pub(crate) fn has_triangles(surface: &Surface) -> bool {
    surface.polygons.iter().chain(&surface.bystanders).any(|p| p.corners().len() == 3)
}
