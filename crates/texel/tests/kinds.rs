//! What grows: how much of it, where, and from which numbers; and that a texel knows what it was made from.

use glam::{Vec2, Vec3};
use pelage_texel::{
    BuildError, BuildOptions, Domain, Foliage, Fur, Geometry, Grass, Kind, Leaves, Moss, Needles, Pile,
    Preset, Procedure, Sheet, Source, Spheres, Value, build,
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
    for Preset { kind, name, make, .. } in Kind::PRESETS {
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
    // Two halves of 6 pieces, the last of each a triangle.
    assert_eq!(count(&Grass::tussock()), 420 * 2 * 11);
    assert_eq!(count(&Fur::hair()), 400 * 24);
    // Stems of 3 pieces with 3 sides; leaves of two halves, each of a triangle, a quad and a triangle.
    assert_eq!(count(&Moss { capsules: 0.0, ..Moss::cushion() }), 260 * (18 + 30 * 8));
    assert_eq!(count(&Pile::cut()), 64 * 20 * 8 * 6);
    // Twigs of 8 pieces; leaves of two halves of 5 pieces, and their stalks.
    assert_eq!(count(&Foliage::shrub()), 26 * (8 * 6 + 13 * (2 * 8 + 6)));
    // Shoots of 6 pieces; pointed needles of a quad and a triangle on each of 3 sides.
    assert_eq!(count(&Needles { side_shoots: 0, ..Needles::spruce() }), 26 * (6 * 6 + 110 * 9));
    assert_eq!(count(&Leaves::green()), 300 * 2);
    assert_eq!(count(&Sheet::tilted()), 2);
    // 16 rings of 32 quads, of which the polar ones are triangles.
    assert_eq!(count(&Spheres::lattice()), 8 * 32 * (2 * 14 + 2));
    for Preset { kind, name, make, .. } in Kind::PRESETS {
        let triangles = count(&make());
        println!("{kind}:{name}: {triangles} triangles");
        assert!(triangles <= 1_000_000, "{kind}:{name}: {triangles}");
    }
}

#[test]
fn seeds_differ() {
    for seed in [0, 2, u64::MAX] {
        assert_ne!(Fur { seed, ..Fur::hair() }.geometry(), Fur::hair().geometry());
        assert_ne!(Grass { seed, ..Grass::lawn() }.geometry(), Grass::lawn().geometry());
        assert_ne!(Moss { seed, ..Moss::star() }.geometry(), Moss::star().geometry());
        assert_ne!(Pile { seed, ..Pile::loops() }.geometry(), Pile::loops().geometry());
        assert_ne!(Foliage { seed, ..Foliage::ivy() }.geometry(), Foliage::ivy().geometry());
        assert_ne!(Needles { seed, ..Needles::fir() }.geometry(), Needles::fir().geometry());
        assert_ne!(Leaves { seed, ..Leaves::green() }.geometry(), Leaves::green().geometry());
    }
}

/// What wraps around the tile leaves no seam: the strip of a tenth along the edges s = 0 and s = 1 holds as much as two
/// tenths anywhere else do, and the same along t.
#[test]
fn there_is_no_seam() {
    for Preset { kind, name, make, .. } in Kind::PRESETS {
        let geometry = make().geometry();
        if geometry.triangles.is_empty() {
            // A density has no triangles.
            continue;
        }
        let total = area(&geometry);
        for axis in 0..2 {
            let mut tenths = [0.0; 10];
            for triangle in &geometry.triangles {
                let middle = (triangle[0] + triangle[1] + triangle[2])[axis] / 3.0;
                let tenth = (10.0 * middle.rem_euclid(1.0)) as usize;
                tenths[tenth.min(9)] += 0.5 * across(*triangle).length() / total;
            }
            let edges = tenths[0] + tenths[9];
            // Of the nine ways to take two neighbouring tenths within the tile.
            let within: Vec<f32> = tenths.windows(2).map(|pair| pair[0] + pair[1]).collect();
            let [least, most] =
                [f32::min, f32::max].map(|pick| within.iter().copied().reduce(pick).unwrap_or(0.2));
            println!("{kind}:{name}, axis {axis}: {edges:.3} at the seam, {least:.3} to {most:.3} within");
            // A sheet or a lattice is what it is; what is scattered is about as even at the seam as elsewhere.
            let spread = most - least;
            assert!(
                kind == "sheet" || (least - spread..=most + spread).contains(&edges),
                "{kind}:{name}, axis {axis}: {edges} {tenths:?}"
            );
        }
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
    // Folding turns each half about the midrib, and its area with it.
    let folded = Grass { fold: 35.0, ..grass.clone() };
    assert_eq!(folded.geometry().triangles.len(), 2 * grass.geometry().triangles.len());
    assert!((area(&folded.geometry()) / expected - 1.0).abs() < 1e-4);
    // Each half-width is 1 − x² of the root's: trapezia over 4 pieces give ⅔ − 1/(6 · 4²).
    let pointed = Grass { taper: 1.0, ..grass };
    let expected = expected * (2.0 / 3.0 - 1.0 / 96.0);
    assert!((area(&pointed.geometry()) / expected - 1.0).abs() < 1e-4);
}

#[test]
fn blades_bend_between_nothing_and_twice_the_mean() {
    let grass = Grass { count: 2000, bend: 0.6_f32.to_degrees(), segments: 32, ..Grass::meadow() };
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

/// Red at the root and blue at the tip: how far along a triangle's colour says that it is.
fn blueness(color: Vec3) -> f32 {
    color.z / (color.x + color.z)
}

#[test]
fn colours_go_from_root_to_tip() {
    let [root_color, tip_color] = [Vec3::X, Vec3::Z];
    let fur = Fur {
        root_color,
        tip_color,
        color_variation: 0.0,
        color_midpoint: 0.5,
        undercoat: 0.0,
        segments: 10,
        ..Fur::long()
    };
    for strand in fur.geometry().colors.chunks(10 * 6) {
        for (k, piece) in strand.chunks(6).enumerate() {
            // Smoothstep at the middle of each piece.
            let x = (k as f32 + 0.5) / 10.0;
            assert!(piece.iter().all(|&c| (blueness(c) - x * x * (3.0 - 2.0 * x)).abs() < 1e-5));
        }
    }
    // Half and half at the midpoint: smoothstep is ½ at ½.
    let late = Fur { color_midpoint: 0.75, segments: 2, ..fur };
    assert!((blueness(late.geometry().colors[6]) - 0.5).abs() < 1e-5);
    let grass = Grass {
        root_color,
        tip_color,
        other_tip_color: tip_color,
        color_variation: 0.0,
        dry: 0.0,
        ..Grass::meadow()
    };
    for blade in grass.geometry().colors.chunks(8) {
        for (triangle, &color) in blade.iter().enumerate() {
            assert!((blueness(color) - ((triangle / 2) as f32 + 0.5) / 4.0).abs() < 1e-5);
        }
    }
    let pile =
        Pile { root_color: Vec3::splat(0.1), tip_color: Vec3::ONE, color_variation: 0.0, ..Pile::cut() };
    for fiber in pile.geometry().colors.chunks(8 * 6) {
        assert!(fiber.is_sorted_by(|a, b| a.x <= b.x) && fiber[0].x < 0.2 && fiber[47].x > 0.9);
    }
    let moss =
        Moss { base_color: root_color, tip_color, color_variation: 0.0, capsules: 0.0, ..Moss::star() };
    for shoot in moss.geometry().colors.chunks(18 + 46 * 8) {
        // Leaves come in order of age; the gradient goes on along each by a quarter of what the leaf has.
        let leaves: Vec<f32> = shoot[18..].chunks(8).map(|leaf| blueness(leaf[7])).collect();
        assert!(leaves.is_sorted() && leaves[0] < 0.05 && leaves[45] > 0.9, "{leaves:?}");
    }
    let needles =
        Needles { color: root_color, tip_color, color_variation: 0.0, side_shoots: 0, ..Needles::pine() };
    for shoot in needles.geometry().colors.chunks(36 + 150 * 9) {
        let needles: Vec<f32> = shoot[36..].chunks(9).map(|needle| blueness(needle[0])).collect();
        assert!(needles.is_sorted() && needles[0] < 0.01 && needles[149] > 0.95, "{needles:?}");
    }
}

#[test]
fn leaves_have_the_area_of_their_outline() {
    // One leaf a twig, at its tip, of 0.7 times the length; twigs and stalks without thickness.
    let foliage = Foliage {
        twigs: 50,
        length: 0.3,
        leaves: 1,
        twig_radius: 0.0,
        leaf_variation: 0.0,
        widest: 0.5,
        pointed: 0.5,
        fold: 20.0,
        droop: 0.0,
        segments: 8,
        ..Foliage::shrub()
    };
    assert_eq!(foliage.geometry().triangles.len(), 50 * 2 * 14);
    // The outline is then 4x(1 − x), whose mean by trapezia over n pieces is ⅔(1 − 1/n²).
    let outline = 2.0 / 3.0 * (1.0 - 1.0 / 64.0);
    let expected = 50.0 * (0.7 * foliage.leaf_length).powi(2) * foliage.leaf_width * outline;
    let measured = area(&foliage.geometry());
    println!("{measured} {expected}");
    assert!((measured / expected - 1.0).abs() < 1e-3);
}

#[test]
fn a_leaf_is_widest_where_it_is_said_to_be() {
    for (widest, pointed) in [(0.25, 0.0), (0.25, 1.0), (0.7, 0.4)] {
        let foliage = Foliage {
            twigs: 1,
            length: 0.3,
            leaves: 1,
            twig_radius: 0.0,
            leaf_variation: 0.0,
            fold: 0.0,
            droop: 0.0,
            widest,
            pointed,
            segments: 32,
            ..Foliage::shrub()
        };
        // Of a flat blade the first triangle is (base, right, left), and then pairs follow: (left, right, far right),
        // (left, far right, far left).
        let geometry = foliage.geometry();
        let far = geometry.triangles[2..].iter().step_by(2).map(|[_, right, left]| (right - left).length());
        let widths: Vec<f32> = far.collect();
        let most = (0..widths.len()).max_by(|&a, &b| widths[a].total_cmp(&widths[b])).unwrap();
        let place = (most + 2) as f32 / 32.0;
        println!("widest at {place} for {widest}, pointed {pointed}: {widths:?}");
        assert!((place - widest).abs() <= 1.0 / 32.0 + 1e-5);
        assert!((widths[most] / (0.7 * foliage.leaf_length * foliage.leaf_width) - 1.0).abs() < 0.01);
    }
}

#[test]
fn cushions_are_domed() {
    let moss = Moss {
        shoots: 2000,
        leaves: 0,
        capsules: 0.0,
        stem_radius: 1e-4,
        length: 0.9,
        length_variation: 0.0,
        cushions: 1,
        dome: 0.5,
        splay: 0.0,
        ..Moss::cushion()
    };
    let geometry = moss.geometry();
    let mut tops: Vec<f32> = geometry
        .triangles
        .chunks(18)
        .map(|stem| stem.iter().flatten().map(|p| p.z).fold(0.0, f32::max))
        .collect();
    tops.sort_unstable_by(f32::total_cmp);
    // Stems wander by up to 0.15 radians off the upright, which takes at most 1 − cos 0.15 = 1.1 % of their height. At
    // the rim, half a tile from the middle, they are half as long, and so are those in the corners beyond.
    println!("{} to {}", tops[0], tops[1999]);
    assert!((0.45 * 0.988..0.451).contains(&tops[0]) && (0.89..0.901).contains(&tops[1999]));
    let corners = tops.iter().filter(|&&top| top < 0.451).count() as f32 / 2000.0;
    // The tile less its inscribed disk: 1 − π/4 = 0.215.
    assert!((corners - 0.215).abs() < 0.03, "{corners}");
}

#[test]
fn yarn_is_cut_or_looped() {
    let plain = Pile {
        tufts: 2,
        height: 0.8,
        height_variation: 0.0,
        jitter: 0.0,
        bend: 0.0,
        fibers: 1,
        plies: 1,
        fiber_radius: 1e-3,
        thickness: 0.0,
        segments: 16,
        ..Pile::cut()
    };
    let middle = |ring: &[[Vec3; 3]]| ring.iter().map(|t| t[0]).sum::<Vec3>() / ring.len() as f32;
    for (loops, end) in [(0.0, 0.8), (1.0, 0.0)] {
        let geometry = Pile { loops, ..plain.clone() }.geometry();
        assert_eq!(geometry.triangles.len(), 4 * 16 * 6);
        for fiber in geometry.triangles.chunks(16 * 6) {
            // Each side of a piece is two triangles: (a, b, c) and (a, c, d), whose c is on the far ring.
            let last: Vec<[Vec3; 3]> = fiber[90..].iter().map(|&[_, _, c]| [c; 3]).collect();
            let top = fiber.iter().flatten().map(|p| p.z).fold(0.0, f32::max);
            assert!((middle(&last).z - end).abs() < 2e-3 && (top - 0.8).abs() < 2e-3, "{top}");
            // The feet of a loop stand half the distance between neighbours to the left and right of it.
            let apart = (middle(&last) - middle(&fiber[..6])).x;
            assert!((apart - loops * 0.5).abs() < 4e-3, "{apart}");
        }
    }
}

#[test]
fn needles_are_combed_into_a_plane() {
    for (comb, flat) in [(1.0, true), (0.0, false)] {
        let needles = Needles {
            comb,
            needle_radius: 1e-5,
            needle_bend: 0.0,
            bend: 0.0,
            side_shoots: 0,
            twig_radius: 0.0,
            needles: 40,
            ..Needles::fir()
        };
        for shoot in needles.geometry().triangles.chunks(40 * 9) {
            // The tips: the last corner of each needle's last triangle.
            let tips: Vec<Vec3> = shoot.chunks(9).map(|needle| needle[8][2]).collect();
            let base = shoot[0][0];
            let mut normals = tips.iter().map(|tip| (tip - base).cross(tips[39] - base));
            let normal =
                normals.by_ref().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap().normalize();
            let off = tips.iter().map(|tip| (tip - base).dot(normal).abs()).fold(0.0, f32::max);
            assert_eq!(off < 1e-3, flat, "{comb}: {off}");
        }
    }
}

#[test]
fn every_parameter_is_described() {
    for Preset { kind, name, make, about } in Kind::PRESETS {
        let content = make();
        assert!(!about.is_empty() && content.about().len() > 20);
        for parameter in content.parameters() {
            let Domain { lo, hi, name: domain } = parameter.domain;
            assert!(lo < hi && !domain.is_empty(), "{kind}:{name} {}", parameter.name);
            assert!(
                parameter.meaning.ends_with('.') && !parameter.meaning.contains("  "),
                "{}",
                parameter.meaning
            );
            if let Value::Color(_) = parameter.value {
                assert_eq!([lo, hi], [0.0, 1.0], "{kind}:{name} {}", parameter.name);
            }
        }
    }
    let parameters = Kind::from(Fur::long()).parameters();
    let told = |name: &str| {
        let found = parameters.iter().find(|parameter| parameter.name == name).unwrap();
        format!("{} {} {}", found.value, found.domain.name, found.unit)
    };
    assert_eq!(told("seed"), "1 any whole number ");
    assert_eq!(told("count"), "1100 1 to 1000000 strands");
    assert_eq!(told("lean"), "[0, 0] -10 to 10 texel edges a texel edge");
    assert_eq!(told("root_color"), "[0.6, 0.58, 0.56] 0 to 1 ");
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
    assert_eq!(refused(Fur { curl_turns: 17.0, ..Fur::long() }.into()), "curl_turns");
    assert_eq!(refused(Moss { shoots: 0, ..Moss::star() }.into()), "shoots");
    assert_eq!(refused(Moss { leaf_droop: 181.0, ..Moss::star() }.into()), "leaf_droop");
    assert_eq!(refused(Pile { tufts: 0, ..Pile::cut() }.into()), "tufts");
    assert_eq!(refused(Pile { plies: 0, ..Pile::cut() }.into()), "plies");
    assert_eq!(refused(Pile { twist: f32::NEG_INFINITY, ..Pile::cut() }.into()), "twist");
    assert_eq!(refused(Foliage { widest: 0.0, ..Foliage::shrub() }.into()), "widest");
    assert_eq!(
        refused(Foliage { twig_color: Vec3::new(0.0, 1.5, 0.0), ..Foliage::shrub() }.into()),
        "twig_color"
    );
    assert_eq!(refused(Needles { bundle: 0, ..Needles::pine() }.into()), "bundle");
    assert_eq!(refused(Needles { needle_radius: -0.01, ..Needles::pine() }.into()), "needle_radius");
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
        bend in 0.0_f32..=85.0,
        size in 0.0_f32..=0.5,
        tilt in 0.0_f32..=1.0,
        droop in -180.0_f32..=180.0,
    ) {
        let grass = Grass { seed, count, length, length_variation: variation, bend, ..Grass::meadow() };
        let leaves = Leaves { seed, count, size, size_variation: variation, tilt, ..Leaves::green() };
        let moss = Moss {
            seed, shoots: count, length, length_variation: variation, dome: tilt, splay: bend, leaf_length: size,
            leaf_droop: droop, leaves: 6, capsules: tilt, ..Moss::cushion()
        };
        let pile = Pile {
            seed, tufts: 1 + count % 5, height: length, height_variation: variation, loops: tilt, bend: bend / 8.5,
            fibers: 3, thickness: 4.0 * size, twist: droop / 10.0, ..Pile::cut()
        };
        let foliage = Foliage {
            seed, twigs: 1 + count % 5, length: 2.0 * length, length_variation: variation, spread: bend, bend: droop.max(-90.0),
            leaves: 4, leaf_length: size, facing: tilt, droop, ..Foliage::shrub()
        };
        let needles = Needles {
            seed, shoots: 1 + count % 5, length: 2.0 * length, length_variation: variation, spread: bend, bend: droop.max(-90.0),
            needles: 5, needle_length: size, comb: tilt, needle_bend: 0.5 * droop, ..Needles::spruce()
        };
        let kinds: [Kind; 6] = [grass.into(), leaves.into(), moss.into(), pile.into(), foliage.into(), needles.into()];
        for kind in kinds {
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
