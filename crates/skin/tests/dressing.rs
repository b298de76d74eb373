//! Texel coordinates: what they are, where a quad stays one box, and that they are continuous across edges.

use pelage_geom::glam::{Vec2, Vec3};
use pelage_geom::{Face, MaterialId, Mesh};
use pelage_skin::{Lattice, Layout, Skin, SkinError, SkinOptions, extrude, surface};
use proptest::prelude::*;
use std::collections::HashMap;

fn tiled(tiling: f32) -> SkinOptions {
    SkinOptions { tiling: Some(tiling), ..SkinOptions::new(0.01) }
}

/// (s, t) at the corners of a patch, in box order.
fn corners(skin: &Skin, patch: usize) -> [Vec2; 4] {
    let lattice = skin.patches[patch].lattice;
    [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|uv| lattice.point(uv))
}

/// How far (s, t) differs from a whole number across the edges between patches, at most.
fn worst_seam(skin: &Skin) -> f32 {
    const SIDES: [&[[usize; 2]]; 2] = [&[[0, 1], [1, 3], [3, 2], [2, 0]], &[[0, 1], [1, 2], [2, 0]]];
    let mut edges: HashMap<[u32; 2], [Vec2; 2]> = HashMap::new();
    let mut worst = 0f32;
    for (i, patch) in skin.patches.iter().enumerate() {
        let st = corners(skin, i);
        for &[p, q] in SIDES[usize::from(patch.is_prism())] {
            let (mut ends, mut here) = ([patch.vertices[p], patch.vertices[q]], [st[p], st[q]]);
            if ends[0] > ends[1] {
                ends.reverse();
                here.reverse();
            }
            if let Some(there) = edges.insert(ends, here) {
                let jump = here[0] - there[0];
                worst = worst.max((jump - jump.round()).abs().max_element());
                // The same whole number at both ends, or the copies would be stretched along the edge.
                worst = worst.max((here[1] - there[1] - jump).abs().max_element());
            }
        }
    }
    worst
}

#[test]
fn a_plane_is_laid_out_by_its_coordinates() {
    // Four quads on [0,1]² at tiling 2: one whole copy each, shifted to [0,1]².
    let skin = extrude(&surface::plane(1.0, 2, 2), &|_| true, &tiled(2.0)).unwrap();
    assert_eq!(skin.report.boxes, 4);
    assert!(skin.patches.iter().all(|p| p.lattice == Lattice::UNIT));
    assert_eq!(skin.report.copy_width, 0.5);
    // At tiling 1 each holds a quarter.
    let skin = extrude(&surface::plane(1.0, 2, 2), &|_| true, &tiled(1.0)).unwrap();
    let half = Lattice { origin: Vec2::new(0.5, 0.5), u: 0.5 * Vec2::X, v: 0.5 * Vec2::Y };
    assert_eq!(skin.patches[3].lattice, half);
    assert_eq!(skin.report.mirrored, 0);
}

#[test]
fn borders_between_copies_coincide_with_edges() {
    // 0.3_f32 · 10 is 3.000000119: without snapping, a sliver of the next copy would be left on the patch.
    let skin = extrude(&surface::plane(1.0, 10, 10), &|_| true, &tiled(10.0)).unwrap();
    assert!(skin.patches.iter().all(|p| p.lattice == Lattice::UNIT));
}

#[test]
fn the_mesh_s_own_coordinates_are_kept_in_box_order() {
    let skin = extrude(&surface::plane(1.0, 1, 1), &|_| true, &tiled(3.0)).unwrap();
    assert_eq!(skin.uvs, Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE]]));
    let p = skin.patches[0].vertices.map(|i| skin.base[i as usize]);
    // u along +X, v along −Z.
    assert_eq!([p[1] - p[0], p[2] - p[0], p[3] - p[0]], [Vec3::X, -Vec3::Z, Vec3::X - Vec3::Z]);
}

