//! What the integration tests share: bent boxes, contents to put in them, and the same contents as explicit
//! triangles.

pub mod stage;

use std::ops::ControlFlow;
use std::sync::Arc;

use pelage::build;
use pelage::geom::glam::{Vec2, Vec3};
use pelage::geom::{Face, Material, MaterialId, Mesh};
use pelage::skin::{Anchor, Lattice, Patch, Skin};
use pelage::texel::{BuildOptions, Geometry, Texel};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Scene, Settings, render};

/// A skin of one box, between four corners below and four above (in the order A B C D, E F G H), filled by one
/// texel.
pub fn one_box(base: [Vec3; 4], top: [Vec3; 4]) -> Skin {
    let patch = Patch {
        vertices: [0, 1, 2, 3],
        face: 0,
        material: MaterialId::default(),
        lattice: Lattice::UNIT,
        anchor: Anchor::default(),
    };
    Skin { base: base.into(), top: top.into(), patches: vec![patch], ..Skin::default() }
}

/// The unit cube with its top twisted by `twist` radians about its axis and pushed aside by `shear`.
pub fn twisted_box(twist: f32, shear: Vec2) -> Skin {
    let base = [Vec3::ZERO, Vec3::X, Vec3::NEG_Z, Vec3::new(1.0, 0.0, -1.0)];
    let centre = Vec3::new(0.5, 0.0, -0.5);
    let top = base.map(|p| {
        let (d, turn) = (p - centre, Vec2::from_angle(twist));
        let turned = turn.rotate(Vec2::new(d.x, d.z));
        centre + Vec3::new(turned.x + shear.x, 1.0, turned.y + shear.y)
    });
    one_box(base, top)
}

/// Numbers in `[0, 1)` that depend on nothing but `seed`: the splitmix64 generator.
pub fn random(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 40) as f32 / (1 << 24) as f32
    }
}

/// `count` upright blades, each of 4 quads, bent a little, inside the unit cube.
pub fn blades(count: usize, seed: u64) -> Geometry {
    let mut random = random(seed);
    let mut geometry = Geometry::default();
    for _ in 0..count {
        let root = Vec3::new(0.15 + 0.7 * random(), 0.15 + 0.7 * random(), 0.0);
        let across = Vec2::from_angle(6.3 * random()).extend(0.0) * 0.03;
        let lean = Vec2::from_angle(6.3 * random()).extend(0.0) * 0.12;
        let height = 0.6 + 0.35 * random();
        let at = |x: f32| root + lean * x * x + Vec3::Z * height * x;
        let color = Vec3::new(0.2 + 0.5 * random(), 0.6, 0.2);
        for i in 0..4 {
            let (a, b) = (i as f32 / 4.0, (i + 1) as f32 / 4.0);
            let (wa, wb) = (across * (1.0 - 0.7 * a), across * (1.0 - 0.7 * b));
            geometry.push_quad([at(a) - wa, at(a) + wa, at(b) + wb, at(b) - wb], color);
        }
    }
    geometry
}

/// A sheet across the texel at height `w`, tilted by `slope` along s, of one `color`.
pub fn sheet(w: f32, slope: f32, color: Vec3) -> Geometry {
    let at = |s: f32, t: f32| Vec3::new(s, t, w + slope * (s - 0.5));
    let mut geometry = Geometry::default();
    geometry.push_quad([at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)], color);
    geometry
}

/// A texel of `2^depth` voxels a side.
pub fn texel(geometry: &Geometry, depth: u32, periodic: bool) -> Arc<Texel> {
    let options = BuildOptions { depth, periodic, ..BuildOptions::standard() };
    Arc::new(build("test", geometry.clone(), &options, &|_| ()).expect("the geometry is sound"))
}

/// The content of every box of `skin` as explicit triangles: each is cut into `pieces`² and carried through the
/// box's map. For skins with one whole texel in each box.
pub fn expand(geometry: &Geometry, skin: &Skin, pieces: usize) -> Mesh {
    let mut mesh = Mesh { name: "expanded".into(), ..Mesh::default() };
    for patch in 0..skin.len() {
        assert_eq!(skin.patches[patch].lattice, Lattice::UNIT);
        let hexahedron = skin.hexahedron(patch);
        for &[a, b, c] in &geometry.triangles {
            let point = |i: usize, j: usize| {
                let (x, y) = (i as f32 / pieces as f32, j as f32 / pieces as f32);
                hexahedron.map().point((a + x * (b - a) + y * (c - a)).as_dvec3()).as_vec3()
            };
            let mut push = |corners: [Vec3; 3]| {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(corners);
                mesh.faces.push(Face::triangle([first, first + 1, first + 2], MaterialId(0)));
            };
            for i in 0..pieces {
                for j in 0..pieces - i {
                    push([point(i, j), point(i + 1, j), point(i, j + 1)]);
                    if i + j + 1 < pieces {
                        push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                    }
                }
            }
        }
    }
    mesh
}

/// A scene of nothing but coats, meshes and a uniform white surrounding.
pub fn scene(coats: Vec<(Skin, Arc<Texel>)>, meshes: Vec<Mesh>) -> Scene {
    let coats = coats.into_iter().map(|(skin, texel)| Coat {
        skin,
        texels: texel.into(),
        tint: Vec3::ONE,
        wears_material: false,
    });
    Scene::new(Description {
        coats: coats.collect(),
        meshes,
        materials: vec![Material { base_color: Vec3::ONE, ..Material::default() }],
        textures: vec![],
        lights: vec![],
        environment: Environment::uniform(Vec3::ONE),
    })
    .expect("the scene is sound")
}

/// Renders without being watched.
pub fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    render(scene, camera, settings, &|_| ControlFlow::Continue(())).expect("the settings are sound")
}

/// Root mean square difference of alpha.
pub fn alpha_rmse(a: &Film, b: &Film) -> f32 {
    let sum: f32 = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a.alpha - b.alpha).powi(2)).sum();
    (sum / a.pixels.len() as f32).sqrt()
}

/// Mean alpha.
pub fn mean_alpha(film: &Film) -> f32 {
    film.pixels.iter().map(|p| p.alpha).sum::<f32>() / film.pixels.len() as f32
}
