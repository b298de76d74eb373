//! Shading normals for meshes that stand for smooth surfaces.

use glam::Vec3;
use pelage_geom::Mesh;

/// Gives a mesh the normals of its vertices, the mean of its faces' by area; a face that is turned from that mean by
/// more than `crease_angle` degrees has its own.
pub fn smooth_normals(mesh: &mut Mesh, crease_angle: f32) {
    let areas: Vec<Vec3> = (0..mesh.faces.len()).map(|f| mesh.area_vector(f)).collect();
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for (face, area) in mesh.faces.iter().zip(&areas) {
        for &v in face.corners() {
            sums[v as usize] += *area;
        }
    }
    let cosine = crease_angle.to_radians().cos();
    let corners = mesh.faces.iter().zip(&areas).map(|(face, area)| {
        let own = area.normalize_or(Vec3::Y);
        let mut normals = [own; 4];
        for (normal, &v) in normals.iter_mut().zip(face.corners()) {
            let mean = sums[v as usize].normalize_or(own);
            *normal = if mean.dot(own) >= cosine { mean } else { own };
        }
        normals
    });
    mesh.normals = Some(corners.collect());
}
