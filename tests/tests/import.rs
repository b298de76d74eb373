//! Reading meshes: what good files hold, and what bad ones are told.
//!
//! Longer than most files here: one test a kind of file and a kind of fault.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3, vec3};
use pelage::geom::Mesh;
use pelage::import::{Fault, ImportError, ImportOptions, Imported, Limits, Place, Up, import};
use pelage::tracer::Light;
use proptest::prelude::*;

/// A folder with files in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).expect("a file");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn import(&self, name: &str) -> Result<Imported, ImportError> {
        import(&self.path(name), &ImportOptions::default())
    }
}

fn obj(text: &str) -> Result<Imported, ImportError> {
    Folder::new(&[("a.obj", text.as_bytes())]).import("a.obj")
}

fn gltf(json: &str) -> Result<Imported, ImportError> {
    Folder::new(&[("a.gltf", json.as_bytes())]).import("a.gltf")
}

fn stage() -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/stage.glb")).expect("the asset")
}

/// A triangle in a data URI: positions (0,0,0), (1,0,0), (0,1,0), then indices 0, 1, 2 as bytes.
const TRIANGLE: &str = "data:application/octet-stream;base64,\
AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC";

/// A glTF file with that triangle as mesh 0, and `nodes` as its nodes; `more` goes into its root.
fn triangle_scene(nodes: &str, more: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},{more}"nodes":{nodes},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":3}}],
        "buffers":[{{"byteLength":39,"uri":"{TRIANGLE}"}}]}}"#
    )
}

/// Six times the volume enclosed, positive where faces wind counter-clockwise seen from outside.
fn signed_volume(mesh: &Mesh) -> f32 {
    let p = |i: u32| mesh.positions[i as usize];
    let of = |c: &[u32]| (1..c.len() - 1).map(|k| p(c[0]).dot(p(c[k]).cross(p(c[k + 1])))).sum::<f32>();
    mesh.faces.iter().map(|f| of(f.corners())).sum()
}

const CUBE: &str = "\
o Cube
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f -8 -4 -1 -5
";

#[test]
fn obj_quads_stay_quads() {
    let cube = obj(CUBE).expect("a cube");
    let [mesh] = &cube.meshes[..] else { panic!("one mesh") };
    assert_eq!((mesh.name.as_str(), mesh.positions.len(), mesh.faces.len()), ("Cube", 8, 6));
    assert!(mesh.faces.iter().all(|f| f.is_quad()));
    // A unit cube, all of it facing outwards.
    assert_eq!(signed_volume(mesh), 6.0);
    assert!(cube.warnings.is_empty(), "{:?}", cube.warnings);
}

#[test]
fn obj_axes_and_units() {
    let folder = Folder::new(&[("a.obj", b"v 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3")]);
    let options = ImportOptions { up: Up::Z, unit: 0.01, ..ImportOptions::default() };
    let mesh = &import(&folder.path("a.obj"), &options).expect("a triangle").meshes[0];
    // (x, y, z) with z upwards is (x, z, −y) with y upwards.
    assert_eq!(mesh.positions[0], vec3(1.0, 3.0, -2.0) * 0.01);
}

#[test]
fn obj_welds_by_position_and_keeps_corners_apart() {
    // Two triangles that repeat their common edge, with different texture coordinates there.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 0.25 0.5\n\
                f 1/1 2/1 3/1\nf 4/2 5/2 6/2\n";
    let mesh = &obj(text).expect("two triangles").meshes[0];
    assert_eq!(mesh.positions.len(), 4);
    let uvs = mesh.uvs.as_ref().expect("texture coordinates");
    assert_eq!((uvs[0][1], uvs[1][0]), (Vec2::ZERO, Vec2::new(0.25, 0.5)));
}

