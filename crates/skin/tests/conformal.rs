//! Generated coordinates: flat where a surface can be, little stretched where it cannot, the same on every run.

use std::f64::consts::PI;

use pelage_geom::glam::{Vec2, Vec3};
use pelage_geom::{Face, MaterialId, Mesh};
use pelage_skin::{Distortion, Layout, Skin, SkinError, SkinOptions, extrude, surface};

fn conformal(mesh: &Mesh) -> Skin {
    let options = SkinOptions { layout: Layout::Conformal, tiling: Some(4.0), ..SkinOptions::new(0.02) };
    extrude(mesh, &|_| true, &options).unwrap()
}

fn without_uvs(mesh: Mesh) -> Mesh {
    Mesh { uvs: None, ..mesh }
}

/// A quarter of a cylinder of radius 1 m, 2 m long, of quads with straight sides.
fn gutter(around: u32, along: u32) -> Mesh {
    let mut mesh = Mesh { name: "Gutter".into(), ..Mesh::default() };
    for j in 0..=along {
        for i in 0..=around {
            let angle = std::f32::consts::FRAC_PI_2 * i as f32 / around as f32;
            mesh.positions.push(Vec3::new(angle.cos(), angle.sin(), 2.0 * j as f32 / along as f32));
        }
    }
    let at = |i: u32, j: u32| i + (around + 1) * j;
    for j in 0..along {
        for i in 0..around {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.faces.push(Face::quad([corners[0], corners[3], corners[2], corners[1]], MaterialId(0)));
        }
    }
    mesh
}

#[test]
fn what_can_be_unrolled_is_not_stretched() {
    let skin = conformal(&gutter(24, 16));
    let distortion = skin.distortion();
    assert_eq!((distortion.charts.len(), distortion.seam_edges), (1, 0));
    assert!(distortion.worst < 1.0 + 1e-4, "{distortion}");
    // Parallelograms stay one box each; four copies a metre.
    assert_eq!((skin.report.boxes, skin.report.prisms), (24 * 16, 0));
    assert!((skin.report.copy_width - 0.25).abs() < 1e-4, "{}", skin.report.copy_width);
    // Where the gutter is steepest, t grows upwards.
    let steep = skin.patches.iter().find(|p| p.face == 0).unwrap();
    let [a, b, c] = [0, 1, 2].map(|k| skin.base[steep.vertices[k] as usize]);
    let rise = (b - a).y * steep.lattice.u + (c - a).y * steep.lattice.v;
    assert!(rise.y > 0.0 && rise.x.abs() < 0.05 * rise.y, "{rise}");
}

/// What is stretched least of a sphere, in how many pieces.
#[test]
fn closed_surfaces_are_cut_until_they_lie_flat() {
    for (mesh, area) in [(surface::torus(1.0, 0.4, 48, 24), 4.0 * PI * PI * 0.4), (sphere(24, 12), 4.0 * PI)]
    {
        let mesh = without_uvs(mesh);
        let skin = conformal(&mesh);
        skin.validate(6).unwrap();
        let distortion = skin.distortion();
        println!("{}: {distortion}", mesh.name);
        assert_eq!(distortion.charts.len(), 1, "{distortion}");
        assert!(distortion.mean < 1.15 && distortion.hundredth < 1.45, "{distortion}");
        assert!(distortion.seam_edges > 0 && distortion.seam_length < 5.0 * area.sqrt(), "{distortion}");
        assert_eq!(skin, conformal(&mesh));
    }
}

/// A sphere of quads and, around its poles, triangles.
fn sphere(around: usize, down: usize) -> Mesh {
    let sphere = pelage_skin::tessellate::Parametric::Sphere { radius: 1.0 };
    pelage_skin::tessellate::uniform(&sphere, around, down).unwrap().mesh
}

#[test]
fn pieces_lie_alike_and_holes_and_shared_edges_are_no_obstacle() {
    // A cube without its lid, three faces on one edge, and two triangles that touch at a corner.
    let mut mesh = Mesh { name: "Odds".into(), ..Mesh::default() };
    let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    mesh.positions = vec![
        p(0.0, 0.0, 0.0),
        p(1.0, 0.0, 0.0),
        p(1.0, 0.0, 1.0),
        p(0.0, 0.0, 1.0),
        p(0.0, 1.0, 0.0),
        p(1.0, 1.0, 0.0),
        p(1.0, 1.0, 1.0),
        p(0.0, 1.0, 1.0),
        p(2.0, 0.0, 0.0),
        p(2.0, 1.0, 0.0),
        p(3.0, 0.0, 0.5),
        p(3.0, 1.0, 1.0),
    ];
    let quad = |v: [u32; 4]| Face::quad(v, MaterialId(0));
    mesh.faces = vec![
        quad([0, 1, 2, 3]),
        quad([0, 4, 5, 1]),
        quad([1, 5, 6, 2]),
        quad([2, 6, 7, 3]),
        quad([3, 7, 4, 0]),
        quad([1, 8, 9, 5]),
        Face::triangle([8, 10, 9], MaterialId(0)),
        Face::triangle([10, 11, 8], MaterialId(0)),
    ];
    let skin = conformal(&mesh);
    let Distortion { worst, charts, .. } = skin.distortion();
    // All of it can be unfolded.
    assert!(worst < 1.0 + 1e-3 && !charts.is_empty(), "{worst}");
    assert!(skin.patches.iter().all(|p| p.lattice.origin != Vec2::NAN));
}

#[test]
fn what_would_take_too_long_is_refused() {
    let plane = surface::plane(1.0, 500, 401);
    let options = SkinOptions { layout: Layout::Conformal, ..SkinOptions::new(0.02) };
    match extrude(&plane, &|_| true, &options) {
        Err(SkinError::ConformalSize { faces: 200_500, most: 200_000, .. }) => {}
        other => panic!("{:?}", other.map(|skin| skin.len())),
    }
}

#[test]
fn the_layout_of_texture_coordinates_is_judged_too() {
    // A plane of 2 m × 1 m whose texture coordinates are square: copies are twice as long as wide, so √2 off either way.
    let mut plane = surface::plane(2.0, 8, 8);
    plane.positions.iter_mut().for_each(|p| p.z *= 0.5);
    let skin =
        extrude(&plane, &|_| true, &SkinOptions { tiling: Some(3.0), ..SkinOptions::new(0.02) }).unwrap();
    let distortion = skin.distortion();
    assert_eq!((distortion.charts.len(), distortion.seam_edges), (1, 0));
    for stretch in [distortion.mean, distortion.worst, distortion.hundredth, f64::from(skin.stretch(0))] {
        assert!((stretch - 2_f64.sqrt()).abs() < 1e-5, "{distortion}");
    }
}
