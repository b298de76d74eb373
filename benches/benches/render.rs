//! Whole pictures: a furred torus, near and far, along the curved and the straight path, with and without light.

use std::hint::black_box;
use std::ops::ControlFlow;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pelage::geom::glam::Vec3;
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::texel::{BuildOptions, Fur, build};
use pelage::tracer::{Camera, Coat, Description, Environment, Light, Path, Rays, Scene, Settings, render};

fn torus() -> Scene {
    let mesh = surface::torus(1.0, 0.4, 64, 32);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.12)).expect("a torus extrudes");
    let fur = Fur { count: 400, ..Fur::long() };
    let options = BuildOptions { depth: 5, ..BuildOptions::preview() };
    let texel = build("fur", fur, &options, &|_| ()).expect("fur is sound");
    let sun = Light::Directional {
        direction: Vec3::new(-1.0, -2.0, -1.0),
        illuminance: Vec3::splat(3.0),
        angle: 0.01,
    };
    Scene::new(Description {
        meshes: vec![mesh],
        coats: vec![Coat { skin, texels: texel.into(), tint: Vec3::ONE, wears_material: false }],
        materials: vec![],
        textures: vec![],
        lights: vec![sun],
        environment: Environment::uniform(Vec3::splat(0.3)),
    })
    .expect("a sound scene")
}

fn pictures(c: &mut Criterion) {
    let scene = torus();
    let settings = Settings { size: [96, 96], ..Settings::default() };
    let near = Camera::look_at(Vec3::new(0.5, 2.0, 2.5), Vec3::ZERO, Vec3::Y, 0.8);
    let far = Camera { position: 8.0 * near.position, ..near };
    let mut group = c.benchmark_group("render");
    group.sample_size(10).throughput(Throughput::Elements(96 * 96));
    let mut run = |name: &str, camera: Camera, settings: Settings| {
        let draw = || render(&scene, &camera, &settings, &|_| ControlFlow::Continue(()));
        group.bench_function(name, |b| b.iter(|| black_box(draw())));
    };
    run("near", near, settings);
    run("near, straight path", near, Settings { path: Path::Straight, ..settings });
    run("near, one ray", near, Settings { rays: Rays::One, ..settings });
    run("near, no shadows", near, Settings { shadows: false, ..settings });
    run("far", far, settings);
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
