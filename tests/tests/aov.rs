//! What a pixel shows besides its colour, and the EXR channels that hold it.

use std::f32::consts::SQRT_2;

use exr::prelude::{ReadChannels, ReadLayers};
use glam::Vec3;
use pelage::output::{Aov, ExrOptions, OutputError, write_exr_with};
use pelage::skin::{SkinOptions, extrude, surface};
use pelage::tracer::{Aovs, Camera, Settings, render_aovs};
use pelage_tests::{picture, scene, sheet, texel};

/// Two boxes of 1 m × 2 m side by side, a copy of a solid sheet in each, seen from above.
#[test]
fn each_box_has_its_number_its_stretch_and_its_normal() {
    let skin = extrude(&surface::plane(2.0, 2, 1), &|_| true, &SkinOptions::per_patch(0.1)).expect("a skin");
    let middle = |patch: usize| {
        skin.patches[patch].corners().iter().map(|&v| skin.base[v as usize].x).sum::<f32>() / 4.0
    };
    let left = if middle(0) < 0.0 { 0 } else { 1 };
    let scene = scene(vec![(skin, texel(&sheet(0.5, 0.0, Vec3::ONE), 3, false))], vec![]);
    let camera = Camera::look_at(4.0 * Vec3::Y, Vec3::ZERO, Vec3::NEG_Z, 0.8);
    let settings = Settings { size: [40, 30], ..Settings::default() };
    let aovs = render_aovs(&scene, &camera, &settings).expect("settings are sound");
    for (i, &patch) in aovs.patch.iter().enumerate() {
        // At 4 m a picture is 3.4 m high, and 8.9 pixels are a metre.
        let (x, y) = (i as f32 % 40.0 - 19.5, (i / 40) as f32 - 14.5);
        if x.abs() > 1.0 && x.abs() < 7.0 && y.abs() < 7.0 {
            assert_eq!(patch, if x < 0.0 { left } else { 1 - left }, "{x} {y}");
            // A copy is 1 m × 2 m where √2 m is the mean.
            assert!((aovs.stretch[i] - SQRT_2).abs() < 1e-5, "{}", aovs.stretch[i]);
            assert!(aovs.normal[i].distance(Vec3::Y) < 1e-6);
        } else if x.abs() > 11.0 || y.abs() > 11.0 {
            assert_eq!((patch, aovs.stretch[i], aovs.normal[i]), (Aovs::NO_PATCH, 0.0, Vec3::ZERO));
        }
    }

    let film = picture(&scene, &camera, &settings);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    let wanted = [Aov::Stretch, Aov::Patch, Aov::Normal];
    write_exr_with(&film, &aovs, &wanted, &path, &ExrOptions::default()).expect("written");
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .expect("an EXR");
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "Z", "normal.X", "normal.Y", "normal.Z", "patch", "stretch"]);
    let patches: Vec<u32> = channels[8].sample_data.values_as_f32().map(|x| x as u32).collect();
    let rounded = |p: &u32| *p as f32 as u32;
    assert_eq!(patches, aovs.patch.iter().map(rounded).collect::<Vec<_>>());

    let other = Aovs { patch: vec![0; 7], ..aovs };
    match write_exr_with(&film, &other, &wanted, &path, &ExrOptions::default()) {
        Err(OutputError::Layers { pixels: 7, expected: 1200 }) => {}
        other => panic!("{other:?}"),
    }
}
