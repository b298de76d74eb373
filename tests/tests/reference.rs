//! The reference renderer against closed forms, and against the same triangles as an opaque mesh.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};
use std::ops::ControlFlow;
use std::sync::Arc;

use pelage::expand::{check_model, write_model};
use pelage::geom::glam::{Vec2, Vec3};
use pelage::geom::{Face, Material, MaterialId, Mesh};
use pelage::import::{ImportOptions, import};
use pelage::skin::{Lattice, Patch, Skin, SkinOptions, extrude, surface};
use pelage::texel::{Geometry, Texel};
use pelage::tracer::reference::{self, Expansion, Fineness, Lighting, ReferenceError, ReferenceSettings};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Pixel, Rect, Scene, Settings};
use pelage_tests::{alpha_rmse, blades, expand, mean_alpha, one_box, scene, sheet, texel, twisted_box};

/// The unit cube, s along X, t along −Z, w upwards.
fn cube() -> Skin {
    twisted_box(0.0, Vec2::ZERO)
}

/// Looks down on the unit cube from `height`, X to the right; at the height of `y` the picture shows `[0,1]²`, rows
/// along t downwards from 1.
fn from_above(height: f32, y: f32) -> Camera {
    let fov = 2.0 * (0.5 / (height - y)).atan();
    let eye = Vec3::new(0.5, height, -0.5);
    Camera::look_at(eye, eye - Vec3::Y, Vec3::NEG_Z, fov)
}

fn settings(side: u32, samples: u32) -> ReferenceSettings {
    ReferenceSettings { size: [side, side], samples, ..ReferenceSettings::default() }
}

fn picture(scene: &Scene, camera: &Camera, settings: &ReferenceSettings) -> Film {
    reference::render(scene, camera, settings, &|_| ControlFlow::Continue(())).expect("a sound scene")
}

fn lit(skin: Skin, texel: Arc<Texel>, meshes: Vec<Mesh>, light: Light) -> Scene {
    let mut scene = scene(vec![(skin, texel)], meshes);
    scene
        .set_lighting(Lighting { lights: vec![light], environment: Environment::BLACK })
        .expect("a sound light");
    scene
}

fn sun(direction: Vec3) -> Light {
    Light::Directional { direction, illuminance: Vec3::splat(2.0), angle: 0.0 }
}

/// A level square of the texel, from (s0, t0) to (s1, t1) at height w.
fn level([s0, s1]: [f32; 2], [t0, t1]: [f32; 2], w: f32) -> Geometry {
    let mut geometry = Geometry::default();
    let at = |s, t| Vec3::new(s, t, w);
    geometry.push_quad([at(s0, t0), at(s1, t0), at(s1, t1), at(s0, t1)], Vec3::ONE);
    geometry
}

fn joined(parts: &[Geometry]) -> Geometry {
    let mut whole = Geometry::default();
    for part in parts {
        for (&triangle, &color) in part.triangles.iter().zip(&part.colors) {
            whole.push(triangle, color);
        }
    }
    whole
}

#[test]
fn what_is_painted_on_a_skin_colours_its_content() {
    // A white sheet seen from above, lit from there: E/π times the colour between the corners, bilinear in the picture.
    let painted = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
    let skin = Skin { colors: Some(painted.to_vec()), ..cube() };
    let scene = lit(skin, texel(&sheet(0.5, 0.0, Vec3::ONE), 5, true), vec![], sun(Vec3::NEG_Y));
    let camera = from_above(50.0, 0.5);
    let cones = pelage_tests::picture(&scene, &camera, &Settings { size: [8, 8], ..Settings::default() });
    let judge = picture(&scene, &camera, &settings(8, 16));
    let [a, b, c, d] = painted;
    for i in 0..64 {
        let [u, v] = [(i % 8) as f32 + 0.5, 7.5 - (i / 8) as f32].map(|x| x / 8.0);
        let expected = a.lerp(b, u).lerp(c.lerp(d, u), v) * 2.0 * FRAC_1_PI;
        for film in [&cones, &judge] {
            let found = film.pixels[i].color;
            // Cones take it at the middle of what they see of a voxel, the judge at 16 places: within a quarter pixel.
            assert!(found.abs_diff_eq(expected, 2.0 * FRAC_1_PI / 32.0), "{i}: {found} for {expected}");
        }
    }
}

