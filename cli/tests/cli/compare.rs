//! `pelage compare` from outside: what it says, what it writes, and what it refuses.

use std::fs;
use std::path::Path;

use pelage::geom::glam::Vec3;
use pelage::output::{Display, ExrOptions, Tone, write_exr, write_png};
use pelage::tracer::{Film, Pixel, Rect};
use serde_json::Value;

use super::folder::Folder;

/// A folder with an opaque grey test and a brighter reference, as EXR and PNG.
fn pictures() -> Folder {
    let folder = Folder::new();
    for (name, color) in [("a", 0.2), ("b", 0.25)] {
        let film = grey(color, [16, 12], Rect::whole([16, 12]));
        exr(&folder, name, &film);
        let display = Display { exposure: 1.0, tone: Tone::None };
        write_png(&film, &folder.path(&format!("{name}.png")), &display).expect("written");
    }
    folder
}

fn exr(folder: &Folder, name: &str, film: &Film) {
    write_exr(film, &folder.path(&format!("{name}.exr")), &ExrOptions::default()).expect("written");
}

/// The object that `--json` tells.
fn json(folder: &Folder, line: &str) -> Value {
    let told = folder.told(&format!("compare {line} --json"));
    assert_eq!(told.lines().count(), 1);
    serde_json::from_str(&told).expect("JSON")
}

fn grey(color: f32, size: [u32; 2], window: Rect) -> Film {
    let pixel = Pixel { color: Vec3::splat(color), alpha: 1.0, depth: 1.0 };
    Film { size, window, pixels: vec![pixel; window.area()] }
}

#[test]
fn a_table_and_an_object() {
    let folder = pictures();
    let m = json(&folder, "a.exr b.exr");
    let keys: Vec<&str> = m.as_object().expect("an object").keys().map(String::as_str).collect();
    let mut expected = [
        "test",
        "reference",
        "x",
        "y",
        "width",
        "height",
        "exposure",
        "ppd",
        "flip",
        "rmse",
        "rel_mse",
        "psnr",
        "energy_ratio",
        "alpha_bias",
        "alpha_difference",
        "max_difference",
    ];
    expected.sort_unstable();
    let mut sorted = keys.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, expected);
    let number = |key: &str| m[key].as_f64().expect("a number");
    // .2 against .25 everywhere.
    assert!((number("rmse") - 0.05).abs() < 1e-7);
    assert!((number("rel_mse") - 0.0025 / 0.0725).abs() < 1e-6);
    assert!((number("energy_ratio") - 0.8).abs() < 1e-6);
    assert_eq!(number("alpha_bias"), 0.0);
    // The reference is shown at .8.
    assert!((number("exposure") - 3.2).abs() < 1e-5);
    assert!(number("flip") > 0.01 && number("psnr") > 10.0);

    let output = folder.run("compare a.png b.png");
    let said = String::from_utf8(output.stdout).expect("text");
    assert_eq!((output.status.code(), said.lines().count()), (Some(0), 8), "{said}");
    assert!(said.contains("    energy ratio  0.8"), "{said}");
    let same = folder.run("compare a.png a.png");
    assert!(String::from_utf8_lossy(&same.stdout).contains("PSNR  no difference"));
}

#[test]
fn a_difference_of_three_panels() {
    let folder = pictures();
    json(&folder, "a.png b.png --diff d.png");
    let png = fs::read(folder.path("d.png")).expect("the picture");
    // Width and height in the header: three times 16, and 12.
    assert_eq!(png[16..24], [0, 0, 0, 48, 0, 0, 0, 12]);
    // The first two panels are the pictures themselves.
    let of =
        |name: &str| pelage_validate::Picture::open(Path::new(&folder.path(name))).expect("a picture").film;
    let (three, a, b) = (of("d.png"), of("a.png"), of("b.png"));
    assert_eq!(three.get(0, 0), a.get(0, 0));
    assert_eq!(three.get(16, 0), b.get(0, 0));
    assert_ne!(three.get(32, 0), b.get(0, 0));
}

#[test]
fn parts_of_pictures() {
    let folder = pictures();
    let window = Rect { x: 4, y: 2, width: 8, height: 6 };
    exr(&folder, "part", &grey(0.25, [16, 12], window));
    folder.fails("compare part.exr b.exr", 2, "8x6 pixels from column 4 and row 2 against 16x12");
    folder.fails("compare part.exr b.exr", 2, "--crop names a part of both");
    let m = json(&folder, "part.exr b.exr --crop 5,8,3,7");
    assert_eq!(
        (m["width"].as_u64(), m["height"].as_u64(), m["rmse"].as_f64()),
        (Some(3), Some(4), Some(0.0))
    );
    folder.fails(
        "compare part.exr b.exr --crop 0,8,3,7",
        2,
        "part.exr: --crop 0,8,3,7 is not within its columns 4 to 12 and rows 2 to 8",
    );
    folder.fails("compare a.exr b.exr --crop 8,8,0,4", 2, "a.exr: --crop 8,8,0,4 is not within");
}

#[test]
fn what_cannot_be_compared() {
    let folder = pictures();
    exr(&folder, "small", &grey(0.2, [8, 8], Rect::whole([8, 8])));
    fs::write(folder.path("cut.png"), b"\x89PNG\r\n\x1a\n\0\0").expect("a file");
    fs::create_dir(folder.path("folder.exr")).expect("a folder");
    folder.fails("compare small.exr b.exr", 2, "small.exr: 8x8 pixels against 16x12 of the reference b.exr");
    folder.fails("compare a.png b.exr", 2, "a PNG holds what a screen shows, an EXR radiance");
    folder.fails("compare gone.png b.png", 2, "gone.png: cannot be read");
    folder.fails("compare cut.png b.png", 2, "cut.png: the picture cannot be decoded");
    folder.fails("compare folder.exr b.exr", 2, "folder.exr: is not a regular file");
    folder.fails("compare a.gif b.png", 2, "a.gif: unknown picture format: expected .png or .exr");
    folder.fails("compare a.png b.png --exposure 1", 2, "--exposure: a PNG is exposed already");
    folder.fails("compare a.exr b.exr --exposure 1e9", 2, "beyond what can be shown");
    folder.fails("compare a.exr b.exr --diff d.exr", 2, "d.exr: a difference is written as .png");
    folder.fails("compare a.exr b.exr --diff none/d.png", 3, "none/d.png: cannot be written");
    // clap's own messages take a few lines.
    for line in ["compare a.png", "compare a.exr b.exr --ppd 0", "compare a.exr b.exr --crop 1,2,3"] {
        assert_eq!(folder.run(line).status.code(), Some(2), "{line}");
    }
}
