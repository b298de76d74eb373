//! Folded boxes are found, named, and mended, left out or refused; degenerate meshes have defined results.

use pelage_geom::glam::{Vec2, Vec3};
use pelage_geom::{Certificate, Face, MaterialId, Mesh, MeshError, certify};
use pelage_skin::{Folds, Outcome, Skin, SkinError, SkinOptions, extrude, surface};
use proptest::prelude::*;

/// A groove along z: y = |x| over x = −4d … 4d with d = 1, three quads long.
///
/// On the slopes the vectors are (∓1, 1)/√2, in the groove (0, 1). The box beside the groove has its top edge from
/// (0, h) to (1 − h/√2, 1 + h/√2), so that at its inner top corner det J = (1 − h/√2) h per unit of length: it
/// is folded where h ≥ √2. At its outer one it is (2 − h) h/√2. No other box is ever folded.
fn groove() -> Mesh {
    let mut mesh = surface::plane(8.0, 8, 3);
    for p in &mut mesh.positions {
        p.y = p.x.abs();
    }
    mesh.uvs = None;
    mesh
}

fn options(height: f32, folds: Folds) -> SkinOptions {
    SkinOptions { folds, ..SkinOptions::new(height) }
}

fn assert_certified(skin: &Skin) {
    skin.validate(6).unwrap();
    assert!((0..skin.len()).all(|i| certify(&skin.hexahedron(i), 6).is_valid()));
}

