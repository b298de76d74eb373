//! Models to texels: what their materials, textures and lines become, measured.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{IVec3, Vec2, Vec3, Vec4, vec3};
use pelage::bake::{BakeFault, Content, ContentOptions, Fit, content, read};
use pelage::geom::{Alpha, AlphaMode, Face, Material, MaterialId, Mesh, Texture, TextureId, evenly};
use pelage::import::{Imported, Strand, Up};
use pelage::texel::{BuildOptions, Texel, build};

/// A horizontal quad over the unit square at half height, u along s and v along t; texture 0 is its colour, texture
/// 1 its alpha.
fn quad(material: Material, textures: Vec<Texture>) -> Imported {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
    let mesh = Mesh {
        name: "quad".into(),
        positions: corners.map(|p| p.extend(0.5)).to_vec(),
        faces: vec![Face::quad([0, 1, 2, 3], MaterialId(0))],
        uvs: Some(vec![corners]),
        ..Mesh::default()
    };
    Imported { meshes: vec![mesh], materials: vec![material], textures, ..Imported::default() }
}

/// A square texture of the unit square's colours.
fn painted(side: usize, color: impl Fn(Vec2) -> Vec3) -> Texture {
    let pixel = |i: usize| {
        color(Vec2::new((i % side) as f32 + 0.5, side as f32 - 0.5 - (i / side) as f32) / side as f32)
    };
    Texture::new(side, side, (0..side * side).map(pixel).collect()).expect("a square")
}

/// Kept where it is, +Z up, for 64 voxels a side.
fn kept() -> ContentOptions {
    ContentOptions { up: Up::Z, fit: Fit::Keep, resolution: 64, ..ContentOptions::default() }
}

fn baked(model: &Imported, options: &ContentOptions) -> Content {
    content(Path::new("model"), model, options, &|_| ()).expect("content")
}

fn fault(model: &Imported, options: &ContentOptions) -> BakeFault {
    content(Path::new("model"), model, options, &|_| ()).expect_err("a fault").fault
}

fn area(content: &Content) -> f64 {
    let area = |[a, b, c]: &[Vec3; 3]| f64::from(0.5 * (b - a).cross(c - a).length());
    content.geometry.triangles.iter().map(area).sum()
}

fn built(content: Content, periodic: bool) -> Texel {
    let options = BuildOptions { depth: 6, periodic, ..BuildOptions::preview() };
    build("model", content.geometry, &options, &|_| ()).expect("a texel")
}

/// The part of the floor over which vertical sightlines are stopped by a level, of that where `inside` holds.
fn coverage(texel: &Texel, level: u32, inside: impl Fn(Vec2) -> bool) -> f64 {
    let level = texel.level(level);
    let size = level.resolution() as f32;
    const POINTS: usize = 40_000;
    let point = |i: usize| evenly(i).as_vec2();
    let mut stopped = 0.0;
    for at in (0..POINTS).map(point).filter(|&p| inside(p)) {
        stopped += f64::from(1.0 - level.transmittance((at * size).extend(size), (at * size).extend(0.0)));
    }
    stopped / POINTS as f64
}

#[test]
fn a_mask_cuts_a_disc() {
    // A disc of diameter 0.8, 1 inside and 0 outside: π/4 · 0.8² = 0.5027 of the square.
    let disc = painted(256, |p| Vec3::splat(if p.distance(Vec2::splat(0.5)) < 0.4 { 1.0 } else { 0.0 }));
    let alpha = Alpha { mode: AlphaMode::Mask(0.5), factor: 1.0, texture: Some(TextureId(0)) };
    let model = quad(Material { alpha, ..Material::default() }, vec![disc]);
    let content = baked(&model, &kept());
    let disc = std::f64::consts::FRAC_PI_4 * 0.64;
    println!("area {:.4}, disc {disc:.4}", area(&content));
    assert!((area(&content) / disc - 1.0).abs() < 0.01);
    let texel = built(content, false);
    for level in [6, 4, 2] {
        let covered = coverage(&texel, level, |_| true);
        println!("level {level}: {covered:.4}");
        assert!((covered / disc - 1.0).abs() < 0.01, "level {level}: {covered}");
    }
}

