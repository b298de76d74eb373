//! The selected faces made fit to stand on: welded, without degenerate or repeated ones, their edges counted.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::{Face, MaterialId, Mesh};
use rayon::prelude::*;

use crate::Report;

/// A triangle or quad of the surface to be covered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    /// Counter-clockwise; the fourth is [`Face::NONE`] for a triangle.
    pub vertices: [u32; 4],
    /// The face of the mesh that it came from.
    pub face: u32,
    pub material: MaterialId,
    /// The mesh's texture coordinates at the corners, zero without any; the fourth of a triangle is unused.
    pub uvs: [Vec2; 4],
}

impl Polygon {
    /// The three or four indices.
    pub fn corners(&self) -> &[u32] {
        if self.vertices[3] == Face::NONE { &self.vertices[..3] } else { &self.vertices }
    }

    /// The corners' positions, the fourth of a triangle repeating the first.
    pub fn points(&self, positions: &[Vec3]) -> [DVec3; 4] {
        let first = self.vertices[0];
        self.vertices.map(|i| positions[if i == Face::NONE { first } else { i } as usize].as_dvec3())
    }

    /// The normal times the area; in `f64`, so that only the rounding of the positions themselves counts.
    pub fn area_vector(&self, positions: &[Vec3]) -> DVec3 {
        let [a, b, c, d] = self.points(positions);
        0.5 * (c - a).cross(d - b)
    }
}

/// Polygons over shared vertices, some of which may be unused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub positions: Vec<Vec3>,
    pub polygons: Vec<Polygon>,
    /// Faces that get no box, but give their vector to the vertices they share ([`crate::Border::Mesh`]).
    pub bystanders: Vec<Polygon>,
}

/// Collects the faces for which `selected` holds, and with `bystanders` the others too.
///
/// Vertices at exactly the same position become one (0 and −0 are the same), so that a mesh split at its
/// texture seams still has one vector a point. Quads with two equal corners in a row become triangles.
pub(crate) fn collect(
    mesh: &Mesh,
    selected: &dyn Fn(usize) -> bool,
    bystanders: bool,
    report: &mut Report,
) -> Surface {
    let welded = weld(mesh, report);
    let mut surface = Surface { positions: mesh.positions.clone(), ..Surface::default() };
    let mut seen = HashSet::new();
    for (index, face) in mesh.faces.iter().enumerate() {
        let wanted = selected(index);
        if !wanted && !bystanders {
            continue;
        }
        let uvs = mesh.uvs.as_ref().map_or([Vec2::ZERO; 4], |uvs| uvs[index]);
        let polygon = distinct_corners(face, index as u32, uvs, &welded)
            .filter(|p| p.area_vector(&mesh.positions).length() > smallest_area(p, &mesh.positions));
        match polygon {
            Some(polygon) if !wanted => surface.bystanders.push(polygon),
            Some(polygon) if seen.insert(canonical(polygon.vertices)) => surface.polygons.push(polygon),
            Some(_) => report.duplicate_faces.push(index as u32),
            None if wanted => report.zero_area_faces.push(index as u32),
            None => {}
        }
    }
    surface
}

/// For each vertex of the mesh, the first one at the same position.
fn weld(mesh: &Mesh, report: &mut Report) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    for &i in mesh.faces.iter().flat_map(Face::corners) {
        used[i as usize] = true;
    }
    report.isolated_vertices = used.iter().filter(|&&u| !u).count();

    let mut first = HashMap::with_capacity(mesh.positions.len());
    let key = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let welded = (0..mesh.positions.len())
        .map(|i| match used[i] {
            true => *first.entry(key(mesh.positions[i])).or_insert(i as u32),
            false => i as u32,
        })
        .collect::<Vec<u32>>();
    report.welded_vertices = welded.iter().enumerate().filter(|&(i, &w)| i as u32 != w).count();
    welded
}

/// The face with its welded corners, repeated ones dropped; `None` where fewer than three remain.
fn distinct_corners(face: &Face, index: u32, uvs: [Vec2; 4], welded: &[u32]) -> Option<Polygon> {
    let mut polygon =
        Polygon { vertices: [Face::NONE; 4], face: index, material: face.material, uvs: [Vec2::ZERO; 4] };
    let corners = face.corners();
    let mut count = 0;
    for (k, &corner) in corners.iter().enumerate() {
        let vertex = welded[corner as usize];
        let next = welded[corners[(k + 1) % corners.len()] as usize];
        if vertex != next {
            (polygon.vertices[count], polygon.uvs[count]) = (vertex, uvs[k]);
            count += 1;
        }
    }
    let [a, b, c, d] = polygon.vertices;
    (count >= 3 && a != c && b != d).then_some(polygon)
}

/// The area under which a polygon has none: an `f32`'s rounding times its longest diagonal or side, squared.
fn smallest_area(polygon: &Polygon, positions: &[Vec3]) -> f64 {
    let [a, b, c, d] = polygon.points(positions);
    let spans = [b - a, c - b, d - c, a - d, c - a, d - b];
    f64::from(f32::EPSILON) * spans.iter().map(|s| s.length_squared()).fold(0.0, f64::max)
}

/// The same for all rotations of a polygon, and only for those.
fn canonical(vertices: [u32; 4]) -> [u32; 4] {
    let count = if vertices[3] == Face::NONE { 3 } else { 4 };
    let start = (0..count).min_by_key(|&i| vertices[i]).unwrap_or(0);
    let mut turned = vertices;
    for (i, v) in turned[..count].iter_mut().enumerate() {
        *v = vertices[(start + i) % count];
    }
    turned
}

/// Counts the edges with one face, with more than two, and with two that run the same way.
pub(crate) fn count_edges(polygons: &[Polygon], report: &mut Report) {
    // An edge is its smaller and its larger vertex and whether it is run backwards, packed so as to sort.
    let mut edges: Vec<(u64, bool)> = polygons
        .par_iter()
        .flat_map_iter(|polygon| {
            let corners = polygon.corners();
            (0..corners.len()).map(move |i| {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), a > b)
            })
        })
        .collect();
    edges.par_sort_unstable();
    for faces in edges.chunk_by(|a, b| a.0 == b.0) {
        match faces {
            [_] => report.open_edges += 1,
            [a, b] => report.misoriented_edges += usize::from(a.1 == b.1),
            _ => report.non_manifold_edges += 1,
        }
    }
}