#[test]
fn a_matt_sheet_under_a_sun() {
    // Radiance of a Lambertian of albedo ρ that a sun of E lux meets at angle θ: ρ/π · E cos θ.
    let color = Vec3::new(0.5, 0.25, 1.0);
    let direction = Vec3::new(0.6, -0.8, 0.0);
    let scene = lit(cube(), texel(&sheet(0.5, 0.0, color), 3, true), vec![], sun(direction));
    let film = picture(&scene, &from_above(5.0, 0.5), &settings(8, 4));
    let expected = color * FRAC_1_PI * 2.0 * 0.8;
    for pixel in &film.pixels {
        assert!((pixel.color - expected).abs().max_element() < 1e-5, "{pixel:?} for {expected}");
        assert_eq!(pixel.alpha, 1.0);
        assert!((pixel.depth - 4.5).abs() < 1e-4);
    }
}

#[test]
fn a_round_light_is_its_mean() {
    // A disk of angular radius a, centred above a level sheet: the mean of cos over the tangent disk of radius
    // tan a is ∫ 2x/(tan² a) / sqrt(1 + x²) dx = 2 (sqrt(1 + tan² a) − 1) / tan² a.
    let angle = 1.2_f32;
    let light = Light::Directional { direction: Vec3::NEG_Y, illuminance: Vec3::splat(2.0), angle };
    let scene = lit(cube(), texel(&sheet(0.5, 0.0, Vec3::ONE), 3, true), vec![], light);
    let film = picture(&scene, &from_above(5.0, 0.5), &settings(4, 1024));
    let tan = (0.5 * angle).tan();
    let expected = 2.0 * FRAC_1_PI * 2.0 * ((1.0 + tan * tan).sqrt() - 1.0) / (tan * tan);
    let mean = film.pixels.iter().map(|p| p.color.x).sum::<f32>() / 16.0;
    println!("{mean} for {expected}");
    assert!((mean / expected - 1.0).abs() < 1e-3);
}

#[test]
fn shadows_end_where_they_must() {
    // A roof over s < ½, ½ above a floor, under a sun that goes ½ sideways for 1 down: its shadow moves by ¼, so of
    // the floor that is seen from above, s in [½, 1], the first half is dark. Roof and floor are content or a mesh.
    let (roof, floor) = (level([0.0, 0.5], [0.0, 1.0], 0.6), level([0.0, 1.0], [0.0, 1.0], 0.1));
    let light = sun(Vec3::new(0.5, -1.0, 0.0));
    let mesh = |geometry: &Geometry| vec![expand(geometry, &cube(), 1)];
    let content = |geometry: &Geometry| texel(geometry, 3, false);
    let cases = [
        ("content on content", lit(cube(), content(&joined(&[roof.clone(), floor.clone()])), vec![], light)),
        ("mesh on content", lit(cube(), content(&floor), mesh(&roof), light)),
        ("content on mesh", lit(cube(), content(&roof), mesh(&floor), light)),
    ];
    for (name, scene) in cases {
        // 16 pixels to the width of the floor; its right half in two quarters, from far away.
        let film = picture(&scene, &from_above(500.0, 0.1), &settings(16, 16));
        let column = |x: u32| (0..16).map(|y| film.get(x, y).expect("inside").color.x).sum::<f32>() / 16.0;
        let bright = 2.0 * FRAC_1_PI * 1.25_f32.sqrt().recip();
        for x in 9..12 {
            assert_eq!(column(x), 0.0, "{name}: column {x}");
        }
        for x in 12..16 {
            assert!(
                (column(x) - bright).abs() < 1e-3 * bright,
                "{name}: column {x}: {} for {bright}",
                column(x)
            );
        }
    }
}

#[test]
fn two_prisms_are_a_quad() {
    let geometry = blades(60, 3);
    let mut prisms = cube();
    let [a, b, c, d] = [0, 1, 2, 3];
    let half = |vertices: [u32; 3], lattice| Patch {
        vertices: [vertices[0], vertices[1], vertices[2], Face::NONE],
        lattice,
        ..prisms.patches[0]
    };
    let far = Lattice { origin: Vec2::ONE, u: Vec2::NEG_X, v: Vec2::NEG_Y };
    prisms.patches = vec![half([a, b, c], Lattice::UNIT), half([d, c, b], far)];
    let texel = texel(&geometry, 3, true);
    let camera = Camera::look_at(Vec3::new(2.0, 1.5, 1.5), Vec3::new(0.5, 0.4, -0.5), Vec3::Y, 0.6);
    let whole = picture(&scene(vec![(cube(), texel.clone())], vec![]), &camera, &settings(64, 16));
    let halves = picture(&scene(vec![(prisms, texel)], vec![]), &camera, &settings(64, 16));
    let rmse = alpha_rmse(&whole, &halves);
    println!("alpha {:.4} and {:.4}, RMSE {rmse:.6}", mean_alpha(&whole), mean_alpha(&halves));
    // The same samples hit the same triangles, but for those within rounding of an edge.
    assert!(mean_alpha(&whole) > 0.1 && rmse < 2e-3);
}

