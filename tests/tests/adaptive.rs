//! One cone for a pixel where it says all, and four rays where edges go through it.

use std::ops::ControlFlow;

use pelage::geom::Mesh;
use pelage::geom::glam::Vec3;
use pelage::skin::{Skin, SkinOptions, extrude, surface};
use pelage::tracer::{Camera, Film, Rays, Scene, Settings, render_counted};
use pelage_tests::stage::{BOXES, Content, Shot, flat, suns};
use pelage_tests::{alpha_rmse, blades, scene, sheet, texel};

fn picture(scene: &Scene, camera: &Camera, rays: Rays) -> (Film, u64) {
    let settings = Settings { size: [120, 120], rays, ..Settings::default() };
    let (film, counts) = render_counted(scene, camera, &settings, &|_| ControlFlow::Continue(()))
        .expect("the settings are sound");
    (film, counts.rays)
}

/// The root of the mean square difference of two pictures' colours, over some of the pixels.
fn rmse(a: &Film, b: &Film, of: impl Fn(usize) -> bool) -> f32 {
    let squares: Vec<f32> = (a.pixels.iter().zip(&b.pixels).enumerate())
        .filter(|(i, _)| of(*i))
        .map(|(_, (a, b))| (a.color - b.color).length_squared())
        .collect();
    assert!(squares.len() > 50, "of {} pixels nothing can be said", squares.len());
    (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
}

/// Thick grass, or fur, in boxes of six pixels, all of them on a ground: one cone is as near to the geometry as four rays.
#[test]
fn a_field_takes_one_cone_a_pixel() {
    for content in [Content::Grass, Content::Fur] {
        let ground = surface::plane(BOXES as f32, 1, 1);
        let mut field = scene(vec![(flat(), texel(&content.geometry(), 5, true))], vec![ground]);
        let [side, ..] = suns(35.0);
        field.set_lighting(side.clone()).expect("the light is sound");
        let shot = Shot::new(35.0, 6.0, 64);
        let truth = &shot.truth(&field, &[side], 64, true)[0];
        let [one, four] = [Rays::Adaptive, Rays::Four].map(|rays| {
            let film = shot.cone(&field, &Settings { rays, ..Settings::default() });
            rmse(&film, truth, |_| true)
        });
        println!("{content:?}: RMSE adaptive {one:.4}, four {four:.4}");
        assert!(one < 1.15 * four, "{content:?}: off by {one}, four rays by {four}");
    }
}

fn extruded(mesh: &Mesh) -> Skin {
    extrude(mesh, &|_| true, &SkinOptions::per_patch(0.2)).expect("it extrudes")
}

#[test]
fn outlines_are_as_smooth_as_with_four_rays() {
    let camera = Camera::look_at(Vec3::new(0.5, 2.0, 2.5), Vec3::ZERO, Vec3::Y, 0.9);
    // A coat on a ring, whose hairs end before the background, and one that ends in mid-air.
    let ring = surface::torus(1.0, 0.4, 60, 24);
    let dressed = scene(vec![(extruded(&ring), texel(&blades(200, 3), 5, true))], vec![ring]);
    let mat = surface::plane(2.0, 30, 30);
    let mat = scene(vec![(extruded(&mat), texel(&sheet(0.5, 0.0, Vec3::ONE), 5, true))], vec![]);
    for (name, scene, saved) in [("ring", dressed, 0.3), ("mat", mat, 0.0)] {
        let [(one, _), (four, of_four), (adaptive, of_adaptive), (all, _)] =
            [Rays::One, Rays::Four, Rays::Adaptive, Rays::Sixteen].map(|rays| picture(&scene, &camera, rays));
        let [one, four, adaptive] = [one, four, adaptive].map(|film| alpha_rmse(&film, &all));
        let left = of_adaptive as f32 / of_four as f32;
        println!(
            "{name}: alpha RMSE one {one:.4}, four {four:.4}, adaptive {adaptive:.4}; {left} of the rays"
        );
        assert!(adaptive < 1.1 * four && adaptive < 0.7 * one, "{name}");
        assert!(left < 1.0 - saved, "{name}: {left} of the rays");
    }
}

#[test]
fn opaque_edges_before_a_coat_are_smooth() {
    let camera = Camera::look_at(Vec3::new(0.0, 9.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6);
    // A card that stands askew before a field.
    let corners = [[-0.7, 1.0, 0.4], [0.6, 1.0, 0.7], [0.7, 1.0, -0.6], [-0.6, 1.0, -0.5]].map(Vec3::from);
    let card =
        Mesh { positions: vec![corners[0], corners[1], corners[3], corners[2]], ..surface::plane(1.0, 1, 1) };
    let ground = surface::plane(24.0, 1, 1);
    let field = extruded(&surface::plane(24.0, 96, 96));
    let mut field = scene(vec![(field, texel(&blades(200, 3), 5, true))], vec![card.clone(), ground]);
    field.set_lighting(suns(35.0)[0].clone()).expect("the light is sound");
    let [(one, _), (four, of_four), (adaptive, of_adaptive), (all, _)] =
        [Rays::One, Rays::Four, Rays::Adaptive, Rays::Sixteen].map(|rays| picture(&field, &camera, rays));
    let (alone, _) = picture(&scene(vec![], vec![card]), &camera, Rays::Sixteen);
    let at_edge = |i: usize| (0.05..0.95).contains(&alone.pixels[i].alpha);
    let [one, four, adaptive] = [one, four, adaptive].map(|film| rmse(&film, &all, at_edge));
    println!("RMSE one {one:.4}, four {four:.4}, adaptive {adaptive:.4}; {of_adaptive} rays of {of_four}");
    assert!(adaptive < 1.1 * four && adaptive < 0.8 * one);
    assert!(3 * of_adaptive < of_four, "all of the field takes one cone");
}