#[test]
fn a_copy_is_about_as_wide_as_asked_for() {
    // A plane of 1 m over [0,1]²: boxes 3 cm high, copies twice as wide, so 1/0.06 = 16.7 → 17 of them.
    let options = SkinOptions { aspect: 2.0, ..SkinOptions::new(0.03) };
    let skin = extrude(&surface::plane(1.0, 5, 5), &|_| true, &options).unwrap();
    assert_eq!(skin.report.tiling, 17.0);
    assert!((skin.report.copy_width - 1.0 / 17.0).abs() < 1e-6);
}

#[test]
fn a_torus_has_no_seam() {
    // Its coordinates jump from 1 to 0, which a whole tiling turns into a whole number of copies.
    let skin = extrude(&surface::torus(1.0, 0.4, 24, 12), &|_| true, &SkinOptions::new(0.07)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.prisms), (288, 0));
    assert!(skin.report.tiling > 1.0);
    assert!(worst_seam(&skin) < 1e-5, "{}", worst_seam(&skin));
}

#[test]
fn a_parallelogram_is_affine_and_a_trapezoid_is_not() {
    let mut mesh = surface::plane(1.0, 1, 1);
    mesh.uvs = Some(vec![[(0.0, 0.0), (0.5, 0.1), (0.8, 0.7), (0.3, 0.6)].map(Vec2::from)]);
    let skin = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    assert_eq!((skin.report.boxes, skin.report.split_by_uvs), (1, 0));
    // The fourth corner 0.01 off: more than the tolerance of 1/512.
    mesh.uvs = Some(vec![[(0.0, 0.0), (0.5, 0.1), (0.81, 0.7), (0.3, 0.6)].map(Vec2::from)]);
    let skin = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    assert_eq!((skin.report.prisms, skin.report.split_by_uvs), (2, 1));
    assert!(worst_seam(&skin) < 1e-6);
    // … and less than a tolerance of 0.02: one box again, no corner off by more than a quarter of the gap.
    let lax = SkinOptions { affine_tolerance: 0.02, ..tiled(1.0) };
    let skin = extrude(&mesh, &|_| true, &lax).unwrap();
    assert_eq!(skin.report.boxes, 1);
    let [a, b, c, d] = corners(&skin, 0);
    for (got, wanted) in [(a, (0.0, 0.0)), (b, (0.5, 0.1)), (c, (0.3, 0.6)), (d, (0.81, 0.7))] {
        assert!(got.distance(Vec2::from(wanted)) < 0.0026, "{got}");
    }
}

#[test]
fn mirrored_coordinates_are_counted() {
    let mut mesh = surface::plane(1.0, 2, 1);
    for uv in mesh.uvs.as_mut().unwrap()[1].iter_mut() {
        uv.x = 1.0 - uv.x;
    }
    let skin = extrude(&mesh, &|_| true, &tiled(2.0)).unwrap();
    assert_eq!(skin.report.mirrored, 1);
    assert!(skin.patches[1].lattice.determinant() < 0.0);
    skin.validate(4).unwrap();
}

#[test]
fn coordinates_without_area_fall_back_on_the_shape() {
    let mut mesh = surface::plane(1.0, 2, 1);
    mesh.uvs.as_mut().unwrap()[1] = [Vec2::splat(0.3); 4];
    // The other quad is ½ m × 1 m over ½ × 1, so a copy at tiling 4 is ¼ m wide: 2 × 4 whole copies.
    let skin = extrude(&mesh, &|_| true, &tiled(4.0)).unwrap();
    assert_eq!((skin.report.zero_area_uvs, skin.report.boxes), (1, 2));
    assert_eq!(
        skin.patches[1].lattice,
        Lattice { origin: Vec2::new(-1.0, -2.0), u: 2.0 * Vec2::X, v: 4.0 * Vec2::Y }
    );
    skin.validate(4).unwrap();

    // A triangle is laid flat: legs of ½ m and 1 m, a copy ¼ m wide.
    mesh.faces[1] = Face::triangle(mesh.faces[1].vertices[..3].try_into().unwrap(), MaterialId(0));
    let skin = extrude(&mesh, &|_| true, &tiled(4.0)).unwrap();
    assert_eq!((skin.report.zero_area_uvs, skin.report.prisms), (1, 1));
    assert!((skin.patches[1].lattice.determinant() - 8.0).abs() < 1e-5);
}

