//! What must hold whatever the content: solid is opaque, empty is empty, white in white is white, and bending the
//! boxes covers what bending the content would.

use pelage::geom::glam::{Vec2, Vec3};
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::texel::{Geometry, Leaves, Procedure};
use pelage::tracer::{Camera, Lod, Rays, Settings};
use pelage_tests::stage::{self, Content, Shot};
use pelage_tests::{blades, mean_alpha, picture, scene, sheet, texel, twisted_box};

/// A flat skin of 12 × 12 boxes, seen from above at 45°, at `distance`.
fn view(distance: f32) -> Camera {
    Camera::look_at(Vec3::new(0.3, 1.0, 1.0).normalize() * distance, Vec3::ZERO, Vec3::Y, 0.35)
}

fn flat(geometry: &Geometry) -> pelage::tracer::Scene {
    let mesh = surface::plane(6.0, 12, 12);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    scene(vec![(skin, texel(geometry, 5, true))], vec![])
}

#[test]
fn a_solid_sheet_is_opaque_at_every_level() {
    let scene = flat(&sheet(0.5, 0.0, Vec3::ONE));
    for level in 0..=5 {
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
fn an_empty_voxel_shows_nothing() {
    // A square over half of the texel: at every level that divides it, what is above the other half is empty.
    let mut geometry = Geometry::default();
    let at = |s: f32, t: f32| Vec3::new(s, t, 0.55);
    geometry.push_quad([at(0.0, 0.0), at(0.5, 0.0), at(0.5, 1.0), at(0.0, 1.0)], Vec3::ONE);
    // The unit cube, s along X; the picture shows `[0, 1]²` of it at the height of the square.
    let scene = scene(vec![(twisted_box(0.0, Vec2::ZERO), texel(&geometry, 5, false))], vec![]);
    let eye = Vec3::new(0.5, 10.55, -0.5);
    let camera = Camera::look_at(eye, eye - Vec3::Y, Vec3::NEG_Z, 2.0 * 0.05_f32.atan());
    for level in 1..=5 {
        let settings = Settings { size: [32, 32], lod: Lod::Level(level), ..Settings::default() };
        let film = picture(&scene, &camera, &settings);
        for (i, p) in film.pixels.iter().enumerate() {
            // A ray leans by ½ in 10 at most: half a pixel on the way from the square to the top or the bottom.
            match i % 32 {
                0..15 => assert!(p.alpha > 0.95, "level {level}, pixel {i}: {p:?}"),
                17.. => assert!(p.alpha == 0.0 && p.color == Vec3::ZERO, "level {level}, pixel {i}: {p:?}"),
                _ => {}
            }
        }
    }
}

#[test]
fn white_in_white_surroundings_is_white() {
    // Albedo 1 and radiance 1 from everywhere, nothing hidden from it: every visible thing sends radiance 1.
    for geometry in [Content::Leaves, Content::Grass].map(Content::geometry) {
        let scene = flat(&geometry);
        for distance in [3.0, 12.0, 80.0] {
            let settings = Settings { size: [48, 48], shadows: false, ..Settings::default() };
            let film = picture(&scene, &view(distance), &settings);
            for (i, p) in film.pixels.iter().enumerate() {
                let white = Vec3::splat(p.alpha);
                assert!(
                    (p.color - white).abs().max_element() < 0.01,
                    "distance {distance}, pixel {i}: {p:?}"
                );
            }
            assert!(film.pixels.iter().any(|p| p.alpha > 0.3));
        }
    }
}

#[test]
fn a_deformed_box_covers_what_its_deformed_content_covers() {
    let leaves = Leaves { count: 60, tilt: 1.0, ..Leaves::green() }.geometry();
    // Height over width, and what the top is pushed aside by, over the height.
    let deformed = [("squashed", 0.4, 0.0), ("stretched", 2.5, 0.0), ("sheared", 1.0, 1.0)];
    let mut faults = Vec::new();
    for (content, geometry) in [("leaves", leaves), ("blades", blades(40, 5))] {
        let texel = texel(&geometry, 5, true);
        for (deformation, height, shear) in deformed {
            let mesh = surface::plane(24.0, 24, 24);
            let options = SkinOptions { lean: Vec3::X * shear, ..SkinOptions::per_patch(height) };
            let skin = extrude(&mesh, &|_| true, &options).expect("a plane extrudes");
            let scene = stage::coat(skin, texel.clone());
            for (elevation, width) in [(30.0, 24.0), (55.0, 24.0), (80.0, 24.0), (55.0, 6.0)] {
                let shot = Shot::new(elevation, width, 48);
                let truth = shot.truth(&scene, &[scene.lighting()], 32, false);
                let settings = Settings { rays: Rays::Sixteen, ..Settings::default() };
                let [shown, covered] = [&shot.cone(&scene, &settings), &truth[0]].map(mean_alpha);
                let bias = shown - covered;
                let line = format!(
                    "{content}, {deformation}, from {elevation}°, box {width} px: {covered:.3} covered, {bias:+.4}"
                );
                println!("{line}");
                // The goal is .01 of the picture. Coarse levels miss it by a little: .013 where boxes are sheared.
                if bias.abs() > if width > 10.0 { 0.01 } else { 0.015 } {
                    faults.push(line);
                }
            }
        }
    }
    assert!(faults.is_empty(), "out of tolerance:\n{}", faults.join("\n"));
}

#[test]
fn no_light_comes_through_the_ground() {
    // A sun from below an opaque plane on which the coat stands: everything above it is black.
    use pelage::tracer::{Coat, Description, Environment, Light, Scene};
    let mesh = surface::plane(6.0, 12, 12);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    let coat =
        Coat { skin, texels: texel(&blades(80, 5), 5, true).into(), tint: Vec3::ONE, wears_material: false };
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
