//! Skins between two meshes: their boxes have exactly the corners that were given, whoever gave them.

use pelage_geom::glam::{Mat3, Vec2, Vec3};
use pelage_geom::{Face, Hexahedron, MaterialId, Mesh, MeshError, Trilinear, certify};
use pelage_skin::{Border, Folds, Skin, SkinError, SkinOptions, cage, extrude, mean_height, surface};
use proptest::prelude::*;

const ALL: &dyn Fn(usize) -> bool = &|_| true;

fn refusing() -> SkinOptions {
    SkinOptions { folds: Folds::Refuse, ..SkinOptions::default() }
}

/// The base and the top of a skin as two meshes, one face a patch.
fn meshes(skin: &Skin) -> [Mesh; 2] {
    let faces: Vec<Face> =
        skin.patches.iter().map(|p| Face { vertices: p.outline(), material: p.material }).collect();
    let around = |[a, b, c, d]: [Vec2; 4], patch: usize| {
        if skin.patches[patch].is_prism() { [a, b, c, Vec2::ZERO] } else { [a, b, d, c] }
    };
    let uvs = skin.uvs.as_ref().map(|uvs| uvs.iter().enumerate().map(|(i, &uv)| around(uv, i)).collect());
    [("base", &skin.base), ("top", &skin.top)].map(|(name, positions)| Mesh {
        name: name.into(),
        positions: positions.clone(),
        faces: faces.clone(),
        uvs: uvs.clone(),
        ..Mesh::default()
    })
}

/// The mesh with its vertices moved.
fn moved(mesh: &Mesh, to: impl Fn(Vec3) -> Vec3) -> Mesh {
    let positions = mesh.positions.iter().map(|&p| to(p)).collect();
    Mesh { name: "top".into(), positions, ..mesh.clone() }
}

/// The mesh with vertices of its own for every face, last face's first.
fn torn_apart(mesh: &Mesh) -> Mesh {
    let mut torn = Mesh { positions: Vec::new(), ..mesh.clone() };
    for face in torn.faces.iter_mut().rev() {
        for v in face.vertices.iter_mut().filter(|v| **v != Face::NONE) {
            torn.positions.push(mesh.positions[*v as usize]);
            *v = (torn.positions.len() - 1) as u32;
        }
    }
    torn
}

#[test]
fn the_cage_of_a_skin_is_that_skin() {
    let leaning = SkinOptions { lean: Vec3::new(0.5, 0.0, 0.2), ..SkinOptions::new(0.05) };
    let per_patch = SkinOptions { tiling: Some(3.0), ..SkinOptions::per_patch(0.1) };
    let with_triangles = {
        let mut mesh = surface::plane(1.0, 3, 3);
        let [a, b, c, d] = mesh.faces[4].vertices;
        mesh.faces[4] = Face::triangle([a, b, c], MaterialId(0));
        mesh.faces.push(Face::triangle([a, c, d], MaterialId(0)));
        let uvs = mesh.uvs.as_mut().unwrap();
        let [ta, tb, tc, td] = uvs[4];
        uvs[4] = [ta, tb, tc, Vec2::ZERO];
        uvs.push([ta, tc, td, Vec2::ZERO]);
        mesh
    };
    let refined = Mesh { uvs: None, ..with_triangles.clone() };
    for (mesh, options) in [
        (surface::torus(1.0, 0.4, 24, 12), SkinOptions::new(0.05)),
        (surface::plane(2.0, 5, 7), leaning),
        (surface::cube_sphere(1.0, 6), per_patch),
        (with_triangles, SkinOptions { tiling: Some(4.0), ..leaning }),
        (refined, leaning),
    ] {
        let skin = extrude(&mesh, ALL, &options).unwrap();
        let [base, top] = meshes(&skin);
        // However vertices are welded: shared in both, in one only, in neither.
        for (base, top) in [
            (base.clone(), top.clone()),
            (torn_apart(&base), top.clone()),
            (base.clone(), torn_apart(&top)),
            (torn_apart(&base), torn_apart(&top)),
        ] {
            let again = cage(&base, &top, ALL, &SkinOptions { lean: Vec3::ZERO, ..options }).unwrap();
            assert_eq!(again.len(), skin.len());
            assert_eq!(again.report.torn_vertices, 0);
            for (i, (p, q)) in again.patches.iter().zip(&skin.patches).enumerate() {
                assert_eq!(again.hexahedron(i), skin.hexahedron(i));
                assert_eq!((p.lattice, p.material), (q.lattice, q.material));
            }
            assert_eq!(again.uvs, skin.uvs);
        }
        let again = cage(&base, &top, ALL, &SkinOptions { lean: Vec3::ZERO, ..options }).unwrap();
        assert_eq!((&again.base, &again.top), (&skin.base, &skin.top));
        assert!(again.patches.iter().zip(&skin.patches).all(|(p, q)| p.vertices == q.vertices));
    }
}

