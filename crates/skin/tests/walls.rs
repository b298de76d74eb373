//! Neighbours share whole walls: the same four corner points, to the last bit, and nothing overlaps or is missing.

use std::collections::HashMap;

use pelage_geom::glam::{DVec3, Vec2, Vec3};
use pelage_geom::{Face, Hexahedron, MaterialId, Mesh};
use pelage_skin::{Border, Skin, SkinOptions, extrude, surface};
use proptest::prelude::*;

/// Every side wall of every box as its four corner points, with the number of boxes that it belongs to.
fn walls(skin: &Skin) -> HashMap<[[u64; 3]; 4], usize> {
    let mut walls = HashMap::new();
    for patch in 0..skin.len() {
        let hexahedron = skin.hexahedron(patch);
        let corners = hexahedron.map().corners.map(|c| c.to_array().map(f64::to_bits));
        let sides: &[[usize; 4]] = match hexahedron.is_prism() {
            true => &[[0, 1, 4, 5], [1, 2, 5, 6], [2, 0, 6, 4]],
            false => &[[0, 1, 4, 5], [1, 3, 5, 7], [3, 2, 7, 6], [2, 0, 6, 4]],
        };
        for side in sides {
            let mut wall = side.map(|i| corners[i]);
            wall.sort_unstable();
            *walls.entry(wall).or_insert(0) += 1;
        }
    }
    walls
}

fn assert_closed(skin: &Skin) {
    skin.validate(6).unwrap();
    assert!(!skin.is_empty());
    let walls = walls(skin);
    let odd = walls.values().filter(|&&boxes| boxes != 2).count();
    assert_eq!(odd, 0, "{odd} of {} walls do not belong to exactly two boxes", walls.len());
}

/// ∫ det J over a box. det J has degree 2 in each coordinate, so two Gauss points a direction are exact; over a prism
/// it is linear in the barycentrics, so its value at the centroid times ½ is.
fn volume(hexahedron: &Hexahedron) -> f64 {
    let g = 0.5 / 3f64.sqrt();
    let nodes = [0.5 - g, 0.5 + g];
    let mut sum = 0.0;
    for w in nodes {
        if hexahedron.is_prism() {
            let third = 1.0 / 3.0;
            sum += 0.25 * hexahedron.map().determinant(DVec3::new(third, third, w));
            continue;
        }
        for u in nodes {
            for v in nodes {
                sum += 0.125 * hexahedron.map().determinant(DVec3::new(u, v, w));
            }
        }
    }
    sum
}

/// The volume enclosed by the bilinear patches on `points`: ⅓ ∫ S · (∂S/∂u × ∂S/∂v), again of degree 2.
fn enclosed(skin: &Skin, points: &[Vec3]) -> f64 {
    let g = 0.5 / 3f64.sqrt();
    let mut sum = 0.0;
    for patch in &skin.patches {
        let [a, b, c, d] = patch.vertices.map(|i| points[i as usize].as_dvec3());
        for u in [0.5 - g, 0.5 + g] {
            for v in [0.5 - g, 0.5 + g] {
                let s = a.lerp(b, u).lerp(c.lerp(d, u), v);
                let (du, dv) = ((b - a).lerp(d - c, v), (c - a).lerp(d - b, u));
                sum += 0.25 * s.dot(du.cross(dv)) / 3.0;
            }
        }
    }
    sum
}

fn shell(n: u32) -> (Skin, f64) {
    let skin = extrude(&surface::cube_sphere(1.0, n), &|_| true, &SkinOptions::new(0.25)).unwrap();
    let total = (0..skin.len()).map(|i| volume(&skin.hexahedron(i))).sum();
    (skin, total)
}

#[test]
fn a_sphere_is_closed_and_its_boxes_fill_the_shell() {
    let (skin, total) = shell(8);
    assert_eq!((skin.report.boxes, skin.report.prisms), (6 * 64, 0));
    assert_eq!((skin.report.open_edges, skin.report.misoriented_edges), (0, 0));
    assert_closed(&skin);
    // The walls cancel in pairs, so the boxes hold what lies between the base and the top.
    let between = enclosed(&skin, &skin.top) - enclosed(&skin, &skin.base);
    assert!((total - between).abs() < 1e-12, "{total} {between}");
}