#[test]
fn coordinates_on_a_line_have_no_area_despite_rounding() {
    let mut mesh = surface::plane(1.0, 1, 1);
    // Their rounding, 4e-6, is far more than nothing at 100 copies a unit.
    let on_line = |x: f32| Vec2::new(x, 100.0 + 0.1 * x);
    mesh.uvs = Some(vec![[0.1, 0.35, 0.8, 0.55].map(on_line)]);
    let skin = extrude(&mesh, &|_| true, &SkinOptions { layout: Layout::Uv, ..tiled(100.0) }).unwrap();
    assert_eq!(skin.report.zero_area_uvs, 1);
    skin.validate(4).unwrap();
}

#[test]
fn without_any_area_in_them_coordinates_are_not_used() {
    let mut mesh = surface::plane(1.0, 2, 2);
    mesh.uvs = Some(vec![[Vec2::ZERO; 4]; 4]);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert!(skin.patches.iter().all(|p| p.lattice == Lattice::UNIT));
    assert_eq!(skin.report.zero_area_uvs, 4);
    let none = Mesh { uvs: None, ..mesh };
    let options = SkinOptions { layout: Layout::Uv, ..SkinOptions::new(0.1) };
    assert_eq!(extrude(&none, &|_| true, &options), Err(SkinError::NoUvs { mesh: "plane".into() }));
}

#[test]
fn far_coordinates_lose_no_precision() {
    // 4096 + ¼ and the like are exact in f32; what is stored is the fraction alone.
    let mut mesh = surface::plane(1.0, 4, 4);
    let near = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    for uv in mesh.uvs.as_mut().unwrap().iter_mut().flatten() {
        *uv += Vec2::new(4096.0, -4096.0);
    }
    let far = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    for (near, far) in near.patches.iter().zip(&far.patches) {
        assert_eq!(near.lattice, far.lattice);
        // It is known by another number, 4096 copies away.
        assert_eq!(far.anchor.first, [near.anchor.first[0] + 4096, near.anchor.first[1] - 4096]);
    }
}

#[test]
fn patches_that_share_a_copy_know_it_by_one_number() {
    // Copies at tiling 1.7 straddle the edges of a plane of 6 × 5 quads, of which some are cut into triangles.
    let mut mesh = surface::plane(1.0, 6, 5);
    for quad in [3, 8, 20] {
        let [a, b, c, d] = mesh.faces[quad].vertices;
        let uvs = mesh.uvs.as_ref().unwrap()[quad];
        mesh.faces[quad] = Face::triangle([a, b, c], MaterialId(0));
        mesh.faces.push(Face::triangle([a, c, d], MaterialId(0)));
        mesh.uvs.as_mut().unwrap().push([uvs[0], uvs[2], uvs[3], Vec2::ZERO]);
    }
    let skin = extrude(&mesh, &|_| true, &tiled(1.7)).unwrap();
    assert_eq!(skin.len(), 33);
    for (i, patch) in skin.patches.iter().enumerate() {
        for (corner, vertex) in patch.vertices.iter().take(patch.corners().len()).enumerate() {
            // (s, t) in the island is 1.7 (x, −z), measured from the corner where the texture coordinates are 0.
            let st = corners(&skin, i)[corner] + Vec2::from(patch.anchor.first.map(|n| n as f32));
            let p = skin.base[*vertex as usize];
            let expected = 1.7 * Vec2::new(p.x + 0.5, 0.5 - p.z);
            assert!((st - expected).length() < 1e-5, "patch {i}: {st} for {expected}");
        }
        assert_eq!(patch.anchor.island, skin.patches[0].anchor.island);
    }
    // Per patch, each has copies of its own, and so have charts that have nothing to do with each other.
    let own = extrude(&mesh, &|_| true, &SkinOptions::per_patch(0.1)).unwrap();
    let mut islands: Vec<u32> = own.patches.iter().map(|p| p.anchor.island).collect();
    islands.dedup();
    assert_eq!(islands.len(), own.len());
    let mut mesh = surface::plane(1.0, 2, 1);
    mesh.uvs.as_mut().unwrap()[1] = mesh.uvs.as_ref().unwrap()[0];
    mesh.uvs.as_mut().unwrap()[1].iter_mut().for_each(|uv| *uv += Vec2::splat(0.01));
    let two = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    assert_ne!(two.patches[0].anchor.island, two.patches[1].anchor.island);
}