#[test]
fn obj_materials_and_their_textures() {
    let mut png = std::io::Cursor::new(Vec::new());
    // Grey 188 is 0.5029 in linear light.
    image::RgbImage::from_pixel(2, 2, image::Rgb([188; 3]))
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("a PNG");
    let mtl = "newmtl red fur\nKd 0.5\nPr 0.25\nKe 1 2 3\nmap_Kd -s 2 3 1 -o 0.5 0 0 -clamp on my tex.png\n\
               newmtl lost\nmap_Kd missing.png\n";
    let text = "mtllib my mats.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 1\nusemtl red fur\nf 1/1 2/1 3/1\n";
    let folder = Folder::new(&[
        ("a.obj", text.as_bytes()),
        ("my mats.mtl", mtl.as_bytes()),
        ("my tex.png", png.get_ref()),
    ]);
    let scene = folder.import("a.obj").expect("a triangle");
    let material = &scene.materials[scene.meshes[0].faces[0].material.0 as usize];
    assert_eq!((material.name.as_str(), material.base_color), ("red fur", Vec3::splat(0.5)));
    assert_eq!((material.roughness, material.emissive), (0.25, vec3(1.0, 2.0, 3.0)));
    let texture = &scene.textures[material.base_color_texture.expect("a texture").0 as usize];
    assert!((texture.mean().x - 0.5029).abs() < 1e-3, "{}", texture.mean());
    // (0.5, 1) · (2, 3) + (0.5, 0).
    assert_eq!(scene.meshes[0].uvs.as_ref().expect("uvs")[0][0], Vec2::new(1.5, 3.0));
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(warning.place, Place::Line(7));
    assert!(warning.message.contains("missing.png"));
}

#[test]
fn obj_says_what_it_left_out() {
    let text = "# p\nv 0 0 0\nv 1 0 0 # x\nv 2 1 0\nv 1 2 0\nv 0 1 0\nusemtl none\n\
                f 1 2 \\\n 3 4 5\nl 1 2\nl 2 3\n";
    let scene = obj(text).expect("a pentagon");
    assert_eq!(scene.meshes[0].faces.len(), 3);
    let places: Vec<_> = scene.warnings.iter().map(|w| w.place.clone()).collect();
    assert_eq!(places, [Place::Line(7), Place::Line(8), Place::Line(10)], "{:?}", scene.warnings);
}

#[test]
fn obj_errors_name_the_line() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases: [(&str, usize, &str); 12] = [
        ("v nan 0 0", 4, "`nan` is not a usable number"),
        ("v 1e39 0 0", 4, "not a usable number"),
        ("v 1 2", 4, "expected 3 numbers, found 2"),
        ("v 1 two 3", 4, "`two` is not a usable number"),
        ("\nf 1 2 4", 5, "vertex 4 does not exist: there are 3"),
        ("f 1 2 0", 4, "vertex 0 does not exist"),
        ("f 1 2 -4", 4, "vertex -4 does not exist"),
        ("f 1/1 2/1 3/1", 4, "texture coordinate 1 does not exist: there are 0"),
        ("f 1//1 2//1 3//1", 4, "normal 1 does not exist"),
        ("f 1 2", 4, "a face needs three corners"),
        ("f 1 2 x", 4, "`x` is not a usable number"),
        ("f 1 2 99999999999999999999", 4, "not a usable number"),
    ];
    for (line, number, message) in cases {
        let error = obj(&format!("{head}{line}\n")).expect_err(line);
        assert_eq!(error.place, Place::Line(number), "{line}");
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    assert!(matches!(obj("").expect_err("empty").fault, Fault::NoFaces));
    assert!(matches!(obj("v 0 0 0\n").expect_err("no faces").fault, Fault::NoFaces));
}

