//! The selected faces made fit to stand on: welded, without degenerate or repeated ones, their edges counted.

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::{Attribute, Face, MaterialId, Mesh};
use rayon::prelude::*;

use crate::Report;
use crate::border::Side;

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
    /// The coordinates that the texel is laid out by: these, or generated ones.
    pub laid: [Vec2; 4],
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

    /// The triangle on three of the corners.
    pub fn triangle(&self, pick: [usize; 3]) -> Self {
        let [a, b, c] = pick.map(|i| self.vertices[i]);
        let of = |list: [Vec2; 4]| {
            let [a, b, c] = pick.map(|i| list[i]);
            [a, b, c, Vec2::ZERO]
        };
        Self { vertices: [a, b, c, Face::NONE], uvs: of(self.uvs), laid: of(self.laid), ..*self }
    }
}

/// Polygons over shared vertices, some of which may be unused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub positions: Vec<Vec3>,
    /// Where the box over each position reaches, where that was given ([`crate::cage`]).
    pub tops: Option<Vec<Vec3>>,
    /// The mesh's vertex attributes, by position.
    pub attributes: Vec<Attribute>,
    pub polygons: Vec<Polygon>,
    /// Faces that get no box, but count for the vectors of the vertices they share ([`crate::Border::Mesh`]).
    pub bystanders: Vec<Polygon>,
}

impl Surface {
    /// Adds the vertex in the middle of others, with its top where there are tops and its attributes; the result is
    /// its index. Two vertices give the same bits in either order.
    pub fn middle(&mut self, of: &[u32]) -> u32 {
        let mean = |points: &[Vec3]| {
            let sum: DVec3 = of.iter().map(|&i| points[i as usize].as_dvec3()).sum();
            (sum / of.len() as f64).as_vec3()
        };
        self.positions.push(mean(&self.positions));
        if let Some(tops) = &mut self.tops {
            tops.push(mean(tops));
        }
        for Attribute { values, .. } in &mut self.attributes {
            let sum: f64 = of.iter().map(|&i| f64::from(values[i as usize])).sum();
            values.push((sum / of.len() as f64) as f32);
        }
        (self.positions.len() - 1) as u32
    }
}

/// Collects the faces for which `selected` holds, and with `bystanders` the others too; `tops` has one point a vertex
/// of the mesh.
///
/// Vertices at exactly the same position (with the same top, where there are tops) become one, so that a mesh split
/// at its texture seams still has one vector a point. Quads with two equal corners in a row become triangles.
pub(crate) fn collect(
    mesh: &Mesh,
    tops: Option<Vec<Vec3>>,
    selected: &dyn Fn(usize) -> bool,
    bystanders: bool,
    report: &mut Report,
) -> Surface {
    let welded = weld(mesh, tops.as_deref(), report);
    let wanted: Vec<bool> = (0..mesh.faces.len()).map(selected).collect();
    let polygons: Vec<Option<Polygon>> = mesh
        .faces
        .par_iter()
        .enumerate()
        .map(|(index, face)| {
            let uvs = mesh.uvs.as_ref().map_or([Vec2::ZERO; 4], |uvs| uvs[index]);
            distinct_corners(face, index as u32, uvs, &welded).filter(|p| has_area(p, &mesh.positions))
        })
        .collect();
    let (positions, attributes) = (mesh.positions.clone(), mesh.attributes.clone());
    let mut surface = Surface { positions, tops, attributes, ..Surface::default() };
    for (index, (polygon, wanted)) in polygons.into_iter().zip(wanted).enumerate() {
        match polygon {
            Some(polygon) if wanted => surface.polygons.push(polygon),
            Some(polygon) if bystanders => surface.bystanders.push(polygon),
            None if wanted => report.zero_area_faces.push(index as u32),
            _ => {}
        }
    }
    drop_duplicates(&mut surface.polygons, report);
    surface
}

