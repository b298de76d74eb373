//! What must hold whatever the content: solid is opaque, empty is empty, white in white is white.

use pelage::geom::glam::Vec3;
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::texel::Geometry;
use pelage::tracer::{Camera, Lod, Settings};
use pelage_tests::{blades, picture, scene, sheet, texel};

/// A flat skin of 12 × 12 boxes, seen from above at 45°, at `distance`.
fn view(distance: f32) -> Camera {
    Camera::look_at(Vec3::new(0.3, 1.0, 1.0).normalize() * distance, Vec3::ZERO, Vec3::Y, 0.35)
}

fn flat(geometry: &Geometry) -> pelage::tracer::Scene {
    let mesh = surface::plane(6.0, 12, 12);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    scene(vec![(skin, texel(geometry, 6, true))], vec![])
}

#[test]
fn a_solid_sheet_is_opaque_at_every_level() {
    // Coverage is fitted with a floor of .05 ray, so that a solid voxel lets at most some thousandths through.
    let scene = flat(&sheet(0.5, 0.0, Vec3::ONE));
    for level in 0..=6 {
        let settings = Settings { size: [48, 48], lod: Lod::Level(level), ..Settings::default() };
        let film = picture(&scene, &view(4.0), &settings);
        let thinnest = film.pixels.iter().map(|p| p.alpha).fold(1.0, f32::min);
        println!("level {level}: smallest alpha {thinnest:.4}");
        assert!(thinnest > 0.985, "level {level}: alpha {thinnest}");
    }
}

#[test]
fn an_empty_texel_shows_nothing() {
    let scene = flat(&Geometry::default());
    let film = picture(&scene, &view(4.0), &Settings { size: [32, 32], ..Settings::default() });
    assert!(film.pixels.iter().all(|p| p.alpha == 0.0 && p.color == Vec3::ZERO && p.depth == f32::INFINITY));
}

#[test]
fn white_in_white_surroundings_is_white() {
    // Albedo 1 and radiance 1 from everywhere, nothing hidden from it: every visible thing sends radiance 1.
    let mut geometry = blades(80, 5);
    geometry.colors.fill(Vec3::ONE);
    let scene = flat(&geometry);
    for distance in [3.0, 12.0, 80.0] {
        let settings = Settings { size: [48, 48], shadows: false, ..Settings::default() };
        let film = picture(&scene, &view(distance), &settings);
        for (i, p) in film.pixels.iter().enumerate() {
            let white = Vec3::splat(p.alpha);
            assert!((p.color - white).abs().max_element() < 0.01, "distance {distance}, pixel {i}: {p:?}");
        }
        assert!(film.pixels.iter().any(|p| p.alpha > 0.3));
    }
}

#[test]
fn no_light_comes_through_the_ground() {
    // A sun from below an opaque plane on which the coat stands: everything above it is black.
    use pelage::tracer::{Coat, Description, Environment, Light, Scene};
    let mesh = surface::plane(6.0, 12, 12);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    let coat = Coat { skin, texel: texel(&blades(80, 5), 5, true), tint: Vec3::ONE, wears_material: false };
    let light = Light::Directional {
        direction: Vec3::new(0.3, 1.0, 0.2),
        illuminance: Vec3::splat(3.0),
        angle: 0.01,
    };
    let scene = Scene::new(Description {
        meshes: vec![mesh],
        coats: vec![coat],
        materials: vec![],
        textures: vec![],
        lights: vec![light],
        environment: Environment::BLACK,
    })
    .expect("a sound scene");
    for lod in [Lod::default(), Lod::Level(0), Lod::Level(4)] {
        let film = picture(&scene, &view(4.0), &Settings { size: [48, 48], lod, ..Settings::default() });
        let brightest = film.pixels.iter().map(|p| p.color.max_element()).fold(0.0, f32::max);
        println!("{lod:?}: brightest {brightest}");
        assert!(brightest < 1e-6, "{lod:?}: {brightest}");
    }
}