#[test]
fn a_groove_folds_at_its_derived_height() {
    let below = extrude(&groove(), &|_| true, &options(1.41, Folds::Refuse)).unwrap();
    assert_eq!(below.len(), 24);
    assert_certified(&below);
    match extrude(&groove(), &|_| true, &options(1.42, Folds::Refuse)) {
        Err(SkinError::Folded { count, first, .. }) => {
            // Two boxes beside the groove, three times.
            assert_eq!(count, 6);
            // The faces come row by row, eight a row: the first beside the groove is the fourth.
            assert_eq!((first.face, first.outcome), (3, Outcome::Found { patch: 3 }));
            assert!(first.determinant < 0.0 && first.at.z == 1.0, "{first}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn folded_boxes_are_left_out_where_asked() {
    let skin = extrude(&groove(), &|_| true, &options(1.5, Folds::LeaveOut)).unwrap();
    assert_eq!((skin.len(), skin.report.left_out(), skin.report.mended_vertices), (18, 6, 0));
    assert!(
        skin.report.folds.iter().all(|f| f.outcome == Outcome::LeftOut && [3, 4].contains(&(f.face % 8)))
    );
    assert!(skin.patches.iter().all(|p| ![3, 4].contains(&(p.face % 8))));
    assert_certified(&skin);
}

#[test]
fn folded_boxes_are_mended() {
    let skin = extrude(&groove(), &|_| true, &options(1.5, Folds::Mend)).unwrap();
    assert_eq!((skin.len(), skin.report.left_out(), skin.report.mended()), (24, 0, 6));
    assert_certified(&skin);
    // 1.5 × 0.8 = 1.2 < √2: one step, at the groove and the rows beside it: three rows of four vertices.
    assert_eq!((skin.report.mended_vertices, skin.report.shortest), (12, 0.8));
    for fold in &skin.report.folds {
        let Outcome::Mended { patch } = fold.outcome else { panic!("{fold}") };
        assert_eq!(skin.patches[patch as usize].face, fold.face);
    }
}

#[test]
fn the_inside_of_a_sphere_is_mended_to_less_than_its_radius() {
    let mut hollow = surface::cube_sphere(1.0, 6);
    hollow.faces.iter_mut().for_each(|f| f.vertices.swap(1, 3));
    let skin = extrude(&hollow, &|_| true, &options(3.0, Folds::Mend)).unwrap();
    assert_eq!((skin.len(), skin.report.left_out()), (216, 0));
    assert_certified(&skin);
    let heights = skin.base.iter().zip(&skin.top).map(|(b, t)| b.distance(*t));
    let (least, most) = heights.fold((f32::INFINITY, 0f32), |(lo, hi), h| (lo.min(h), hi.max(h)));
    // 3 × 0.8⁵ = 0.983 is the first below the radius; the polyhedron's is a little less, so one step more is fair.
    assert!(most < 1.0 && least > 0.75, "{least} {most}");
}

#[test]
fn what_cannot_be_mended_does_not_shorten_its_neighbours() {
    // A plane with one quad hanging below it, inside out: its boxes are folded at any height.
    let mut mesh = surface::plane(3.0, 3, 3);
    mesh.faces[4].vertices.swap(1, 3);
    mesh.uvs = None;
    let skin = extrude(&mesh, &|_| true, &options(0.5, Folds::Mend)).unwrap();
    assert_eq!((skin.len(), skin.report.left_out(), skin.report.mended_vertices), (8, 1, 0));
    assert_eq!((skin.report.folds[0].face, skin.report.misoriented_edges), (4, 4));
    assert_certified(&skin);
}

#[test]
fn mended_patches_are_named_by_their_place_in_the_skin() {
    // The second quad of the second row is inside out and goes; those that follow move up by one.
    let mut mesh = groove();
    mesh.faces[9].vertices.swap(1, 3);
    let skin = extrude(&mesh, &|_| true, &options(1.5, Folds::Mend)).unwrap();
    assert_eq!((skin.len(), skin.report.left_out(), skin.report.mended()), (23, 1, 6));
    for fold in &skin.report.folds {
        if let Outcome::Mended { patch } = fold.outcome {
            assert_eq!(skin.patches[patch as usize].face, fold.face);
        }
    }
}

#[test]
fn a_height_below_the_rounding_of_the_vertices_leaves_nothing() {
    let mut mesh = surface::plane(1.0, 2, 2);
    mesh.positions.iter_mut().for_each(|p| p.y = 1000.0);
    let skin = extrude(&mesh, &|_| true, &options(1e-6, Folds::Mend)).unwrap();
    assert!(skin.is_empty());
    assert_eq!(skin.report.left_out(), 4);
}

#[test]
fn cancelling_normals_are_named() {
    // A sheet with two sides on the same four vertices: one box on the first, none on the other.
    let mut mesh = surface::plane(1.0, 1, 1);
    mesh.uvs = None;
    mesh.faces.push(Face::quad([0, 2, 3, 1], MaterialId(0)));
    let skin = extrude(&mesh, &|_| true, &options(0.1, Folds::Mend)).unwrap();
    assert_eq!(skin.report.cancelled_normals, [0, 1, 2, 3]);
    assert_eq!((skin.len(), skin.report.left_out(), skin.patches[0].face), (1, 1, 0));
    assert!(skin.top.iter().zip(&skin.base).all(|(t, b)| (*t - *b).y > 0.09));
    assert_certified(&skin);
}

#[test]
fn a_corner_whose_mean_normal_is_hidden_is_turned() {
    // A fan of seven triangles around the origin. Six lie in the ground and fill 5/6 of the turn; the last gap is
    // closed by a fin: up to a point P above the ground and down again. The ground's angle, 300°, outweighs the fin.
    let ring = |degrees: f32| Vec3::new(degrees.to_radians().cos(), 0.0, -degrees.to_radians().sin());
    let mut positions = vec![Vec3::ZERO];
    positions.extend((0..=6).map(|i| ring(50.0 * i as f32)));
    // Leaning back over the ground, so that the outer side of the fin looks down.
    positions.push(Vec3::new(-0.6, 0.7, -0.3));
    let fans = [[1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7], [7, 8], [8, 1]];
    let faces = fans.map(|[a, b]| Face::triangle([0, a, b], MaterialId(0))).to_vec();
    let uvs = Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ZERO]; faces.len()]);
    let mesh = Mesh { name: "fin".into(), positions, faces, uvs, ..Mesh::default() };
    let skin = extrude(&mesh, &|_| true, &options(0.05, Folds::Mend)).unwrap();
    let up = (skin.top[0] - skin.base[0]).normalize();
    let seen = (0..mesh.faces.len()).map(|i| mesh.area_vector(i).normalize().dot(up)).fold(1.0, f32::min);
    assert!(skin.report.turned_normals >= 1);
    assert!(seen > 0.0);
    assert_eq!(skin.report.left_out(), 0);
    assert_certified(&skin);
}

#[test]
fn nan_and_other_faults_of_a_mesh_are_named() {
    let mut mesh = surface::plane(1.0, 3, 3);
    mesh.positions[5].y = f32::NAN;
    match extrude(&mesh, &|_| true, &SkinOptions::default()) {
        Err(SkinError::Mesh(MeshError::NonFinite { vertex, .. })) => assert_eq!(vertex, 5),
        other => panic!("{other:?}"),
    }
    let empty = Mesh { name: "nothing".into(), ..Mesh::default() };
    let error = extrude(&empty, &|_| true, &SkinOptions::default()).unwrap_err();
    assert_eq!(error, SkinError::Mesh(MeshError::NoFaces { mesh: "nothing".into() }));
}