#[test]
fn a_shifted_lattice_is_shifted_content() {
    // Periodic content moved by (−.3, −.45) on one whole copy, or the content as it is and the lattice moved by
    // (.3, .45): what leaves the tile on one side comes in on the other.
    let geometry = blades(60, 8);
    let offset = Vec2::new(0.3, 0.45);
    let mut moved = geometry.clone();
    moved.triangles.iter_mut().flatten().for_each(|p| *p -= offset.extend(0.0));
    let mut shifted = cube();
    shifted.patches[0].lattice.origin = offset;
    let camera = Camera::look_at(Vec3::new(2.0, 1.5, 1.5), Vec3::new(0.5, 0.4, -0.5), Vec3::Y, 0.6);
    let a = picture(&scene(vec![(cube(), texel(&moved, 3, true))], vec![]), &camera, &settings(64, 16));
    let b = picture(&scene(vec![(shifted, texel(&geometry, 3, true))], vec![]), &camera, &settings(64, 16));
    println!("alpha {:.4} and {:.4}, RMSE {:.6}", mean_alpha(&a), mean_alpha(&b), alpha_rmse(&a, &b));
    assert!(mean_alpha(&a) > 0.1 && alpha_rmse(&a, &b) < 2e-3);
}

#[test]
fn a_bent_box_shows_what_a_mesh_of_its_triangles_does() {
    // An independent path: the same blades cut 24² times and carried into a twisted, leaning box beforehand, as an
    // opaque mesh. The same samples see the same, but for the silhouettes' 1/20 pixel.
    let mut geometry = blades(40, 5);
    geometry.colors.fill(Vec3::ONE);
    let skin = twisted_box(0.9, Vec2::new(0.5, 0.2));
    let camera = Camera::look_at(Vec3::new(2.4, 1.6, 1.7), Vec3::new(0.7, 0.45, -0.4), Vec3::Y, 0.6);
    let light = Lighting {
        lights: vec![sun(Vec3::new(-0.5, -0.8, -0.6))],
        environment: Environment::uniform(Vec3::splat(0.4)),
    };
    let mesh = expand(&geometry, &skin, 24);
    let mut filled = scene(vec![(skin, texel(&geometry, 3, false))], vec![]);
    let mut explicit = scene(vec![], vec![mesh]);
    let films = [&mut filled, &mut explicit].map(|scene| {
        scene.set_lighting(light.clone()).expect("a sound light");
        picture(scene, &camera, &settings(96, 64))
    });
    let [a, b] = &films;
    let energy = films.each_ref().map(|film| film.pixels.iter().map(|p| p.color.x).sum::<f32>());
    let rmse = (a
        .pixels
        .iter()
        .zip(&b.pixels)
        .map(|(a, b)| (a.color - b.color).length_squared() / 3.0)
        .sum::<f32>()
        / a.pixels.len() as f32)
        .sqrt();
    println!("alpha {:.5} and {:.5}, RMSE {:.5}", mean_alpha(a), mean_alpha(b), alpha_rmse(a, b));
    println!("energy {:.3} and {:.3}, RMSE {rmse:.5}", energy[0], energy[1]);
    assert!(mean_alpha(a) > 0.05);
    assert!((mean_alpha(a) / mean_alpha(b) - 1.0).abs() < 1e-3 && alpha_rmse(a, b) < 5e-3);
    assert!((energy[0] / energy[1] - 1.0).abs() < 3e-3 && rmse < 0.01);
}

