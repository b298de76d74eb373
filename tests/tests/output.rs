//! Picture files: what is in them, and that they appear whole or not at all.

use std::fs;

use exr::prelude::{ReadChannels, ReadLayers, Vec2 as ExrVec2};
use glam::{Vec3, vec3};
use pelage::output::{Display, ExrOptions, Format, OutputError, Tone, check_output, write_exr, write_png};
use pelage::tracer::{Camera, Film, Pixel, Rect};

/// A crop of 5 × 3 pixels at (7, 2) of a picture of 16 × 9, every pixel different.
fn film() -> Film {
    let mut film = Film::new([16, 9], Rect { x: 7, y: 2, width: 5, height: 3 });
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        let x = i as f32 / 14.0;
        *pixel = Pixel { color: vec3(x, 0.5 * x, 2.0 * x * x), alpha: x, depth: 1.0 + x };
    }
    film.pixels[0] = Pixel::EMPTY;
    film
}

#[test]
fn exr_gives_back_the_same_floats_in_the_same_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    let film = film();
    let camera = Camera::look_at(vec3(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.8);
    write_exr(&film, &path, &ExrOptions { camera: Some(camera) }).expect("written");

    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(&path)
        .expect("an EXR");
    let display = image.attributes.display_window;
    assert_eq!((display.position, display.size), (ExrVec2(0, 0), ExrVec2(16, 9)));
    assert_eq!(image.attributes.chromaticities.expect("chromaticities").red, ExrVec2(0.64, 0.33));
    let [layer] = &image.layer_data[..] else { panic!("one part") };
    assert_eq!((layer.attributes.layer_position, layer.size), (ExrVec2(7, 2), ExrVec2(5, 3)));
    let named: Vec<_> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(named, ["A", "B", "G", "R", "Z"]);
    for (channel, of) in layer.channel_data.list.iter().zip([
        |p: &Pixel| p.alpha,
        |p: &Pixel| p.color.z,
        |p: &Pixel| p.color.y,
        |p: &Pixel| p.color.x,
        |p: &Pixel| p.depth,
    ]) {
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(values, film.pixels.iter().map(of).collect::<Vec<_>>(), "{}", channel.name);
    }
    // World to camera takes the camera's place to the origin: p · M = 0 for row vectors p = (x, y, z, 1).
    let m = layer.attributes.world_to_camera.expect("worldToCamera");
    for axis in 0..3 {
        let at = (0..3).map(|k| camera.position[k] * m[4 * k + axis]).sum::<f32>() + m[12 + axis];
        assert!(at.abs() < 1e-6, "{at}");
    }
}

#[test]
fn png_is_the_window_as_a_screen_shows_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    let display = Display { exposure: 1.0, tone: Tone::None };
    write_png(&film(), &path, &display).expect("written");
    let image = image::open(&path).expect("a PNG").to_rgba8();
    assert_eq!(image.dimensions(), (5, 3));
    assert_eq!(image.get_pixel(0, 0).0, [0; 4]);
    // The last pixel is (1, ½, 2): ½ is 188 in sRGB, 2 is cut off.
    assert_eq!(image.get_pixel(4, 2).0, [255, 188, 255, 255]);
    // Pixel 7: x = ½, colour / alpha = (1, ½, 1).
    assert_eq!(image.get_pixel(2, 1).0, [255, 188, 255, 128]);
}

#[test]
fn the_same_bytes_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut large = Film::new([300, 200], Rect::whole([300, 200]));
    for (i, pixel) in large.pixels.iter_mut().enumerate() {
        *pixel = Pixel { color: Vec3::splat((i as f32 * 0.37).sin().abs()), alpha: 1.0, depth: i as f32 };
    }
    let write = |name: &str| {
        let path = folder.path().join(name);
        match check_output(&path).expect("writable") {
            Format::Png => write_png(&large, &path, &Display::default()),
            Format::Exr => write_exr(&large, &path, &ExrOptions::default()),
        }
        .expect("written");
        fs::read(path).expect("the file")
    };
    assert_eq!(write("a.png"), write("b.png"));
    assert_eq!(write("a.exr"), write("b.exr"));
    // Nothing else is left in the folder.
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 4);
}

#[test]
fn failure_leaves_the_old_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    fs::write(&path, "precious").expect("a file");
    let mut broken = film();
    broken.pixels.pop();
    let error = write_exr(&broken, &path, &ExrOptions::default()).expect_err("too few pixels");
    assert!(matches!(error, OutputError::Film { pixels: 14, width: 5, height: 3 }));
    assert!(matches!(write_png(&broken, &path, &Display::default()), Err(OutputError::Film { .. })));
    assert_eq!(fs::read(&path).expect("the file"), b"precious");
    // A folder of that name cannot be replaced; what was written beside it is gone.
    let taken = folder.path().join("taken.png");
    fs::create_dir(&taken).expect("a folder");
    fs::write(taken.join("inside"), "precious").expect("a file");
    assert!(matches!(write_png(&film(), &taken, &Display::default()), Err(OutputError::Io { .. })));
    let mut names: Vec<_> =
        fs::read_dir(folder.path()).expect("the folder").map(|e| e.expect("an entry").file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.exr", "taken.png"]);
}

#[test]
fn asking_beforehand() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    assert_eq!(check_output(&path("a.PNG")).expect("png"), Format::Png);
    assert_eq!(check_output(&path("a.exr")).expect("exr"), Format::Exr);
    assert!(matches!(check_output(&path("a.jpg")), Err(OutputError::Extension { .. })));
    assert!(matches!(check_output(&path("none/a.png")), Err(OutputError::Io { .. })));
    fs::create_dir(path("b.png")).expect("a folder");
    assert!(matches!(check_output(&path("b.png")), Err(OutputError::Folder { .. })));
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
}
