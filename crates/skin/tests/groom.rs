//! What each operation does to the vectors of a skin whose geometry is known; masks; folded boxes after grooming.

use std::sync::Arc;

use pelage_geom::glam::{Vec2, Vec3};
use pelage_geom::{Attribute, MaterialId, Mesh, Texture, certify};
use pelage_skin::groom::{
    Channel, Clump, Comb, Field, GroomOptions, Mask, Noise, Operation, Part, Plane, Region, Smooth, Step,
    Swirl, Tilt, Turn, Wind, groom,
};
use pelage_skin::{Folds, Mending, Skin, SkinError, SkinOptions, extrude, surface};
use proptest::prelude::*;

/// 16 × 16 boxes, 0.1 m high, on a square of 2 m about the origin in the plane y = 0.
fn lawn() -> Skin {
    extrude(&surface::plane(2.0, 16, 16), &|_| true, &SkinOptions::new(0.1)).unwrap()
}

/// The vectors after one operation everywhere, with where they stand.
fn after(skin: &Skin, operation: Operation) -> Vec<(Vec3, Vec3)> {
    let groomed = groom(skin, &[Step::everywhere(operation)], &keeping()).unwrap();
    strands(&groomed.skin)
}

fn strands(skin: &Skin) -> Vec<(Vec3, Vec3)> {
    skin.base.iter().zip(&skin.top).map(|(b, t)| (*b, *t - *b)).collect()
}

/// Nothing is mended, so that what an operation did is seen.
fn keeping() -> GroomOptions {
    GroomOptions { mending: Mending { folds: Folds::Keep, ..Mending::default() }, ..GroomOptions::default() }
}

fn refusing() -> GroomOptions {
    GroomOptions {
        mending: Mending { folds: Folds::Refuse, ..Mending::default() },
        ..GroomOptions::default()
    }
}

/// Degrees.
fn from_normal(vector: Vec3) -> f32 {
    vector.angle_between(Vec3::Y).to_degrees()
}

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn lengths_are_scaled_and_set() {
    for (_, v) in after(&lawn(), Operation::Scale(0.5)) {
        assert!(close(v.length(), 0.05, 1e-8));
    }
    for (_, v) in after(&lawn(), Operation::Height(0.3)) {
        assert!(close(v.length(), 0.3, 1e-7) && close(from_normal(v), 0.0, 1e-2));
    }
}

#[test]
fn all_are_tilted_the_same_way_and_not_past_it() {
    // The paper's figure c.
    for (_, v) in after(&lawn(), Operation::Tilt(Tilt { towards: Vec3::X, angle: 40.0 })) {
        let expected = 0.1 * Vec3::new(40f32.to_radians().sin(), 40f32.to_radians().cos(), 0.0);
        assert!(v.distance(expected) < 1e-7, "{v}");
    }
    // Towards a direction 45° from upright, however large the angle.
    for (_, v) in after(&lawn(), Operation::Tilt(Tilt { towards: Vec3::new(1.0, 1.0, 0.0), angle: 170.0 })) {
        assert!(close(from_normal(v), 45.0, 1e-2));
    }
    // Nothing lies flatter than `steepest`.
    for (_, v) in after(&lawn(), Operation::Tilt(Tilt { towards: Vec3::X, angle: 120.0 })) {
        assert!(close(from_normal(v), 80.0, 1e-2));
    }
}