#[test]
fn a_quad_per_patch_holds_whole_copies() {
    let options = SkinOptions { tiling: Some(2.4), ..SkinOptions::per_patch(0.1) };
    let skin = extrude(&surface::cube_sphere(1.0, 3), &|_| true, &options).unwrap();
    let two = Lattice { origin: Vec2::splat(-1.0), u: 2.0 * Vec2::X, v: 2.0 * Vec2::Y };
    assert!(skin.patches.iter().all(|p| p.lattice == two));
    assert_eq!(skin.report.tiling, 2.0);
}

#[test]
fn a_bent_quad_splits_where_asked() {
    let mut mesh = surface::plane(1.0, 1, 1);
    // One corner raised by 0.4: the diagonals pass each other about 0.2 apart, over an area of about 1.
    mesh.positions[0].y = 0.4;
    let whole = extrude(&mesh, &|_| true, &tiled(1.0)).unwrap();
    assert_eq!(whole.report.boxes, 1);
    for (limit, prisms) in [(0.15, 2), (0.25, 0)] {
        let options = SkinOptions { split_nonplanar: Some(limit), ..tiled(1.0) };
        let skin = extrude(&mesh, &|_| true, &options).unwrap();
        assert_eq!((skin.report.prisms, skin.report.split_nonplanar), (prisms, prisms / 2));
        assert_eq!(worst_seam(&skin), 0.0);
        skin.validate(4).unwrap();
    }
}

#[test]
fn a_quad_that_is_not_convex_becomes_two_prisms() {
    // An arrowhead: the third corner lies inside the triangle of the others.
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.2, 0.2, 0.0), Vec3::Y];
    let faces = vec![Face::quad([0, 1, 2, 3], MaterialId(0))];
    let mesh = Mesh { name: "arrow".into(), positions, faces, ..Mesh::default() };
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert_eq!((skin.report.prisms, skin.report.split_concave), (2, 1));
    assert!(skin.report.folds.is_empty());
    // Both keep their halves of the one copy.
    assert_eq!(worst_seam(&skin), 0.0);
    assert!(skin.patches.iter().all(|p| p.lattice.determinant() == 1.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Where the coordinates are continuous, so is the lattice, whatever is split.
    #[test]
    fn lattices_are_continuous(
        // No triangle loses its area: its height over the diagonal is 0.177, and corners come nearer by less than 0.17.
        jitter in prop::collection::vec((-0.06f32..0.06, -0.06f32..0.06), 25),
        tiling in 0.3f32..20.0,
        far in -50f32..50.0,
    ) {
        let mut mesh = surface::plane(1.0, 4, 4);
        let uv = |i: u32| {
            let (p, j) = (mesh.positions[i as usize], jitter[i as usize]);
            Vec2::new(p.x + j.0 + far, -p.z + j.1)
        };
        mesh.uvs = Some(mesh.faces.iter().map(|f| f.vertices.map(uv)).collect());
        let skin = extrude(&mesh, &|_| true, &tiled(tiling)).unwrap();
        prop_assert!(skin.report.split_by_uvs > 0);
        // A box may be off by a quarter of the affine tolerance at each corner, and so may its neighbour.
        prop_assert!(worst_seam(&skin) < 1.0 / 512.0, "{}", worst_seam(&skin));
        // A lattice near 0: no corner further than the patch is wide.
        for patch in &skin.patches {
            let reach = patch.lattice.u.abs() + patch.lattice.v.abs() + 1.0;
            prop_assert!((patch.lattice.origin.abs()).cmple(reach).all());
        }
    }
}

#[test]
fn charts_of_an_atlas_get_copies_of_one_size() {
    // Two unit squares side by side, one given a half and the other a tenth of the atlas's width: with height ¼
    // both must get 4 × 4 copies, four to a metre.
    let mut mesh = surface::plane(2.0, 2, 1);
    for p in &mut mesh.positions {
        p.z *= 0.5;
    }
    let square = |x: f32, side: f32| {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec2::new(x + side * u, side * v))
    };
    mesh.uvs = Some(vec![square(0.0, 0.5), square(0.8, 0.1)]);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.25)).unwrap();
    assert_eq!(skin.len(), 2);
    for patch in &skin.patches {
        let determinant = patch.lattice.determinant().abs();
        assert!((determinant - 16.0).abs() < 1e-3, "{determinant} copies");
    }
    // A tiling that was asked for is left alone.
    let asked = SkinOptions { tiling: Some(10.0), ..SkinOptions::new(0.25) };
    let skin = extrude(&mesh, &|_| true, &asked).unwrap();
    let copies: Vec<f32> = skin.patches.iter().map(|p| p.lattice.determinant().abs()).collect();
    assert!((copies[0] - 25.0).abs() < 1e-3 && (copies[1] - 1.0).abs() < 1e-3, "{copies:?}");
}

