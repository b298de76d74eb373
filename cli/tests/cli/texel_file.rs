//! Texel files from outside: told of, drawn, rendered, and refused.

use std::fs;

use super::folder::Folder;

#[test]
fn a_texel_in_a_file() {
    let folder = Folder::with_triangle();
    let path = |name: &str| folder.path(name);
    folder.told("texel grow spheres -o balls.texel --resolution 8 --licence CC0-1.0 -q");

    let told = folder.told("texel info balls.texel");
    for expected in ["name         balls", "grown: spheres", "CC0-1.0", "8³, levels 0 to 3", "checksum"] {
        assert!(told.contains(expected), "{told}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&folder.told("texel info --json balls.texel")).unwrap();
    let bytes = folder.read("balls.texel");
    assert_eq!(json["bytes"], bytes.len());
    assert_eq!(json["levels"][0]["voxels"], 1);
    // A lattice of balls looks alike from all three sides.
    let opacity = |axis: usize| json["opacity"][axis].as_f64().expect("a number");
    assert!((opacity(0) - opacity(1)).abs() < 0.05 && opacity(2) > 0.2 && opacity(2) < 1.0, "{told}");

    folder.told("texel view balls.texel -o balls.png --size 16 -q");
    let png = fs::read(path("balls.png")).expect("the picture");
    // Five panels of 16 pixels by two rows of 16 and a line of 12.
    assert_eq!(png[16..24], [0, 0, 0, 80, 0, 0, 0, 56]);

    // The same texel, grown for the picture or read: the same picture.
    let scene = |texel: &str| format!("geometry = [{{ file = 'a.obj' }}]\n[[skin]]\n{texel}\nheight = 0.2\n");
    folder.write("read.toml", scene("texel.file = 'balls.texel'"));
    folder.write("grown.toml", scene("texel.spheres = { resolution = 8 }"));
    for method in ["cone", "reference --spp 1"] {
        for name in ["read", "grown"] {
            folder.told(&format!("render {name}.toml -o {name}.png -q --size 24x16 --method {method}"));
        }
        assert_eq!(fs::read(path("read.png")).unwrap(), fs::read(path("grown.png")).unwrap(), "{method}");
    }
    folder.told("render a.obj --texel balls.texel -o a.png -q --size 24x16");

    let mut bad = bytes.clone();
    bad[bytes.len() / 2] ^= 4;
    for (name, content) in [("cut", &bytes[..400]), ("bad", &bad), ("obj", &b"o Body"[..])] {
        folder.write(&format!("{name}.texel"), content);
    }
    folder.write("scene.toml", scene("texel.file = 'bad.texel'"));
    folder.write("away.toml", scene("texel.file = '../balls.texel'"));
    folder.write("gone.toml", scene("texel.file = 'gone.texel'"));
    for (line, message) in [
        ("texel info cut.texel", "cut.texel: ends within "),
        ("texel info bad.texel", "is damaged: its checksum does not match"),
        ("texel view obj.texel -o o.png", "obj.texel: is not a texel file"),
        ("texel info gone.texel", "gone.texel: cannot be read: "),
        ("render scene.toml -o s.png -q", "bad.texel: "),
        (
            "render away.toml -o s.png -q",
            "away.toml:3:14: skin[0].texel.file: refers to `../balls.texel`, which is outside",
        ),
        (
            "render gone.toml -o s.png -q",
            "gone.toml:3:14: skin[0].texel.file: refers to `gone.texel`, which cannot",
        ),
        ("render read.toml -o s.png -q --resolution 8", "--resolution: means nothing to a texel from a file"),
    ] {
        folder.fails(line, 2, message);
    }
    assert!(!path("s.png").exists() && !path("o.png").exists());
}