#[test]
fn the_shell_of_a_sphere_converges_in_second_order() {
    // (4/3) π (1.25³ − 1): an inscribed polyhedron errs by the square of its edges.
    let exact = 4.0 / 3.0 * core::f64::consts::PI * (1.25f64.powi(3) - 1.0);
    let [coarse, fine] = [16, 32].map(|n| exact - shell(n).1);
    assert!(fine > 0.0 && fine < 0.01 * exact, "{fine}");
    assert!((coarse / fine - 4.0).abs() < 0.1, "{}", coarse / fine);
}

#[test]
fn prisms_fill_the_shell_as_boxes_do() {
    // A regular octahedron of radius 1 has volume 4/3; its vectors are radial, so at height 1 the top has radius 2.
    let mut mesh = octahedron();
    mesh.uvs = Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ZERO]; 8]);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(1.0)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.prisms), (0, 8));
    assert_closed(&skin);
    let total: f64 = (0..skin.len()).map(|i| volume(&skin.hexahedron(i))).sum();
    assert!((total - 4.0 / 3.0 * 7.0).abs() < 1e-6, "{total}");
}

#[test]
fn triangles_without_texture_coordinates_become_three_quads_each() {
    let skin = extrude(&octahedron(), &|_| true, &SkinOptions::new(0.2)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.prisms, skin.report.refined), (24, 0, true));
    // 6 corners, 12 midpoints, 8 centres.
    assert_eq!(skin.base.len(), 26);
    assert_closed(&skin);
}

#[test]
fn a_mesh_of_triangles_and_quads_conforms() {
    // A cube with a pyramid for a roof: five quads, four triangles.
    let at = Vec3::new;
    let positions = vec![
        at(0.0, 0.0, 0.0),
        at(1.0, 0.0, 0.0),
        at(1.0, 0.0, 1.0),
        at(0.0, 0.0, 1.0),
        at(0.0, 1.0, 0.0),
        at(1.0, 1.0, 0.0),
        at(1.0, 1.0, 1.0),
        at(0.0, 1.0, 1.0),
        at(0.5, 1.7, 0.5),
    ];
    let quads = [[0, 1, 2, 3], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];
    let roof = [[4, 8, 5], [5, 8, 6], [6, 8, 7], [7, 8, 4]];
    let mut faces: Vec<Face> = quads.map(|q| Face::quad(q, MaterialId(0))).to_vec();
    faces.extend(roof.map(|t| Face::triangle(t, MaterialId(1))));
    let house = Mesh { name: "house".into(), positions, faces, ..Mesh::default() };

    let skin = extrude(&house, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!(skin.report.boxes, 5 * 4 + 4 * 3);
    assert_closed(&skin);
    assert_eq!(skin.patches.iter().filter(|p| p.material == MaterialId(1)).count(), 12);

    // Its walls alone are all quads: nothing is split.
    let skin = extrude(&house, &|face| (1..5).contains(&face), &SkinOptions::new(0.1)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.open_edges), (4, 8));
}

#[test]
fn a_quad_that_is_not_convex_is_cut_before_it_is_split() {
    // An arrowhead, whose corners' mean (0.3, 0.3) lies outside it, beside a triangle.
    let at = |x, y| Vec3::new(x, y, 0.0);
    let positions = vec![at(0.0, 0.0), at(1.0, 0.0), at(0.2, 0.2), at(0.0, 1.0), at(0.0, -1.0)];
    let faces = vec![Face::quad([0, 1, 2, 3], MaterialId(0)), Face::triangle([0, 4, 1], MaterialId(0))];
    let mesh = Mesh { name: "arrow".into(), positions, faces, ..Mesh::default() };
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.open_edges), (9, 10));
    assert!(skin.report.folds.is_empty());
    skin.validate(6).unwrap();
}

#[test]
fn a_mesh_that_is_split_at_its_seams_is_welded() {
    let whole = surface::cube_sphere(1.0, 4);
    let mut apart = Mesh { name: "apart".into(), ..Mesh::default() };
    for face in &whole.faces {
        let first = apart.positions.len() as u32;
        apart.positions.extend(face.vertices.map(|i| whole.positions[i as usize]));
        apart.faces.push(Face::quad([first, first + 1, first + 2, first + 3], face.material));
    }
    let skin = extrude(&apart, &|_| true, &SkinOptions::new(0.2)).unwrap();
    assert_eq!(skin.base.len(), whole.positions.len());
    assert_eq!(skin.report.welded_vertices, apart.positions.len() - whole.positions.len());
    assert_closed(&skin);
}

