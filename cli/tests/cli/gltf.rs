//! Skins in glTF files, from outside.

use super::folder::Folder;

/// A triangle whose mesh has these members.
fn triangle(mesh: &str, material: &str) -> String {
    format!(
        r#"{{
"asset": {{ "version": "2.0" }}, "extensionsUsed": ["PELAGE_skin"], "extensionsRequired": ["PELAGE_skin"],
"scene": 0, "scenes": [{{ "nodes": [0] }}], "nodes": [{{ "mesh": 0, "name": "Body" }}],
"materials": [{{ "name": "Coat"{material} }}],
"meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": 0 }}], "name": "Shape"{mesh} }}],
"buffers": [{{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }}],
"bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
"accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0] }}]
}}"#
    )
}

#[test]
fn skins_of_meshes_and_materials_are_worn() {
    let folder = Folder::new();
    let skin =
        r#", "extensions": { "PELAGE_skin": { "texel": { "fur": { "preset": "short" } }, "height": 0.05 } }"#;
    let extras = r#", "extras": { "pelage_texel": "grass:lawn", "pelage_height": 0.05, "pelage_tint": [1, 0.5, 0.2], "other": 1 }"#;
    for (name, text) in [
        ("mesh", triangle(skin, "")),
        ("material", triangle("", skin)),
        ("extras", triangle(extras, "")),
        ("none", triangle("", "")),
    ] {
        folder.write(&format!("{name}.gltf"), text);
        let output = folder.run(&format!("check {name}.gltf"));
        let said = String::from_utf8(output.stderr).expect("text");
        assert!(said.ends_with(&format!("{name}.gltf: nothing is wrong: 1 mesh, 3 boxes\n")), "{said}");
        assert!(said.starts_with("note: ") && said.contains("stretch"), "{said}");
    }
    // The flag stands in for what the file says.
    let small = "-q --size 12x8 --rays 1 --resolution 4";
    folder.told(&format!("render mesh.gltf -o a.png {small}"));
    folder.told(&format!("render extras.gltf --texel fur:short --height 0.05 -o b.png {small}"));
    assert_eq!(folder.read("a.png"), folder.read("b.png"));
    folder.told(&format!("render extras.gltf -o c.png {small}"));
    assert_ne!(folder.read("a.png"), folder.read("c.png"));
}

#[test]
fn vertices_colour_what_grows_on_them() {
    let folder = Folder::new();
    // The triangle, with red, green and blue corners after its positions.
    let bare = triangle(r#", "extras": { "pelage_texel": "fur:short" }"#, "");
    let painted = bare
        .replace(r#""POSITION": 0"#, r#""POSITION": 0, "COLOR_0": 1"#)
        .replace("36", "72")
        .replace("AAAAAAAAgD8AAAAA", "AAAAAAAAgD8AAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/")
        .replace(r#""accessors": ["#, r#""accessors": [
{ "bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0] },
{ "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3" },"#);
    folder.write("unpainted.gltf", painted.as_str());
    folder.write(
        "painted.gltf",
        painted.replace(r#""extras": {"#, r#""extras": { "pelage_vertex_color": "COLOR_0","#),
    );
    folder.write(
        "bare.gltf",
        bare.replace(r#""extras": {"#, r#""extras": { "pelage_vertex_color": "COLOR_1","#),
    );
    for name in ["painted", "unpainted"] {
        folder.told(&format!("render {name}.gltf -o {name}.png -q --size 12x8 --rays 1 --resolution 4"));
    }
    assert_ne!(folder.read("painted.png"), folder.read("unpainted.png"));
    folder.fails(
        "check bare.gltf",
        2,
        "extras.pelage_vertex_color: there is no vertex attribute of three numbers on mesh",
    );
}

#[test]
fn what_cannot_be_is_named() {
    let folder = Folder::new();
    let extension = |content: &str| format!(r#", "extensions": {{ "PELAGE_skin": {content} }}"#);
    let extras = |content: &str| format!(r#", "extras": {{ {content} }}"#);
    for (mesh, message) in [
        (
            extension(r#"{ "heigth": 1 }"#),
            "a.gltf:5:132: mesh `Shape`: PELAGE_skin: there is no field `heigth`: did you mean `height`?",
        ),
        (extension("3"), "mesh `Shape`: PELAGE_skin: found 3: expected a table"),
        (extension(r#"{ "height": -1 }"#), "mesh `Shape`: PELAGE_skin.height: must be positive"),
        (extension(r#"{ "on": "Body" }"#), "mesh `Shape`: PELAGE_skin.on: must be left out"),
        (
            extension(r#"{ "texel": { "file": "gone.texel" } }"#),
            "mesh `Shape`: PELAGE_skin.texel.file: refers to `gone.texel`, which cannot be read",
        ),
        (
            extras(r#""pelage_heigth": 1"#),
            "mesh `Shape`: extras: there is no field `heigth`: did you mean `height`?",
        ),
        (
            extras(r#""pelage_texel": "fur:lung""#),
            "mesh `Shape`: extras.pelage_texel.fur.preset: there is no preset of fur `lung`: did you mean `long`?",
        ),
        (extras(r#""pelage_texel": 3"#), "mesh `Shape`: extras.pelage_texel: found 3: expected a table"),
        (
            extras(r#""pelage_resolution": 100"#),
            "mesh `Shape`: extras.pelage_texel.fur.resolution: must be a power of two",
        ),
    ] {
        folder.write("a.gltf", triangle(&mesh, ""));
        folder.fails("render a.gltf -o a.png -q", 2, message);
    }
}