#[test]
fn a_blend_thins() {
    // Alpha 0.3 on the left, 0.9 on the right; vertex alpha ½ for all.
    let ramp = painted(64, |p| Vec3::splat(if p.x < 0.5 { 0.6 } else { 1.0 }));
    let alpha = Alpha { mode: AlphaMode::Blend, factor: 1.0, texture: Some(TextureId(0)) };
    let mut model = quad(Material { alpha, ..Material::default() }, vec![ramp]);
    model.meshes[0].colors = Some(vec![[Vec4::new(1.0, 1.0, 1.0, 0.5); 4]]);
    let content = baked(&model, &kept());
    // (0.3 + 0.5)/2 of the square, pixel interpolation between the halves being symmetric.
    assert!((area(&content) - 0.4).abs() < 0.004, "{}", area(&content));
    let texel = built(content, false);
    for level in [6, 3] {
        let [left, right] = [coverage(&texel, level, |p| p.x < 0.5), coverage(&texel, level, |p| p.x >= 0.5)];
        println!("level {level}: {left:.4} {right:.4}");
        assert!((left - 0.15).abs() < 0.005 && (right - 0.25).abs() < 0.005, "level {level}: {left} {right}");
    }
}

#[test]
fn colours_follow_a_checker() {
    // Two by two pixels' worth of colours, in blocks so large that interpolation blurs little.
    let checker = |p: Vec2| match (p.x < 0.5, p.y < 0.5) {
        (true, true) => Vec3::X,
        (false, true) => Vec3::Y,
        (true, false) => Vec3::Z,
        (false, false) => Vec3::ONE,
    };
    let material = Material {
        base_color: Vec3::new(1.0, 0.5, 0.25),
        base_color_texture: Some(TextureId(0)),
        ..Material::default()
    };
    let base = material.base_color;
    let model = quad(material, vec![painted(256, checker)]);
    let content = baked(&model, &kept());
    println!("{} triangles", content.geometry.triangles.len());
    // Even parts are not cut further: far fewer than the 64² voxels of the sheet.
    assert!(content.geometry.triangles.len() < 2500);
    assert!((area(&content) - 1.0).abs() < 1e-5);
    // Texture coordinates repeat at the borders, where the colours meet as well.
    let near_seam =
        |p: Vec2| p.to_array().iter().any(|x| [0.0, 0.5, 1.0].iter().any(|s| (x - s).abs() < 0.03));
    for (corners, color) in content.geometry.triangles.iter().zip(&content.geometry.colors) {
        let middle = (corners[0] + corners[1] + corners[2]).truncate() / 3.0;
        if !near_seam(middle) {
            assert!((*color - base * checker(middle)).length() < 1e-4, "{middle}: {color}");
        }
    }
    let texel = built(content, false);
    let level = texel.level(6);
    for cell in level.cells() {
        let middle = Vec2::new(cell[0] as f32 + 0.5, cell[1] as f32 + 0.5) / 64.0;
        let voxel = level.find(IVec3::from_array(cell.map(|c| c as i32))).expect("an occupied cell");
        let albedo = level.voxel(voxel).albedo;
        assert!(
            near_seam(middle) || (albedo - base * checker(middle)).abs().max_element() < 0.01,
            "{middle}"
        );
    }
}

#[test]
fn what_leaves_one_side_enters_the_other() {
    // Moved by a quarter in s and out of the cube in t.
    let mut model = quad(Material::default(), vec![]);
    for p in &mut model.meshes[0].positions {
        p.x = 0.25 + 0.5 * p.x + 0.5;
        p.y -= 3.0;
    }
    let tiled = baked(&model, &ContentOptions { tile: true, ..kept() });
    assert!(tiled.warnings.is_empty(), "{:?}", tiled.warnings);
    let texel = built(tiled, true);
    let [wrapped, gap] = [
        coverage(&texel, 6, |p| (p.x - 0.5).abs() > 0.25),
        coverage(&texel, 6, |p| (p.x - 0.5).abs() < 0.25),
    ];
    assert!((wrapped - 0.5).abs() < 0.005 && gap < 0.001, "{wrapped} {gap}");
    // Without wrapping none of it is inside.
    assert!(matches!(fault(&model, &kept()), BakeFault::Outside { .. }));
    model.meshes[0].positions.iter_mut().for_each(|p| p.y += 3.0);
    let cut = baked(&model, &kept());
    assert!(cut.warnings[0].message.contains("outside of the texel is cut off"), "{:?}", cut.warnings);
    let covered = coverage(&built(cut, false), 6, |_| true);
    assert!((covered - 0.25).abs() < 0.003, "{covered}");
}