#[test]
fn obj_objects_materials_and_groups() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n";
    // Two objects of one name stay two; the changes of material within them cut nothing, and neither does `g`.
    let text = format!(
        "mtllib m.mtl\n{vertices}o A\nusemtl\tred\nf 1 2 3\ng part\nusemtl blue # sky\nf 2 4 3\n\
         usemtl red\nf 1 4 2\no empty\no A\nf 1 2 3\no\nusemtl\nf 1 3 4\n"
    );
    let mtl = b"Kd 9 9\nnewmtl\tred\nKd 1 0 0\nnewmtl blue # sky\nKd 0 0 1\n";
    let folder = Folder::new(&[("a.obj", text.as_bytes()), ("m.mtl", mtl)]);
    let scene = folder.import("a.obj").expect("three objects");
    let colours = |mesh: &Mesh| {
        mesh.faces.iter().map(|f| scene.materials[f.material.0 as usize].base_color).collect::<Vec<_>>()
    };
    let found: Vec<_> = scene.meshes.iter().map(|m| (m.name.as_str(), colours(m))).collect();
    let grey = Vec3::splat(0.8);
    assert_eq!(found, [("A", vec![Vec3::X, Vec3::Z, Vec3::X]), ("A", vec![Vec3::X]), ("", vec![grey])]);
    assert_eq!(scene.meshes[0].positions.len(), 4);
    // Without any `o`, groups are the meshes.
    let groups = obj(&format!("{vertices}f 1 2 3\ng b\nf 2 4 3\ng b\nf 1 2 4\n")).expect("three groups");
    assert_eq!(groups.meshes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["", "b", "b"]);
}

#[test]
fn obj_corners_without_attributes_borrow_none() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nvn 0 0 2\n\
                o bare\nf 1 2 3\no whole\nf 1/1/1 2/-1/-1 3/1/1\no some\nf 1/1/1 2/1/1 3/1/1\nf 1/1 2 3//1\n";
    let scene = obj(text).expect("triangles");
    let [bare, whole, some] = &scene.meshes[..] else { panic!("three meshes") };
    assert_eq!((&bare.uvs, &bare.normals, &some.uvs, &some.normals), (&None, &None, &None, &None));
    assert_eq!(whole.uvs.as_ref().expect("uvs")[0][..3], [Vec2::new(0.5, 0.0); 3]);
    assert_eq!(whole.normals.as_ref().expect("normals")[0][..3], [Vec3::Z; 3]);
    // Texture coordinates and normals, of the last one alone.
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings.iter().all(|w| w.message.starts_with("mesh `some`")));
}

/// A library for the triangle of `with_library`.
fn with_library(mtl: &[u8]) -> Folder {
    let text = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    Folder::new(&[("a.obj", text), ("m.mtl", mtl)])
}

#[test]
fn mtl_lines_are_completed_or_named() {
    let colour = |line: &str| {
        let folder = with_library(format!("newmtl m\n{line}\n").as_bytes());
        folder.import("a.obj").map(|scene| scene.materials[0].base_color)
    };
    for (line, expected) in [
        ("Kd 0.5", vec3(0.5, 0.5, 0.5)),
        ("Kd 0.5 0.25", vec3(0.5, 0.25, 0.5)),
        ("Kd 0.5 0.25 -1 7", vec3(0.5, 0.25, 0.0)),
        ("Pm 0.5\nKd 1 1 1", vec3(0.5, 0.5, 0.5)),
        // What is not used cannot be wrong.
        ("Ka 1\nNi\nillum 999\nmap_Kd\nmap_bump\nnewmtl\nKd 0", vec3(0.8, 0.8, 0.8)),
    ] {
        assert_eq!(colour(line).expect(line), expected, "{line}");
    }
    for (line, reason) in [
        ("Kd", "`` is not a usable number"),
        ("Kd 1 x 1", "`x` is not a usable number"),
        ("Ke 1 1 inf", "`inf` is not a usable number"),
        ("d x", "`x` is not a usable number"),
        ("Ns nan", "`nan` is not a usable number"),
        ("Pr 1e39", "`1e39` is not a usable number"),
    ] {
        let error = colour(line).expect_err(line);
        assert_eq!(error.place, Place::Line(1));
        let message = error.to_string();
        assert!(message.ends_with(&format!("m.mtl:2: {reason}")), "{message}");
    }
}

