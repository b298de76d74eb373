//! The curved path shows what the deformed geometry shows; the straight one does not. [seed §5, §7]

use pelage::geom::glam::{Vec2, Vec3};
use pelage::tracer::{Camera, Lod, Path, Rays, Settings};
use pelage_tests::{alpha_rmse, blades, expand, mean_alpha, picture, scene, texel, twisted_box};

fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.6, 1.0, 2.6), Vec3::new(0.6, 0.45, -0.4), Vec3::Y, 0.6)
}

#[test]
fn curved_matches_the_expanded_geometry() {
    let geometry = blades(40, 7);
    let texel = texel(&geometry, 7, false);
    let settings = Settings { size: [128, 128], rays: Rays::Sixteen, ..Settings::default() };
    // Undeformed, and twisted by 75° and sheared.
    for (twist, shear, bent) in [(0.0, Vec2::ZERO, false), (1.3, Vec2::new(0.7, -0.2), true)] {
        let skin = twisted_box(twist, shear);
        let truth = picture(&scene(vec![], vec![expand(&geometry, &skin, 4)]), &camera(), &settings);
        let boxes = scene(vec![(skin, texel.clone())], vec![]);
        let curved = picture(&boxes, &camera(), &settings);
        let straight = picture(&boxes, &camera(), &Settings { path: Path::Straight, ..settings });
        let (c, s) = (alpha_rmse(&curved, &truth), alpha_rmse(&straight, &truth));
        let bias = mean_alpha(&curved) / mean_alpha(&truth);
        println!("twist {twist}: alpha RMSE curved {c:.4}, straight {s:.4}, bias {bias:.4}");
        assert!(c < 0.06, "curved: alpha RMSE {c}");
        assert!((bias - 1.0).abs() < 0.03, "curved: mean alpha {bias} of the geometry's");
        if bent {
            assert!(s > 4.0 * c, "the straight path should be visibly wrong: {s} against {c}");
        } else {
            assert!(alpha_rmse(&curved, &straight) < 1e-4, "an undeformed box has no curve");
        }
    }
}

#[test]
fn the_curve_converges_with_its_tolerance() {
    let texel = texel(&blades(40, 7), 6, false);
    let skin = twisted_box(1.3, Vec2::new(0.7, -0.2));
    let boxes = scene(vec![(skin, texel)], vec![]);
    let settings =
        Settings { size: [96, 96], lod: Lod::Level(6), rays: Rays::Sixteen, ..Settings::default() };
    let at = |path_tolerance| picture(&boxes, &camera(), &Settings { path_tolerance, ..settings });
    let exact = at(0.001);
    let [coarse, default, fine] =
        [0.4, settings.path_tolerance, 0.01].map(|tolerance| alpha_rmse(&at(tolerance), &exact));
    println!("alpha RMSE against 0.001 voxel: 0.4 {coarse:.5}, default {default:.5}, 0.01 {fine:.5}");
    // A shift by a twentieth of a voxel flips some of the sixteen rays at the edges of blades, no more.
    assert!(default < 0.015 && fine < 0.5 * default && default < 0.5 * coarse);
}

#[test]
fn more_rays_come_nearer_to_the_geometry() {
    let geometry = blades(40, 7);
    let skin = twisted_box(1.3, Vec2::new(0.7, -0.2));
    let sixteen = Settings { size: [64, 64], rays: Rays::Sixteen, ..Settings::default() };
    let truth = picture(&scene(vec![], vec![expand(&geometry, &skin, 4)]), &camera(), &sixteen);
    let boxes = scene(vec![(skin, texel(&geometry, 7, false))], vec![]);
    let error = |rays| alpha_rmse(&picture(&boxes, &camera(), &Settings { rays, ..sixteen }), &truth);
    let [one, four, all] = [Rays::One, Rays::Four, Rays::Sixteen].map(error);
    println!("alpha RMSE with 1, 4 and 16 rays a pixel: {one:.4}, {four:.4}, {all:.4}");
    assert!(four < 0.7 * one && all < 0.7 * four);
}
