//! Newton's inverse in both precisions, over boxes mild to strong.

mod random;

use pelage_geom::glam::DVec3;
use pelage_geom::{Certificate, DTrilinear, Hexahedron, InverseError, Trilinear, certify, paper};
use random::Random;

fn valid(random: &mut Random) -> Trilinear {
    loop {
        let map = random.any_box();
        if let Certificate::Valid { .. } = certify(&Hexahedron::cuboid(map), 4) {
            return map;
        }
    }
}

#[test]
fn points_of_valid_boxes_come_back() {
    let mut random = Random::new(20);
    for _ in 0..200_000 {
        let map = valid(&mut random);
        let wide = DTrilinear::from(map);
        let u = random.inside();
        let found = wide.inverse(wide.point(u), 1e-12).expect("a point of a valid box");
        assert!(found.distance(u) < 1e-9, "{u} came back as {found}: {map:?}");
        let narrow = u.as_vec3();
        let found = map.inverse(map.point(narrow), 1e-5).expect("a point of a valid box");
        // Where det J is small, f32 cannot tell points apart that are this near in the scene.
        assert!(
            map.point(found).distance(map.point(narrow)) < 1e-5,
            "{narrow} came back as {found}: {map:?}"
        );
    }
}

#[test]
fn points_beside_the_box_are_outside() {
    let mut random = Random::new(21);
    for _ in 0..100_000 {
        let map = DTrilinear::from(valid(&mut random));
        let [lo, hi] = map.bounds();
        let x = lo + (hi - lo) * random.inside() + random.direction() * (hi - lo).length();
        assert!(map.inverse(x, 1e-12).is_err(), "{x} is beside the bounds of {map:?}");
    }
    // A parallelepiped extrapolates uniquely: the error tells the very coordinates.
    let outside = DVec3::new(2.5, -1.0, 0.5);
    let Err(InverseError::Outside { coordinates }) = DTrilinear::identity().inverse(outside, 1e-12) else {
        panic!("{outside} is outside the unit cube")
    };
    assert!(coordinates.distance(outside) < 1e-12);
    let extended = DTrilinear::identity().inverse_extended(outside, DVec3::splat(0.5), 1e-12);
    assert!(extended.expect("an affine map").distance(outside) < 1e-12);
}

#[test]
fn the_boundary_is_inside() {
    let mut random = Random::new(22);
    for _ in 0..50_000 {
        let map = DTrilinear::from(valid(&mut random));
        let mut u = random.inside().to_array();
        u[random.below(3)] = random.unit().round();
        let u = DVec3::from_array(u);
        let found = map.inverse(map.point(u), 1e-9).expect("a point of the surface");
        assert!(found.distance(u) < 1e-8 && found == found.clamp(DVec3::ZERO, DVec3::ONE));
    }
}

#[test]
fn it_agrees_with_the_paper_where_that_converges() {
    let mut random = Random::new(23);
    let mut compared = 0;
    for _ in 0..100_000 {
        let map = DTrilinear::from(valid(&mut random));
        let x = map.point(random.inside());
        let Some(paper) = paper::inv_t(&map, x, 1e-13, 50) else { continue };
        if paper == paper.clamp(DVec3::ZERO, DVec3::ONE) {
            compared += 1;
            let found = map.inverse(x, 1e-13).expect("a point of a valid box");
            assert!(found.distance(paper) < 1e-9, "{found} instead of the paper's {paper}");
        }
    }
    assert!(compared > 90_000, "{compared}");
}

#[test]
fn what_has_no_inverse_says_so() {
    let point = DTrilinear { corners: [DVec3::ONE; 8] };
    assert!(matches!(point.inverse(DVec3::ZERO, 1e-9), Err(InverseError::Singular { .. })));
    let mut flat = DTrilinear::identity();
    for c in &mut flat.corners {
        c.z = 0.0;
    }
    assert!(matches!(flat.inverse(DVec3::splat(0.5), 1e-9), Err(InverseError::Singular { .. })));
    assert!(DTrilinear::identity().inverse(DVec3::NAN, 1e-9).is_err());
    assert!(Trilinear::identity().inverse(DVec3::splat(3.0).as_vec3(), 1e-5).is_err());
    assert_eq!(paper::inv_t(&flat, DVec3::splat(0.5), 1e-9, 50), None);
}

#[test]
fn a_box_far_away_is_as_good_as_its_coordinates() {
    let mut random = Random::new(24);
    for _ in 0..20_000 {
        let near = valid(&mut random);
        let far = Trilinear { corners: near.corners.map(|c| c + DVec3::new(3e3, -1e3, 2e3).as_vec3()) };
        if !certify(&Hexahedron::cuboid(far), 4).is_valid() {
            continue;
        }
        let u = random.inside().as_vec3();
        let x = far.point(u);
        // A coordinate near 3000 is a multiple of 2⁻¹²: some of them are lost, in f32 as in the corners themselves.
        match far.inverse(x, 1e-5) {
            Ok(found) => assert!(far.point(found).distance(x) < 12.0 / 4096.0, "{u} came back as {found}"),
            Err(InverseError::Outside { coordinates }) => {
                assert!(
                    (coordinates - u.as_dvec3()).abs().max_element() < 0.1,
                    "{u} came back as {coordinates}"
                );
            }
            Err(other) => panic!("{other}: {far:?} at {u}"),
        }
        let wide = DTrilinear::from(far);
        let found = wide.inverse(wide.point(u.as_dvec3()), 1e-9).expect("a point of a valid box");
        assert!(found.distance(u.as_dvec3()) < 1e-6);
    }
}