#[test]
fn options_out_of_their_domain_are_named() {
    let mesh = surface::plane(1.0, 1, 1);
    let named = |options: SkinOptions| match extrude(&mesh, &|_| true, &options) {
        Err(SkinError::Option { option, .. }) => option,
        other => panic!("{other:?}"),
    };
    for height in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(named(SkinOptions::new(height)), "height");
    }
    assert_eq!(named(SkinOptions { tiling: Some(0.0), ..SkinOptions::default() }), "tiling");
    assert_eq!(named(SkinOptions { aspect: f32::NAN, ..SkinOptions::default() }), "aspect");
    assert_eq!(named(SkinOptions { shortest: 1.5, ..SkinOptions::default() }), "shortest");
    assert_eq!(
        named(SkinOptions { split_nonplanar: Some(-1.0), ..SkinOptions::default() }),
        "split_nonplanar"
    );
}

#[test]
fn nothing_to_cover_is_an_error() {
    let mut mesh = surface::plane(1.0, 2, 1);
    let nothing = |zero_area| SkinError::NothingSelected { mesh: "plane".into(), faces: 2, zero_area };
    assert_eq!(extrude(&mesh, &|_| false, &SkinOptions::default()), Err(nothing(0)));
    mesh.positions.iter_mut().for_each(|p| p.x = 0.0);
    assert_eq!(extrude(&mesh, &|_| true, &SkinOptions::default()), Err(nothing(2)));
}

#[test]
fn degenerate_faces_are_counted_and_left_out() {
    let mut mesh = surface::plane(3.0, 3, 1);
    mesh.uvs = None;
    let material = MaterialId(0);
    // A line, a point, a quad with opposite corners in one, and a second copy of face 0, turned by a corner.
    let [a, b, c, d] = mesh.faces[0].vertices;
    mesh.faces.push(Face::triangle([0, 1, 2], material));
    mesh.faces.push(Face::triangle([a, a, a], material));
    mesh.faces.push(Face::quad([a, b, a, c], material));
    mesh.faces.push(Face::quad([c, d, a, b], material));
    mesh.positions.push(Vec3::splat(9.0));
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!(skin.report.zero_area_faces, [3, 4, 5]);
    assert_eq!(skin.report.duplicate_faces, [6]);
    assert_eq!(skin.report.isolated_vertices, 1);
    assert_eq!((skin.len(), skin.report.boxes, skin.base.len()), (3, 3, 8));
}

#[test]
fn a_quad_with_a_collapsed_side_is_a_triangle() {
    let mut mesh = surface::plane(1.0, 1, 1);
    mesh.positions[3] = mesh.positions[2];
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!((skin.report.prisms, skin.report.boxes, skin.report.welded_vertices), (1, 0, 1));
    assert_certified(&skin);
}

#[test]
fn three_faces_on_an_edge_share_its_wall() {
    // Three quads like the pages of a book, 120° apart around the z axis: their normals cancel on it.
    let mut mesh = Mesh { name: "book".into(), positions: vec![Vec3::ZERO, Vec3::Z], ..Mesh::default() };
    for page in 0..3 {
        let out = Vec3::new((page as f32 * 2.0944).cos(), (page as f32 * 2.0944).sin(), 0.0);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([out, out + Vec3::Z]);
        mesh.faces.push(Face::quad([0, first, first + 1, 1], MaterialId(0)));
    }
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!((skin.report.non_manifold_edges, skin.report.open_edges), (1, 9));
    assert!(!skin.is_empty());
    assert_eq!(skin.len() + skin.report.left_out(), 3);
    assert_certified(&skin);
}

#[test]
fn validate_names_what_is_wrong() {
    let skin = extrude(&surface::plane(1.0, 2, 2), &|_| true, &SkinOptions::new(0.1)).unwrap();
    let spoilt = |spoil: &dyn Fn(&mut Skin)| {
        let mut copy = skin.clone();
        spoil(&mut copy);
        copy.validate(4).unwrap_err()
    };
    assert_eq!(spoilt(&|s| s.top.truncate(3)), SkinError::Length { list: "top", length: 3, expected: 9 });
    assert_eq!(
        spoilt(&|s| s.uvs = Some(Vec::new())),
        SkinError::Length { list: "uvs", length: 0, expected: 4 }
    );
    assert_eq!(
        spoilt(&|s| s.patches[2].vertices[1] = 77),
        SkinError::IndexOutOfRange { patch: 2, index: 77, count: 9 }
    );
    assert_eq!(spoilt(&|s| s.top[8].x = f32::NAN), SkinError::NonFinite { vertex: 8 });
    assert_eq!(spoilt(&|s| s.patches[1].lattice.v = s.patches[1].lattice.u), SkinError::Lattice { patch: 1 });
    // A top corner pulled through the base.
    match spoilt(&|s| s.top[0].y = -0.1) {
        SkinError::FoldedBox(fold) => {
            assert_eq!((fold.face, fold.outcome), (0, Outcome::Found { patch: 0 }));
            let certificate = certify(&skin.hexahedron(0), 4);
            assert!(matches!(certificate, Certificate::Valid { .. }) && fold.determinant <= 0.0);
        }
        other => panic!("{other}"),
    }
}

