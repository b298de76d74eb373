//! What grows: how much of it, where, and from which numbers; and that a texel knows what it was made from.

use glam::{Vec2, Vec3};
use pelage_texel::{
    BuildError, BuildOptions, Fur, Geometry, Grass, Kind, Leaves, Preset, Procedure, Sheet, Source, Spheres,
    build,
};
use proptest::prelude::*;

/// Twice the area, as a vector across the triangle.
fn across([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

fn area(geometry: &Geometry) -> f32 {
    geometry.triangles.iter().map(|&triangle| 0.5 * across(triangle).length()).sum()
}

#[test]
fn presets_are_sound_and_stay_in_the_texel() {
    for Preset { kind, name, make } in Kind::PRESETS {
        let content = make();
        assert_eq!(content.name(), kind);
        assert_eq!(content.validate(), Ok(()), "{kind}:{name}");
        let geometry = content.geometry();
        assert_eq!(geometry.validate(), Ok(()), "{kind}:{name}");
        // A leaning tube's round end, or a bent blade, goes below the surface by less than its radius.
        let inside = geometry.triangles.iter().flatten().all(|p| (-0.02..=1.0).contains(&p.z));
        assert!(inside, "{kind}:{name}");
        assert_eq!(make().geometry(), geometry, "{kind}:{name}");
    }
    assert_eq!(Kind::PRESETS[0].kind, Kind::default().name());
}

#[test]
fn presets_have_the_triangles_that_they_say() {
    let count = |procedure: &dyn Procedure| procedure.geometry().triangles.len();
    assert_eq!(count(&Grass::meadow()), 200 * 8);
    assert_eq!(count(&Fur::hair()), 400 * 24);
    assert_eq!(count(&Leaves::green()), 300 * 2);
    assert_eq!(count(&Sheet::tilted()), 2);
    // 16 rings of 32 quads, of which the polar ones are triangles.
    assert_eq!(count(&Spheres::lattice()), 8 * 32 * (2 * 14 + 2));
}

#[test]
fn seeds_differ() {
    for seed in [0, 2, u64::MAX] {
        assert_ne!(Fur { seed, ..Fur::hair() }.geometry(), Fur::hair().geometry());
        assert_ne!(Grass { seed, ..Grass::lawn() }.geometry(), Grass::lawn().geometry());
        assert_ne!(Leaves { seed, ..Leaves::green() }.geometry(), Leaves::green().geometry());
    }
}

#[test]
fn upright_blades_have_the_area_of_their_outline() {
    let grass = Grass { bend: 0.0, taper: 0.0, length_variation: 0.0, ..Grass::meadow() };
    // Rectangles.
    let expected = 200.0 * grass.width * grass.length;
    assert!((area(&grass.geometry()) / expected - 1.0).abs() < 1e-4);
    for triangle in grass.geometry().triangles {
        assert!(across(triangle).z.abs() < 1e-7);
    }
    // Each half-width is 1 − x² of the root's: trapezia over 4 pieces give ⅔ − 1/(6 · 4²).
    let pointed = Grass { taper: 1.0, ..grass };
    let expected = expected * (2.0 / 3.0 - 1.0 / 96.0);
    assert!((area(&pointed.geometry()) / expected - 1.0).abs() < 1e-4);
}

#[test]
fn blades_bend_between_nothing_and_twice_the_mean() {
    let grass = Grass { count: 2000, bend: 0.6, segments: 32, ..Grass::meadow() };
    let geometry = grass.geometry();
    let mut angles: Vec<f32> = geometry
        .triangles
        .chunks(64)
        .map(|blade| {
            // The last piece's two long edges run from corner 1 to 2 of its first triangle.
            let [_, b, c] = blade[62];
            (c - b).normalize().z.clamp(-1.0, 1.0).acos()
        })
        .collect();
    angles.sort_unstable_by(f32::total_cmp);
    // Evenly spread over 0 to 1.2 by blade, at 31.5/32 of the arc; edges taper inwards, which adds a little.
    let mean = angles.iter().sum::<f32>() / 2000.0;
    assert!((mean - 0.6).abs() < 0.03, "{mean}");
    assert!(angles[0] < 0.15 && (1.1..1.3).contains(&angles[1999]), "{} {}", angles[0], angles[1999]);
}

#[test]
fn leaves_have_their_size_and_tilt() {
    for tilt in [0.0, 0.4, 1.0] {
        let leaves = Leaves { count: 4000, size_variation: 0.0, tilt, ..Leaves::green() };
        let geometry = leaves.geometry();
        // A kite: half of length times width.
        let expected = 4000.0 * 0.5 * leaves.size.powi(2) * leaves.aspect;
        assert!((area(&geometry) / expected - 1.0).abs() < 1e-4);
        // Cosines evenly over 1 − tilt to 1: the mean is 1 − tilt/2, and 4000 of them stray by under 0.005 · tilt.
        let cosine = geometry.triangles.iter().map(|&t| across(t).normalize().z.abs()).sum::<f32>() / 8000.0;
        println!("tilt {tilt}: mean cosine {cosine:.4}");
        assert!((cosine - (1.0 - 0.5 * tilt)).abs() < 0.02);
    }
}

#[test]
fn spheres_are_as_large_from_every_side() {
    let spheres = Spheres { rings: 64, ..Spheres::lattice() };
    let geometry = spheres.geometry();
    // Every line through a closed convex body crosses it twice: half the sum of projected areas is its shadow.
    let expected = 8.0 * core::f32::consts::PI * (0.25 * spheres.fill).powi(2);
    for d in [Vec3::X, Vec3::Z, Vec3::new(0.36, 0.48, 0.8)] {
        let shadow: f32 = geometry.triangles.iter().map(|&t| 0.25 * across(t).dot(d).abs()).sum();
        assert!((shadow / expected - 1.0).abs() < 2e-3, "{d}: {shadow} {expected}");
    }
}

#[test]
fn a_sheet_lies_where_it_is_said_to() {
    let sheet = Sheet { height: 0.4, slope: Vec2::new(0.3, -0.2), ..Sheet::tilted() };
    for p in sheet.geometry().triangles.into_iter().flatten() {
        assert!((p.z - (0.4 + 0.3 * (p.x - 0.5) - 0.2 * (p.y - 0.5))).abs() < 1e-6);
    }
}

#[test]
fn parameters_out_of_their_domain_are_named() {
    let refused = |kind: Kind| match build("", kind, &BuildOptions::preview(), &|_| ()) {
        Err(BuildError::Parameter { field, .. }) => field,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(Fur { count: 0, ..Fur::long() }.into()), "count");
    assert_eq!(refused(Fur { sides: 2, ..Fur::long() }.into()), "sides");
    assert_eq!(refused(Fur { lean: Vec2::new(0.0, f32::NAN), ..Fur::long() }.into()), "lean");
    assert_eq!(refused(Grass { count: 1_000_001, ..Grass::lawn() }.into()), "count");
    assert_eq!(refused(Grass { segments: 0, ..Grass::lawn() }.into()), "segments");
    assert_eq!(refused(Grass { bend: f32::INFINITY, ..Grass::lawn() }.into()), "bend");
    assert_eq!(refused(Leaves { size: 0.6, ..Leaves::green() }.into()), "size");
    assert_eq!(refused(Leaves { color: Vec3::splat(-0.1), ..Leaves::green() }.into()), "color");
    assert_eq!(refused(Sheet { height: 1.5, ..Sheet::tilted() }.into()), "height");
    assert_eq!(refused(Spheres { side: 65, ..Spheres::lattice() }.into()), "side");
    assert_eq!(refused(Spheres { rings: 1, ..Spheres::lattice() }.into()), "rings");
    // Each number may be, and all of them together may not.
    let heavy = Fur { count: 1_000_000, segments: 32, ..Fur::long() };
    let most = 50_000_000;
    assert_eq!(heavy.validate(), Err(BuildError::Heavy { count: 192_000_000, most }));
    // Messages show what was written, not its nearest f64.
    let message = Fur { clump: 1.2, ..Fur::long() }.validate().unwrap_err().to_string();
    assert_eq!(message, "clump is 1.2, which is not in 0 to 1");
}

#[test]
fn a_texel_knows_its_source() {
    let fur = Fur { count: 40, ..Fur::hair() };
    let options = BuildOptions { depth: 4, ..BuildOptions::preview() };
    let grown = build("fur", fur.clone(), &options, &|_| ()).unwrap();
    assert_eq!(grown.source(), &Source::Grown(fur.clone().into()));
    assert_eq!(*grown.source().geometry().unwrap(), fur.geometry());
    let embedded = build("fur", fur.geometry(), &options, &|_| ()).unwrap();
    assert_eq!(embedded.source(), &Source::from(fur.geometry()));
    let [grown, embedded] = [grown, embedded].map(|texel| texel.without_source());
    assert_eq!(grown, embedded);
    assert_eq!(grown.source().geometry(), None);
    assert_eq!(build("", Source::Unknown, &options, &|_| ()), Err(BuildError::Sourceless));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_sound_stays_in_the_texel(
        seed: u64,
        count in 1_u32..60,
        length in 0.0_f32..=1.0,
        variation in 0.0_f32..=1.0,
        bend in 0.0_f32..=1.5,
        size in 0.0_f32..=0.5,
        tilt in 0.0_f32..=1.0,
    ) {
        let grass = Grass { seed, count, length, length_variation: variation, bend, ..Grass::meadow() };
        let leaves = Leaves { seed, count, size, size_variation: variation, tilt, ..Leaves::green() };
        for kind in [Kind::from(grass), Kind::from(leaves)] {
            prop_assert_eq!(kind.validate(), Ok(()));
            let geometry = kind.geometry();
            prop_assert_eq!(geometry.validate(), Ok(()));
            for p in geometry.triangles.iter().flatten() {
                // Even the tip of an arc of 3 radians is above its root: rounding is all that may be below.
                prop_assert!((-1e-5..=1.000_001).contains(&p.z), "{} {}", kind.name(), p);
            }
        }
    }
}