#[test]
fn white_in_white_is_white() {
    // Without shadows everything white in a white surrounding sends radiance 1; a sheet alone does with them, too,
    // because nothing stands between it and the upper half of the surroundings.
    let mesh = surface::plane(6.0, 6, 6);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.5)).expect("a plane extrudes");
    let mut white = blades(60, 2);
    white.colors.fill(Vec3::ONE);
    let camera = Camera::look_at(Vec3::new(0.3, 3.0, 3.0), Vec3::ZERO, Vec3::Y, 0.5);
    for (geometry, shadows) in [(white, false), (sheet(0.5, 0.2, Vec3::ONE), true)] {
        // The tilted sheet has a step where its copies meet, which blocks some of the sky: only level it is alone.
        let geometry = if shadows { level([0.0, 1.0], [0.0, 1.0], 0.5) } else { geometry };
        let scene = scene(vec![(skin.clone(), texel(&geometry, 3, true))], vec![]);
        let film = picture(&scene, &camera, &ReferenceSettings { shadows, ..settings(48, 16) });
        for p in &film.pixels {
            assert!((p.color - Vec3::splat(p.alpha)).abs().max_element() < 1e-5, "{p:?}");
        }
        assert!(mean_alpha(&film) > 0.3);
    }
}

#[test]
fn tiles_threads_and_lightings_change_nothing() {
    let mesh = surface::torus(1.0, 0.4, 12, 8);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.2)).expect("a torus extrudes");
    let scene = scene(vec![(skin, texel(&blades(30, 4), 3, true))], vec![mesh]);
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6);
    let settings = ReferenceSettings { size: [50, 40], samples: 4, ..ReferenceSettings::default() };
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let whole = pool(1).install(|| picture(&scene, &camera, &settings));
    assert_eq!(whole, pool(3).install(|| picture(&scene, &camera, &settings)));

    let crop = Rect { x: 13, y: 5, width: 21, height: 19 };
    let part = picture(&scene, &camera, &ReferenceSettings { crop: Some(crop), ..settings });
    for y in 5..24 {
        for x in 13..34 {
            assert_eq!(part.get(x, y), whole.get(x, y));
        }
    }

    // Where nothing is seen, nothing is lit.
    let away = Camera::look_at(Vec3::new(0.0, 0.0, 9.0), Vec3::new(0.0, 0.0, 20.0), Vec3::Y, 0.6);
    assert_eq!(picture(&scene, &away, &settings).pixels, vec![Pixel::EMPTY; 2000]);

    let other = Lighting { lights: vec![sun(Vec3::NEG_Y)], environment: Environment::BLACK };
    let both = [other, scene.lighting()];
    let films = reference::render_under(&scene, &camera, &settings, &both, &|_| ControlFlow::Continue(()));
    assert_eq!(films.expect("pictures")[1], whole);
    let again = picture(&scene, &camera, &ReferenceSettings { seed: 1, ..settings });
    assert!(again != whole && (mean_alpha(&again) - mean_alpha(&whole)).abs() < 0.01);
}

#[test]
fn what_cannot_be_is_named() {
    let camera = from_above(3.0, 0.0);
    let render = |scene: &Scene, settings: &ReferenceSettings| {
        reference::render(scene, &camera, settings, &|_| ControlFlow::Continue(())).expect_err("no picture")
    };
    let known = texel(&blades(30, 4), 3, true);
    let unknown = Arc::new(Texel::clone(&known).without_source());
    let message = render(&scene(vec![(cube(), unknown)], vec![]), &settings(4, 1)).to_string();
    assert!(message.starts_with("coat 0: the texel `test` does not hold the geometry"), "{message}");
    let scene = scene(vec![(cube(), known)], vec![]);
    let small = ReferenceSettings { memory: 1000, ..settings(4, 1) };
    assert!(matches!(render(&scene, &small), ReferenceError::Memory { memory: 1000, .. }));
    for samples in [0, 65_537] {
        assert!(matches!(render(&scene, &settings(4, samples)), ReferenceError::Setting { .. }));
    }
    let stopped = reference::render(&scene, &camera, &settings(40, 1), &|_| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(ReferenceError::Cancelled { .. })));
}

#[test]
fn content_wears_what_the_surface_below_does() {
    // A material of (.5, 1, .25) and a tint of (1, .5, 1) on white content under a white sky.
    let mut skin = one_box(
        [Vec3::ZERO, Vec3::X, Vec3::NEG_Z, Vec3::new(1.0, 0.0, -1.0)],
        [Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, -1.0), Vec3::new(1.0, 1.0, -1.0)],
    );
    skin.patches[0].material = MaterialId(0);
    let coat = Coat {
        skin,
        texels: texel(&sheet(0.5, 0.0, Vec3::ONE), 3, true).into(),
        tint: Vec3::new(1.0, 0.5, 1.0),
        wears_material: true,
    };
    let scene = Scene::new(Description {
        meshes: vec![],
        coats: vec![coat],
        materials: vec![Material { base_color: Vec3::new(0.5, 1.0, 0.25), ..Material::default() }],
        textures: vec![],
        lights: vec![],
        environment: Environment::uniform(Vec3::ONE),
    })
    .expect("a sound scene");
    let camera = Camera { vertical_fov: 0.1 * FRAC_PI_2, ..from_above(4.0, 0.5) };
    let film = picture(&scene, &camera, &settings(2, 4));
    assert!(
        (film.pixels[0].color - Vec3::new(0.5, 0.5, 0.25)).abs().max_element() < 1e-5,
        "{:?}",
        film.pixels[0]
    );
}