#[test]
fn part_of_a_cage_is_part_of_the_skin() {
    let mesh = surface::torus(1.0, 0.4, 12, 8);
    let options = SkinOptions { border: Border::Mesh, tiling: Some(12.0), ..SkinOptions::new(0.05) };
    let whole = extrude(&mesh, ALL, &options).unwrap();
    let [base, top] = meshes(&whole);
    let half = |face: usize| face.is_multiple_of(2);
    let expected = extrude(&mesh, &half, &options).unwrap();
    let found = cage(&base, &top, &half, &options).unwrap();
    assert_eq!((found.base, found.top, found.patches), (expected.base, expected.top, expected.patches));
}

/// A certified box: corners of the unit cube, each moved by less than 0.3.
fn valid_box() -> impl Strategy<Value = [Vec3; 8]> {
    let off = || prop::array::uniform3(-0.3f32..0.3).prop_map(Vec3::from);
    let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let moved = prop::array::uniform8(off()).prop_map(move |off| std::array::from_fn(|i| corner(i) + off[i]));
    moved.prop_filter("it is folded", |p: &[Vec3; 8]| {
        let [a, b, c, d, e, f, g, h] = *p;
        certify(&Hexahedron::cuboid(Trilinear::new([a, b, c, d], [e, f, g, h])), 6).is_valid()
    })
}

proptest! {
    #[test]
    fn boxes_from_elsewhere_come_in_as_they_are(boxes in prop::collection::vec(valid_box(), 1..6)) {
        // Corners A … D of each box are a face of the base, E … H the same face of the top.
        let mesh = |name: &str, first: usize| {
            let mut mesh = Mesh { name: name.into(), ..Mesh::default() };
            for corners in &boxes {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| (mesh.positions.len() + i) as u32);
                mesh.positions.extend_from_slice(&corners[first..first + 4]);
                mesh.faces.push(Face::quad([a, b, d, c], MaterialId(0)));
            }
            mesh
        };
        let skin = cage(&mesh("base", 0), &mesh("top", 4), ALL, &refusing()).unwrap();
        prop_assert_eq!((skin.report.boxes, skin.report.prisms), (boxes.len(), 0));
        for (patch, corners) in skin.patches.iter().zip(&boxes) {
            let at = |points: &[Vec3]| patch.vertices.map(|v| points[v as usize]);
            prop_assert_eq!(&at(&skin.base)[..], &corners[..4]);
            prop_assert_eq!(&at(&skin.top)[..], &corners[4..]);
        }
    }
}