#[test]
fn obj_stays_in_its_folder() {
    let inner = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let folder = Folder::new(&[("secret.mtl", b"newmtl m\nKd 1 0 0\n")]);
    fs::create_dir(folder.path("scene")).expect("a folder");
    for reference in ["../secret.mtl", "/dev/zero", "/etc/passwd", "..\\secret.mtl", "nothing.mtl"] {
        fs::write(folder.path("scene/a.obj"), format!("mtllib {reference}\n{inner}")).expect("a file");
        let scene = folder.import("scene/a.obj").expect("a picture without its colours");
        assert_eq!(scene.warnings[0].place, Place::Line(1), "{reference}");
        assert_eq!(scene.materials[0].base_color, Vec3::splat(0.8), "{reference}");
    }
    // Allowed when asked for.
    fs::write(folder.path("scene/a.obj"), format!("mtllib ../secret.mtl\n{inner}")).expect("a file");
    let options = ImportOptions { allow_dirs: vec![folder.path(".")], ..ImportOptions::default() };
    let scene = import(&folder.path("scene/a.obj"), &options).expect("a picture");
    assert_eq!(scene.materials[0].base_color, Vec3::X);
}

#[cfg(unix)]
#[test]
fn links_out_of_the_folder_and_devices_are_not_read() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new(&[("outside.mtl", b"newmtl m\nKd 1 0 0\n")]);
    fs::create_dir(folder.path("scene")).expect("a folder");
    let text = "mtllib link.mtl\nmtllib zero.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.path("scene/a.obj"), text).expect("a file");
    symlink(folder.path("outside.mtl"), folder.path("scene/link.mtl")).expect("a link");
    symlink("/dev/zero", folder.path("scene/zero.mtl")).expect("a link");
    let scene = folder.import("scene/a.obj").expect("a picture without its colours");
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    // The scene itself must be a file too, however it is called.
    symlink("/dev/zero", folder.path("zero.obj")).expect("a link");
    assert!(matches!(folder.import("zero.obj").expect_err("a device").fault, Fault::NotRegular));
}

#[test]
fn what_is_no_scene_file() {
    let folder = Folder::new(&[("a.fbx", b""), ("noext", b"")]);
    fs::create_dir(folder.path("folder.obj")).expect("a folder");
    assert!(matches!(folder.import("a.fbx").expect_err("fbx").fault, Fault::Extension { .. }));
    assert!(matches!(folder.import("noext").expect_err("nothing").fault, Fault::Extension { .. }));
    assert!(matches!(folder.import("folder.obj").expect_err("a folder").fault, Fault::NotRegular));
    assert!(matches!(folder.import("missing.obj").expect_err("missing").fault, Fault::Io(_)));
}

#[test]
fn caps_are_named() {
    let folder = Folder::new(&[("a.obj", CUBE.as_bytes()), ("a.glb", &stage())]);
    let limited = |name: &str, limits: Limits| {
        let options = ImportOptions { limits, ..ImportOptions::default() };
        import(&folder.path(name), &options).expect_err("a cap").to_string()
    };
    let all = Limits::default();
    let message = limited("a.obj", Limits { faces: 4, ..all });
    assert!(message.ends_with(":14: faces: 5 is over the limit of 4"), "{message}");
    assert!(limited("a.obj", Limits { file_bytes: 20, ..all }).contains("over the limit of 20"));
    assert!(
        limited("a.glb", Limits { image_pixels: 255, ..all }).contains("images[0]: pixels of the image: 256")
    );
    assert!(limited("a.glb", Limits { nodes: 5, ..all }).contains("nodes: nodes: 6 is over the limit of 5"));
    assert!(limited("a.glb", Limits { faces: 9, ..all }).contains("faces: 10 is over the limit of 9"));
    // The floor has 4 · 3 + 4 · 2 + 6 numbers, the wedge 4 · 3 + 12, twice.
    assert!(limited("a.glb", Limits { numbers: 73, ..all }).contains("numbers in accessors: 74"));
}

