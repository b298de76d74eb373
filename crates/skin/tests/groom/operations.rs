//! What each operation does to vectors.

use pelage_geom::Mesh;
use pelage_geom::glam::{Vec2, Vec3};
use pelage_skin::groom::{
    Clump, Comb, Field, Mask, Noise, Operation, Part, Plane, Region, Smooth, Step, Swirl, Tilt, Turn, Wind,
    groom,
};
use pelage_skin::{Skin, SkinOptions, extrude, surface};

use crate::lawn::{after, close, from_normal, keeping, lawn, refusing, strands};

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

#[test]
fn a_density_leaves_out_boxes_by_chance() {
    let skin = lawn();
    let thinned = |step: Step| groom(&skin, &[step], &refusing()).unwrap().skin;
    let half = thinned(Step::everywhere(Operation::Density(0.5)));
    // 256 draws: 128 within four standard deviations of 8.
    assert!((96..=160).contains(&half.len()), "{}", half.len());
    assert_eq!(half.len() + half.report.thinned, skin.len());
    assert_eq!(half.report.boxes, half.len());
    assert_eq!(half.uvs.as_ref().map(Vec::len), Some(half.len()));
    // What stays at a lower density stays at a higher one.
    let fifth = thinned(Step::everywhere(Operation::Density(0.2)));
    assert!(fifth.len() < half.len());
    assert!(fifth.patches.iter().all(|p| half.patches.iter().any(|q| q.face == p.face)));
    // Only where the mask is.
    let right = Region::Box { min: Vec3::new(0.0, -1.0, -2.0), max: Vec3::splat(2.0), falloff: 0.0 };
    let bald = thinned(Step { operation: Operation::Density(0.0), masks: vec![Mask::new(right)] });
    let middle = |skin: &Skin, i: usize| {
        skin.patches[i].corners().iter().map(|&v| skin.base[v as usize].x).sum::<f32>()
    };
    assert!((0..bald.len()).all(|i| middle(&bald, i) < 0.0));
    // Boxes at the mask's edge, at x from −1/8 to 0, are as often there as not.
    assert!((112..128).contains(&bald.len()), "{}", bald.len());
}