#[test]
fn prisms_have_the_corners_of_their_triangles() {
    let triangle = |name: &str, positions: [[f32; 3]; 3]| Mesh {
        name: name.into(),
        positions: positions.map(Vec3::from).to_vec(),
        faces: vec![Face::triangle([0, 1, 2], MaterialId(0))],
        uvs: Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ZERO]]),
        ..Mesh::default()
    };
    let base = triangle("base", [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    let top = triangle("top", [[0.2, 0.1, 1.], [0.9, 0.3, 0.7], [0.1, 0.8, 1.3]]);
    let skin = cage(&base, &top, ALL, &refusing()).unwrap();
    assert_eq!((skin.report.prisms, skin.report.boxes), (1, 0));
    assert_eq!((&skin.base, &skin.top), (&base.positions, &top.positions));
}

#[test]
fn what_becomes_quads_divides_the_boxes_that_were_given() {
    // Without texture coordinates a triangle becomes three quads, and the quad beside it four: seven boxes. The map
    // of a quad's quarter is the given map of that quarter, so that a quarter's corner over the middle of the quad
    // is the mean of the four tops, and one over the middle of an edge that of two.
    let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [2., 0.5, 0.]].map(Vec3::from);
    let faces = vec![Face::quad([0, 1, 2, 3], MaterialId(0)), Face::triangle([1, 4, 2], MaterialId(0))];
    let base = Mesh { name: "base".into(), positions: positions.to_vec(), faces, ..Mesh::default() };
    let top = moved(&base, |p| p + Vec3::new(0.3 * p.y, -0.1 * p.x, 1.0 + 0.25 * p.x * p.y));
    let skin = cage(&base, &top, ALL, &refusing()).unwrap();
    assert!(skin.report.refined);
    assert_eq!((skin.report.boxes, skin.report.prisms), (7, 0));
    let over = |x: f32, y: f32| {
        let i = skin.base.iter().position(|p| *p == Vec3::new(x, y, 0.0)).expect("a vertex");
        skin.top[i]
    };
    let t = &top.positions;
    assert_eq!(over(0.5, 0.5), (t[0] + t[1] + t[2] + t[3]) / 4.0);
    assert_eq!(over(1.0, 0.5), (t[1] + t[2]) / 2.0);
    assert_eq!(over(1.0, 1.0), t[2]);
}

#[test]
fn a_bent_and_twisted_cage_is_certified() {
    // Fur combed to 40° along a field that turns around the middle: the top of (x, z) leans by up to 40° across
    // (x, z) and is turned with it.
    let base = surface::plane(2.0, 12, 12);
    let top = moved(&base, |p| {
        let angle = 40f32.to_radians() * p.length().min(1.0);
        let across = Vec3::Y.cross(p).normalize_or_zero();
        p + Mat3::from_axis_angle(Vec3::Y, 0.3) * (0.15 * (angle.cos() * Vec3::Y + angle.sin() * across))
    });
    let skin = cage(&base, &top, ALL, &refusing()).unwrap();
    assert_eq!((skin.len(), skin.report.folds.len()), (144, 0));
    skin.validate(6).unwrap();
    // Every vector is 0.15 m long.
    assert!((mean_height(&base, &top, ALL) - 0.15).abs() < 1e-6);
    // Copies as wide as those vectors are long: 2/0.15 = 13.3 of them on the plane.
    assert_eq!(skin.report.tiling, 13.0);
}

#[test]
fn folded_boxes_are_mended_towards_the_base() {
    // The top of a plane's middle vertex dips to 0.1 m below it, the others lie 1 m above: the four boxes around it
    // are folded at any height; det J at the vertex is −0.1 · 1. Every other box stays.
    let base = surface::plane(4.0, 4, 4);
    let dip = moved(&base, |p| p + if p == Vec3::ZERO { -0.1 * Vec3::Y } else { Vec3::Y });
    let skin = cage(&base, &dip, ALL, &SkinOptions::default()).unwrap();
    assert_eq!((skin.len(), skin.report.left_out(), skin.report.mended_vertices), (12, 4, 0));
    match cage(&base, &dip, ALL, &refusing()) {
        Err(SkinError::Folded { count: 4, first, .. }) => {
            assert!((first.determinant + 0.1).abs() < 1e-6, "{first}");
        }
        other => panic!("{other:?}"),
    }
    // Leaning over its neighbour by 1.5 m for 1 m up, the middle one folds the boxes on its right; a shorter vector
    // would not: (1.5 s, s) stays left of the neighbour at 1 m where s < 2/3, so 0.8² = 0.64 is enough.
    let leaning = moved(&base, |p| p + if p == Vec3::ZERO { Vec3::new(1.5, 1.0, 0.0) } else { Vec3::Y });
    let skin = cage(&base, &leaning, ALL, &SkinOptions::default()).unwrap();
    assert_eq!((skin.len(), skin.report.left_out()), (16, 0));
    assert!(skin.report.mended() >= 2 && skin.report.shortest < 1.0, "{}", skin.report);
    skin.validate(6).unwrap();
    let middle = skin.base.iter().position(|p| *p == Vec3::ZERO).expect("the middle");
    let vector = skin.top[middle] - skin.base[middle];
    assert!((vector - skin.report.shortest * Vec3::new(1.5, 1.0, 0.0)).length() < 1e-6, "{vector}");
}