#[test]
fn combing_follows_a_field_along_the_surface() {
    let comb = |along: Field| after(&lawn(), Operation::Comb(Comb { along, angle: 50.0 }));
    let lies = |v: Vec3, direction: Vec3, degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        v.distance(0.1 * (sin * direction.normalize() + cos * Vec3::Y)) < 1e-6
    };
    for (_, v) in comb(Field::Vector(Vec3::new(1.0, 0.0, 1.0))) {
        assert!(lies(v, Vec3::new(1.0, 0.0, 1.0), 50.0), "{v}");
    }
    // Straight onto the surface: stays upright.
    assert!(comb(Field::Vector(Vec3::NEG_Y)).iter().all(|(_, v)| from_normal(*v) < 1e-2));
    // A field at 60° to the surface has half its length along it: tan of the angle is halved.
    let (sin, cos) = 60f32.to_radians().sin_cos();
    let half = (0.5 * 50f32.to_radians().tan()).atan().to_degrees();
    for (_, v) in comb(Field::Vector(Vec3::new(cos, -sin, 0.0))) {
        assert!(lies(v, Vec3::X, half), "{v}");
    }
    // On the plane u runs along +X and v along −Z.
    assert!(comb(Field::Uv(Vec2::X)).iter().all(|(_, v)| lies(*v, Vec3::X, 50.0)));
    assert!(comb(Field::Uv(-Vec2::Y)).iter().all(|(_, v)| lies(*v, Vec3::Z, 50.0)));
    for (p, v) in comb(Field::AwayFrom(Vec3::ZERO)) {
        assert!(p.length() < 1e-6 || lies(v, p, 50.0), "{p} {v}");
    }
    // Along an L: far from its corner each strand follows the piece that it is near.
    let corner = Field::Curve(vec![Vec3::new(-9.0, 0.0, 0.0), Vec3::ZERO, Vec3::new(0.0, 0.0, 9.0)]);
    for (p, v) in comb(corner) {
        let direction = (v - v.dot(Vec3::Y) * Vec3::Y).normalize();
        if p.x < -0.3 && p.z < 0.2 {
            // On 9 m towards the corner the direction turns from that piece's to halfway between both.
            assert!(direction.dot(Vec3::X) > 0.7 && direction.z >= 0.0, "{p} {v}");
        }
        assert!(close(from_normal(v), 50.0, 1e-2));
    }
}

#[test]
fn uv_directions_do_not_depend_on_how_faces_are_cut_or_mirrored() {
    let mut mesh = surface::torus(1.0, 0.3, 24, 12);
    let along = |mesh: &Mesh, uv: Vec2| {
        let skin = extrude(mesh, &|_| true, &SkinOptions::new(0.02)).unwrap();
        after(&skin, Operation::Comb(Comb { along: Field::Uv(uv), angle: 40.0 }))
    };
    // u runs around the axis: with the tangent (−sin, 0, −cos) at (cos, 0, −sin).
    for (p, v) in along(&mesh, Vec2::X) {
        let around = Vec3::new(p.z, 0.0, -p.x).normalize();
        let flat = v.dot(around) / v.length();
        assert!(close(flat, 40f32.to_radians().sin(), 2e-3), "{p} {v} {flat}");
    }
    let plain = along(&mesh, Vec2::new(0.3, 1.0));
    mesh.uvs.iter_mut().flatten().flatten().for_each(|uv| uv.x = -uv.x);
    for ((_, v), (_, mirrored)) in plain.iter().zip(along(&mesh, Vec2::new(-0.3, 1.0))) {
        assert!(v.distance(mirrored) < 1e-7, "{v} {mirrored}");
    }
}

#[test]
fn a_parting_leans_to_both_sides() {
    let part = Part { point: Vec3::ZERO, across: Vec3::X, angle: 45.0, width: 0.2, reach: 0.6 };
    for (p, v) in after(&lawn(), Operation::Part(part)) {
        let x = p.x.abs();
        if !(1e-6..=0.6).contains(&x) {
            assert!(from_normal(v) < 1e-2, "{p} {v}");
        } else {
            assert!(v.x * p.x > 0.0 && v.z == 0.0, "{p} {v}");
        }
        // Between 0.2 and 0.6 it fades: 0.25 is a place of vertices, a step of 1 − 3·(1/8)² + 2·(1/8)³ from full.
        if close(x, 0.25, 1e-6) {
            let fade = 1.0 - 3.0 / 64.0 + 2.0 / 512.0;
            assert!(close(v.x.abs() / v.y, fade, 1e-5), "{p} {v}");
        }
    }
}

