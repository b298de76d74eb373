//! Copies that differ, against the geometry that they stand for.

use std::ops::ControlFlow;
use std::sync::Arc;

use pelage::geom::glam::Vec3;
use pelage::skin::{Skin, SkinOptions, extrude, surface};
use pelage::texel::{Geometry, Texel};
use pelage::tracer::reference::{self, Expansion, Fineness, ReferenceSettings};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Lod, Scene, Settings, Variety};
use pelage_tests::{blades, mean_alpha, picture, random, texel};

/// Tilted squares, one colour: quite unlike blades.
fn squares(seed: u64) -> Geometry {
    let mut random = random(seed);
    let mut geometry = blades(0, 0);
    for _ in 0..25 {
        let middle = Vec3::new(0.1 + 0.8 * random(), 0.1 + 0.8 * random(), 0.2 + 0.7 * random());
        let along = 0.08 * Vec3::new(random() - 0.5, random() - 0.5, 0.3 * random()).normalize();
        let across = 0.08 * along.cross(Vec3::Z).normalize();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        geometry.push_quad(corners.map(|[a, b]| middle + a * along + b * across), Vec3::new(0.9, 0.25, 0.1));
    }
    geometry.specular = 0.04;
    geometry
}

/// Rolling land of 3 × 3 quads, a copy and a half on each: copies straddle the edges.
fn land() -> Skin {
    let mut mesh = surface::plane(3.0, 3, 3);
    for p in &mut mesh.positions {
        p.y = 0.35 * (1.3 * p.x + 0.6 * p.z).sin();
    }
    let lean = Vec3::new(0.5, 0.0, 0.2);
    let options = SkinOptions { lean, tiling: Some(4.5), ..SkinOptions::new(0.6) };
    extrude(&mesh, &|_| true, &options).expect("gentle hills extrude")
}

fn scene(texels: Variety) -> Scene {
    let sun = Light::Directional {
        direction: Vec3::new(-0.7, -1.0, -0.4),
        illuminance: Vec3::splat(3.0),
        angle: 0.0,
    };
    Scene::new(Description {
        meshes: vec![],
        coats: vec![Coat { skin: land(), texels, tint: Vec3::ONE, wears_material: false }],
        materials: vec![],
        textures: vec![],
        lights: vec![sun],
        environment: Environment::uniform(Vec3::splat(0.3)),
    })
    .expect("a sound scene")
}

fn varied() -> Variety {
    Variety {
        texels: vec![(texel(&blades(45, 9), 3, true), 2.0), (texel(&squares(4), 2, true), 1.0)],
        turns: true,
        mirrors: true,
        height: 0.4,
        color: 0.4,
        seed: 1,
    }
}

const SIZE: [u32; 2] = [48, 36];

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.4, 3.2, 3.6), Vec3::new(0.0, 0.2, 0.0), Vec3::Y, 0.75)
}

fn by_reference(scene: &Scene, samples: u32) -> Film {
    let settings = ReferenceSettings { size: SIZE, samples, ..ReferenceSettings::default() };
    reference::render(scene, &camera(), &settings, &|_| ControlFlow::Continue(())).expect("a source")
}

/// Root mean square difference of colour between the means of 4 × 4 pixels, which samples make little noise in.
fn rmse(a: &Film, b: &Film) -> f32 {
    let blocks = |film: &Film| -> Vec<Vec3> {
        let block = |i: u32| {
            let [x, y] = [4 * (i % 12), 4 * (i / 12)];
            (0..16).map(|k| film.get(x + k % 4, y + k / 4).expect("a pixel").color).sum::<Vec3>() / 16.0
        };
        (0..12 * 9).map(block).collect()
    };
    let (a, b) = (blocks(a), blocks(b));
    (a.iter().zip(&b).map(|(a, b)| a.distance_squared(*b)).sum::<f32>() / (3 * a.len()) as f32).sqrt()
}

fn mean_color(film: &Film) -> Vec3 {
    film.pixels.iter().map(|p| p.color).sum::<Vec3>() / film.pixels.len() as f32
}

