//! Light on a coat against light on the geometry that it stands for: one sun with hard shadows, no sky.

use std::sync::Arc;

use pelage::geom::Material;
use pelage::geom::glam::Vec3;
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::texel::{Fur, Geometry, Procedure, Texel};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Rays, Scene, Settings};
use pelage_tests::{blades, expand, mean_alpha, picture, texel};

/// A flat skin of 8 × 8 boxes, as a coat and as triangles, under a sun that shines along `direction`.
fn scenes(geometry: &Geometry, texel: &Arc<Texel>, direction: Vec3) -> [Scene; 2] {
    let mesh = surface::plane(4.0, 8, 8);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    let expanded = expand(geometry, &skin, 1);
    let coat = Coat { skin, texel: texel.clone(), tint: Vec3::ONE, wears_material: false };
    let scene = |coats, meshes| {
        Scene::new(Description {
            meshes,
            coats,
            materials: vec![Material { base_color: Vec3::ONE, ..Material::default() }],
            textures: vec![],
            lights: vec![Light::Directional { direction, illuminance: Vec3::splat(3.0), angle: 0.0 }],
            environment: Environment::BLACK,
        })
        .expect("a sound scene")
    };
    [scene(vec![coat], vec![]), scene(vec![], vec![expanded])]
}

fn mean_radiance(film: &Film) -> f32 {
    film.pixels.iter().map(|p| p.color.x).sum::<f32>() / film.pixels.len() as f32
}

/// Compares at three distances, where boxes are about 80, 30 and 8 pixels wide: alpha within `coverage`, energy within
/// a tolerance for each.
fn compare(name: &str, mut geometry: Geometry, coverage: f32, tolerances: [f32; 3]) {
    geometry.colors.fill(Vec3::ONE);
    geometry.specular = 0.0;
    let texel = texel(&geometry, 6, true);
    let side = Vec3::new(-1.0, -1.0, 0.2);
    let from_the_eye = Vec3::new(-0.2, -1.0, -0.8);
    let behind = Vec3::new(0.1, -0.6, 1.0);
    for (distance, tolerance) in [3.0, 8.0, 30.0].into_iter().zip(tolerances) {
        let camera =
            Camera::look_at(Vec3::new(0.2, 0.8, 1.0).normalize() * distance, Vec3::ZERO, Vec3::Y, 0.25);
        let settings = Settings { size: [64, 64], ..Settings::default() };
        let measure = |light: &str, direction: Vec3| {
            let [coat, expanded] = scenes(&geometry, &texel, direction);
            let cone = picture(&coat, &camera, &settings);
            let truth = picture(&expanded, &camera, &Settings { rays: Rays::Sixteen, ..settings });
            let [seen, true_one] = [&cone, &truth].map(mean_radiance);
            let alpha = mean_alpha(&cone) / mean_alpha(&truth);
            let energy = seen / true_one;
            println!("{name}, distance {distance:>2}, light {light}: energy {energy:.3}, alpha {alpha:.3}");
            assert!((alpha - 1.0).abs() < coverage, "{name}, {light} at {distance}: alpha {alpha}");
            [seen, true_one]
        };
        let [seen, from_the_side] = measure("from the side", side);
        assert!((seen / from_the_side - 1.0).abs() < tolerance);
        let [seen, truth] = measure("near the eye", from_the_eye);
        assert!((seen / truth - 1.0).abs() < tolerance);
        // Next to nothing of the light from behind is seen: it is judged against the light from the side.
        let [seen, truth] = measure("from behind", behind);
        assert!((seen - truth).abs() < tolerance * from_the_side);
    }
}

// The tolerances are what is reached, rounded up; where they are wide, one ellipsoid does not hold the normals of
// what a voxel contains. [fidelity, What falls short]

#[test]
fn blades_are_as_bright_as_their_geometry() {
    compare("blades", blades(60, 11), 0.02, [0.08, 0.08, 0.15]);
}

#[test]
fn fur_is_as_bright_as_its_geometry() {
    let fur = Fur { count: 80, root_radius: 0.016, tip_radius: 0.006, ..Fur::long() };
    compare("fur", fur.geometry(), 0.04, [0.12, 0.25, 0.25]);
}