#[test]
fn a_top_on_its_base_leaves_nothing() {
    let base = surface::plane(1.0, 2, 2);
    let skin = cage(&base, &moved(&base, |p| p), ALL, &SkinOptions::default()).unwrap();
    assert!(skin.is_empty());
    assert_eq!(skin.report.left_out(), 4);
}

#[test]
fn vertices_with_several_tops_are_counted() {
    // Two unit quads side by side, whose boxes part company above their common edge.
    let base = surface::plane(2.0, 2, 1);
    let mut top = torn_apart(&moved(&base, |p| p + Vec3::Y));
    for v in top.faces[0].vertices {
        top.positions[v as usize].x -= 0.1;
    }
    let skin = cage(&base, &top, ALL, &refusing()).unwrap();
    assert_eq!((skin.len(), skin.report.torn_vertices, skin.report.open_edges), (2, 2, 8));
    assert_eq!(skin.base.len(), 8);
}

#[test]
fn other_faces_are_named() {
    let base = surface::plane(1.0, 3, 2);
    let up = |mesh: &Mesh| moved(mesh, |p| p + 0.1 * Vec3::Y);
    let failure = |top: &Mesh| cage(&base, top, ALL, &SkinOptions::default()).unwrap_err();
    let names = || ("plane".to_owned(), "top".to_owned());

    let mut fewer = up(&base);
    fewer.faces.truncate(4);
    fewer.uvs = None;
    let ((b, t), error) = (names(), failure(&fewer));
    assert_eq!(error, SkinError::CageFaces { base: b, top: t, base_faces: 6, top_faces: 4 });
    assert_eq!(
        error.to_string(),
        "mesh `plane` has 6 faces and the top of its cage, `top`, has 4: face 4 is in one of them only"
    );

    // Said before the count: it is the reason for it.
    let mut cut = up(&base);
    let [a, b, c, d] = cut.faces[2].vertices;
    cut.uvs = None;
    cut.faces[2] = Face::triangle([a, b, c], MaterialId(0));
    cut.faces.insert(3, Face::triangle([a, c, d], MaterialId(0)));
    let (b, t) = names();
    let expected = SkinError::CageCorners { base: b, top: t, face: 2, base_corners: 4, top_corners: 3 };
    assert_eq!(failure(&cut), expected);

    // The same faces in another order, and each begun at another corner.
    let mut swapped = up(&base);
    swapped.faces.swap(0, 5);
    let mut turned = up(&base);
    turned.faces.iter_mut().for_each(|f| f.vertices.rotate_left(1));
    for other in [swapped, turned] {
        assert!(matches!(failure(&other), SkinError::CageVertices { face: 0, .. }), "{}", failure(&other));
    }
}

#[test]
fn numbers_that_are_none_are_named() {
    let base = surface::plane(1.0, 2, 2);
    let mut top = moved(&base, |p| p + Vec3::Y);
    top.positions[3].z = f32::INFINITY;
    match cage(&base, &top, ALL, &SkinOptions::default()) {
        Err(SkinError::Top(MeshError::NonFinite { vertex: 3, .. })) => {}
        other => panic!("{other:?}"),
    }
    match cage(&top, &base, ALL, &SkinOptions::default()) {
        Err(SkinError::Mesh(MeshError::NonFinite { vertex: 3, .. })) => {}
        other => panic!("{other:?}"),
    }
    let leaning = SkinOptions { lean: Vec3::X, ..SkinOptions::default() };
    match cage(&base, &base, ALL, &leaning) {
        Err(SkinError::Option { option: "lean", .. }) => {}
        other => panic!("{other:?}"),
    }
}
