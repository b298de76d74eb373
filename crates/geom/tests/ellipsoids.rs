//! Ellipsoids of normals against the flakes they stand for: what is seen, how it is sampled, and what deformation
//! does to it.

mod random;

use core::f64::consts::{PI, TAU};

use pelage_geom::glam::{DMat3, DVec3, Mat3, Vec3};
use pelage_geom::{Ellipsoid, Symmetric3};
use random::Random;

/// A random positive definite S with axes between `least` and 1.
fn random_ellipsoid(random: &mut Random, least: f64) -> Ellipsoid {
    let (x, y) = random.direction().as_vec3().any_orthonormal_pair();
    let axes = Mat3::from_cols(x, y, x.cross(y));
    let mut axis = || random.between(least, 1.0).powi(2) as f32;
    let values = Vec3::new(axis(), axis(), axis());
    Ellipsoid(Symmetric3::from_diagonal(values).congruence(axes.transpose()))
}

/// A well-conditioned random J.
fn random_jacobian(random: &mut Random) -> Mat3 {
    loop {
        let j = Mat3::from_cols(
            Vec3::X + random.cube(0.6).as_vec3(),
            Vec3::Y + random.cube(0.6).as_vec3(),
            Vec3::Z + random.cube(0.6).as_vec3(),
        );
        if j.determinant() > 0.2 {
            return j;
        }
    }
}

/// Midpoints of an equal-area grid on the sphere, with the solid angle of each.
fn sphere(rows: usize) -> (Vec<DVec3>, f64) {
    let columns = 2 * rows;
    let point = |i: usize| {
        let z = 1.0 - 2.0 * ((i / columns) as f64 + 0.5) / rows as f64;
        let phi = TAU * ((i % columns) as f64 + 0.5) / columns as f64;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    };
    ((0..rows * columns).map(point).collect(), 4.0 * PI / (rows * columns) as f64)
}

#[test]
fn constructors_show_what_they_say() {
    let axis = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    let across = axis.any_orthonormal_vector();
    let slanted = (axis + across).normalize();
    let half = core::f32::consts::FRAC_1_SQRT_2;
    let tube = core::f32::consts::FRAC_2_PI;
    for (ellipsoid, expected) in [
        (Ellipsoid::needle(axis), [0.0, tube, tube * half]),
        (Ellipsoid::flake(axis), [1.0, 0.0, half]),
        (Ellipsoid::isotropic(), [0.5; 3]),
    ] {
        for (w, shown) in [axis, across, slanted].into_iter().zip(expected) {
            // The root turns the rounding 1e-7 of S into 3e-4 where nothing is shown.
            assert!((ellipsoid.projected_area(w).powi(2) - shown * shown).abs() < 1e-6, "{ellipsoid:?} {w}");
        }
    }
}

#[test]
fn ellipsoids_of_sampled_normals_are_the_constructors() {
    let mut random = Random::new(30);
    let axis = random.direction().as_vec3();
    let (x, y) = axis.any_orthonormal_pair();
    let tube = (0..1000).map(|i| {
        let (sin, cos) = (i as f32 * core::f32::consts::TAU / 1000.0).sin_cos();
        (x * cos + y * sin, 2.0)
    });
    let (ball, _) = sphere(100);
    let ball = ball.into_iter().map(|n| (n.as_vec3(), 0.5));
    for (fitted, expected) in [
        (Ellipsoid::from_normals(tube), Ellipsoid::needle(axis)),
        (Ellipsoid::from_normals([(axis, 3.0), (-axis, 1.0)]), Ellipsoid::flake(axis)),
        (Ellipsoid::from_normals(ball), Ellipsoid::isotropic()),
    ] {
        let difference = (fitted.0 - expected.0).to_mat3().to_cols_array();
        assert!(difference.iter().all(|d| d.abs() < 1e-3), "{fitted:?} {expected:?}");
    }
    assert_eq!(Ellipsoid::from_normals([]), Ellipsoid::default());
    let mean = Ellipsoid::mean([(Ellipsoid::flake(Vec3::X), 1.0), (Ellipsoid::flake(Vec3::Y), 3.0)]);
    assert_eq!(mean.0, Symmetric3::from_diagonal(Vec3::new(0.25, 0.75, 0.0)));
    assert_eq!(Ellipsoid::mean([]), Ellipsoid::default());
}