#[test]
fn a_whorl_goes_round() {
    let swirl = Swirl { centre: Vec3::ZERO, axis: Vec3::Y, radius: 1.0, angle: 40.0, pitch: 90.0 };
    for (p, v) in after(&lawn(), Operation::Swirl(swirl)) {
        // Counter-clockwise seen from above: Y × p.
        assert!(v.dot(Vec3::Y.cross(p)) >= 0.0 && v.dot(p).abs() < 1e-6, "{p} {v}");
        if close(p.length(), 0.5, 1e-6) {
            assert!(close(from_normal(v), 40.0, 1e-2), "{p} {v}");
        }
        if p.length() > 1.0 || p == Vec3::ZERO {
            assert!(from_normal(v) < 1e-2, "{p} {v}");
        }
    }
}

#[test]
fn weight_hangs_on_walls_and_lies_on_floors() {
    assert!(after(&lawn(), Operation::Gravity(2.0)).iter().all(|(_, v)| from_normal(*v) < 1e-2));
    let mut wall = surface::plane(2.0, 4, 4);
    wall.positions.iter_mut().for_each(|p| *p = Vec3::new(p.x, -p.z, 0.0));
    let skin = extrude(&wall, &|_| true, &SkinOptions::new(0.1)).unwrap();
    for (_, v) in after(&skin, Operation::Gravity(1.0)) {
        // A tangent of 1: 45° down from the wall's normal +Z.
        assert!(v.distance(0.1 * Vec3::new(0.0, -1.0, 1.0).normalize()) < 1e-7, "{v}");
    }
}

#[test]
fn gusts_travel_with_the_wind() {
    let wind = |time: f32| {
        let wind =
            Wind { direction: Vec3::X, strength: 0.5, gust: 1.0, size: 0.4, speed: 2.0, time, seed: 3 };
        after(&lawn(), Operation::Wind(wind))
    };
    // Vertices are 1/8 m apart: what is at one is at the next after 1/16 s.
    let (now, then) = (wind(0.0), wind(1.0 / 16.0));
    let mut spread = 0.0f32;
    for ((p, a), (_, b)) in now.iter().zip(&then[1..]) {
        if p.x < 0.99 {
            assert!(a.distance(*b) < 1e-6, "{p} {a} {b}");
            spread = spread.max((from_normal(*a) - from_normal(now[0].1)).abs());
        }
    }
    assert!(spread > 5.0, "{spread}");
}

#[test]
fn what_is_beyond_a_plane_is_cut_off() {
    let plane = Plane { point: Vec3::new(0.0, 0.06, 0.0), normal: Vec3::Y };
    assert!(after(&lawn(), Operation::Trim(plane)).iter().all(|(_, v)| close(v.y, 0.06, 1e-7)));
    // A slanted one: y = 0.06 − 0.1 x above the lawn. Where its height is under 1/16 of 0.1 m, that is left.
    let plane = Plane { point: Vec3::new(0.0, 0.06, 0.0), normal: Vec3::new(0.1, 1.0, 0.0) };
    for (p, v) in after(&lawn(), Operation::Trim(plane)) {
        let expected = (0.06 - 0.1 * p.x).clamp(0.1 / 16.0, 0.1);
        assert!(close(v.y, expected, 1e-6), "{p} {v}");
    }
}

#[test]
fn locks_lean_together() {
    let clump = |amount: f32| after(&lawn(), Operation::Clump(Clump { size: 0.5, amount, seed: 7 }));
    let (half, full) = (clump(0.45), clump(0.9));
    // Towards a middle that does not depend on the amount, so twice as far.
    let mut moved = 0.0f32;
    for (((p, a), (_, b)), (_, v)) in half.iter().zip(&full).zip(strands(&lawn())) {
        if from_normal(*b) < 79.9 {
            assert!((2.0 * (*a - v)).distance(*b - v) < 1e-6, "{p}");
        }
        moved = moved.max((*b - v).length());
    }
    assert!(moved > 0.1 && moved < 0.9, "{moved}");
}

