//! Boxes that are folded after grooming, or before it.

use pelage_geom::certify;
use pelage_geom::glam::{Vec2, Vec3};
use pelage_skin::groom::{
    Clump, Comb, Field, GroomOptions, Mask, Noise, Operation, Plane, Region, Smooth, Step, Swirl, Tilt, Turn,
    groom,
};
use pelage_skin::{Folds, SkinError, SkinOptions, extrude, surface};
use proptest::prelude::*;

use crate::lawn::{close, from_normal, lawn, refusing, strands};

#[test]
fn a_tilt_that_folds_is_limited_and_no_length_is_lost() {
    // Two rows of vertices lean towards each other, across boxes 1/8 m wide: at 0.1 m their tops meet where
    // 2 · 0.1 · sin α = 1/8, at α = 38.7°. One row alone folds its boxes where tan α = (1/8) / 0.1, at 51.3°.
    let skin = lawn();
    let row = |x: f32| {
        let there = skin.base.iter().enumerate().filter(move |(_, p)| close(p.x, x, 1e-6));
        there.map(|(i, _)| i as u32).collect::<Vec<_>>()
    };
    let tilt = |towards: Vec3, x: f32| Step {
        operation: Operation::Tilt(Tilt { towards, angle: 45.0 }),
        masks: vec![Mask::new(Region::Vertices(row(x)))],
    };
    let steps = [tilt(Vec3::X, 0.0), tilt(Vec3::NEG_X, 0.125)];
    match groom(&skin, &steps, &refusing()) {
        Err(SkinError::StillFolded { count: 16, .. }) => {}
        other => panic!("{other:?}"),
    }
    let groomed = groom(&skin, &steps, &GroomOptions::default()).unwrap();
    assert_eq!(groomed.effects.iter().map(|e| e.folded).collect::<Vec<_>>(), [0, 16]);
    assert!(groomed.effects[1].first.is_some());
    let report = &groomed.skin.report;
    assert_eq!((report.mended(), report.left_out(), report.turned_back), (16, 0, 34));
    assert_eq!(report.mended_vertices, 0);
    groomed.skin.validate(6).unwrap();
    for (p, v) in strands(&groomed.skin) {
        assert!(close(v.length(), 0.1, 1e-6), "{p} {v}");
        // Eight steps of 5.6° lead back: two of them, to 33.75°.
        if close(p.x, 0.0, 1e-6) || close(p.x, 0.125, 1e-6) {
            assert!(close(from_normal(v), 33.75, 1e-2), "{p} {v}");
        }
    }
}

#[test]
fn boxes_that_fold_only_before_grooming_are_not_touched() {
    // A groove that is folded at 1.5 m and is not at half of it.
    let mut groove = surface::plane(8.0, 8, 3);
    groove.positions.iter_mut().for_each(|p| p.y = p.x.abs());
    let options = SkinOptions { folds: Folds::Keep, ..SkinOptions::new(1.5) };
    let skin = extrude(&groove, &|_| true, &options).unwrap();
    assert_eq!((skin.len(), skin.report.folds.len()), (24, 6));
    let groomed = groom(&skin, &[Step::everywhere(Operation::Scale(0.5))], &refusing()).unwrap();
    assert_eq!((groomed.effects[0].folded, groomed.skin.report.folds.len()), (0, 0));
    assert!(strands(&groomed.skin).iter().all(|(_, v)| close(v.length(), 0.75, 1e-6)));
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let torus = surface::torus(1.0, 0.4, 60, 30);
    let skin = extrude(&torus, &|_| true, &SkinOptions::new(0.1)).unwrap();
    let steps = [
        Operation::Comb(Comb { along: Field::Uv(Vec2::X), angle: 60.0 }),
        Operation::Noise(Noise { height: 0.4, tilt: 30.0, size: 0.1, seed: 5 }),
        Operation::Clump(Clump { size: 0.2, amount: 0.6, seed: 1 }),
        Operation::Smooth(Smooth { steps: 3, amount: 0.4 }),
    ]
    .map(Step::everywhere);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| groom(&skin, &steps, &GroomOptions::default()).unwrap())
    };
    assert_eq!(with(1), with(3));
}

/// Any operation, within its domain and mostly strong.
fn operation() -> impl Strategy<Value = Operation> {
    let vector = || prop::array::uniform3(-1.0f32..1.0).prop_map(|v| Vec3::from(v) + Vec3::splat(1e-3));
    prop_oneof![
        (0.1f32..3.0).prop_map(Operation::Scale),
        (0.01f32..0.4).prop_map(Operation::Height),
        (0.0f32..4.0).prop_map(Operation::Gravity),
        (vector(), 0.0f32..180.0).prop_map(|(towards, angle)| Operation::Tilt(Tilt { towards, angle })),
        (vector(), 0.0f32..85.0)
            .prop_map(|(p, angle)| Operation::Comb(Comb { along: Field::AwayFrom(p), angle })),
        (vector(), 0.0f32..85.0)
            .prop_map(|(d, angle)| Operation::Comb(Comb { along: Field::Uv(Vec2::new(d.x, d.y)), angle })),
        (vector(), vector(), 0.0f32..85.0).prop_map(|(centre, axis, angle)| {
            Operation::Swirl(Swirl { centre, axis, radius: 1.0, angle, pitch: 70.0 })
        }),
        (vector(), vector()).prop_map(|(point, normal)| Operation::Trim(Plane { point, normal })),
        (vector(), -180.0f32..180.0).prop_map(|(axis, angle)| Operation::Turn(Turn { axis, angle })),
        vector().prop_map(|v| Operation::Move(0.1 * v)),
        (0u32..9, 0.02f32..1.0)
            .prop_map(|(seed, size)| { Operation::Noise(Noise { height: 0.9, tilt: 60.0, size, seed }) }),
        (0u32..9, 0.05f32..1.0).prop_map(|(seed, size)| Operation::Clump(Clump { size, amount: 0.8, seed })),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn whatever_is_done_every_box_that_stays_is_certified(
        operations in prop::collection::vec(operation(), 1..5),
        radius in 0.1f32..1.0,
    ) {
        let torus = surface::torus(1.0, 0.4, 24, 12);
        let skin = extrude(&torus, &|_| true, &SkinOptions::new(0.1)).unwrap();
        let mask = Mask::new(Region::Sphere { centre: Vec3::X, radius, falloff: 0.5 });
        let steps: Vec<Step> = (operations.into_iter().enumerate())
            .map(|(i, operation)| Step { operation, masks: if i % 2 == 0 { vec![] } else { vec![mask.clone()] } })
            .collect();
        let groomed = groom(&skin, &steps, &GroomOptions::default()).unwrap().skin;
        prop_assert_eq!(groomed.len() + groomed.report.left_out(), skin.len());
        prop_assert!((0..groomed.len()).all(|i| certify(&groomed.hexahedron(i), 6).is_valid()));
        prop_assert_eq!(groomed.base, skin.base);
    }
}