/// What points at exactly the same position have in common, and only those.
pub(crate) type Place = [u32; 3];

/// The place of a point; 0 and −0 are the same.
pub(crate) fn place(point: Vec3) -> Place {
    // Adding zero turns −0 into 0.
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// For each vertex of the mesh, the first one at the same position, and with the same top.
fn weld(mesh: &Mesh, tops: Option<&[Vec3]>, report: &mut Report) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    for &i in mesh.faces.iter().flat_map(Face::corners) {
        used[i as usize] = true;
    }
    let key = |i: u32| {
        let of = |points: &[Vec3]| place(points[i as usize]);
        (of(&mesh.positions), tops.map(of))
    };
    let mut places: Vec<((Place, Option<Place>), u32)> =
        (0..used.len() as u32).filter(|&i| used[i as usize]).map(|i| (key(i), i)).collect();
    report.isolated_vertices = used.len() - places.len();
    places.par_sort_unstable();
    let mut welded: Vec<u32> = (0..used.len() as u32).collect();
    for vertices in places.chunk_by(|a, b| a.0 == b.0) {
        report.welded_vertices += vertices.len() - 1;
        for &(_, i) in vertices {
            welded[i as usize] = vertices[0].1;
        }
    }
    welded
}

/// The face with its welded corners, repeated ones dropped; `None` where fewer than three remain.
fn distinct_corners(face: &Face, index: u32, uvs: [Vec2; 4], welded: &[u32]) -> Option<Polygon> {
    let mut polygon = Polygon {
        vertices: [Face::NONE; 4],
        face: index,
        material: face.material,
        uvs: [Vec2::ZERO; 4],
        laid: [Vec2::ZERO; 4],
    };
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
    polygon.laid = polygon.uvs;
    let [a, b, c, d] = polygon.vertices;
    (count >= 3 && a != c && b != d).then_some(polygon)
}

/// Whether the area exceeds the rounding of an `f32` times the square of the longest side or diagonal.
fn has_area(polygon: &Polygon, positions: &[Vec3]) -> bool {
    let [a, b, c, d] = polygon.points(positions);
    let spans = [b - a, c - b, d - c, a - d, c - a, d - b];
    let longest = spans.iter().map(|s| s.length_squared()).fold(0.0, f64::max);
    polygon.area_vector(positions).length() > f64::from(f32::EPSILON) * longest
}

/// Keeps the first of the polygons that have the same corners in the same order around.
fn drop_duplicates(polygons: &mut Vec<Polygon>, report: &mut Report) {
    let mut keys: Vec<([u32; 4], u32)> =
        polygons.par_iter().map(|p| (canonical(p.vertices), p.face)).collect();
    keys.par_sort_unstable();
    let repeated = keys.chunk_by(|a, b| a.0 == b.0).flat_map(|same| &same[1..]);
    report.duplicate_faces = repeated.map(|&(_, face)| face).collect();
    report.duplicate_faces.sort_unstable();
    polygons.retain(|p| report.duplicate_faces.binary_search(&p.face).is_err());
}

/// The same for all rotations of a polygon, and only for those.
fn canonical(vertices: [u32; 4]) -> [u32; 4] {
    let count = if vertices[3] == Face::NONE { 3 } else { 4 };
    let start = (0..count).min_by_key(|&i| vertices[i]).unwrap_or(0);
    let mut turned = vertices;
    turned[..count].rotate_left(start);
    turned
}

/// Counts the edges with one face, with more than two, and with two that run the same way.
pub(crate) fn count_edges(polygons: &[Polygon], report: &mut Report) {
    let outline = |i: usize| (polygons[i].vertices, polygons[i].corners().len());
    for faces in Side::by_edge(&Side::all(polygons.len(), outline)) {
        match faces {
            [_] => report.open_edges += 1,
            [a, b] => report.misoriented_edges += usize::from(a.backwards == b.backwards),
            _ => report.non_manifold_edges += 1,
        }
    }
}