#[test]
fn the_density_shows_the_projected_area() {
    let mut random = Random::new(31);
    let (points, solid_angle) = sphere(200);
    for _ in 0..20 {
        let ellipsoid = random_ellipsoid(&mut random, 0.3);
        let w = random.direction().as_vec3();
        let integral = |f: &dyn Fn(Vec3) -> f32| -> f64 {
            points.iter().map(|m| f64::from(f(m.as_vec3()))).sum::<f64>() * solid_angle
        };
        let shown = integral(&|m| w.dot(m).max(0.0) * ellipsoid.density(m));
        let expected = f64::from(ellipsoid.projected_area(w));
        assert!((shown / expected - 1.0).abs() < 2e-3, "{shown} instead of {expected}");
        let total = integral(&|m| ellipsoid.visible_density(w, m));
        assert!((total - 1.0).abs() < 2e-3, "{total}");
    }
    // A ball's normals are even: area 2 over 4π, to either side.
    assert!((Ellipsoid::isotropic().density(Vec3::Y) - 1.0 / TAU as f32).abs() < 1e-6);
}

/// The χ² statistic of sampled visible normals, over cells of equal solid angle, against the density integrated over
/// each cell; with its degrees of freedom.
fn chi_square(random: &mut Random, ellipsoid: &Ellipsoid, w: Vec3, samples: usize) -> (f64, usize) {
    const ROWS: usize = 12;
    const COLUMNS: usize = 24;
    const FINE: usize = 24;
    let cell = |m: Vec3| {
        let row = ((1.0 - f64::from(m.z)) * 0.5 * ROWS as f64) as usize;
        let turn = f64::from(m.y).atan2(f64::from(m.x)) / TAU;
        let column = ((turn - turn.floor()) * COLUMNS as f64) as usize;
        row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
    };
    let mut expected = vec![0.0; ROWS * COLUMNS];
    for row in 0..ROWS * FINE {
        for column in 0..COLUMNS * FINE {
            let z = 1.0 - 2.0 * (row as f64 + 0.5) / (ROWS * FINE) as f64;
            let phi = TAU * (column as f64 + 0.5) / (COLUMNS * FINE) as f64;
            let r = (1.0 - z * z).sqrt();
            let m = DVec3::new(r * phi.cos(), r * phi.sin(), z).as_vec3();
            expected[row / FINE * COLUMNS + column / FINE] += f64::from(ellipsoid.visible_density(w, m));
        }
    }
    let total: f64 = expected.iter().sum();
    let mut seen = vec![0.0; ROWS * COLUMNS];
    for _ in 0..samples {
        let m = ellipsoid.sample_visible(w, [random.unit() as f32, random.unit() as f32]);
        seen[cell(m)] += 1.0;
    }
    // Cells that expect less than five are counted together.
    let (mut statistic, mut used, mut rest) = (0.0, 0, [0.0; 2]);
    for (&e, &s) in expected.iter().zip(&seen) {
        let e = e / total * samples as f64;
        if e < 5.0 {
            rest = [rest[0] + e, rest[1] + s];
        } else {
            statistic += (s - e) * (s - e) / e;
            used += 1;
        }
    }
    if rest[0] >= 5.0 {
        statistic += (rest[1] - rest[0]).powi(2) / rest[0];
        used += 1;
    }
    (statistic, used - 1)
}

