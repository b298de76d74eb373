//! Moving away through a level boundary: what is seen changes as the geometry's picture does, without a jump.

use pelage::tracer::{Rays, Settings};
use pelage_tests::stage::{Content, Shot, coat, flat, mean_radiance, suns};
use pelage_tests::texel;

/// Boxes from 24 to 12 pixels wide: cones read the texel between its levels 4.6 and 3.6, and cross level 4.
const FRAMES: u32 = 12;

/// Pixels a side: enough that the mean over them is not moved by which points the rays of one frame happen to meet. Of
/// 40 a side it was, by up to .01.
const SIDE: u32 = 80;

/// How much more the cone's mean may change from frame to frame than the geometry's, relative to the mean. The goal is
/// .01; reached are .009 with leaves and .005 with grass.
const EXCESS: f32 = 0.015;

fn zoom(content: Content) {
    let mut scene = coat(flat(), texel(&content.geometry(), 5, true));
    let [side, ..] = suns(35.0);
    scene.set_lighting(side.clone()).expect("the light is sound");
    let frames: Vec<[f32; 2]> = (0..FRAMES)
        .map(|i| {
            let width = 24.0 * 0.5_f32.powf(i as f32 / (FRAMES - 1) as f32);
            let shot = Shot::new(35.0, width, SIDE);
            let truth = shot.truth(&scene, std::slice::from_ref(&side), 8, true);
            let cone = shot.cone(&scene, &Settings { rays: Rays::Sixteen, ..Settings::default() });
            [mean_radiance(&cone), truth.iter().map(mean_radiance).sum()]
        })
        .collect();
    let mean = frames.iter().map(|[cone, _]| cone).sum::<f32>() / FRAMES as f32;
    for (i, pair) in frames.windows(2).enumerate() {
        let [ours, theirs] = [0, 1].map(|of| (pair[1][of] - pair[0][of]) / mean);
        println!("{content:?}, frame {i}: changes by {ours:+.4}, the geometry's by {theirs:+.4}");
        assert!(
            ours.abs() < theirs.abs() + EXCESS,
            "{content:?}, frame {i}: jumps by {ours}, the geometry's by {theirs}"
        );
    }
}

#[test]
fn leaves_do_not_jump_from_one_level_to_the_next() {
    zoom(Content::Leaves);
}

#[test]
fn grass_does_not_jump_from_one_level_to_the_next() {
    zoom(Content::Grass);
}
