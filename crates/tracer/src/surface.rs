//! Opaque meshes: where a ray meets their triangles, exactly between neighbours.

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::{MaterialId, Mesh, Ray};

use crate::accel::Accel;

/// All opaque triangles of a scene.
pub(crate) struct Surfaces {
    accel: Accel,
    triangles: Vec<Triangle>,
}

/// An opaque triangle.
pub(crate) struct Triangle {
    pub corners: [Vec3; 3],
    pub normals: [Vec3; 3],
    pub uvs: [Vec2; 3],
    pub material: MaterialId,
}

/// A point of an opaque surface, as a ray found it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceHit {
    /// Distance along the ray, in scene units.
    pub t: f64,
    /// Where, in scene space.
    pub point: DVec3,
    /// The triangle's own normal, unit length, on the side it winds counter-clockwise.
    pub geometric_normal: Vec3,
    /// The interpolated shading normal, unit length, on the same side.
    pub normal: Vec3,
    /// Where shadow cones start, on the front and on the back: lifted to the curved surface that the normals stand
    /// for, so that the flat faces of a smooth mesh do not cut its shadow's edge into facets. [Hanika21]
    pub lifted: [DVec3; 2],
    /// Texture coordinates.
    pub uv: Vec2,
    /// Units of uv per scene unit there.
    pub uv_density: f32,
    /// What the surface is made of.
    pub material: MaterialId,
}

impl Surfaces {
    /// Collects the triangles of all meshes; a quad is cut along its shorter diagonal.
    pub(crate) fn new(meshes: Vec<Mesh>) -> Self {
        let count = meshes.iter().flat_map(|m| &m.faces).map(|f| 1 + usize::from(f.is_quad())).sum();
        let (mut triangles, mut bounds) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for mesh in meshes {
            for f in 0..mesh.faces.len() {
                let halves = triangles.len();
                triangles.extend(triangles_of(&mesh, f));
                let points = || triangles[halves..].iter().flat_map(|t: &Triangle| t.corners);
                let around = [Vec3::INFINITY, Vec3::NEG_INFINITY];
                let around = points().fold(around, |[lo, hi], p| [lo.min(p), hi.max(p)]);
                // The halves of a quad share their bounds, and so a leaf: it is half the tree.
                bounds.resize(triangles.len(), around);
            }
        }
        Self { accel: Accel::new(bounds), triangles }
    }

    /// How many triangles there are.
    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// The triangles, in the order of the meshes and their faces.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.triangles.iter()
    }

    /// The first surface along the ray before `t_max`.
    pub(crate) fn closest(&self, ray: &Ray, t_max: f64) -> Option<SurfaceHit> {
        let (t, index) = self.accel.closest(ray, t_max, |i, limit| {
            intersect(&self.triangles[i as usize].corners, ray, limit).map(|(t, _)| t)
        })?;
        let triangle = &self.triangles[index as usize];
        let (_, weights) = intersect(&triangle.corners, ray, f64::INFINITY)?;
        Some(triangle.hit(ray.at(t), t, weights))
    }

    /// Whether a surface is in the way before `t_max`.
    pub(crate) fn blocked(&self, ray: &Ray, t_max: f64) -> bool {
        self.accel.any(ray, t_max, |i, limit| {
            intersect(&self.triangles[i as usize].corners, ray, limit).map(|(t, _)| t)
        })
    }
}

impl Triangle {
    fn hit(&self, point: DVec3, t: f64, weights: Vec3) -> SurfaceHit {
        let [a, b, c] = self.corners;
        let area = (b - a).cross(c - a);
        let geometric_normal = area.normalize_or(Vec3::Y);
        let mix = weights.x * self.normals[0] + weights.y * self.normals[1] + weights.z * self.normals[2];
        let normal = mix.normalize_or(geometric_normal);
        let lifted = [self.lifted(point, weights, 1.0), self.lifted(point, weights, -1.0)];
        let [p, q, r] = self.uvs;
        let uv_area = (q - p).perp_dot(r - p).abs();
        SurfaceHit {
            t,
            point,
            geometric_normal,
            // A normal on the other side (files have them) would turn the surface inside out.
            normal: if normal.dot(geometric_normal) < 0.0 { -normal } else { normal },
            lifted,
            uv: weights.x * p + weights.y * q + weights.z * r,
            uv_density: (uv_area / area.length().max(f32::MIN_POSITIVE)).sqrt(),
            material: self.material,
        }
    }
}

impl Triangle {
    /// The point raised to the planes across the corners' normals, by its weights, where it lies below them.
    fn lifted(&self, point: DVec3, weights: Vec3, side: f64) -> DVec3 {
        let mut lifted = point;
        for (i, (&corner, &normal)) in self.corners.iter().zip(&self.normals).enumerate() {
            let normal = side * normal.as_dvec3();
            let below = (point - corner.as_dvec3()).dot(normal).min(0.0);
            lifted -= f64::from(weights[i]) * below * normal;
        }
        lifted
    }
}

