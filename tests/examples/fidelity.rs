//! Scratch: energy of coats against geometry.
use std::ops::ControlFlow;
use std::sync::Arc;

use pelage::geom::Material;
use pelage::geom::glam::{Vec2, Vec3};
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::texel::{Fur, Geometry, Procedure, Texel};
use pelage::tracer::reference::{self, Lighting, ReferenceSettings};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Lod, Rays, Rect, Scene, Settings};
use pelage_tests::{mean_alpha, picture, random, texel};

fn grass() -> Geometry {
    let mut random = random(3);
    let mut g = Geometry::default();
    for _ in 0..200 {
        let root = Vec3::new(random(), random(), 0.0);
        let across = Vec2::from_angle(6.3 * random()).extend(0.0) * 0.015;
        let lean = Vec2::from_angle(6.3 * random()).extend(0.0) * (0.25 * random());
        let height = 0.5 + 0.45 * random();
        let at = |x: f32| root + lean * x * x + Vec3::Z * height * x;
        for i in 0..4 {
            let (a, b) = (i as f32 / 4.0, (i + 1) as f32 / 4.0);
            let (wa, wb) = (across * (1.0 - 0.8 * a), across * (1.0 - 0.8 * b));
            g.push_quad([at(a) - wa, at(a) + wa, at(b) + wb, at(b) - wb], Vec3::ONE);
        }
    }
    g
}

fn leaves() -> Geometry {
    let mut random = random(5);
    let mut g = Geometry::default();
    for _ in 0..300 {
        let c = Vec3::new(random(), random(), 0.06 + 0.88 * random());
        let z = 2.0 * random() - 1.0;
        let n = (Vec2::from_angle(6.3 * random()) * (1.0 - z * z).sqrt()).extend(z);
        let a = n.any_orthonormal_vector();
        let (s, co) = (6.3 * random()).sin_cos();
        let a = a * co + n.cross(a) * s;
        let b = n.cross(a);
        g.push_quad([c - 0.06 * a, c - 0.03 * b, c + 0.06 * a, c + 0.03 * b], Vec3::ONE);
    }
    g
}

fn content(name: &str) -> Geometry {
    match name {
        "sheet" => pelage_tests::sheet(0.5, 0.3, Vec3::ONE),
        "leaves" => leaves(),
        "grass" => grass(),
        _ => Fur { count: 400, root_radius: 0.009, tip_radius: 0.003, ..Fur::long() }.geometry(),
    }
}

fn mean(film: &Film) -> f32 {
    film.pixels.iter().map(|p| p.color.x).sum::<f32>() / film.pixels.len() as f32
}