#[test]
fn stretched_parts_of_a_chart_get_finer_copies() {
    // A strip of ten unit squares in one chart, the last four stretched.
    let mut mesh = surface::plane(10.0, 10, 1);
    for p in &mut mesh.positions {
        p.z *= 0.1;
    }
    let widths = [0.1_f32, 0.1, 0.1, 0.1, 0.1, 0.1, 0.02, 0.02, 0.02, 0.02];
    let mut left = 0.0;
    let uvs = widths.map(|w| {
        let x = left;
        left += w;
        // Sides of 0.1 and w: density √(0.1 w) per metre: 0.1, and 0.0447 in the stretched part.
        [(x, 0.0), (left, 0.0), (left, 0.1), (x, 0.1)].map(|(u, v)| Vec2::new(u, v))
    });
    mesh.uvs = Some(uvs.to_vec());
    // Mean density √((6·0.01 + 4·0.002)/10) = 0.0825, so tiling is 1/(0.0825·0.5) = 24: the stretched part has
    // log₂(0.0825/0.0447) = 0.88 octaves less, within one: no polygon changes.
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.5)).unwrap();
    let sides: Vec<f32> = skin.patches.iter().map(|p| p.lattice.v.length()).collect();
    assert!(sides.iter().all(|s| (s - sides[0]).abs() < 1e-4), "{sides:?}");
    // Four times narrower still, 0.005: density 0.0224 against 0.0787, 1.8 octaves: copies twice as fine there.
    let mut uvs = mesh.uvs.take().unwrap();
    let mut left = 0.6;
    for (uv, w) in uvs.iter_mut().skip(6).zip([0.005_f32; 4]) {
        *uv = [(left, 0.0), (left + w, 0.0), (left + w, 0.1), (left, 0.1)].map(|(u, v)| Vec2::new(u, v));
        left += w;
    }
    mesh.uvs = Some(uvs);
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.5)).unwrap();
    let sides: Vec<f32> = skin.patches.iter().map(|p| p.lattice.v.length()).collect();
    assert!((sides[9] / sides[0] - 2.0).abs() < 1e-3, "{sides:?}");
    assert!(sides.iter().all(|s| [1.0, 2.0].iter().any(|k| (s / sides[0] - k).abs() < 1e-3)), "{sides:?}");
}
