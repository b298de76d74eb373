//! Moving away through a level boundary: what is seen changes as the geometry's picture does, without a jump.

use pelage::tracer::Settings;
use pelage_tests::stage::{Content, Shot, coat, flat, mean_radiance, suns};
use pelage_tests::texel;

#[test]
fn no_jump_is_seen_from_one_level_to_the_next() {
    // Boxes from 24 to 12 pixels wide: cones read the texel between its levels 4.6 and 3.6, and cross level 4.
    const FRAMES: u32 = 12;
    for content in [Content::Leaves, Content::Grass] {
        let mut scene = coat(flat(), texel(&content.geometry(), 5, true));
        let [side, ..] = suns(35.0);
        scene.set_lighting(side.clone()).expect("the light is sound");
        let frames: Vec<[f32; 2]> = (0..FRAMES)
            .map(|i| {
                let width = 24.0 * 0.5_f32.powf(i as f32 / (FRAMES - 1) as f32);
                let shot = Shot::new(35.0, width, 40);
                let truth = shot.truth(&scene, std::slice::from_ref(&side), 32, true);
                let cone = shot.cone(&scene, &Settings::default());
                [mean_radiance(&cone), truth.iter().map(mean_radiance).sum()]
            })
            .collect();
        let mean = frames.iter().map(|[cone, _]| cone).sum::<f32>() / FRAMES as f32;
        for (i, pair) in frames.windows(2).enumerate() {
            let [ours, theirs] = [0, 1].map(|of| (pair[1][of] - pair[0][of]).abs() / mean);
            println!("{content:?}, frame {i}: {:?} changes by {ours:.4}, the geometry's by {theirs:.4}", pair[0]);
            assert!(ours < theirs + 0.01, "{content:?}, frame {i}: jumps by {ours}, the geometry by {theirs}");
        }
    }
}