#[test]
fn glb_with_everything() {
    let scene = Folder::new(&[("stage.glb", &stage())]).import("stage.glb").expect("the asset");
    let names: Vec<_> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["Floor", "Wedge", "Mirrored"]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);

    // The wedge has the volume 0.4 · 0.4 · 0.6 / 6 = 0.016, and so has its mirror image, still facing outwards.
    for (mesh, at) in [(&scene.meshes[1], 0.1), (&scene.meshes[2], -0.1)] {
        assert!((signed_volume(mesh) / 6.0 - 0.016).abs() < 1e-6, "{}", mesh.name);
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.positions[0], vec3(at, 0.0, 0.0));
    }
    let [lo, hi] = scene.meshes[2].bounds().expect("vertices");
    assert!((lo - vec3(-0.5, 0.0, 0.0)).length() < 1e-6 && (hi - vec3(-0.1, 0.6, 0.4)).length() < 1e-6);

    // The first pixel of the image is light; it is at u = 0 and the top of v, here v = 1 after four repetitions
    // of the file's v = 0 downwards.
    let texture = &scene.textures[scene.materials[0].base_color_texture.expect("a texture").0 as usize];
    assert_eq!(texture.size(), [16, 16]);
    let uvs = scene.meshes[0].uvs.as_ref().expect("texture coordinates")[0];
    assert_eq!(uvs[0], Vec2::new(0.0, 1.0 - 4.0));
    // sRGB 230 is 0.7913 in linear light, sRGB 60 is 0.0452.
    assert!((texture.sample(Vec2::new(0.25, 0.75), 0.0).x - 0.7913).abs() < 1e-3);
    assert!((texture.sample(Vec2::new(0.75, 0.75), 0.0).x - 0.0452).abs() < 1e-3);
    assert_eq!(scene.materials[1].name, "Clay");
    assert_eq!(scene.materials[1].roughness, 0.5);

    let [(name, camera)] = &scene.cameras[..] else { panic!("one camera") };
    assert_eq!((name.as_str(), camera.position, camera.vertical_fov), ("View", vec3(0.0, 1.2, 3.0), 0.7));
    // Turned by −20° about x: it looks down by 20°.
    assert!((camera.forward().y + 20_f32.to_radians().sin()).abs() < 1e-4, "{}", camera.forward());

    let [Light::Directional { direction, illuminance, .. }, Light::Point { position, intensity, .. }] =
        scene.lights[..]
    else {
        panic!("{:?}", scene.lights)
    };
    // Turned by −60° about x from −z: down by sin 60°.
    assert!((direction - vec3(0.0, -0.866_025, -0.5)).length() < 1e-5, "{direction}");
    assert!((illuminance - 3.0 * vec3(1.0, 0.9, 0.8)).length() < 1e-6);
    assert_eq!((position, intensity), (Vec3::ONE, 2.0 * vec3(0.5, 0.7, 1.0)));
}

#[test]
fn gltf_nodes_multiply() {
    let nodes = r#"[{"translation":[10,0,0],"children":[1]},{"scale":[2,2,2],"mesh":0,"name":"T"}]"#;
    let scene = gltf(&triangle_scene(nodes, "")).expect("a triangle");
    assert_eq!(scene.meshes[0].positions, [vec3(10.0, 0.0, 0.0), vec3(12.0, 0.0, 0.0), vec3(10.0, 2.0, 0.0)]);
    assert_eq!(scene.meshes[0].name, "T");
    // Without a material: a light grey.
    assert_eq!(scene.materials[scene.meshes[0].faces[0].material.0 as usize].base_color, Vec3::splat(0.8));
}

#[test]
fn gltf_skin_at_rest() {
    // All vertices hang on joint 1 alone, which stands at (5, 0, 0) and was bound at (1, 0, 0): everything moves
    // by (4, 0, 0), and the mesh's own node does not count. Weights of 2 are brought back to 1.
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let mut bin = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    bin.extend([1_u8, 0, 0, 0].repeat(3));
    bin.extend(floats(&[2., 0., 0., 0.].repeat(3)));
    let mut bind = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    bind.extend(glam::Mat4::from_translation(vec3(-1.0, 0.0, 0.0)).to_cols_array());
    bin.extend(floats(&bind));
    let json = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
        "nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},{"children":[2]},{"translation":[5,0,0]}],
        "skins":[{"joints":[1,2],"inverseBindMatrices":3}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
            {"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"},
            {"bufferView":3,"componentType":5126,"count":2,"type":"MAT4"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},
            {"buffer":0,"byteOffset":48,"byteLength":48},{"buffer":0,"byteOffset":96,"byteLength":128}],
        "buffers":[{"byteLength":224,"uri":"a%20b.bin"}]}"#;
    let scene =
        Folder::new(&[("a.gltf", json.as_bytes()), ("a b.bin", &bin)]).import("a.gltf").expect("a triangle");
    assert_eq!(scene.meshes[0].positions, [vec3(4.0, 0.0, 0.0), vec3(5.0, 0.0, 0.0), vec3(4.0, 1.0, 0.0)]);
}

