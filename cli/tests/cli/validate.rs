//! `pelage validate` from outside: tables, JSON, pages, goals and refusals, on scenes as small as they can be.

use std::fs;

use serde_json::Value;

use super::folder::Folder;

const SHEET: &str = "geometry = [{ file = \"a.obj\" }]\n\
                     [[skin]]\nheight = 0.4\ntiling = 2\ntexel.sheet = { resolution = 8 }\n\
                     [camera.framed]\nazimuth = 20\nelevation = 40\n[render]\nsize = [64, 48]\n";

/// As little as can be asked for.
const LITTLE: &str = "-t 2 --size 8 --spp 4 --frames 2 --distances 16,8h";

/// A folder with a square on the ground and a scene with a sheet on it.
fn sheet() -> Folder {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    );
    folder.write("s.toml", SHEET);
    folder
}

#[test]
fn a_table_and_a_page() {
    let folder = sheet();
    let output = folder.run(&format!("validate s.toml -q -o r.html {LITTLE}"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
    let said = String::from_utf8(output.stdout).expect("text");
    // A heading, the names of the columns, two distances under three lights, an empty line.
    assert_eq!(said.lines().count(), 2 + 2 * 3 + 1, "{said}");
    assert!(said.starts_with("s.toml: 4 samples"), "{said}");
    for word in ["8h", "side", "near view", "behind"] {
        assert!(said.contains(word), "{said}");
    }
    let page = fs::read_to_string(folder.path("r.html")).expect("the page");
    assert_eq!(page.matches("<img src=\"data:image/png;base64,iVBOR").count(), 6);
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>") && !page.contains("http"));
}

#[test]
fn an_object_for_programs() {
    let folder = sheet();
    let run = || folder.run(&format!("validate s.toml -q --json --goals fur {LITTLE},near")).stdout;
    let list: Value = serde_json::from_slice(&run()).expect("JSON");
    let study = &list[0];
    assert_eq!(study["scene"], "s.toml");
    assert_eq!(study["goals"]["alpha_bias"], 0.015);
    let found = &study["distances"][0];
    assert_eq!((&found["distance"], found["lights"].as_array().map(Vec::len)), (&"16".into(), Some(3)));
    assert!((found["box_pixels"].as_f64().expect("a number") - 16.0).abs() < 1e-3);
    // Two copies a side of one box, where the pixel is a sixteenth of it: the level is about 3.
    let level = found["level"].as_f64().expect("a number");
    assert!((2.0..4.0).contains(&level), "{level}");
    let halfway = study["distances"][1]["level"].as_f64().expect("a number");
    assert!((halfway - halfway.floor() - 0.5).abs() < 1e-3, "{halfway}");
    // A pixel half as wide as a voxel of level 3, the finest.
    let near = study["distances"][2]["level"].as_f64().expect("a number");
    assert!((near - 4.0).abs() < 1e-3, "{near}");
    let cell = &found["lights"][0];
    for key in ["light", "energy_error", "rmse", "flip", "worth", "flicker", "flicker_of_16", "misses"] {
        assert!(cell.get(key).is_some(), "{key}");
    }
    // Two runs differ in nothing but the time that they took.
    let mut again: Value = serde_json::from_slice(&run()).expect("JSON");
    again[0]["seconds"] = study["seconds"].clone();
    assert_eq!(list, again);
}

#[test]
fn goals_and_the_exit_code() {
    let folder = sheet();
    // An eighth of the voxels, magnified: a goal is missed for certain.
    let line = "validate s.toml -q --resolution 2 --distances 64 --frames 0 --size 16 --spp 16";
    assert_eq!(folder.run(line).status.code(), Some(0));
    let strict = folder.run(&format!("{line} --strict"));
    assert_eq!(strict.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&strict.stderr).contains("goals missed"));
    assert!(!strict.stdout.is_empty());
}

#[test]
fn mesh_files_and_their_own_light() {
    let folder = sheet();
    let line = "validate a.obj -q --texel sheet --resolution 4 --height 0.3 --lights scene --frames 0 --size 8 --spp 4";
    let output = folder.run(&format!("{line} --distances 8"));
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("scene") && said.lines().count() == 4, "{said}");
}

#[test]
fn what_cannot_be_validated() {
    let folder = sheet();
    folder.write("bare.toml", "geometry = [{ file = \"a.obj\" }]\n[render]\nsize = [16, 16]\n");
    let away = "[camera.look_at]\neye = [0, 9, 9]\ntarget = [0, 9, 99]\n";
    folder.write("away.toml", SHEET.replace("[camera.framed]\nazimuth = 20\nelevation = 40\n", away));
    folder.fails("validate -q bare.toml", 2, "bare.toml: nothing grows in the scene");
    folder.fails("validate -q away.toml", 2, "away.toml: the camera sees no coat");
    // Told before the first scene takes its time.
    folder.fails("validate -q s.toml gone.toml", 2, "gone.toml: cannot be read");
    folder.fails("validate -q s.toml -o r.txt", 2, "r.txt: a report is written as .html");
    folder.fails("validate -q s.toml -o none/r.html", 3, "none/r.html: cannot be written");
    folder.fails("validate -q s.toml --resolution 3", 2, "must be a power of two");
    for flags in
        ["--spp 5", "--spp 0", "--size 1", "--frames 1", "--distances far", "--distances 0", "--lights sun"]
    {
        assert_eq!(folder.run(&format!("validate s.toml {flags}")).status.code(), Some(2), "{flags}");
    }
    assert_eq!(folder.run("validate").status.code(), Some(2));
}