#[test]
fn smoothing_evens_out_noise_and_leaves_what_is_even() {
    let skin = lawn();
    let still = after(&skin, Operation::Smooth(Smooth { steps: 5, amount: 1.0 }));
    assert!(still.iter().all(|(_, v)| v.distance(0.1 * Vec3::Y) < 1e-6));
    let noise = Operation::Noise(Noise { height: 0.5, tilt: 40.0, size: 0.15, seed: 1 });
    let spread = |steps: &[Step]| {
        let groomed = groom(&skin, steps, &keeping()).unwrap().skin;
        let lengths: Vec<f32> = strands(&groomed).iter().map(|(_, v)| v.length()).collect();
        let mean = lengths.iter().sum::<f32>() / lengths.len() as f32;
        lengths.iter().map(|l| (l - mean).powi(2)).sum::<f32>() / lengths.len() as f32
    };
    let rough = [Step::everywhere(noise)];
    let smoothed = [rough[0].clone(), Step::everywhere(Operation::Smooth(Smooth { steps: 8, amount: 0.5 }))];
    let (before, after) = (spread(&rough), spread(&smoothed));
    println!("variance of lengths: {before:e} before smoothing, {after:e} after");
    assert!(before > 1e-5 && after < 0.2 * before, "{before} {after}");
}

#[test]
fn chosen_vectors_are_turned() {
    // The paper's figure d: one patch is chosen, and two of its vectors turned.
    let skin = lawn();
    let [a, b, ..] = skin.patches[100].vertices;
    let turn = Operation::Turn(Turn { axis: Vec3::Z, angle: -30.0 });
    let step = Step { operation: turn, masks: vec![Mask::new(Region::Vertices(vec![a, b]))] };
    let groomed = groom(&skin, &[step], &refusing()).unwrap();
    assert_eq!((groomed.effects[0].vertices, groomed.effects[0].folded), (2, 0));
    for (i, (before, after)) in strands(&skin).into_iter().zip(strands(&groomed.skin)).enumerate() {
        if [a, b].contains(&(i as u32)) {
            // Clockwise about +Z, by 30°: towards +X.
            assert!(after.1.distance(0.1 * Vec3::new(0.5, 0.75f32.sqrt(), 0.0)) < 1e-7);
        } else {
            assert_eq!(before, after);
        }
    }
    let step = Step {
        operation: Operation::Move(Vec3::new(0.0, 0.0, 0.02)),
        masks: vec![Mask::new(Region::Patches(vec![100]))],
    };
    let groomed = groom(&skin, &[step], &refusing()).unwrap();
    assert_eq!(groomed.effects[0].vertices, 4);
    assert!(groomed.skin.top[a as usize].distance(skin.top[a as usize] + 0.02 * Vec3::Z) < 1e-7);
}

fn weights(skin: &Skin, masks: &[Mask]) -> Vec<f32> {
    // Moved by 1 m in full, a vertex tells its weight.
    let step = Step { operation: Operation::Move(Vec3::Z), masks: masks.to_vec() };
    let groomed = groom(skin, &[step], &keeping()).unwrap().skin;
    groomed.top.iter().zip(&skin.top).map(|(a, b)| a.z - b.z).collect()
}

#[test]
fn masks_fade_multiply_and_turn_round() {
    let skin = lawn();
    let sphere = Region::Sphere { centre: Vec3::ZERO, radius: 0.25, falloff: 0.5 };
    let inside = Region::Box { min: Vec3::new(0.0, -1.0, -2.0), max: Vec3::splat(2.0), falloff: 0.0 };
    let plain = weights(&skin, &[Mask::new(sphere.clone())]);
    let outside = weights(&skin, &[Mask::outside(sphere.clone())]);
    let product = weights(&skin, &[Mask::new(sphere), Mask::new(inside)]);
    for (i, p) in skin.base.iter().enumerate() {
        let x = ((p.length() - 0.25) / 0.5).clamp(0.0, 1.0);
        let expected = 1.0 - x * x * (3.0 - 2.0 * x);
        assert!(close(plain[i], expected, 1e-5), "{p} {}", plain[i]);
        assert!(close(outside[i], 1.0 - expected, 1e-5));
        assert!(close(product[i], if p.x >= 0.0 { expected } else { 0.0 }, 1e-5));
    }
}