/// A coordinate that coincides with others often enough to make degenerate faces.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![4 => (-2..3i8).prop_map(f32::from), 1 => -1e3f32..1e3, 1 => Just(1e-20f32), 1 => Just(-0.0f32)]
}

fn any_mesh() -> impl Strategy<Value = Mesh> {
    let positions = prop::collection::vec((coordinate(), coordinate(), coordinate()), 4..12);
    (positions, any::<bool>()).prop_flat_map(|(positions, with_uvs)| {
        let index = 0..positions.len() as u32;
        let corner = prop::collection::vec(index, 4);
        let uv = || prop_oneof![2 => 0f32..1.0, 1 => Just(0.5f32), 1 => Just(f32::MAX), 1 => Just(1e-30f32)];
        let uvs = prop::collection::vec((uv(), uv()), 4);
        let face = (corner, any::<bool>(), uvs);
        prop::collection::vec(face, 1..12).prop_map(move |faces| {
            let mut mesh = Mesh { name: "any".into(), ..Mesh::default() };
            mesh.positions = positions.iter().map(|&p| Vec3::from(p)).collect();
            for (corner, quad, uvs) in &faces {
                let vertices = [corner[0], corner[1], corner[2], if *quad { corner[3] } else { Face::NONE }];
                mesh.faces.push(Face { vertices, material: MaterialId(0) });
                if with_uvs {
                    let uvs = [0, 1, 2, 3].map(|i: usize| Vec2::from(uvs[i]));
                    mesh.uvs.get_or_insert_default().push(uvs);
                }
            }
            mesh
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Whatever the mesh: a named error, or a skin of which every box is certified and every face accounted for.
    #[test]
    fn any_mesh_gives_a_valid_skin_or_an_error(
        mesh in any_mesh(),
        height in prop_oneof![Just(1e-6f32), 0.01f32..3.0, Just(1e12f32)],
        tiling in prop_oneof![Just(None), (1e-6f32..1e6).prop_map(Some)],
    ) {
        let options = SkinOptions { tiling, ..SkinOptions::new(height) };
        match extrude(&mesh, &|_| true, &options) {
            Ok(skin) => {
                prop_assert_eq!(skin.validate(options.certificate_depth), Ok(()));
                let report = &skin.report;
                let unmade = |face: &u32| {
                    report.zero_area_faces.contains(face)
                        || report.duplicate_faces.contains(face)
                        || report.folds.iter().any(|f| f.face == *face && f.outcome == Outcome::LeftOut)
                };
                for face in 0..mesh.faces.len() as u32 {
                    prop_assert!(unmade(&face) || skin.patches.iter().any(|p| p.face == face), "face {}", face);
                }
            }
            Err(error) => prop_assert!(matches!(error, SkinError::NothingSelected { .. }), "{}", error),
        }
    }
}

#[test]
fn lean_tilts_by_its_part_across_the_normal() {
    // On a plane facing +Y, a lean of (1, 5, 0) has the part (1, 0, 0) across: vectors turn 45° towards +x and
    // keep their length. On a sphere the boxes stay valid, and the pole, where the lean is the normal, stays.
    let options = SkinOptions { lean: Vec3::new(1.0, 5.0, 0.0), ..SkinOptions::new(0.2) };
    let plane = extrude(&surface::plane(2.0, 4, 4), &|_| true, &options).unwrap();
    let diagonal = 0.2 * Vec3::new(1.0, 1.0, 0.0).normalize();
    assert!(plane.base.iter().zip(&plane.top).all(|(b, t)| (*t - *b - diagonal).length() < 1e-6));
    assert_certified(&plane);

    let options = SkinOptions { lean: Vec3::new(0.0, -0.8, 0.0), ..SkinOptions::new(0.1) };
    let sphere = extrude(&surface::cube_sphere(1.0, 8), &|_| true, &options).unwrap();
    let pole = (0..sphere.base.len()).max_by(|&a, &b| sphere.base[a].y.total_cmp(&sphere.base[b].y)).unwrap();
    assert!((sphere.top[pole] - sphere.base[pole] - 0.1 * Vec3::Y).length() < 1e-5);
    let side = (0..sphere.base.len()).min_by(|&a, &b| {
        let height = |i: usize| sphere.base[i].y.abs() + sphere.base[i].z.abs();
        height(a).total_cmp(&height(b))
    });
    assert!(sphere.top[side.unwrap()].y < -0.05);
    assert_certified(&sphere);

    let flat = SkinOptions { lean: Vec3::new(f32::NAN, 0.0, 0.0), ..SkinOptions::new(0.1) };
    assert!(matches!(
        extrude(&surface::plane(1.0, 1, 1), &|_| true, &flat),
        Err(SkinError::Option { option: "lean", .. })
    ));
}