#[test]
fn gltf_errors_name_the_field() {
    let good = r#"[{"mesh":0}]"#;
    let file = |nodes: &str, more: &str| triangle_scene(nodes, more);
    let with = |from: &str, to: &str| {
        let text = triangle_scene(good, "");
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let deep: String = (1..1100).map(|i| format!("{{\"children\":[{i}]}},")).collect();
    let cases = [
        (
            file(good, r#""extensionsRequired":["KHR_draco_mesh_compression"],"#),
            "extensionsRequired: requires the glTF extension `KHR_draco_mesh_compression`",
        ),
        (file(r#"[{"mesh":7}]"#, ""), "nodes[0]: mesh 7 does not exist: there are 1"),
        (
            file(
                r#"[{"children":[1]},{"children":[2],"mesh":0},{"children":[1]}]"#,
                r#""scenes":[{"nodes":[0]}],"#,
            ),
            "nodes[1]: has two parents, or is its own ancestor",
        ),
        (file(r#"[{"children":[5]}]"#, ""), "nodes: node 5 does not exist"),
        (
            file(&format!("[{deep}{{\"mesh\":0}}]"), r#""scenes":[{"nodes":[0]}],"#),
            "depth of the nodes: 1025 is over the limit of 1024",
        ),
        (
            file(r#"[{"mesh":0,"scale":[1e300,1,1]}]"#, ""),
            "nodes[0]: `the node's transform` is not a usable number",
        ),
        (file(good, r#""scene":3,"#), "scene: scene 3 does not exist"),
        (
            with(r#""count":3,"type":"VEC3""#, r#""count":4,"type":"VEC3""#),
            "accessors[0]: reaches beyond the end of its buffer view",
        ),
        (
            with(r#""count":3,"type":"VEC3""#, r#""count":3,"type":"VEC2""#),
            "accessors[0]: has 2 components where 3 are needed",
        ),
        (
            with(r#""count":3,"type":"VEC3""#, r#""count":9000000000000000000,"type":"VEC3""#),
            "accessors[0]: numbers in accessors: 18446744073709551615 is over the limit",
        ),
        (
            with(
                r#""count":3,"type":"SCALAR""#,
                r#""count":3,"byteOffset":18446744073709551615,"type":"SCALAR""#,
            ),
            "accessors[1]: reaches beyond",
        ),
        (
            with(r#""byteLength":36}"#, r#""byteLength":99}"#),
            "bufferViews[0]: reaches beyond the end of its buffer",
        ),
        (
            with(r#""buffer":0,"byteLength":36"#, r#""buffer":1,"byteLength":36"#),
            "bufferViews[0]: buffer 1 does not exist",
        ),
        (
            with(r#"{"byteLength":39"#, r#"{"byteLength":40"#),
            "buffers[0]: holds 39 bytes of the 40 it claims",
        ),
        (with("AAEC\"", "AAED\""), "meshes[0].primitives[0]: vertex 3 does not exist: there are 3"),
        (with("base64,AAAA", "base64,AADAf"), "buffers[0]"),
        (with("base64,AAAAAAAA", "base64,AADAfwAA"), "meshes[0].primitives[0]: `[NaN"),
        (
            with(r#""uri":"data:"#, r#""uri":"file:///etc/passwd","x":"data:"#),
            "buffers[0]: refers to `file:///etc/passwd`, which is outside",
        ),
        (
            with(r#""uri":"data:"#, r#""uri":"../up.bin","x":"data:"#),
            "buffers[0]: refers to `../up.bin`, which is outside",
        ),
        (
            with(r#""uri":"data:"#, r#""uri":"/dev/zero","x":"data:"#),
            "buffers[0]: refers to `/dev/zero`, which is outside",
        ),
        (with(r#""uri":"data:"#, r#""uri":"gone.bin","x":"data:"#), "buffers[0]: cannot be read"),
        (with(r#""POSITION":0"#, r#""POSITION":9"#), "accessor: accessor 9 does not exist"),
        (with(r#""asset""#, r#""#), ":1: the JSON cannot be read"),
    ];
    for (text, message) in cases {
        let error = gltf(&text).expect_err(message).to_string();
        assert!(error.contains(message), "{error}\nshould say: {message}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    assert!(gltf(&triangle_scene(good, "")).is_ok());
}

#[test]
fn gltf_leaves_out_what_it_names() {
    let text = triangle_scene(
        r#"[{"mesh":0}]"#,
        r#""extensionsUsed":["VENDOR_sparkle"],"materials":[{"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"gone.png"}],"#,
    );
    let text = text
        .replace(r#""indices":1}"#, r#""indices":1,"material":0},{"attributes":{"POSITION":0},"mode":1}"#);
    let scene = gltf(&text).expect("a triangle");
    let said: Vec<_> = scene.warnings.iter().map(ToString::to_string).collect();
    for part in [
        "`VENDOR_sparkle` is not supported",
        "images[0]: the texture is left out",
        "points and lines are left out",
    ] {
        assert!(said.iter().any(|s| s.contains(part)), "{said:?}");
    }
    assert_eq!(said.len(), 3, "{said:?}");
    assert_eq!(scene.meshes[0].faces.len(), 1);
}

#[test]
fn an_image_that_claims_too_much_is_refused_before_it_is_decoded() {
    // A PNG header of 60000 × 60000 pixels and nothing else.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    let header = [0_u8, 0, 0xea, 0x60, 0, 0, 0xea, 0x60, 8, 2, 0, 0, 0];
    png.extend(header);
    png.extend(crc32(b"IHDR", &header).to_be_bytes());
    png.extend([0; 4]);
    png.extend(b"IDAT");
    png.extend(crc32(b"IDAT", &[]).to_be_bytes());
    let text = triangle_scene(
        r#"[{"mesh":0}]"#,
        r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"bomb.png"}],"#,
    );
    let folder = Folder::new(&[("a.gltf", text.as_bytes()), ("bomb.png", &png)]);
    let error = folder.import("a.gltf").expect_err("a bomb");
    assert!(
        error.to_string().contains("images[0]: pixels of the image: 3600000000 is over the limit"),
        "{error}"
    );
}

/// CRC-32 as PNG has it.
fn crc32(kind: &[u8], data: &[u8]) -> u32 {
    !kind.iter().chain(data).fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    })
}

/// Imports bytes as a file of this name: any outcome but a panic or a long wait.
fn survives(folder: &Folder, name: &str, bytes: &[u8]) {
    fs::write(folder.path(name), bytes).expect("a file");
    let begun = Instant::now();
    if let Err(error) = folder.import(name) {
        let message = error.to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert!(begun.elapsed() < Duration::from_secs(5), "{name} of {} bytes", bytes.len());
}

/// A line of each kind that a library may have.
const MTL: &str = "\
newmtl m
Ka 1 1 1
Kd 0.5 0.5 0.5
Ks 0 0 0
Ke 0 0 0
Ns 10
Ni 1.5
d 1
illum 2
Pr 0.5
Pm 0.1
map_Kd -s 1 1 1 -clamp on no.png
bump -bm 1 no.png
";

/// Imports the triangle of `with_library` with these bytes as its library.
fn survives_library(folder: &Folder, bytes: &[u8]) {
    fs::write(folder.path("m.mtl"), bytes).expect("a file");
    let text = fs::read(folder.path("a.obj")).expect("a file");
    survives(folder, "a.obj", &text);
}

#[test]
fn truncated_files() {
    let folder = Folder::new(&[]);
    let glb = stage();
    for length in (0..glb.len()).step_by(64) {
        survives(&folder, "cut.glb", &glb[..length]);
    }
    let json = triangle_scene(r#"[{"mesh":0}]"#, "");
    for length in (0..json.len()).step_by(16) {
        survives(&folder, "cut.gltf", &json.as_bytes()[..length]);
    }
    for length in 0..CUBE.len() {
        survives(&folder, "cut.obj", &CUBE.as_bytes()[..length]);
    }
    let folder = with_library(&[]);
    for length in 0..MTL.len() {
        survives_library(&folder, &MTL.as_bytes()[..length]);
    }
}

#[test]
fn flipped_bits() {
    let folder = Folder::new(&[]);
    let glb = stage();
    // 2048 places spread over the whole file by the golden ratio, a different bit each.
    for i in 0..2048_usize {
        let mut bytes = glb.clone();
        let place = (i as f64 * 0.618_033_988_75).fract() * bytes.len() as f64;
        bytes[place as usize] ^= 1 << (i % 8);
        survives(&folder, "flip.glb", &bytes);
    }
    for i in 0..CUBE.len() * 8 {
        let mut bytes = CUBE.as_bytes().to_vec();
        bytes[i / 8] ^= 1 << (i % 8);
        survives(&folder, "flip.obj", &bytes);
    }
    let folder = with_library(&[]);
    for i in 0..MTL.len() * 8 {
        let mut bytes = MTL.as_bytes().to_vec();
        bytes[i / 8] ^= 1 << (i % 8);
        survives_library(&folder, &bytes);
    }
}

const WORDS: &[&str] = &[
    "v",
    "\nvt",
    "\nvn",
    "\nf",
    "\nf 1 2 3",
    "\nf 1 2 3 1 2",
    "\no",
    "\ng",
    "\nusemtl",
    "\nmtllib",
    "\nnewmtl",
    "\nKd",
    "\nKe",
    "\nNs",
    "\nPr",
    "\nPm",
    "\nmap_Kd",
    "\nl",
    "\np",
    "\n#",
    "\n",
    "\\\n",
    " ",
    "\t",
    "\r",
    " 1",
    " 2",
    " 3",
    " -1",
    " 0",
    " 1/1",
    " 1//1",
    " 1/1/1",
    " 1/1/1/1",
    " /",
    " -9223372036854775808",
    " 1e38",
    " nan",
    " a",
    " -s",
    " m.mtl",
    "\u{a0}",
    "é",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let folder = Folder::new(&[]);
        survives(&folder, "r.obj", &bytes);
        survives_library(&with_library(&[]), &bytes);
        survives(&folder, "r.gltf", &bytes);
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend(&bytes);
        survives(&folder, "r.glb", &glb);
    }

    /// The words of OBJ and MTL files in any order: what the readers take apart, rather than what they skip.
    #[test]
    fn random_statements(words in proptest::collection::vec(proptest::sample::select(WORDS), 0..80)) {
        let text = words.concat();
        survives(&Folder::new(&[]), "r.obj", text.as_bytes());
        survives_library(&with_library(&[]), text.as_bytes());
        // After this head, some of the faces are good ones.
        let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
        survives(&with_library(text.as_bytes()), "r.obj", format!("mtllib m.mtl\n{head}{text}").as_bytes());
    }

    /// Numbers in the JSON replaced by others, as a fuzzer that knows the structure does.
    #[test]
    fn random_numbers_in_the_json(
        which in any::<proptest::sample::Index>(),
        number in prop_oneof![Just("-1"), Just("0"), Just("1"), Just("65535"), Just("4294967295"), Just("1e38"), Just("18446744073709551615")],
    ) {
        let glb = stage();
        let length = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
        let text = String::from_utf8(glb[20..20 + length].to_vec()).expect("JSON");
        let digits: Vec<usize> = text.char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(i, _)| i).collect();
        let at = digits[which.index(digits.len())];
        let changed = format!("{}{number}{}", &text[..at], &text[at + 1..]);
        let mut bytes = glb[..12].to_vec();
        bytes.extend((changed.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(changed.as_bytes());
        bytes.extend(&glb[20 + length..]);
        let total = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&total.to_le_bytes());
        survives(&Folder::new(&[]), "n.glb", &bytes);
    }
}