#[test]
fn strands_hide_twice_their_radius() {
    // 60 strands side by side, 0.8 long, at many heights: from above 2 r L each, and none above another. The flat ends
    // add nothing from there.
    let radius = 0.003;
    let strand = |i: usize| {
        let t = 0.1 + 0.8 * i as f32 / 60.0;
        let w = 0.2 + 0.6 * (i as f32 * 0.618).fract();
        Strand { points: vec![vec3(0.1, t, w), vec3(0.5, t, w), vec3(0.9, t, w)], ..Strand::default() }
    };
    let strands: Vec<_> = (0..60).map(strand).collect();
    let model = Imported { strands, materials: vec![Material::default()], ..Imported::default() };
    let options = ContentOptions { radius: Some(radius), ..kept() };
    let expected = 60.0 * 2.0 * f64::from(radius) * 0.8;
    // The triangles' own projection: a prism shows half of what its faces do.
    let content = baked(&model, &options);
    let shown: f64 = content
        .geometry
        .triangles
        .iter()
        .map(|[a, b, c]| 0.25 * f64::from((b - a).cross(c - a).z.abs()))
        .sum();
    println!("expected {expected:.4}, triangles {shown:.4}");
    assert!((shown / expected - 1.0).abs() < 0.01);
    let texel = built(content, false);
    let covered = coverage(&texel, 6, |_| true);
    println!("level 6: {covered:.4}");
    // One matrix a voxel says what a strand hides from every side: from one of them it is known to a tenth.
    assert!((covered / expected - 1.0).abs() < 0.1, "{covered} of {expected}");
    // Tapered to a point: the mean radius is half.
    let tapered = baked(&model, &ContentOptions { tip_radius: Some(0.0), ..options });
    let shown: f64 = tapered
        .geometry
        .triangles
        .iter()
        .map(|[a, b, c]| 0.25 * f64::from((b - a).cross(c - a).z.abs()))
        .sum();
    assert!((shown / expected - 0.5).abs() < 0.01, "{shown}");
    assert_eq!(fault(&model, &kept()), BakeFault::Radius { count: 60 });
}

#[test]
fn a_model_is_scaled_into_the_cube() {
    let mut model = quad(Material::default(), vec![]);
    for p in &mut model.meshes[0].positions {
        *p = Vec3::new(40.0 * p.x - 1000.0, 10.0 * p.y, 7.0);
    }
    let bounds = |options: ContentOptions| {
        let corners = baked(&model, &options).geometry.triangles.concat();
        corners.into_iter().fold([Vec3::MAX, Vec3::MIN], |[low, high], p| [low.min(p), high.max(p)])
    };
    let close = |[a, b]: [Vec3; 2], [c, d]: [Vec3; 2]| (a - c).length() + (b - d).length() < 1e-4;
    let options = ContentOptions { up: Up::Z, margin: 0.1, resolution: 64, ..ContentOptions::default() };
    assert!(close(bounds(options.clone()), [vec3(0.1, 0.4, 0.5), vec3(0.9, 0.6, 0.5)]));
    let floor = ContentOptions { fit: Fit::Floor, ..options.clone() };
    assert!(close(bounds(floor), [vec3(0.1, 0.4, 0.0), vec3(0.9, 0.6, 0.0)]));
    // +Y up: what was deep becomes high.
    let upright = ContentOptions { up: Up::Y, ..options };
    assert!(close(bounds(upright), [vec3(0.1, 0.5, 0.4), vec3(0.9, 0.5, 0.6)]));
}

