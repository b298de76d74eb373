//! `pelage texel bake` from outside: exit codes, messages, files.

use super::folder::Folder;

/// A folder with a triangle of its own material.
fn leaf() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", "mtllib a.mtl\nusemtl leaf\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("a.mtl", "newmtl leaf\nKd 0.2 0.6 0.1\n");
    folder
}

#[test]
fn a_texel_of_a_triangle() {
    let folder = leaf();
    let read = |name: &str| folder.read(name);
    for (name, options) in [("one", "-t 1"), ("two", "-t 2"), ("source", "--with-source")] {
        let output =
            folder.run(&format!("texel bake a.obj -o {name}.texel --name leaf --resolution 16 -q {options}"));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty() && output.stderr.is_empty());
    }
    assert_eq!(read("one.texel"), read("two.texel"));
    assert!(read("source.texel").len() > read("one.texel").len());
}

#[test]
fn warnings_are_told_unless_quiet() {
    let folder = leaf();
    folder.write("a.mtl", "newmtl leaf\nKe 1 0 0\n");
    let said = |options: &str| {
        let output = folder.run(&format!("texel bake a.obj -o a.texel --resolution 8 {options}"));
        assert_eq!(output.status.code(), Some(0));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        // On a slow machine progress is told too.
        said.lines().filter(|line| !line.contains('%')).map(|line| format!("{line}\n")).collect::<String>()
    };
    assert_eq!(
        said(""),
        "warning: a.obj: the light that `leaf` gives off is left out: texels give off none\n"
    );
    assert_eq!(said("-q"), "");
    assert!(said("-v").contains("1 triangles"));
}

#[test]
fn mistakes_are_one_line() {
    let folder = leaf();
    folder.fails("texel bake b.obj -o b.texel", 2, "b.obj: cannot be read");
    folder.fails("texel bake a.obj -o b.png", 2, "b.png: has an unknown extension: expected .texel");
    folder.fails("texel bake a.obj -o nowhere/b.texel", 3, "nowhere/b.texel: cannot be written");
    folder.fails(
        "texel bake a.obj -o b.texel --fit keep --margin 0.1",
        2,
        "--margin: means nothing with --fit keep",
    );
    folder.fails(
        "texel bake a.obj -o b.texel --margin 0.5",
        2,
        "a.obj: margin is 0.5, which is not in 0 to 0.45",
    );
    folder.write("far.obj", "v 7 0 0\nv 8 0 0\nv 7 1 0\nf 1 2 3\n");
    folder.fails(
        "texel bake far.obj -o b.texel --fit keep",
        2,
        "far.obj: none of it lies in the unit cube: it spans (7, 1, 0)",
    );
    folder.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.fails("texel bake nan.obj -o b.texel", 2, "nan.obj:1: `nan` is not a usable number");
    folder.write("empty.obj", "v 0 0 0\n");
    folder.fails("texel bake empty.obj -o b.texel", 2, "empty.obj: holds no faces");
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.fails("texel bake flat.obj -o b.texel", 2, "flat.obj: nothing in it has any area");
    folder.write("line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    folder.fails(
        "texel bake line.obj -o b.texel",
        2,
        "line.obj: strands have no thickness of their own (1 of them)",
    );
    folder.write("a.mtl", "newmtl leaf\nd 0\n");
    folder.fails(
        "texel bake a.obj -o b.texel",
        2,
        "a.obj: all of it is transparent or cut away: nothing is left",
    );
}
