//! Texel files from outside: told of, drawn, rendered, and refused.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const TRIANGLE: &str = "o Body\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pelage"));
    command.args(line.split_whitespace()).current_dir(folder).output().expect("the program")
}

fn succeeds(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

fn fails(folder: &Path, line: &str, message: &str) {
    let output = run(folder, line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    assert!(said.contains(message) && said.lines().count() == 1, "{line}: {said}\nshould say: {message}");
}

#[test]
fn a_texel_in_a_file() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let path = |name: &str| folder.join(name);
    fs::write(path("a.obj"), TRIANGLE).expect("a file");
    succeeds(folder, "texel grow spheres -o balls.texel --resolution 8 --licence CC0-1.0 -q");

    let told = succeeds(folder, "texel info balls.texel");
    for expected in ["name         balls", "grown: spheres", "CC0-1.0", "8³, levels 0 to 3", "checksum"] {
        assert!(told.contains(expected), "{told}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&succeeds(folder, "texel info --json balls.texel")).unwrap();
    let bytes = fs::read(path("balls.texel")).expect("the texel");
    assert_eq!(json["bytes"], bytes.len());
    assert_eq!(json["levels"][0]["voxels"], 1);
    // A lattice of balls looks alike from all three sides.
    let opacity = |axis: usize| json["opacity"][axis].as_f64().expect("a number");
    assert!((opacity(0) - opacity(1)).abs() < 0.05 && opacity(2) > 0.2 && opacity(2) < 1.0, "{told}");

    succeeds(folder, "texel view balls.texel -o balls.png --size 16 -q");
    let png = fs::read(path("balls.png")).expect("the picture");
    // Five panels of 16 pixels by two rows of 16 and a line of 12.
    assert_eq!(png[16..24], [0, 0, 0, 80, 0, 0, 0, 56]);

    // The same texel, grown for the picture or read: the same picture.
    let scene = |texel: &str| format!("geometry = [{{ file = 'a.obj' }}]\n[[skin]]\n{texel}\nheight = 0.2\n");
    fs::write(path("read.toml"), scene("texel.file = 'balls.texel'")).expect("a file");
    fs::write(path("grown.toml"), scene("texel.spheres = { resolution = 8 }")).expect("a file");
    for method in ["cone", "reference --spp 1"] {
        for name in ["read", "grown"] {
            succeeds(folder, &format!("render {name}.toml -o {name}.png -q --size 24x16 --method {method}"));
        }
        assert_eq!(fs::read(path("read.png")).unwrap(), fs::read(path("grown.png")).unwrap(), "{method}");
    }
    succeeds(folder, "render a.obj --texel balls.texel -o a.png -q --size 24x16");

    let mut bad = bytes.clone();
    bad[bytes.len() / 2] ^= 4;
    for (name, content) in [("cut", &bytes[..400]), ("bad", &bad), ("obj", TRIANGLE.as_bytes())] {
        fs::write(path(&format!("{name}.texel")), content).expect("a file");
    }
    fs::write(path("scene.toml"), scene("texel.file = 'bad.texel'")).expect("a file");
    fs::write(path("away.toml"), scene("texel.file = '../balls.texel'")).expect("a file");
    fs::write(path("gone.toml"), scene("texel.file = 'gone.texel'")).expect("a file");
    for (line, message) in [
        ("texel info cut.texel", "cut.texel: ends within "),
        ("texel info bad.texel", "is damaged: its checksum does not match"),
        ("texel view obj.texel -o o.png", "obj.texel: is not a texel file"),
        ("texel info gone.texel", "gone.texel: cannot be read: "),
        ("render scene.toml -o s.png -q", "bad.texel: "),
        (
            "render away.toml -o s.png -q",
            "away.toml: skin[0].texel.file: refers to `../balls.texel`, which is outside",
        ),
        (
            "render gone.toml -o s.png -q",
            "gone.toml: skin[0].texel.file: refers to `gone.texel`, which cannot",
        ),
        ("render read.toml -o s.png -q --resolution 8", "--resolution: means nothing to a texel from a file"),
    ] {
        fails(folder, line, message);
    }
    assert!(!path("s.png").exists() && !path("o.png").exists());
}
