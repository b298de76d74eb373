//! Meshes of surfaces: their errors against what geometry says, their connection, and subdivision's limits.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use pelage_geom::glam::{DVec2, DVec3, Vec2, Vec3};
use pelage_geom::{Attribute, Face, MaterialId, Mesh};
use pelage_skin::tessellate::{Bounds, Parametric, Subdivision, adaptive, subdivide, uniform};
use pelage_skin::{SkinError, SkinOptions, extrude, surface};

/// Faces by edge.
fn edges(mesh: &Mesh) -> HashMap<(u32, u32), usize> {
    let mut edges = HashMap::new();
    for face in &mesh.faces {
        let corners = face.corners();
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    edges
}

/// V − E + F, and how many edges have one face.
fn topology(mesh: &Mesh) -> (i64, usize) {
    let edges = edges(mesh);
    assert!(edges.values().all(|&n| n <= 2), "{}: an edge has more than two faces", mesh.name);
    let open = edges.values().filter(|&&n| n == 1).count();
    (mesh.positions.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64, open)
}

/// A hill: high at one corner of the parameters, flat elsewhere.
fn hill() -> Parametric {
    let height = |i: i32, j: i32| 2.0 * (-((i - 2).pow(2) + (j - 2).pow(2)) as f32 / 3.0).exp();
    let heights = (0..17).flat_map(|j| (0..17).map(move |i| height(i, j))).collect();
    Parametric::Heightfield { size: [8.0, 8.0], heights, columns: 17 }
}

fn bezier() -> Parametric {
    let at = |k: usize| {
        let (i, j) = (k % 4, k / 4);
        let height = if (1..3).contains(&i) && (1..3).contains(&j) { 3.0 } else { 0.0 };
        Vec3::new(i as f32 - 1.5, height, 1.5 - j as f32)
    };
    Parametric::Bezier { points: (0..16).map(at).collect() }
}

#[test]
fn the_papers_table_has_its_numbers_of_vertices() {
    let mut last = f64::INFINITY;
    for (n, vertices) in [(4, 25), (8, 81), (16, 289)] {
        let t = uniform(&bezier(), n, n).unwrap();
        assert_eq!((t.mesh.faces.len(), t.mesh.positions.len()), (n * n, vertices));
        assert!(t.deviation().arc < 0.5 * last, "{:?}", t.deviation());
        last = t.deviation().arc;
        t.mesh.validate().unwrap();
    }
}

#[test]
fn arc_error_of_a_circle_is_known() {
    // An arc of angle α has the chord 2 sin(α/2) on the arc α; of a sphere's edges those on the equator and the
    // meridians are great circles, and longest for their angle.
    let error = |angle: f64| 1.0 - (0.5 * angle).sin() / (0.5 * angle);
    for (nu, nv) in [(12, 6), (40, 5)] {
        let sphere = uniform(&Parametric::Sphere { radius: 2.0 }, nu, nv).unwrap();
        let (around, up) = (TAU / nu as f64, PI / nv as f64);
        let expected = error(around.max(up));
        assert!(
            (sphere.deviation().arc / expected - 1.0).abs() < 0.01,
            "{:?} {expected}",
            sphere.deviation()
        );
        let metres = 2.0 * (around * error(around)).max(up * error(up));
        assert!((sphere.deviation().arc_metres / metres - 1.0).abs() < 0.01);
        assert_eq!(topology(&sphere.mesh), (2, 0));
    }
}

#[test]
fn area_error_of_a_torus_is_known() {
    // Its area is 4π² R r; with fine patches all that is missing is second order.
    let torus = Parametric::Torus { major: 1.0, minor: 0.25 };
    for n in [16, 32] {
        let t = uniform(&torus, 2 * n, n).unwrap();
        let missing = 1.0 - f64::from(t.mesh.area()) / (TAU * TAU * 0.25);
        // The measure itself cuts a patch into 12 × 12, which is 1/144 of the error.
        assert!((t.deviation().total_area / missing - 1.0).abs() < 0.05, "{:?} {missing}", t.deviation());
        assert_eq!(topology(&t.mesh), (0, 0));
    }
}

#[test]
fn flat_surfaces_are_exact() {
    let flat = |k: usize| Vec3::new((k % 4) as f32, 0.0, -((k / 4) as f32));
    let net = |columns: usize, rows: usize| {
        (0..columns * rows).map(|k| Vec3::new((k % columns) as f32, 1.0, -((k / columns) as f32))).collect()
    };
    for surface in [
        Parametric::Plane { size: [3.0, 2.0] },
        Parametric::Bezier { points: (0..16).map(flat).collect() },
        Parametric::BSpline { points: net(7, 5), columns: 7 },
        Parametric::Heightfield { size: [1.0, 2.0], heights: vec![0.5; 12], columns: 4 },
    ] {
        let t = uniform(&surface, 5, 4).unwrap();
        assert!(t.deviation().arc < 1e-12 && t.deviation().area < 1e-12, "{:?}", t.deviation());
        // Seen from above: all faces look upwards.
        assert!((0..t.mesh.faces.len()).all(|f| t.mesh.area_vector(f).y > 0.0), "{}", surface.name());
        assert_eq!(topology(&t.mesh).0, 1);
    }
}

#[test]
fn surfaces_go_where_their_points_say() {
    // A Bézier patch passes through its corners; a heightfield through its samples; a B-spline on a plane's net lies
    // where the net does, and begins one net cell inside it.
    let Parametric::Bezier { points } = bezier() else { unreachable!() };
    assert_eq!(bezier().point(DVec2::new(1.0, 0.0)), points[3].as_dvec3());
    let Parametric::Heightfield { heights, .. } = hill() else { unreachable!() };
    for (i, j) in [(0, 0), (2, 2), (16, 3), (7, 16)] {
        let p = hill().point(DVec2::new(i as f64 / 16.0, 1.0 - j as f64 / 16.0));
        assert!((p.y - f64::from(heights[17 * j + i])).abs() < 1e-9, "{i} {j} {p}");
        assert!((p.x - (0.5 * i as f64 - 4.0)).abs() < 1e-9 && (p.z - (0.5 * j as f64 - 4.0)).abs() < 1e-9);
    }
    let net = (0..42).map(|k| Vec3::new((k % 7) as f32, 1.0, -((k / 7) as f32))).collect();
    let spline = Parametric::BSpline { points: net, columns: 7 };
    assert!(spline.point(DVec2::ZERO).distance(DVec3::new(1.0, 1.0, -1.0)) < 1e-12);
    assert!(spline.point(DVec2::new(0.5, 1.0)).distance(DVec3::new(3.0, 1.0, -4.0)) < 1e-12);
}

#[test]
fn adaptive_meshes_keep_their_bounds_with_fewer_patches_and_no_cracks() {
    for surface in [hill(), bezier(), Parametric::Torus { major: 1.0, minor: 0.3 }] {
        let bounds = Bounds { arc: 0.02, area: 0.05, ..Bounds::NONE };
        let t = adaptive(&surface, &bounds).unwrap();
        let d = t.deviation();
        assert!(d.arc <= bounds.arc && d.area <= bounds.area, "{} {d:?}", surface.name());
        let (_, open) = topology(&t.mesh);
        assert_eq!(open == 0, surface.name() == "torus");
        // The same bounds by a uniform mesh.
        let even = |n: &usize| {
            let d = uniform(&surface, 16 * n, 16 * n).unwrap().deviation();
            d.arc <= bounds.arc && d.area <= bounds.area
        };
        let n = 16 * (1..6).find(even).unwrap();
        println!("{}: {} patches adaptive, {} uniform", surface.name(), t.mesh.faces.len(), n * n);
        assert!(t.mesh.faces.len() <= n * n);
        extrude(&t.mesh, &|_| true, &SkinOptions::strict(0.02)).unwrap();
    }
    let metres = Bounds { arc_metres: 1e-3, area_square_metres: 1e-3, ..Bounds::NONE };
    let d = adaptive(&bezier(), &metres).unwrap().deviation();
    assert!(d.arc_metres <= 1e-3 && d.area_square_metres <= 1e-3, "{d:?}");
}

#[test]
fn what_cannot_be_tessellated_is_named() {
    let error = |surface: &Parametric| uniform(surface, 4, 4).unwrap_err().to_string();
    assert_eq!(
        error(&Parametric::Sphere { radius: -1.0 }),
        "sphere: radius must be positive and at most 1e12"
    );
    assert_eq!(
        error(&Parametric::Torus { major: 1.0, minor: 1.0 }),
        "torus: minor must be positive and less than `major`"
    );
    assert_eq!(error(&Parametric::Bezier { points: vec![] }), "bezier: points must hold 16 control points");
    let spline = Parametric::BSpline { points: vec![Vec3::ZERO; 17], columns: 4 };
    assert_eq!(error(&spline), "bspline: points must fill 4 rows of `columns` points, or more");
    let fine = Bounds { arc: 1e-9, most_patches: 1000, ..Bounds::NONE };
    let error = adaptive(&bezier(), &fine).unwrap_err();
    assert!(matches!(error, SkinError::TooFine { most: 1000, .. }), "{error}");
    let nan = Bounds { arc: f64::NAN, ..Bounds::NONE };
    assert!(matches!(adaptive(&bezier(), &nan), Err(SkinError::Surface { field: "arc", .. })));
    let cube = surface::cube_sphere(1.0, 1);
    for subdivision in [
        Subdivision { levels: 11, ..Subdivision::default() },
        Subdivision { crease_angle: -1.0, ..Subdivision::default() },
    ] {
        assert!(matches!(subdivide(&cube, &subdivision), Err(SkinError::Surface { .. })));
    }
}

fn cube() -> Mesh {
    let mut cube = surface::cube_sphere(1.0, 1);
    cube.positions.iter_mut().for_each(|p| *p = p.signum());
    cube
}

#[test]
fn a_cube_goes_where_it_should() {
    // At a vertex of valence 3 the limit is (9v + 4Σe + Σf) / 24: of (1,1,1) with neighbours that sum to (1,1,1) and
    // opposite corners that sum to (−1,−1,−1): (9 + 4 − 1) / 24 = ½. It is the same whatever the level.
    for levels in 1..4 {
        let t = subdivide(&cube(), &Subdivision { levels, ..Subdivision::default() }).unwrap();
        assert_eq!(t.mesh.faces.len(), 6 * 4_usize.pow(levels));
        assert_eq!(topology(&t.mesh), (2, 0));
        let corner = t.mesh.positions[..8].iter().all(|p| p.abs().distance(Vec3::splat(0.5)) < 1e-6);
        assert!(corner, "{:?}", &t.mesh.positions[..8]);
    }
}

#[test]
fn errors_of_subdivision_fall_by_four() {
    let at =
        |levels| subdivide(&cube(), &Subdivision { levels, ..Subdivision::default() }).unwrap().deviation();
    let [a, b, c] = [1, 2, 3].map(at);
    for (coarse, fine) in [(a, b), (b, c)] {
        // All the surface's: single edges at the cube's corners, where the curvature has no bound, do so more slowly.
        let ratio = coarse.total_area / fine.total_area;
        assert!((3.5..4.5).contains(&ratio) && fine.arc < coarse.arc, "{coarse:?} {fine:?}");
    }
}

#[test]
fn a_regular_net_becomes_its_b_spline() {
    // Where every vertex has four quads, Catmull–Clark's limit is the uniform bicubic B-spline of the net.
    let n = 9;
    let point = |k: usize| {
        let (i, j) = ((k % n) as f32, (k / n) as f32);
        Vec3::new(i, (1.3 * i).sin() + 0.2 * i * (0.9 * j).cos(), -j)
    };
    let points: Vec<Vec3> = (0..n * n).map(point).collect();
    let quad = |i: usize, j: usize| {
        [j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i].map(|k| k as u32)
    };
    let faces =
        (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| Face::quad(quad(i, j), MaterialId(0)))).collect();
    let mesh = Mesh { positions: points.clone(), faces, ..Mesh::default() };
    let spline = Parametric::BSpline { points, columns: n };
    let t = subdivide(&mesh, &Subdivision { levels: 2, ..Subdivision::default() }).unwrap();
    let mut compared = 0;
    for p in t.mesh.positions.iter().map(|p| p.as_dvec3()) {
        // x and z are linear in the parameters, and the border's rule reaches two cells in.
        let (u, v) = (p.x - 1.0, -p.z - 1.0);
        let cells = (n - 3) as f64;
        if (1.0..cells - 1.0).contains(&u) && (1.0..cells - 1.0).contains(&v) {
            let exact = spline.point(DVec2::new(u, v) / cells);
            assert!(p.distance(exact) < 1e-5, "{p} {exact}");
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn borders_and_creases_stay() {
    // The corners of a square and the middles of its straight sides stay on it, whatever is inside.
    let mut square = surface::plane(2.0, 4, 4);
    square.positions[12].y = 1.0;
    let t = subdivide(&square, &Subdivision::default()).unwrap();
    for corner in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        assert!(t.mesh.positions.contains(&Vec3::new(corner[0], 0.0, corner[1])), "{corner:?}");
    }
    let border: f64 = (edges(&t.mesh).iter().filter(|(_, n)| **n == 1))
        .map(|(&(a, b), _)| f64::from(t.mesh.positions[a as usize].distance(t.mesh.positions[b as usize])))
        .sum();
    assert!((border - 8.0).abs() < 1e-5, "{border}");
    // All edges of a cube meet at 90°: with creases from 60° on it stays one.
    let sharp = subdivide(&cube(), &Subdivision { levels: 2, crease_angle: 60.0 }).unwrap();
    assert!((sharp.mesh.area() - 24.0).abs() < 1e-4 && sharp.deviation().total_area < 1e-12);
    // A box with two sharp rims is a cylinder: its rims are planar, cubic curves.
    let mut prism = cube();
    prism.faces.retain(|f| {
        f.corners().iter().any(|&v| prism.positions[v as usize].y < 0.0)
            && f.corners().iter().any(|&v| prism.positions[v as usize].y > 0.0)
    });
    let tube = subdivide(&prism, &Subdivision { levels: 3, ..Subdivision::default() }).unwrap();
    assert_eq!(topology(&tube.mesh), (0, 64));
    assert!(tube.mesh.positions.iter().all(|p| p.y.abs() <= 1.0 + 1e-6));
}

#[test]
fn what_faces_carry_is_interpolated() {
    let mut mesh = surface::plane(1.0, 2, 2);
    mesh.attributes =
        vec![Attribute { name: "_X".into(), values: mesh.positions.iter().map(|p| p.x).collect() }];
    mesh.faces[1].material = MaterialId(2);
    // One of the quads becomes two triangles.
    let uvs = mesh.uvs.clone().unwrap();
    let [a, b, c, d] = mesh.faces[3].vertices;
    mesh.faces[3] = Face::triangle([a, b, c], MaterialId(0));
    mesh.faces.push(Face::triangle([a, c, d], MaterialId(0)));
    let of = |pick: [usize; 3]| [uvs[3][pick[0]], uvs[3][pick[1]], uvs[3][pick[2]], Vec2::ZERO];
    let list = mesh.uvs.as_mut().unwrap();
    list[3] = of([0, 1, 2]);
    list.push(of([0, 2, 3]));
    mesh.validate().unwrap();
    let t = subdivide(&mesh, &Subdivision { levels: 1, ..Subdivision::default() }).unwrap();
    t.mesh.validate().unwrap();
    assert_eq!(t.mesh.faces.len(), 3 * 4 + 2 * 3);
    assert!(t.mesh.faces.iter().all(Face::is_quad));
    assert_eq!(t.mesh.faces.iter().filter(|f| f.material == MaterialId(2)).count(), 4);
    // Texture coordinates and the attribute are linear in the corners: u = x + ½ at the points of edges and faces,
    // before those move.
    for (face, uvs) in t.mesh.faces.iter().zip(t.mesh.uvs.as_ref().unwrap()) {
        for (&v, uv) in face.corners().iter().zip(uvs) {
            assert!((t.mesh.attributes[0].values[v as usize] - (uv.x - 0.5)).abs() < 1e-6);
        }
    }
}