#[test]
fn what_cannot_be_baked_is_named() {
    let nothing = Alpha { mode: AlphaMode::Blend, factor: 0.0, texture: None };
    let model = quad(Material { alpha: nothing, ..Material::default() }, vec![]);
    assert_eq!(fault(&model, &kept()), BakeFault::CutAway);
    let mut point = quad(Material::default(), vec![]);
    point.meshes[0].positions = vec![Vec3::ONE; 4];
    assert_eq!(fault(&point, &ContentOptions::default()), BakeFault::NoArea);
    let mut line = quad(Material::default(), vec![]);
    line.meshes[0].positions = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::X * x).to_vec();
    assert_eq!(fault(&line, &ContentOptions::default()), BakeFault::NoArea);
    let mut far = quad(Material::default(), vec![]);
    far.meshes[0].positions.iter_mut().for_each(|p| p.x += 100.0);
    let tile = ContentOptions { tile: true, ..kept() };
    assert!(matches!(fault(&far, &tile), BakeFault::Far { distance, .. } if distance == 101.0));
    for (options, message) in [
        (ContentOptions { margin: 0.5, ..kept() }, "margin is 0.5, which is not in 0 to 0.45"),
        (ContentOptions { resolution: 1024, ..kept() }, "resolution is 1024, which is not in 2 to 512"),
        (ContentOptions { radius: Some(-1.0), ..kept() }, "radius is -1, which is not in 0 or more"),
        (
            ContentOptions { tip_radius: Some(f32::NAN), ..kept() },
            "tip_radius is NaN, which is not in 0 or more",
        ),
    ] {
        assert_eq!(fault(&far, &options).to_string(), message);
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let noise = painted(64, |p| (p.extend(0.3) * 91.7).map(|x| (x.sin() * 437.5).fract().abs()));
    let material = Material { base_color_texture: Some(TextureId(0)), ..Material::default() };
    let model = quad(material, vec![noise]);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| baked(&model, &kept()).geometry)
    };
    assert_eq!(on(1), on(3));
}

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
}

/// A picture of 2 by 1 pixels: red and opaque on the left, green and a quarter there on the right.
fn picture() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = vec![255, 0, 0, 255, 0, 255, 0, 64];
    let picture = image::RgbaImage::from_raw(2, 1, pixels).expect("two pixels");
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a picture in memory");
    bytes.into_inner()
}

#[test]
fn an_obj_with_lines_colours_and_alpha() {
    let text = b"mtllib a.mtl\n\
        v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 0 2\nv 0 1 2\nv 0 2 2\n\
        vt 0 0\nvt 1 0\nvt 1 1\n\
        usemtl leaf\nf 1/1 2/2 3/3\nusemtl twig\nl 4 5\nl -2 -1\n";
    let library = b"newmtl leaf\nKd 1 1 1\nmap_Kd a.png\nmap_d a.png\nnewmtl twig\nKd 0.5 0.25 0\nd 0.5\n";
    let folder = Folder::new(&[("a.obj", text), ("a.mtl", library), ("a.png", &picture())]);
    let model = read(&folder.path("a.obj")).expect("a leaf on a twig");
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let colors = model.meshes[0].colors.as_ref().expect("colours");
    assert_eq!(colors[0][..3], [Vec3::X, Vec3::Y, Vec3::Z].map(|c| c.extend(1.0)));
    // Two lines that share a vertex are one strand.
    let [strand] = &model.strands[..] else { panic!("{:?}", model.strands) };
    assert_eq!(strand.points, [vec3(0.0, 0.0, 2.0), vec3(0.0, 1.0, 2.0), vec3(0.0, 2.0, 2.0)]);
    let [leaf, twig] = [&model.materials[0], &model.materials[strand.material.0 as usize]];
    assert_eq!((twig.base_color, twig.alpha.factor), (vec3(0.5, 0.25, 0.0), 0.5));
    let Some(TextureId(id)) = leaf.alpha.texture else { panic!("{:?}", leaf.alpha) };
    assert!((model.textures[id as usize].pixels()[1] - 64.0 / 255.0).abs().max_element() < 1e-6);
    // The twig alone, thin enough to be told from nothing.
    let options = ContentOptions { radius: Some(0.01), resolution: 32, ..ContentOptions::default() };
    let content = content(&folder.path("a.obj"), &model, &options, &|_| ()).expect("content");
    assert!(content.geometry.colors.iter().any(|&c| c == vec3(0.5, 0.25, 0.0)));
    // As a scene it is what it was: a triangle.
    let scene = pelage::import::import(&folder.path("a.obj"), &Default::default()).expect("a triangle");
    assert!(scene.strands.is_empty() && scene.meshes[0].colors.is_none());
    assert!(scene.warnings.iter().any(|w| w.message.contains("`l` is not supported (2 times)")));
}

