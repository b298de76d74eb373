//! `pelage bench` from outside.

use serde_json::Value;

use super::folder::Folder;

#[test]
fn a_scene_is_measured() {
    let folder = Folder::new();
    let flags = "--size 24x16 --resolution 2 --runs 2 --cache kept";
    let table = folder.told(&format!(
        "bench --scene one-box,moving --distance mid,far --threads 1,2 --json all.json {flags}"
    ));
    let told: Value = serde_json::from_slice(&folder.read("all.json")).expect("JSON");
    let scenes = told["scenes"].as_array().expect("a list");
    assert_eq!(scenes.len(), 2);
    for (scene, [name, boxes]) in scenes.iter().zip([["one-box", "1"], ["moving", "4096"]]) {
        assert!(
            table.contains(&format!("{name}: ")) && table.contains(&format!("  {boxes} boxes")),
            "{table}"
        );
        assert_eq!(
            [scene["scene"].to_string(), scene["boxes"].to_string()],
            [format!("\"{name}\""), boxes.into()]
        );
        // Two distances, with one thread and with two, along both paths.
        let pictures = scene["pictures"].as_array().expect("a list");
        assert_eq!(pictures.len(), 8);
        for picture in pictures {
            // A ray a pixel, or more.
            assert!(picture["counts"][0].as_u64() >= Some(24 * 16), "{picture}");
            assert!(picture["ns_per_ray"].as_f64() > Some(0.0), "{picture}");
            assert_eq!(picture["over_straight"].is_number(), picture["path"] == "curved", "{picture}");
            assert_eq!(picture["efficiency"].is_number(), picture["threads"] == 2, "{picture}");
        }
        assert_eq!(scene["frame"].is_object(), name == "moving");
    }
    // 200 blades of 8 triangles, and a ground of two.
    assert_eq!(scenes[0]["triangles"], 1602);
    // What was measured can be rendered.
    folder.told("render kept/one-box-far.toml -o far.exr");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let folder = Folder::new();
    assert!(folder.told("bench --list").contains("blades-4096"));
    for (flags, message) in [
        ("--scene blade", "expected one of blades-256, "),
        ("--resolution 100", "expected a power of two from 2 to 512"),
        ("--runs 0", "expected a whole number from 1 to 1000"),
        ("--size 0x8", "expected width x height"),
    ] {
        let output = folder.run(&format!("bench {flags}"));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(message), "{flags}: {said}");
    }
    folder.fails("bench --scene one-box --json none/a.json", 3, "none/a.json");
    folder.write("file", "");
    folder.fails("bench --scene one-box --cache file/in", 2, "--cache file/in");
}
