//! `pelage check` from outside.

use super::folder::Folder;

const WRONG: &str = "\
geometry = [{ file = 'a.obj', scale = 0 }, { file = 'gone.obj' }]
ligth = 3
[[skin]]
on = 'Body'
heigth = 0.1
tint = [1, 'red', 1]
[[skin.groom]]
tilt = { towards = [0, 1, 0] }
[[skin.groom]]
scale = -1
where = { image = 'gone.png' }
[render]
rays = 5
";

#[test]
fn everything_is_told_at_once() {
    let folder = Folder::with_triangle();
    folder.write("s.toml", WRONG);
    let output = folder.run("check s.toml");
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(2), "{said}");
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    let expected = [
        "s.toml:2:1: there is no field `ligth`: did you mean `light`?",
        "s.toml:5:1: skin[0]: there is no field `heigth`: did you mean `height`?",
        "s.toml:6:12: skin[0].tint[1]: found \"red\": expected a number",
        "s.toml:8:1: skin[0].groom[0].tilt: the field `angle` is missing",
        "s.toml:13:8: render.rays: `5`: expected adaptive, 1, 4 or 16",
        "s.toml:1:39: geometry[0].scale: must be positive and at most 1e12",
        "s.toml:10:9: skin[0].groom[1].scale: must be positive",
        "s.toml:1:53: geometry[1].file: refers to `gone.obj`, which cannot be read",
        "s.toml:11:19: skin[0].groom[1].where.image: needs texture coordinates, and mesh `Body` has none",
    ];
    assert_eq!(lines.len(), expected.len(), "{said}");
    for (line, expected) in lines.iter().zip(expected) {
        assert!(
            line.strip_prefix("error: ").is_some_and(|line| line.starts_with(expected)),
            "{line}\n{expected}"
        );
    }
    assert!(said.contains("5 │ heigth = 0.1"), "{said}");
    assert!(said.ends_with("pelage: s.toml: 9 errors\n"), "{said}");
}

#[test]
fn what_makes_sense_has_a_summary() {
    let folder = Folder::with_triangle();
    folder.write(
        "s.json",
        r#"{ "geometry": [{ "file": "a.obj" }], "skin": [{ "on": "Body", "height": 0.1 }] }"#,
    );
    for scene in ["s.json", "a.obj"] {
        let output = folder.run(&format!("check {scene}"));
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(0), "{said}");
        // A triangle without texture coordinates becomes three quads.
        assert!(said.ends_with(&format!("{scene}: nothing is wrong: 1 mesh, 3 boxes\n")), "{said}");
        assert!(folder.run(&format!("check -q {scene}")).stderr.is_empty());
    }
}

#[test]
fn texts_that_are_no_scene() {
    let folder = Folder::with_triangle();
    folder.write("a.toml", "geometry = [{ file = 'a.obj' }]\nskin = [\n");
    folder.write("a.json", "{ \"geometry\": [}");
    folder.write("twice.json", r#"{ "geometry": [], "geometry": [] }"#);
    for (scene, message) in [
        ("a.toml", "error: a.toml:2:"),
        ("a.json", "error: a.json:1:16: expected value"),
        ("twice.json", "error: twice.json: `geometry` is there twice"),
        ("gone.toml", "error: gone.toml: cannot be read"),
        ("gone.glb", "error: gone.glb: cannot be read"),
    ] {
        let output = folder.run(&format!("check {scene}"));
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with(message), "{said}");
    }
}

#[test]
fn odd_things_are_warnings() {
    let folder = Folder::with_triangle();
    let scene = "geometry = [{ file = 'a.obj' }]\n[[skin]]\nheight = 0.1\n[[skin.groom]]\nscale = 2\n\
                 where = { sphere = { centre = [9, 9, 9], radius = 0.1 } }\n";
    folder.write("s.toml", scene);
    let output = folder.run("check s.toml");
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.starts_with("warning: s.toml:4:1: skin[0].groom[0]: changes nothing on `Body`"), "{said}");
    assert!(said.ends_with("s.toml: 1 warning: 1 mesh, 3 boxes\n"), "{said}");
}