#[test]
fn masks_by_material_attribute_and_image() {
    let mut mesh = surface::plane(2.0, 4, 4);
    mesh.faces[5].material = MaterialId(3);
    let values = mesh.positions.iter().map(|p| 0.5 * (p.x + 1.0)).collect();
    mesh.attributes.push(Attribute { name: "_LENGTH".into(), values });
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    let worn = weights(&skin, &[Mask::new(Region::Materials(vec![MaterialId(3)]))]);
    assert_eq!(worn.iter().filter(|w| **w == 1.0).count(), 4);
    let attribute = weights(&skin, &[Mask::new(Region::Attribute("_LENGTH".into()))]);
    // Two pixels, black and white in red: halfway between their centres u goes from 0 to 1 over half the width.
    let texture = Texture::new(2, 1, vec![Vec3::ZERO, Vec3::X]).unwrap();
    let image = Region::Image { texture: Arc::new(texture), channel: Channel::Red };
    let image = weights(&skin, &[Mask::new(image)]);
    for (i, p) in skin.base.iter().enumerate() {
        assert!(close(attribute[i], 0.5 * (p.x + 1.0), 1e-6));
        // Centres at u = ¼ and ¾; beyond them the image repeats, so at its ends it is the mean.
        let expected = [0.5, 0.0, 0.5, 1.0, 0.5][((p.x + 1.0) * 2.0).round() as usize];
        assert!(close(image[i], expected, 1e-5), "{p} {}", image[i]);
    }
    // Where triangles became quads, new vertices have the mean of those they stand between.
    let mut cut = mesh.clone();
    cut.uvs = None;
    cut.faces[0].vertices[3] = pelage_geom::Face::NONE;
    let skin = extrude(&cut, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert!(skin.report.refined && skin.base.len() > mesh.positions.len());
    for (w, p) in weights(&skin, &[Mask::new(Region::Attribute("_LENGTH".into()))]).iter().zip(&skin.base) {
        assert!(close(*w, 0.5 * (p.x + 1.0), 1e-6));
    }
}

#[test]
fn what_makes_no_sense_is_named() {
    let mut bare = surface::plane(1.0, 2, 2);
    bare.uvs = None;
    let skin = extrude(&bare, &|_| true, &SkinOptions::new(0.1)).unwrap();
    let fails = |operation: Operation, masks: Vec<Mask>, message: &str| {
        let steps = [Step::everywhere(Operation::Scale(1.0)), Step { operation, masks }];
        let error = groom(&skin, &steps, &GroomOptions::default()).unwrap_err().to_string();
        assert_eq!(error, format!("groom[1]: {message}"));
    };
    fails(Operation::Scale(f32::NAN), vec![], "scale: must be positive and at most 1000");
    fails(
        Operation::Tilt(Tilt { towards: Vec3::ZERO, angle: 3.0 }),
        vec![],
        "tilt.towards: must be finite and not zero",
    );
    let uv = Operation::Comb(Comb { along: Field::Uv(Vec2::X), angle: 3.0 });
    fails(uv, vec![], "comb.along.uv: needs texture coordinates, and the mesh has none");
    let curve = Operation::Comb(Comb { along: Field::Curve(vec![Vec3::ONE]), angle: 3.0 });
    fails(curve, vec![], "comb.along.curve: must hold two different finite points or more");
    let scale = || Operation::Scale(2.0);
    let mask = |region: Region| vec![Mask::new(region)];
    fails(scale(), mask(Region::Patches(vec![4])), "mask: patch 4 does not exist: there are 4");
    fails(scale(), mask(Region::Attribute("_X".into())), "mask: the mesh has no vertex attribute `_X`");
    let texture = Arc::new(Texture::new(1, 1, vec![Vec3::ONE]).unwrap());
    fails(
        scale(),
        mask(Region::Image { texture, channel: Channel::Mean }),
        "mask: an image needs texture coordinates, and the mesh has none",
    );
    let options = GroomOptions { steepest: 100.0, ..GroomOptions::default() };
    assert!(matches!(groom(&skin, &[], &options), Err(SkinError::Option { option: "steepest", .. })));
}

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
