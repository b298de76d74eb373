//! The certificate of det J against sampled determinants, and on boxes whose answer is known.

mod random;

use pelage_geom::glam::{DVec3, Vec3};
use pelage_geom::{Certificate, Hexahedron, Trilinear, certify};
use random::Random;

/// A point of the box's own half of `[0,1]³`, often on its boundary.
fn point_of(hexahedron: &Hexahedron, random: &mut Random) -> DVec3 {
    let mut u = random.inside();
    if random.below(2) == 0 {
        u = u.round();
    }
    if hexahedron.is_prism() && u.x + u.y > 1.0 {
        (u.x, u.y) = (1.0 - u.y, 1.0 - u.x);
    }
    u
}

fn random_box(random: &mut Random) -> Hexahedron {
    let map = if random.below(2) == 0 { random.jittered(0.6) } else { random.any_box() };
    let [a, b, c, _, e, f, g, _] = map.corners;
    if random.below(2) == 0 { Hexahedron::cuboid(map) } else { Hexahedron::prism([a, b, c], [e, f, g]) }
}

#[test]
fn the_certificate_tells_the_truth() {
    let mut random = Random::new(40);
    let [mut valid, mut folded, mut undecided] = [0; 3];
    for _ in 0..40_000 {
        let hexahedron = random_box(&mut random);
        match certify(&hexahedron, 5) {
            Certificate::Valid { min_determinant } => {
                valid += 1;
                assert!(min_determinant > 0.0);
                for _ in 0..16 {
                    let u = point_of(&hexahedron, &mut random);
                    let determinant = hexahedron.map().determinant(u);
                    assert!(determinant >= min_determinant, "{determinant} at {u}: {hexahedron:?}");
                }
            }
            Certificate::Folded { at, determinant } => {
                folded += 1;
                assert!(at.min_element() >= 0.0 && at.max_element() <= 1.0);
                assert!(!hexahedron.is_prism() || at.x + at.y <= 1.0);
                let there = hexahedron.map().determinant(at);
                assert!(determinant < 1e-12 && (there - determinant).abs() < 1e-12, "{there} at {at}");
            }
            Certificate::Undecided { .. } => undecided += 1,
        }
    }
    assert!(valid > 10_000 && folded > 5_000 && undecided < 40, "{valid} {folded} {undecided}");
}

#[test]
fn a_parallelepiped_has_one_determinant() {
    // Columns (2,0,0), (1,3,0), (0,1,½): det = 3 everywhere.
    let corner = |i: usize| {
        let [u, v, w] = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit as f32);
        Vec3::new(2.0 * u + v, 3.0 * v + w, 0.5 * w)
    };
    let map = Trilinear { corners: core::array::from_fn(corner) };
    let [a, b, c, _, e, f, g, _] = map.corners;
    for hexahedron in [Hexahedron::cuboid(map), Hexahedron::prism([a, b, c], [e, f, g])] {
        let Certificate::Valid { min_determinant } = certify(&hexahedron, 0) else {
            panic!("{hexahedron:?}")
        };
        assert!((min_determinant - 3.0).abs() < 1e-12);
    }
}

#[test]
fn the_half_of_a_prism_that_is_not_there_does_not_count() {
    // The top's third corner is pulled so far that the completing half folds: at D the uprights would be
    // DH = BF + CG − AE, with w component 0.2 + 0.2 − 1 < 0.
    let base = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let top = [Vec3::Z, Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.0, 1.0, 0.2)];
    let prism = Hexahedron::prism(base, top);
    assert!(certify(&prism, 0).is_valid());
    let whole = Trilinear { corners: prism.map().corners.map(|c| c.as_vec3()) };
    assert!(matches!(certify(&Hexahedron::cuboid(whole), 6), Certificate::Folded { .. }));
}

#[test]
fn a_prism_that_folds_between_its_ends_is_found() {
    // A top turned by a half turn is the mirror image through the axis: at w = ½ all three points meet.
    let base = [Vec3::X, Vec3::new(-0.5, 0.866, 0.0), Vec3::new(-0.5, -0.866, 0.0)];
    let top = base.map(|p| Vec3::new(-p.x, -p.y, 1.0));
    let Certificate::Folded { at, .. } = certify(&Hexahedron::prism(base, top), 0) else {
        panic!("a half turn folds")
    };
    assert!((at.z - 0.5).abs() < 1e-9);
}

#[test]
fn boxes_without_volume_are_folded() {
    let mut flat = Trilinear::identity();
    for c in &mut flat.corners {
        c.z = 0.25 * c.x;
    }
    let point = Trilinear { corners: [Vec3::splat(0.3); 8] };
    let mut mirrored = Trilinear::identity();
    for c in &mut mirrored.corners {
        c.x = -c.x;
    }
    let mut broken = Trilinear::identity();
    broken.corners[5].y = f32::NAN;
    for map in [flat, point, mirrored, broken] {
        let [a, b, c, _, e, f, g, _] = map.corners;
        for hexahedron in [Hexahedron::cuboid(map), Hexahedron::prism([a, b, c], [e, f, g])] {
            assert!(matches!(certify(&hexahedron, 4), Certificate::Folded { .. }), "{map:?}");
        }
    }
}
