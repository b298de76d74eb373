//! A skin that moves: vectors are carried with the surface, patches keep their numbers, folds are mended or refused.

use pelage_geom::glam::{Quat, Vec3};
use pelage_skin::{Folds, Mending, Motion, Skin, SkinError, SkinOptions, extrude, surface};

fn torus() -> Skin {
    let lean = Vec3::new(0.3, -0.2, 0.1);
    let options = SkinOptions { lean, ..SkinOptions::strict(0.05) };
    extrude(&surface::torus(1.0, 0.4, 48, 24), &|_| true, &options).unwrap()
}

#[test]
fn vectors_turn_with_the_surface() {
    let rest = torus();
    let mut skin = rest.clone();
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
    let moved: Vec<Vec3> = rest.base.iter().map(|p| turn * *p + Vec3::new(3.0, 0.0, 1.0)).collect();
    skin.update(Motion::Surface(&moved), &Mending::default()).unwrap();
    for i in 0..skin.base.len() {
        let (before, after) = (rest.top[i] - rest.base[i], skin.top[i] - skin.base[i]);
        // Rounding of positions up to 5 m: some 1e-6.
        assert!((turn * before).distance(after) < 5e-6, "{before} {after}");
    }
    assert_eq!(skin.patches, rest.patches);
    assert_eq!(skin.base, moved);
    skin.validate(6).unwrap();
}

#[test]
fn standing_still_changes_no_bit() {
    let rest = torus();
    let mut skin = rest.clone();
    let vectors: Vec<Vec3> = rest.top.iter().zip(&rest.base).map(|(t, b)| *t - *b).collect();
    skin.update(Motion::Vectors(&vectors), &Mending::default()).unwrap();
    let tops = |skin: &Skin| skin.base.iter().zip(&vectors).map(|(b, v)| *b + *v).collect::<Vec<_>>();
    assert_eq!(skin.top, tops(&rest));
    skin.update(Motion::Surface(&rest.base), &Mending::default()).unwrap();
    assert_eq!(skin.top, tops(&rest));
}

#[test]
fn folds_are_turned_back_or_refused() {
    let rest = torus();
    let wild: Vec<Vec3> = rest
        .base
        .iter()
        .enumerate()
        .map(|(i, _)| 0.05 * if i % 2 == 0 { Vec3::X } else { Vec3::NEG_X })
        .collect();
    let mut skin = rest.clone();
    let refuse = Mending { folds: Folds::Refuse, ..Mending::default() };
    assert!(matches!(skin.update(Motion::Vectors(&wild), &refuse), Err(SkinError::StillFolded { .. })));
    assert_eq!(skin, rest);
    let report = skin.update(Motion::Vectors(&wild), &Mending::default()).unwrap();
    assert!(report.turned_back > 0 && report.left_out() == 0, "{report}");
    skin.validate(6).unwrap();
    assert_eq!(skin.patches, rest.patches);
    // A surface that is turned inside out cannot be mended.
    let inside_out: Vec<Vec3> = rest.base.iter().map(|_| Vec3::ZERO).collect();
    let before = skin.clone();
    assert!(matches!(
        skin.update(Motion::Surface(&inside_out), &Mending::default()),
        Err(SkinError::StillFolded { .. })
    ));
    assert_eq!(skin, before);
}

#[test]
fn what_cannot_be_is_named() {
    let mut skin = torus();
    let short = vec![Vec3::Y; 3];
    let error = skin.update(Motion::Vectors(&short), &Mending::default()).unwrap_err();
    assert_eq!(error, SkinError::Length { list: "vectors", length: 3, expected: 1152 });
    let mut base = skin.base.clone();
    base[7].x = f32::NAN;
    let error = skin.update(Motion::Surface(&base), &Mending::default()).unwrap_err();
    assert_eq!(error, SkinError::NonFinite { vertex: 7 });
}
