//! Texels of densities: every level lets through as much light as the density does, along the whole way.

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::evenly;
use pelage_texel::{
    BuildError, BuildOptions, Density, Hypertexture, Kind, Level, Procedure, Source, Texel, build,
};

fn options(depth: u32) -> BuildOptions {
    BuildOptions { depth, ..BuildOptions::preview() }
}

fn built(hypertexture: &Hypertexture, depth: u32) -> Texel {
    build("density", hypertexture.clone(), &options(depth), &|_| ()).expect("a sound preset")
}

/// What a level lets pass between two points (texel coordinates).
fn passed(level: &Level, [from, to]: [Vec3; 2]) -> f32 {
    let scale = level.resolution() as f32;
    level.transmittance(from * scale, to * scale)
}

/// What the density itself does, by the midpoint rule.
fn passed_exactly(density: &Density, [from, to]: [Vec3; 2]) -> f32 {
    let (from, to) = (from.as_dvec3(), to.as_dvec3());
    let steps = 200;
    let part = (to - from).length() / f64::from(steps);
    let at = |i: u32| {
        let p = from.lerp(to, (f64::from(i) + 0.5) / f64::from(steps));
        DVec3::new(p.x - p.x.floor(), p.y - p.y.floor(), p.z)
    };
    (-(0..steps).map(|i| density.extinction(at(i)) * part).sum::<f64>()).exp() as f32
}

/// Sightlines from above, evenly spread, at a slope.
fn sightlines(slope: f32, count: u32) -> impl Iterator<Item = [Vec3; 2]> {
    (0..count).map(move |i| {
        let from = evenly(i as usize).as_vec2().extend(1.0);
        let along = Vec2::from_angle(2.4 * i as f32) * slope;
        [from, from + along.extend(-1.0)]
    })
}

#[test]
fn every_level_stops_as_much_light_as_the_density() {
    for (name, preset) in [("rough", Hypertexture::rough()), ("clouds", Hypertexture::clouds())] {
        let (density, texel) = (preset.density(), built(&preset, 4));
        assert_eq!(texel.validate(), Ok(()));
        for slope in [0.0, 1.0, 3.0] {
            let count = 400;
            let mean =
                |f: &dyn Fn([Vec3; 2]) -> f32| sightlines(slope, count).map(f).sum::<f32>() / count as f32;
            let exact = 1.0 - mean(&|line| passed_exactly(&density, line));
            let levels: Vec<f32> =
                texel.levels().iter().map(|level| 1.0 - mean(&|line| passed(level, line)) - exact).collect();
            println!("{name}, slope {slope}: {exact:.3} stopped; by level {levels:+.3?}");
            for (l, error) in levels.into_iter().enumerate() {
                // Calibrated in classes of 15° of slope, which all slopes of a class together match. Reached, rounded up:
                // .02 straight down, .054 in the one and the eight voxels of levels 0 and 1 at a slope of 18°.
                assert!(error.abs() < if l < 2 { 0.06 } else { 0.025 }, "{name}, level {l}: {error}");
            }
        }
    }
}

#[test]
fn an_even_density_is_exact() {
    // A layer without noise, .2 thick with a boundary of .02: what passes straight down is e^−.2ρ, at 45° e^−.2√2ρ.
    let layer = Hypertexture {
        size: 0.1,
        roundness: 0.0,
        amplitude: 0.0,
        softness: 0.02,
        density: 10.0,
        ..Hypertexture::calm()
    };
    let texel = built(&layer, 3);
    for slope in [0.0_f32, 1.0] {
        let exact = (-2.0 * (1.0 + slope * slope).sqrt()).exp();
        for level in texel.levels() {
            let mean = sightlines(slope, 50).map(|line| passed(level, line)).sum::<f32>() / 50.0;
            println!("slope {slope}, {} voxels a side: {mean:.4}, exactly {exact:.4}", level.resolution());
            assert!((mean - exact).abs() < 0.01, "{mean}, not {exact}");
        }
    }
}

#[test]
fn scatterers_face_out_and_see_out() {
    // A dense ball: what is seen of it from above faces up, and nothing passes through its middle.
    let ball = Hypertexture { amplitude: 0.0, density: 300.0, ..Hypertexture::calm() };
    let options = BuildOptions { depth: 1, ..BuildOptions::standard() };
    let texel = build("ball", ball, &options, &|_| ()).expect("a sound ball");
    let whole = texel.level(0).scatterers(0);
    assert!(whole.points().len() > 500);
    let [mut up, mut down, mut sum] = [0.0, 0.0, 0.0];
    for (i, point) in whole.points().iter().enumerate() {
        up += point.weight() * whole.transmittance(i, Vec3::Z) * point.normal().z;
        down += point.weight() * whole.transmittance(i, Vec3::NEG_Z) * point.normal().z;
        sum += point.weight() * whole.transmittance(i, Vec3::Z);
    }
    // An opaque ball shows its normals by their cosine: on average ∫cos²/∫cos = ⅔ towards the eye, a little less through
    // a boundary of some thickness.
    println!("towards the eye {:.3}", up / sum);
    assert!((up / sum - 2.0 / 3.0).abs() < 0.05 && down < 0.0);
    // Below the levels that are mapped, they are points alone.
    assert!(texel.level(0).scatterers(7).is_empty());
}

#[test]
fn nothing_is_an_empty_texel() {
    let nothing = built(&Hypertexture { density: 0.0, ..Hypertexture::rough() }, 3);
    assert!(nothing.levels().iter().all(Level::is_empty));
    assert_eq!(nothing.validate(), Ok(()));
}

#[test]
fn the_same_texel_with_any_number_of_threads() {
    let one = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| built(&Hypertexture::wild(), 3))
    };
    assert!(one(1) == one(3));
}

#[test]
fn it_has_no_triangles_and_says_so() {
    let kind = Kind::from(Hypertexture::rough());
    assert!(kind.density().is_some() && kind.geometry().triangles.is_empty());
    assert_eq!(Source::from(kind.clone()).geometry(), None);
    assert!(Source::from(kind).density().is_some());
}

#[test]
fn what_cannot_be_is_named() {
    let rough = Hypertexture::rough;
    for (wrong, field) in [
        (Hypertexture { softness: 0.0, ..rough() }, "softness"),
        (Hypertexture { octaves: 7, ..rough() }, "octaves"),
        (Hypertexture { octaves: 0, ..rough() }, "octaves"),
        (Hypertexture { frequency: 0, ..rough() }, "frequency"),
        (Hypertexture { gain: f32::NAN, ..rough() }, "gain"),
        (Hypertexture { density: -1.0, ..rough() }, "density"),
    ] {
        match build("", wrong, &options(3), &|_| ()) {
            Err(BuildError::Parameter { field: named, .. }) => assert_eq!(named, field),
            other => panic!("{field}: {other:?}"),
        }
    }
}