#[test]
fn visible_normals_follow_their_density() {
    let mut random = Random::new(32);
    for _ in 0..24 {
        // Random axes AND random directions: a transposed frame passes along the axes.
        let ellipsoid = random_ellipsoid(&mut random, 0.4);
        let w = random.direction().as_vec3();
        let (statistic, freedom) = chi_square(&mut random, &ellipsoid, w, 40_000);
        // Wilson–Hilferty: the cube root of χ²/k is nearly normal. 24 trials beyond 4.5 σ: one chance in 10⁴.
        let k = freedom as f64;
        let sigmas = ((statistic / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
        assert!(
            sigmas < 4.5,
            "χ² = {statistic} at {freedom} degrees of freedom: {sigmas} σ, {ellipsoid:?}, {w}"
        );
    }
}

#[test]
fn needles_and_flakes_are_sampled_too() {
    let mut random = Random::new(33);
    for _ in 0..2_000 {
        let axis = random.direction().as_vec3();
        let w = random.direction().as_vec3();
        let (needle, flake) = (Ellipsoid::needle(axis).visible(w), Ellipsoid::flake(axis).visible(w));
        for _ in 0..20 {
            let x = [random.unit() as f32, random.unit() as f32];
            let (n, f) = (needle.sample(x), flake.sample(x));
            assert!((n.length() - 1.0).abs() < 1e-5 && n.dot(w) >= -1e-5);
            assert!((f.length() - 1.0).abs() < 1e-5 && f.dot(w) >= -1e-5);
            // S in f32 leaves the root of its rounding, 5e-4, of area that is not there, to compare with the area
            // that is: by the angle, and by the cosine of the flake picked.
            let (sin, cos) = (w.cross(axis).length(), w.dot(axis).abs());
            let picked = (1.0 - x[0]).sqrt();
            assert!(n.dot(axis).abs() < 1e-3 / (sin * picked), "{n} on the needle {axis} from {w}, {x:?}");
            assert!(
                f.cross(axis).length() < 1e-3 / (cos * picked),
                "{f} on the flake {axis} from {w}, {x:?}"
            );
        }
    }
    // End on and edge on nothing is seen, and a unit vector comes back all the same.
    for (ellipsoid, w) in [
        (Ellipsoid::needle(Vec3::Z), Vec3::Z),
        (Ellipsoid::flake(Vec3::Z), Vec3::X),
        (Ellipsoid::default(), Vec3::Y),
    ] {
        let m = ellipsoid.sample_visible(w, [0.3, 0.6]);
        assert!((m.length() - 1.0).abs() < 1e-5 && m.dot(w) >= 0.0, "{m}");
    }
}

#[test]
fn a_needle_shows_its_normals_by_their_cosine() {
    // Across a tube, the visible normals at azimuth φ weigh cos φ/2, so that ⟨N·ω⟩ = ∫ cos²φ/2 dφ = π/4.
    let mut random = Random::new(34);
    let visible = Ellipsoid::needle(Vec3::Z).visible(Vec3::X);
    let count = 200_000;
    let sum: f64 =
        (0..count).map(|_| f64::from(visible.sample([random.unit() as f32, random.unit() as f32]).x)).sum();
    // The cosine's variance is 2/3 − (π/4)² = 0.05: five σ of the mean are 0.0025.
    assert!((sum / f64::from(count) - PI / 4.0).abs() < 2.5e-3);
}

#[test]
fn depth_is_the_same_in_both_spaces() {
    let mut random = Random::new(35);
    for _ in 0..200 {
        let j = random_jacobian(&mut random);
        let wide = j.as_dmat3();
        let inverse_transpose = wide.inverse().transpose();
        let determinant = wide.determinant();
        let flakes: Vec<DVec3> = (0..500).map(|_| random.direction() * random.unit()).collect();
        let ellipsoid = random_ellipsoid(&mut random, 0.1);
        let pushed = ellipsoid.push(&j).expect("a regular J");
        for _ in 0..20 {
            let step = random.direction();
            let scene_step = wide * step;
            // Flake areas map by the cofactor matrix, and their number by unit volume by 1/det J.
            let texel: f64 = flakes.iter().map(|a| a.dot(step).abs()).sum();
            let scene: f64 = flakes
                .iter()
                .map(|a| (determinant * (inverse_transpose * *a)).dot(scene_step).abs() / determinant)
                .sum();
            assert!((scene / texel - 1.0).abs() < 1e-12);
            let (inside, outside) =
                (ellipsoid.projected_area(step.as_vec3()), pushed.projected_area(scene_step.as_vec3()));
            assert!((outside / inside - 1.0).abs() < 1e-4, "{inside} became {outside}");
        }
    }
    // A uniform scale s gives σ' = σ/s.
    let pushed = Ellipsoid::isotropic().push(&Mat3::from_diagonal(Vec3::splat(4.0))).expect("a regular J");
    assert_eq!(pushed.projected_area(Vec3::X), 0.125);
    assert_eq!(Ellipsoid::isotropic().push(&Mat3::from_diagonal(Vec3::new(1.0, 1.0, 0.0))), None);
}

#[test]
fn pushed_visible_normals_are_the_visible_normals_of_the_pushed() {
    let mut random = Random::new(36);
    for _ in 0..12 {
        let j = random_jacobian(&mut random);
        let carry: DMat3 = j.as_dmat3().inverse().transpose();
        let ellipsoid = random_ellipsoid(&mut random, 0.3);
        let pushed = ellipsoid.push(&j).expect("a regular J");
        let w = random.direction().as_vec3();
        let texel_w = (j.inverse() * w).normalize();
        // Moments of the two samplings of what is seen along the same ray.
        let count = 40_000;
        let mut moments = [(DVec3::ZERO, DMat3::ZERO); 2];
        for _ in 0..count {
            let x = [random.unit() as f32, random.unit() as f32];
            let carried = (carry * ellipsoid.sample_visible(texel_w, x).as_dvec3()).normalize();
            let direct = pushed.sample_visible(w, x).as_dvec3();
            for (moment, n) in moments.iter_mut().zip([carried, direct]) {
                moment.0 += n;
                moment.1 += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            }
        }
        let difference = (moments[0].0 - moments[1].0).abs().max_element();
        let second = (moments[0].1 - moments[1].1).to_cols_array();
        // Each entry's deviation is under 1/√n a sampling: five σ of the difference.
        let bound = 5.0 * 2.0_f64.sqrt() * f64::from(count).sqrt();
        assert!(difference < bound && second.iter().all(|d| d.abs() < bound), "{moments:?}");
    }
}

#[test]
fn few_samples_do_not_jump_with_the_view() {
    // A step of 1e-4 of the view may turn no sample of a needle or a flake by more than some thousandths, wherever
    // the view is, the plane z = 0 included; near the edge of a flake, where its normals run away, it is not asked.
    let ellipsoids = [Ellipsoid::needle(Vec3::new(0.1, 0.2, 1.0).normalize()), Ellipsoid::isotropic()];
    for i in 0..2000 {
        let (angle, z) = (0.37 * i as f32, [0.0_f32, 0.5, -0.5, 0.9][i % 4]);
        let flat = (1.0 - z * z).sqrt();
        let view = |z: f32| Vec3::new(flat * angle.cos(), flat * angle.sin(), z).normalize();
        for ellipsoid in &ellipsoids {
            let [above, below] = [view(z + 5e-5), view(z - 5e-5)].map(|w| ellipsoid.visible(w));
            for k in 0..8 {
                let x = [(k as f32 + 0.5) / 8.0, k as f32 * 0.618_034 % 1.0];
                let turned = (above.sample(x) - below.sample(x)).length();
                assert!(turned < 5e-3, "view {i}, sample {k}: {turned}");
            }
        }
    }
}
