//! The same bytes for any number of threads, whole or cropped.

use pelage::geom::glam::Vec3;
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Rect, Scene, Settings};
use pelage_tests::{blades, picture, texel};

fn torus() -> Scene {
    let mesh = surface::torus(1.0, 0.4, 24, 12);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.15)).expect("a torus extrudes");
    let sun = Light::Directional {
        direction: Vec3::new(-1.0, -2.0, -1.0),
        illuminance: Vec3::splat(3.0),
        angle: 0.01,
    };
    Scene::new(Description {
        meshes: vec![mesh],
        coats: vec![Coat {
            skin,
            texels: texel(&blades(60, 3), 5, true).into(),
            tint: Vec3::ONE,
            wears_material: false,
        }],
        materials: vec![],
        textures: vec![],
        lights: vec![sun],
        environment: Environment::uniform(Vec3::splat(0.2)),
    })
    .expect("a sound scene")
}

fn on_threads(threads: usize, scene: &Scene, settings: &Settings) -> Film {
    let camera = Camera::look_at(Vec3::new(0.5, 2.0, 2.5), Vec3::ZERO, Vec3::Y, 0.8);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| picture(scene, &camera, settings))
}

fn bits(film: &Film) -> Vec<[u32; 5]> {
    let of =
        |p: &pelage::tracer::Pixel| [p.color.x, p.color.y, p.color.z, p.alpha, p.depth].map(f32::to_bits);
    film.pixels.iter().map(of).collect()
}

#[test]
fn threads_and_crops_change_nothing() {
    let scene = torus();
    let settings = Settings { size: [90, 70], ..Settings::default() };
    let whole = on_threads(1, &scene, &settings);
    assert!(whole.pixels.iter().any(|p| p.alpha > 0.9) && whole.pixels.iter().any(|p| p.alpha == 0.0));
    assert!(whole.pixels.iter().all(|p| p.color.is_finite() && p.alpha.is_finite()));
    for threads in [2, 3, 8] {
        assert!(bits(&on_threads(threads, &scene, &settings)) == bits(&whole), "{threads} threads");
    }
    let window = Rect { x: 23, y: 11, width: 41, height: 37 };
    let crop = on_threads(2, &scene, &Settings { crop: Some(window), ..settings });
    for y in 0..window.height {
        for x in 0..window.width {
            let (x, y) = (window.x + x, window.y + y);
            assert_eq!(crop.get(x, y), whole.get(x, y), "pixel {x}, {y}");
        }
    }
    assert_eq!(crop.get(0, 0), None);
}
