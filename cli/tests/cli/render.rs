//! `pelage render` and `pelage expand`, and the program as a whole.

use std::fs;
use std::process::Stdio;

use super::folder::Folder;

const SMALL: &str = "--size 24x16 --rays 1 --resolution 8 -t 2";

#[test]
fn a_picture_of_a_triangle() {
    let folder = Folder::with_triangle();
    let output = folder.run(&format!("render a.obj -o a.png -q {SMALL}"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let png = folder.read("a.png");
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    // Width and height in the header.
    assert_eq!(png[16..24], [0, 0, 0, 24, 0, 0, 0, 16]);
    // Again, over the old file, and in another format.
    assert_eq!(
        folder.run(&format!("render a.obj -o a.png -q {}", SMALL.replace("-t 2", "-t 1"))).status.code(),
        Some(0)
    );
    assert_eq!(folder.read("a.png"), png);
    assert_eq!(folder.run(&format!("render a.obj -o a.exr -q {SMALL}")).status.code(), Some(0));
    assert_eq!(folder.read("a.exr")[..4], [0x76, 0x2f, 0x31, 0x01]);
}

#[test]
fn stats_for_programs() {
    let folder = Folder::with_triangle();
    let output = folder.run(&format!("render a.obj -o a.png -q --stats=json {SMALL}"));
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stdout).expect("text");
    assert_eq!(said.lines().count(), 1);
    assert!(said.starts_with("{\"seconds\":{\"load\":") && said.contains("\"faces\":1"), "{said}");
}

#[test]
fn a_scene_file() {
    let folder = Folder::with_triangle();
    let scene = "geometry = [{ file = \"a.obj\", rotate = [0, 90, 0] }]\n\
                 [[skin]]\non = \"Body\"\ntexel.fur = { preset = \"short\", resolution = 8 }\nheight = 0.1\n\
                 [camera.framed]\nazimuth = 90\n\
                 [[light]]\npoint = { position = [0, 1, 2], intensity = [1, 1, 1] }\n\
                 [environment]\nsky = [1, 1, 1]\nground = [0, 0, 0]\n\
                 [render]\nsize = [16, 16]\nrays = 1\nlod = \"sharp\"\nbackground = \"#ff8000\"\n";
    folder.write("scene.toml", scene);
    let output = folder.run("render scene.toml -o a.png -q");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn inputs_that_are_no_scene() {
    let folder = Folder::with_triangle();
    folder.write("empty.obj", "v 0 0 0\n");
    folder.write("nan.obj", "v 0 0 0\nv 1 0 nan\n");
    folder.write("cut.glb", b"glTF\x02\0\0\0\x40\0\0\0");
    folder.write("bad.gltf", "{\n\"asset\":\n");
    folder.write("a.fbx", "");
    fs::create_dir(folder.path("folder.obj")).expect("a folder");
    for (scene, message) in [
        ("missing.obj", "pelage: missing.obj: cannot be read"),
        ("folder.obj", "folder.obj: is not a regular file"),
        ("a.fbx", "a.fbx: has an unknown extension: expected .toml, .json, .gltf, .glb or .obj"),
        ("empty.obj", "empty.obj: holds no faces"),
        ("nan.obj", "nan.obj:2: `nan` is not a usable number"),
        ("cut.glb", "cut.glb: byte 8: the file is shorter than its header says"),
        ("bad.gltf", "bad.gltf:3: the JSON cannot be read: EOF while parsing a value"),
    ] {
        folder.fails(&format!("render {scene} -o a.png"), 2, message);
    }
}

#[test]
fn scene_files_that_make_no_sense() {
    let folder = Folder::with_triangle();
    let head = "geometry = [{ file = \"a.obj\" }]\n";
    for (text, message) in [
        ("[[skin]]\nheigth = 1\n", "s.toml:3:1: skin[0]: there is no field `heigth`: did you mean `height`?"),
        ("[[skin]]\nheight = 'tall'\n", "s.toml:3:10: skin[0].height: found \"tall\": expected a number"),
        ("[[skin]]\nlean = [1, 2]\n", "s.toml:3:8: skin[0].lean: found a list of 2: expected a list of 3"),
        ("[render]\nsize = [1.5, 2]\n", "s.toml:3:9: render.size[0]: found 1.5: expected a whole number"),
        ("camera = 3\n", "s.toml:2:10: camera: found 3: expected one of `look_at`, `framed`, `named`"),
        (
            "[[skin]]\ntiling = 2\naspect = 1\n",
            "s.toml:4:10: skin[0].aspect: must be left out beside `tiling`",
        ),
        ("[[skin]]\nheight = -1\n", "s.toml:3:10: skin[0].height: must be positive and at most 1e12"),
        ("[[skin]]\nheight = nan\n", "s.toml:3:10: skin[0].height: must be positive and at most 1e12"),
        (
            "[[skin]]\ntexel.fur = { preset = \"wool\" }\n",
            "s.toml:3:24: skin[0].texel.fur.preset: there is no preset of fur `wool`: there are `long`, `hair`, `short`, `plush`",
        ),
        (
            "[[skin]]\ntexel.fur = { resolution = 100 }\n",
            "s.toml:3:28: skin[0].texel.fur.resolution: must be a power of two",
        ),
        (
            "[[skin]]\ntexel.gras = {}\n",
            "s.toml:3:7: skin[0].texel: there is no texel `gras`: did you mean `grass`?",
        ),
        (
            "[[skin]]\ntexel.grass = { tapper = 1 }\n",
            "s.toml:3:17: skin[0].texel.grass: there is no field of grass `tapper`: did you mean `taper`?",
        ),
        (
            "[[skin]]\ntexel.leaves = { count = -1 }\n",
            "s.toml:3:26: skin[0].texel.leaves.count: found -1: expected a whole number",
        ),
        (
            "[[skin]]\ntexel.grass = { count = 1000000000 }\n",
            "skin[0].texel.grass.count: is 1000000000, which is not in 1 to 1000000",
        ),
        (
            "[[skin]]\non = [\"Bdoy\"]\n",
            "s.toml:3:6: skin[0].on: there is no mesh or material `Bdoy`: did you mean `Body`?",
        ),
        ("[render]\nrays = 5\n", "s.toml:3:8: render.rays: `5`: expected adaptive, 1, 4 or 16"),
        ("[render]\ncrop = [4, 4, 0, 8]\n", "s.toml:3:8: render.crop: must be x0, x1, y0, y1"),
        ("[camera]\nnamed = \"Main\"\n", "s.toml:3:9: camera.named: there is no camera `Main`"),
        (
            "[camera.look_at]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n",
            "s.toml:2:9: camera.look_at: the eye must not be at the target",
        ),
        (
            "[[light]]\nlaser = {}\n",
            "s.toml:3:1: light[0]: there is no kind `laser`: there are `point`, `spot`, `directional`",
        ),
        ("= 3\n", "s.toml:2:1: "),
    ] {
        folder.write("s.toml", format!("{head}{text}"));
        folder.fails("render s.toml -o a.png -q", 2, message);
    }
    folder.write("s.toml", "");
    folder.fails("render s.toml -o a.png", 2, "geometry: at least one mesh file or surface is needed");
    folder.write("s.toml", "geometry = [{ file = \"../a.obj\" }]");
    folder.fails(
        "render s.toml -o a.png",
        2,
        "s.toml:1:22: geometry[0].file: refers to `../a.obj`, which is outside of the scene's folder",
    );
    folder.write("s.toml", "geometry = [{ file = \"gone.obj\" }]");
    folder.fails(
        "render s.toml -o a.png",
        2,
        "s.toml:1:22: geometry[0].file: refers to `gone.obj`, which cannot be read: ",
    );
    folder.write("s.toml", b"geometry = \"\xff\"");
    folder.fails("render s.toml -o a.png", 2, "s.toml: byte 12: is not UTF-8 text");
}

#[test]
fn flags_that_make_no_sense() {
    let folder = Folder::with_triangle();
    folder.fails(
        "render a.obj -o a.png -q --on bodi",
        2,
        "there is no mesh or material `bodi`: did you mean `Body`?",
    );
    folder.fails("render a.obj -o a.png -q --resolution 3", 2, "must be a power of two");
    folder.fails(
        "render a.obj -o a.png -q --texel none --on Body",
        2,
        "a.obj: --on: there is no skin for it to change",
    );
    folder.fails("render a.obj -o a.png -q --crop 0,9,0,9 --size 8x8 --texel none", 2, "crop");
    // Told from the start, by the name of the field, and not after the texels have been baked.
    folder.fails(
        "render a.obj -o a.png -q --crop 0,9,0,8 --size 8x8",
        2,
        "render.crop: must be x0, x1, y0, y1",
    );
    folder.fails("render a.obj -o a.png -q --size 99999x99999", 2, "render.size: 99999 x 99999 pixels");
    folder.fails("render a.obj -o a.png -q --camera Foo", 2, "camera.named");
    folder.fails("render a.obj -o a.png -q --allow-dir a.obj", 2, "a.obj: cannot be read");
    folder.fails("render a.obj -o a.gif", 2, "unknown picture format: expected .png or .exr");
    // clap's own messages take a few lines.
    for flags in [
        "--size 0x4",
        "--size 640",
        "--texel wool",
        "--rays 3",
        "--background red",
        "--tint 1,2",
        "--on=",
        "-t 257",
        "-t -1",
        "--height -1",
        "--resolution 512x",
        "--frobnicate",
    ] {
        let output = folder.run(&format!("render a.obj -o a.png {flags}"));
        assert_eq!(output.status.code(), Some(2), "{flags}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{flags}");
    }
    assert_eq!(folder.run("render a.obj").status.code(), Some(2));
    assert_eq!(folder.run("").status.code(), Some(2));
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = Folder::with_triangle();
    folder.fails("render a.obj -o none/a.png", 3, "none/a.png: cannot be written");
    fs::create_dir(folder.path("b.png")).expect("a folder");
    folder.fails("render a.obj -o b.png", 3, "b.png: is a folder");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout() {
    let folder = Folder::with_triangle();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("the device");
    let mut command = folder.command(&format!("render a.obj -o a.png -q --stats=json {SMALL}"));
    let output = command.stdout(full).output().expect("the program");
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("pelage: stdout: "));
}

#[test]
fn help_has_examples() {
    let folder = Folder::with_triangle();
    let output = folder.run("render --help");
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stdout).expect("text");
    assert!(said.contains("Examples:") && said.contains("pelage render bunny.obj -o bunny.png"));
    assert!(String::from_utf8(folder.run("--help").stdout).expect("text").contains("Exit codes:"));
}

#[cfg(unix)]
#[test]
fn an_interruption_keeps_the_partial_picture() {
    let folder = Folder::with_triangle();
    // Millions of pixels: far more than can be done before the signal.
    let mut command =
        folder.command("render a.obj -o a.png -v --size 1600x1600 --rays 16 --resolution 8 -t 1");
    let mut child = command.stderr(Stdio::piped()).spawn().expect("the program");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().expect("stderr")));
    // The rendering begins when the stage before it ends.
    assert!(lines.by_ref().map_while(Result::ok).any(|line| line.starts_with("compile:")));
    std::thread::sleep(std::time::Duration::from_millis(300));
    let begun = std::time::Instant::now();
    let killed =
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    let last = lines.map_while(Result::ok).last().expect("a message");
    assert_eq!(child.wait().expect("the program").code(), Some(130));
    assert!(begun.elapsed() < std::time::Duration::from_secs(20));
    assert!(last.contains("interrupted: a.png holds"), "{last}");
    let png = folder.read("a.png");
    assert_eq!(png[16..24], [0, 0, 0x06, 0x40, 0, 0, 0x06, 0x40]);
}