#[test]
fn an_obj_of_lines_alone() {
    let folder =
        Folder::new(&[("a.obj", b"v 0 0 0\nv 0 1 0\nv 1 1 0\nl 1 2 3\n"), ("b.obj", b"v 0 0 0\nl 1\n")]);
    assert_eq!(read(&folder.path("a.obj")).expect("a strand").strands[0].points.len(), 3);
    let error = read(&folder.path("b.obj")).expect_err("half a line").to_string();
    assert!(error.ends_with("b.obj:2: a line needs two vertices, this has 1"), "{error}");
    let error = pelage::import::import(&folder.path("a.obj"), &Default::default()).expect_err("no face");
    assert!(error.to_string().ends_with("holds no faces"), "{error}");
}

#[test]
fn a_gltf_with_lines_and_a_mask() {
    // Positions of a line strip of three points and of a triangle, then three radii, then colours as bytes.
    let floats: [f32; 21] = [
        0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, //
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, //
        0.1, 0.05, 0.0,
    ];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 51]);
    let json = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"scale":[2,2,2]}],
        "meshes":[{"primitives":[
            {"attributes":{"POSITION":0,"_RADIUS":2,"COLOR_0":3},"mode":3,"material":1},
            {"attributes":{"POSITION":1,"COLOR_0":3},"material":0},
            {"attributes":{"POSITION":1},"mode":0}]}],
        "materials":[
            {"name":"leaf","alphaMode":"MASK","alphaCutoff":0.25,
             "pbrMetallicRoughness":{"baseColorTexture":{"index":0},"baseColorFactor":[1,1,1,0.5],
              "metallicFactor":0,"roughnessFactor":0.5}},
            {"name":"glow","emissiveFactor":[1,0,0],"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.5}}],
        "textures":[{"source":0}],"images":[{"uri":"a.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                     {"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"},
                     {"bufferView":0,"byteOffset":72,"componentType":5126,"count":3,"type":"SCALAR"},
                     {"bufferView":0,"byteOffset":84,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}],
        "bufferViews":[{"buffer":0,"byteLength":96}],"buffers":[{"byteLength":96,"uri":"a.bin"}]}"#;
    let files: [(&str, &[u8]); 3] = [("a.gltf", json.as_bytes()), ("a.bin", &bytes), ("a.png", &picture())];
    let folder = Folder::new(&files);
    let model = read(&folder.path("a.gltf")).expect("a strand and a leaf");
    let [strand] = &model.strands[..] else { panic!("{:?}", model.strands) };
    // Twice as large: so is its thickness.
    assert_eq!(strand.points[2], vec3(0.0, 4.0, 0.0));
    assert!(strand.radii.as_ref().is_some_and(|r| (r[0] - 0.2).abs() < 1e-6 && r[2] == 0.0));
    let colors = strand.colors.as_ref().expect("colours");
    assert_eq!(colors[2], Vec4::new(0.0, 0.0, 1.0, 0.2));
    let leaf = model.materials[0].alpha;
    assert_eq!((leaf.mode, leaf.factor, leaf.texture.is_some()), (AlphaMode::Mask(0.25), 0.5, true));
    assert!(model.warnings.iter().any(|w| w.message == "points are left out"), "{:?}", model.warnings);
    let baked =
        content(&folder.path("a.gltf"), &model, &ContentOptions::default(), &|_| ()).expect("content");
    let told: Vec<&str> = baked.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(told, ["the light that `glow` gives off is left out: texels give off none"]);
}