#[test]
fn varied_copies_look_like_their_geometry() {
    let varied = varied();
    let varied_scene = scene(varied.clone());
    let film = picture(&varied_scene, &camera(), &Settings { size: SIZE, ..Settings::default() });
    let judge = by_reference(&varied_scene, 96);
    let (alpha, expected) = (mean_alpha(&film), mean_alpha(&judge));
    let energy = mean_color(&film) / mean_color(&judge);
    // Another choice is another picture: what is compared is not only what all of them have in common.
    let other = rmse(&by_reference(&scene(Variety { seed: 2, ..varied }), 24), &judge);
    let (error, noise) = (rmse(&film, &judge), rmse(&by_reference(&varied_scene, 24), &judge));
    println!(
        "alpha {alpha:.4} of {expected:.4}, energy {energy:.3}, RMSE {error:.4}, noise {noise:.4}, other {other:.4}"
    );
    assert!((alpha / expected - 1.0).abs() < 0.02);
    assert!((energy - 1.0).abs().max_element() < 0.05, "{energy}");
    assert!(error < 0.3 * other, "{error} of {other}");
}

#[test]
fn copies_that_are_all_alike_look_as_one_texel_does() {
    // Twice the same texel: each copy is gone through on its own, and shows what it shows as a part of the whole.
    let one = texel(&blades(45, 9), 3, true);
    let twice = Variety { texels: vec![(one.clone(), 1.0), (one.clone(), 1.0)], ..one.clone().into() };
    assert!(twice.plain().is_none());
    // At one level: otherwise each part of a chord reads that of its own middle, and not that of the whole chord.
    let settings = Settings { size: SIZE, lod: Lod::Level(3), ..Settings::default() };
    let [plain, split] = [one.into(), twice].map(|texels| picture(&scene(texels), &camera(), &settings));
    let worst =
        plain.pixels.iter().zip(&split.pixels).map(|(a, b)| (a.alpha - b.alpha).abs()).fold(0.0, f32::max);
    let error = rmse(&plain, &split);
    println!("alpha off by {worst:.2e} at most, RMSE {error:.2e}");
    // Rounding of the parts' ends, in cells of which there are 8 a copy.
    assert!(worst < 1e-4 && error < 1e-4);
    assert!(mean_alpha(&plain) > 0.1);
}

#[test]
fn weights_and_settings_without_choice_change_nothing() {
    let one = texel(&blades(45, 9), 2, true);
    let settings = Settings { size: [24, 18], ..Settings::default() };
    let plain = picture(&scene(one.clone().into()), &camera(), &settings);
    let weighed = Variety { texels: vec![(one.clone(), 7.5)], seed: 9, ..one.into() };
    assert!(picture(&scene(weighed), &camera(), &settings).pixels == plain.pixels);
}

#[test]
fn an_expansion_has_every_texel() {
    // Every copy of a level, unvaried skin of one copy a box holds one of the two texels, whole.
    let unbaked = |name: &str, geometry| Arc::new(Texel::unbaked(name, geometry).expect("a source"));
    let texels = vec![(unbaked("blades", blades(45, 9)), 2.0), (unbaked("squares", squares(4)), 1.0)];
    let two = Variety { texels, turns: true, mirrors: true, height: 0.4, color: 0.5, seed: 1 };
    let mesh = surface::plane(5.0, 5, 5);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(1.0)).expect("a plane extrudes");
    let scene = Scene::new(Description {
        meshes: vec![],
        coats: vec![Coat { skin, texels: two, tint: Vec3::ONE, wears_material: false }],
        materials: vec![],
        textures: vec![],
        lights: vec![],
        environment: Environment::BLACK,
    })
    .expect("a sound scene");
    let expansion = Expansion::new(&scene, Fineness::Length(1.0)).expect("a source");
    let [upright, scattered, surfaces] = expansion.parts() else { panic!("{:?}", expansion.parts()) };
    assert_eq!([&*upright.name, &*scattered.name, &*surfaces.name], ["blades", "squares", "surfaces"]);
    assert_eq!(surfaces.triangles, 0);
    // 45 blades of 8 triangles, and 25 squares of 2; no content crosses the borders of a copy but some squares do.
    let grown = upright.triangles / (45 * 8);
    assert_eq!(upright.triangles, grown * 45 * 8);
    assert!(grown > 8 && grown < 25 && scattered.triangles >= (25 - grown) * 50, "{grown} of 25");
    let mut tones = Vec::new();
    let visited: Result<(), std::convert::Infallible> = expansion.visit(1, |triangle| {
        tones.push(triangle.colors[0].y);
        Ok(())
    });
    assert!(visited.is_ok() && tones.len() as u64 == scattered.triangles);
    let [lo, hi] = [f32::min, f32::max].map(|f| tones.iter().copied().reduce(f).expect("a tone"));
    // 0.25 · (1 ± ½).
    assert!(lo >= 0.125 && hi <= 0.375 && hi - lo > 0.05, "{lo} to {hi}");
}