fn main() {
    let depth: u32 = std::env::var("DEPTH").ok().and_then(|d| d.parse().ok()).unwrap_or(7);
    let names = std::env::var("NAMES").unwrap_or("sheet,leaves,grass,fur".into());
    let widths: Vec<f32> = std::env::var("WIDTHS").unwrap_or("256,64,22,8,3,1".into()).split(',').map(|w| w.parse().unwrap()).collect();
    for name in names.split(',') {
        let mut geometry = content(name);
        geometry.colors.fill(Vec3::ONE);
        if std::env::var("HEIGHTS").is_ok() {
            geometry.colors = geometry.triangles.iter().map(|t| Vec3::splat((t[0].z + t[1].z + t[2].z) / 3.0).clamp(Vec3::ZERO, Vec3::ONE)).collect();
        }
        geometry.specular = 0.0;
        let start = std::time::Instant::now();
        let texel: Arc<Texel> = texel(&geometry, depth, true);
        println!("{name}: baked in {:.1} s, {} voxels, {:.1} MB", start.elapsed().as_secs_f32(), texel.levels().last().unwrap().len(), texel.levels().iter().map(|l| l.memory()).sum::<usize>() as f32 / 1e6);
        let boxes: u32 = std::env::var("BOXES").ok().and_then(|d| d.parse().ok()).unwrap_or(12);
        let mesh = surface::plane(boxes as f32, boxes, boxes);
        let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(1.0)).unwrap();
        let coat = Coat { skin, texel, tint: Vec3::ONE, wears_material: false };
        let mut scene = Scene::new(Description {
            meshes: vec![],
            coats: vec![coat],
            materials: vec![Material { base_color: Vec3::ONE, ..Material::default() }],
            textures: vec![],
            lights: vec![],
            environment: Environment::BLACK,
        })
        .unwrap();
        for elevation in [25.0_f32, 60.0] {
            let view = |azimuth: f32, elevation: f32| {
                let (s, c) = elevation.to_radians().sin_cos();
                let (sa, ca) = azimuth.to_radians().sin_cos();
                Vec3::new(c * sa, s, c * ca)
            };
            let eye = view(10.0, elevation);
            let lights = [-view(100.0, 40.0), -view(17.0, elevation + 11.0), -view(195.0, 35.0)].map(|direction| Lighting {
                lights: vec![Light::Directional { direction, illuminance: Vec3::splat(3.0), angle: 0.0 }],
                environment: Environment::BLACK,
            });
            let mut lights = lights;
            if std::env::var("AMBIENT").is_ok() {
                lights[0] = Lighting { lights: vec![], environment: Environment::uniform(Vec3::ONE) };
            }
            for &width in &widths {
                let fov = 0.1_f32;
                let size = 1024_u32;
                let distance = size as f32 / width / (2.0 * (fov / 2.0).tan());
                // Off the grid: no pixel's rays all meet the same part of every box.
                let camera = Camera::look_at(eye * distance + Vec3::new(0.013, 0.4, 0.027), Vec3::new(0.013, 0.4, 0.027), Vec3::Y, fov);
                let across = if width > 4.0 { 13.0 * width } else { 0.5 * boxes as f32 * width };
                let side = across.min(if width > 100.0 { 80.0 } else { 56.0 }) as u32 & !1;
                let crop = Rect { x: (size - side) / 2, y: (size - side) / 2, width: side, height: side };
                let shadows = std::env::var("NOSHADOW").is_err();
                let settings = Settings {
                    size: [size, size],
                    crop: Some(crop),
                    lod: std::env::var("LOD").ok().map_or(Lod::default(), |l| Lod::Level(l.parse().unwrap())),
                    shadows,
                    lit_voxels: std::env::var("LIT").ok().map_or(Settings::default().lit_voxels, |l| l.parse().unwrap()),
                    ..Settings::default()
                };
                let truth = reference::render_under(
                    &scene,
                    &camera,
                    &ReferenceSettings { size: [size, size], crop: Some(crop), samples: 32, shadows, ..ReferenceSettings::default() },
                    &lights,
                    &|_| ControlFlow::Continue(()),
                )
                .unwrap();
                let mut line = format!("{name:>6} el {elevation:>2} box {width:>5}:");
                let mut by_side = 1.0;
                for (i, b) in truth.iter().enumerate() {
                    scene.set_lighting(lights[i].clone()).unwrap();
                    let a = picture(&scene, &camera, &settings);
                    if i == 0 {
                        let alpha: f32 = (a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a.alpha - b.alpha).powi(2)).sum::<f32>() / a.pixels.len() as f32).sqrt();
                        line += &format!(" alpha {:.3} of {:.3} rmse {alpha:.3} |", mean_alpha(&a) / mean_alpha(b), mean_alpha(b));
                    }
                    let rmse: f32 = (a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a.color.x - b.color.x).powi(2)).sum::<f32>() / a.pixels.len() as f32).sqrt();
                    let (ma, mb) = (mean(&a), mean(b));
                    if i == 0 { by_side = mb; }
                    line += &format!(" E {:.3} ({:+.3}) rmse {rmse:.3}", ma / mb, (ma - mb) / by_side);
                }
                println!("{line}");
            }
        }
    }
}