fn triangles_of(mesh: &Mesh, f: usize) -> impl Iterator<Item = Triangle> + '_ {
    let face = &mesh.faces[f];
    let p = |i: usize| mesh.positions[face.vertices[i] as usize];
    let halves: &[[usize; 3]] = if !face.is_quad() {
        &[[0, 1, 2]]
    } else if p(0).distance_squared(p(2)) <= p(1).distance_squared(p(3)) {
        &[[0, 1, 2], [0, 2, 3]]
    } else {
        &[[0, 1, 3], [1, 2, 3]]
    };
    halves.iter().map(move |corner| {
        let corners = corner.map(p);
        let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
        Triangle {
            corners,
            normals: mesh.normals.as_ref().map_or([flat; 3], |n| corner.map(|i| n[f][i])),
            uvs: mesh.uvs.as_ref().map_or([Vec2::ZERO; 3], |uv| corner.map(|i| uv[f][i])),
            material: face.material,
        }
    })
}

/// Where the ray meets the triangle before `limit`: distance and barycentric weights.
///
/// Each edge is asked, in `f64` and from its two corners alone, on which side the ray passes; the answers of the
/// two triangles at an edge are exact opposites, so no ray falls between them. [seed §4.1, the mixed product]
pub(crate) fn intersect(corners: &[Vec3; 3], ray: &Ray, limit: f64) -> Option<(f64, Vec3)> {
    let place = |p: Vec3| p.as_dvec3() - ray.origin;
    let (a, b, c) = (place(corners[0]), place(corners[1]), place(corners[2]));
    let d = ray.direction;
    let (u, v, w) = (d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b)));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let sum = u + v + w;
    if sum == 0.0 {
        return None; // seen edge-on, or without area
    }
    // The point in the plane, from the weights of the corners' own distances along the ray.
    let t = (u * a.dot(d) + v * b.dot(d) + w * c.dot(d)) / sum;
    (t > 0.0 && t < limit).then(|| (t, (DVec3::new(u, v, w) / sum).as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_geom::Face;

    #[test]
    fn hit_distance_and_weights() {
        // The ray down at (0.25, 0.25) meets the unit triangle in the plane y = 0 after 2, at weights ½, ¼, ¼.
        let corners = [Vec3::ZERO, Vec3::Z, Vec3::X];
        let ray = Ray { origin: DVec3::new(0.25, 2.0, 0.25), direction: -DVec3::Y };
        let (t, weights) = intersect(&corners, &ray, 10.0).expect("a hit");
        assert!((t - 2.0).abs() < 1e-12);
        assert!((weights - Vec3::new(0.5, 0.25, 0.25)).length() < 1e-6);
        assert!(intersect(&corners, &ray, 1.9).is_none());
        assert!(intersect(&corners, &Ray { direction: DVec3::Y, ..ray }, 10.0).is_none());
        assert!(intersect(&corners, &Ray { direction: DVec3::X, ..ray }, 10.0).is_none());
    }

    #[test]
    fn smooth_faces_are_lifted_to_their_curve() {
        // An eighth of the unit sphere as one triangle. Its middle m = (1,1,1)/3 lies 1 − 1/3 below each corner's
        // plane; a third of that along each axis lifts it to (1,1,1)·(1/3 + 2/9) = (1,1,1)·5/9.
        let corners = [Vec3::X, Vec3::Y, Vec3::Z];
        let triangle = Triangle { corners, normals: corners, uvs: [Vec2::ZERO; 3], material: MaterialId(0) };
        let hit = triangle.hit(DVec3::splat(1.0 / 3.0), 1.0, Vec3::splat(1.0 / 3.0));
        assert!((hit.lifted[0] - DVec3::splat(5.0 / 9.0)).length() < 1e-6, "{}", hit.lifted[0]);
        // Seen from inside, the curve lies beyond the face already; and a flat face is its own curve.
        assert!((hit.lifted[1] - hit.point).length() < 1e-6);
        let flat = Triangle { normals: [Vec3::ONE.normalize(); 3], ..triangle };
        let hit = flat.hit(DVec3::splat(1.0 / 3.0), 1.0, Vec3::splat(1.0 / 3.0));
        assert!((hit.lifted[0] - hit.point).length() < 1e-6);
    }

    #[test]
    fn no_ray_falls_through_a_bumpy_sheet() {
        // A closed 32 × 32 height field; rays aimed exactly at its vertices and edges must hit something.
        let n = 32_u32;
        let height = |i: u32, j: u32| 0.3 * ((i * 7 + j * 13) % 5) as f32;
        let positions =
            (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(i as f32, height(i, j), j as f32))).collect();
        let quad = |i: u32, j: u32| {
            let v = |i: u32, j: u32| j * (n + 1) + i;
            Face::quad([v(i, j), v(i, j + 1), v(i + 1, j + 1), v(i + 1, j)], MaterialId(0))
        };
        let faces = (0..n * n).map(|k| quad(k % n, k / n)).collect();
        let mesh = Mesh { name: "sheet".into(), positions, faces, ..Mesh::default() };
        let surfaces = Surfaces::new(vec![mesh.clone()]);
        let mut hits = 0;
        for k in 0..20_000_u32 {
            let (i, j) = (1 + k % (n - 1), 1 + (k / 31) % (n - 1));
            let along = f64::from(k % 97) / 97.0;
            let a = mesh.positions[(j * (n + 1) + i) as usize].as_dvec3();
            let b = mesh.positions[(j * (n + 1) + i + 1 - 2 * (k % 2)) as usize].as_dvec3();
            let origin = DVec3::new(f64::from(k % 41) * 0.7, 50.0, f64::from(k % 29));
            let direction = (a + along * (b - a) - origin).normalize();
            hits += u32::from(surfaces.closest(&Ray { origin, direction }, f64::INFINITY).is_some());
        }
        assert_eq!(hits, 20_000);
    }
}