#[test]
fn zero_and_minus_zero_are_one_place() {
    let mut mesh = surface::plane(2.0, 2, 1);
    // The two middle vertices lie on x = 0; the second quad gets copies of them on x = −0.
    let copies = mesh.faces[1].vertices.map(|i| {
        let mut p = mesh.positions[i as usize];
        p.x = if p.x == 0.0 { -0.0 } else { p.x };
        p
    });
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(copies);
    mesh.faces[1].vertices = [first, first + 1, first + 2, first + 3];
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.2)).unwrap();
    assert_eq!(skin.base.len(), 6);
    assert_eq!(walls(&skin).values().filter(|&&boxes| boxes == 2).count(), 1);
}

#[test]
fn a_border_stands_upright_or_leans_with_the_mesh() {
    let cube = surface::cube_sphere(3f32.sqrt(), 1);
    let top = (0..6).find(|&i| cube.area_vector(i).y > 1.0).unwrap();
    let skin = extrude(&cube, &|face| face == top, &SkinOptions::new(0.5)).unwrap();
    assert_eq!(skin.base.len(), 4);
    for (b, t) in skin.base.iter().zip(&skin.top) {
        assert!((*t - *b).distance(0.5 * Vec3::Y) < 1e-6);
    }
    // With the sides counted too, the vectors are those of the whole cube: along its diagonals.
    let options = SkinOptions { border: Border::Mesh, ..SkinOptions::new(0.5) };
    let skin = extrude(&cube, &|face| face == top, &options).unwrap();
    assert_eq!((skin.len(), skin.base.len()), (1, 4));
    for (b, t) in skin.base.iter().zip(&skin.top) {
        assert!((*t - *b).distance(0.5 * b.normalize()) < 1e-6);
    }
}

#[test]
fn a_skin_is_the_same_on_any_number_of_threads() {
    let mut mesh = surface::torus(1.0, 0.4, 40, 20);
    mesh.faces.reverse();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| extrude(&mesh, &|face| face % 7 != 3, &SkinOptions::new(0.9)).unwrap())
    };
    let (one, four) = (run(1), run(4));
    assert!(!one.report.folds.is_empty());
    assert_eq!(one, four);
}

fn octahedron() -> Mesh {
    let positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let up = [[0, 2, 4], [4, 2, 1], [1, 2, 5], [5, 2, 0]];
    let down = [[4, 3, 0], [1, 3, 4], [5, 3, 1], [0, 3, 5]];
    let faces = up.into_iter().chain(down).map(|t| Face::triangle(t, MaterialId(0))).collect();
    Mesh { name: "octahedron".into(), positions, faces, ..Mesh::default() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any mixture of triangles and quads on a bumpy sphere, with or without texture coordinates, stays closed.
    #[test]
    fn mixtures_are_closed(
        cut in prop::collection::vec(0..3u8, 54),
        bumps in prop::collection::vec(0.85f32..1.15, 56),
        flat in any::<bool>(),
    ) {
        let ball = surface::cube_sphere(1.0, 3);
        let mut mesh = Mesh { name: "ball".into(), ..Mesh::default() };
        mesh.positions = ball.positions.iter().zip(&bumps).map(|(p, b)| *p * *b).collect();
        for (face, cut) in ball.faces.iter().zip(&cut) {
            let [a, b, c, d] = face.vertices;
            let material = face.material;
            match cut {
                0 => mesh.faces.push(*face),
                1 => mesh.faces.extend([[a, b, c], [a, c, d]].map(|t| Face::triangle(t, material))),
                _ => mesh.faces.extend([[b, c, d], [b, d, a]].map(|t| Face::triangle(t, material))),
            }
        }
        if flat {
            // Seen from above, by vertex: continuous, mirrored below, far from affine.
            let uv = |i: u32| mesh.positions.get(i as usize).map_or(Vec2::ZERO, |p| Vec2::new(p.x, p.z));
            mesh.uvs = Some(mesh.faces.iter().map(|f| f.vertices.map(uv)).collect());
        }
        let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
        prop_assert_eq!(skin.report.left_out(), 0);
        assert_closed(&skin);
    }
}