#[test]
fn the_reference_method() {
    let folder = Folder::with_triangle();
    let output = folder.run("render a.obj -o a.png -q --size 12x8 --method reference --spp 2");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let fails = |flags: &str, message: &str| {
        folder.fails(&format!("render a.obj -o b.png -q --size 12x8 {flags}"), 2, message);
    };
    fails("--spp 16", "render.spp: is of the reference method only");
    fails("--method reference --spp 0", "render.spp: from 1 to 65536");
    fails("--method reference --lod 3", "--lod: means nothing to --method reference");
    fails("--method reference --rays 4", "--rays: means nothing to --method reference");
}

#[test]
fn a_scene_is_expanded() {
    let folder = Folder::with_triangle();
    // Leaves are few triangles: long fur is a hundred megabytes.
    folder.write("a.toml", "geometry = [{ file = 'a.obj' }]\n[[skin]]\ntexel.leaves = {}\n");
    for name in ["a.glb", "a.ply"] {
        let output = folder.run(&format!("expand a.toml -o {name} -q"));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty() && output.stderr.is_empty());
    }
    let output = folder.run("render a.glb --texel none -o a.png -q --size 12x8");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    folder.fails("expand a.obj -o b.glb -q --limit 1KiB", 2, "b.glb: ");
    folder.fails("expand a.obj -o b.glb -q --limit 1KiB", 2, "the limit is 1.00 KiB");
    folder.fails("expand a.obj -o b.stl -q", 2, "unknown model format");
    folder.fails("expand a.obj -o none/b.glb -q", 3, "cannot be written");
    assert_eq!(folder.run("expand a.obj -o b.glb --limit much").status.code(), Some(2));
    assert_eq!(folder.run("expand a.obj -o b.glb --tolerance 0%").status.code(), Some(2));
}