#[test]
fn an_expansion_is_what_is_rendered() {
    // Twice the same picture: of the content in its boxes, and of its expansion as an opaque mesh.
    let mesh = surface::torus(1.0, 0.4, 12, 8);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.2)).expect("a torus extrudes");
    let mut geometry = blades(12, 4);
    geometry.colors.fill(Vec3::ONE);
    let filled = scene(vec![(skin, texel(&geometry, 3, true))], vec![]);
    let expansion = Expansion::new(&filled, Fineness::OfHeight(0.002)).expect("a source");
    let mut explicit = Mesh { name: "expanded".into(), ..Mesh::default() };
    let mut count = 0;
    for part in 0..expansion.parts().len() {
        let visited: Result<(), std::convert::Infallible> = expansion.visit(part, |triangle| {
            let first = explicit.positions.len() as u32;
            explicit.positions.extend(triangle.corners);
            explicit.faces.push(Face::triangle([first, first + 1, first + 2], MaterialId(0)));
            for (corner, normal) in triangle.corners.iter().zip(triangle.normals) {
                let [lo, hi] = expansion.parts()[part].bounds;
                assert!(corner.cmpge(lo).all() && corner.cmple(hi).all());
                assert!((normal.length() - 1.0).abs() < 1e-5);
            }
            count += 1;
            Ok(())
        });
        assert!(visited.is_ok());
    }
    assert_eq!(expansion.triangles(), count);
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6);
    let a = picture(&filled, &camera, &settings(64, 16));
    let b = picture(&scene(vec![], vec![explicit]), &camera, &settings(64, 16));
    println!(
        "{count} triangles; alpha {:.5} and {:.5}, RMSE {:.5}",
        mean_alpha(&a),
        mean_alpha(&b),
        alpha_rmse(&a, &b)
    );
    assert!((mean_alpha(&a) / mean_alpha(&b) - 1.0).abs() < 2e-3 && alpha_rmse(&a, &b) < 0.01);
}

#[test]
fn models_are_read_back() {
    let mut geometry = blades(6, 4);
    geometry.colors.fill(Vec3::new(0.2, 0.5, 1.0));
    let mesh = surface::plane(1.0, 2, 1);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.3)).expect("a plane extrudes");
    let scene = scene(vec![(skin, texel(&geometry, 3, true))], vec![mesh]);
    let expansion = Expansion::new(&scene, Fineness::OfHeight(0.01)).expect("a source");
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, limit: u64| {
        let path = folder.path().join(name);
        let format = check_model(&path).expect("a known format");
        let written = write_model(&expansion, &path, format, limit, &|_| ControlFlow::Continue(()));
        written.map(|()| (path, format.size(&expansion)))
    };
    for name in ["a.glb", "a.obj", "a.ply"] {
        let (path, size) = write(name, 1 << 30).expect("a file");
        let real = std::fs::metadata(&path).expect("the file").len();
        println!("{name}: {real} bytes, {size} foretold");
        assert!(real == size || name == "a.obj" && (size / 2..size).contains(&real));
        if name == "a.ply" {
            continue; // no importer of ours reads it
        }
        let read = import(&path, &ImportOptions::default()).expect("our own file");
        let faces: usize = read.meshes.iter().map(|m| m.faces.len()).sum();
        assert_eq!(faces as u64, expansion.triangles(), "{name}");
        let parts = expansion.parts().iter().filter(|part| part.triangles > 0);
        for (mesh, part) in read.meshes.iter().zip(parts) {
            assert_eq!(mesh.bounds(), Some(part.bounds), "{name}: {}", part.name);
        }
    }
    // One byte too few, and nothing is there.
    let (_, size) = write("b.ply", 1 << 30).expect("a file");
    std::fs::remove_file(folder.path().join("b.ply")).expect("it was there");
    let refused = write("b.ply", size - 1).expect_err("too large").to_string();
    assert!(refused.contains("triangles would take") && !folder.path().join("b.ply").exists(), "{refused}");
}
