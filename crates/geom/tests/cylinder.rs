//! A needle is a thin cylinder: what its ellipsoid sends of the light against the closed forms of a Lambertian cylinder
//! and of Kajiya and Kay. [KajiyaKay89, method §7]
//!
//! Let θ be the angle between the light and the axis, and φ the azimuth between the light and the eye about it. At the
//! azimuth ψ from the eye a cylinder's normal shows cos ψ/2 of what is seen, for |ψ| ≤ π/2, and meets the light by
//! sin θ · cos(ψ − φ) where that is positive. So of a Lambertian cylinder's light the part
//!
//! ```text
//! ∫ cos ψ/2 · sin θ cos⁺(ψ − φ) dψ = sin θ [(π − φ) cos φ + sin φ] / 4
//! ```
//!
//! is seen, over all φ on average sin θ/π: the form of Kajiya and Kay, who leave φ out.

use core::f64::consts::{FRAC_1_PI, PI};

use pelage_geom::glam::{Mat3, Vec3};
use pelage_geom::{Ellipsoid, Symmetric3};

/// The mean of max(0, N·L) over the normals that `eye` sees, by `side`² midpoints.
fn lit(ellipsoid: Ellipsoid, eye: Vec3, light: Vec3, side: u32) -> f64 {
    let visible = ellipsoid.visible(eye);
    let point = |i: u32| (i as f32 + 0.5) / side as f32;
    let cosines = (0..side * side).map(|i| visible.sample([point(i % side), point(i / side)]).dot(light));
    cosines.map(|cosine| f64::from(cosine.max(0.0))).sum::<f64>() / f64::from(side * side)
}

/// The unit vector at an angle to Z and an azimuth about it.
fn around(angle: f64, azimuth: f64) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    Vec3::new((sin * azimuth.cos()) as f32, (sin * azimuth.sin()) as f32, cos as f32)
}

fn cylinder(theta: f64, phi: f64) -> f64 {
    theta.sin() * ((PI - phi) * phi.cos() + phi.sin()) / 4.0
}

const ANGLES: [f64; 4] = [0.3, 0.8, 1.3, 2.2];
const AZIMUTHS: [f64; 6] = [0.0, 0.4, 1.0, 1.8, 2.6, PI];

#[test]
fn a_needle_is_a_lambertian_cylinder() {
    // Turned anyhow, seen from any slope: the closed form does not ask for the eye's.
    let axis = Vec3::new(0.36, -0.48, 0.8);
    let (x, y) = axis.any_orthonormal_pair();
    let turn = Mat3::from_cols(x, y, x.cross(y));
    let needle = Ellipsoid::needle(turn.z_axis);
    for (eye_angle, theta) in ANGLES.into_iter().flat_map(|eye| ANGLES.map(|light| (eye, light))) {
        for phi in AZIMUTHS {
            let seen = lit(needle, turn * around(eye_angle, 0.5), turn * around(theta, 0.5 + phi), 64);
            let expected = cylinder(theta, phi);
            assert!((seen - expected).abs() < 2e-3, "{eye_angle} {theta} {phi}: {seen}, not {expected}");
        }
    }
}

#[test]
fn over_all_azimuths_it_is_kajiya_and_kay_s() {
    let steps = 64;
    for theta in ANGLES {
        let mean: f64 = (0..steps)
            .map(|i| 2.0 * PI * (f64::from(i) + 0.5) / f64::from(steps))
            .map(|phi| lit(Ellipsoid::needle(Vec3::Z), around(1.1, 0.0), around(theta, phi), 32))
            .sum::<f64>()
            / f64::from(steps);
        let expected = theta.sin() * FRAC_1_PI;
        assert!((mean - expected).abs() < 1e-3, "{theta}: {mean}, not {expected}");
    }
}

#[test]
fn ever_thinner_ellipsoids_come_to_it() {
    // Normals along the axis, of which ε shows for each 1 across it: what they add is of the order of ε.
    let worst = |epsilon: f32| {
        let ellipsoid = Ellipsoid(Symmetric3::from_diagonal(Vec3::new(1.0, 1.0, epsilon * epsilon)));
        let mut worst = 0.0_f64;
        for (eye_angle, theta) in ANGLES.into_iter().flat_map(|eye| ANGLES.map(|light| (eye, light))) {
            for phi in AZIMUTHS {
                let seen = lit(ellipsoid, around(eye_angle, 0.0), around(theta, phi), 64);
                worst = worst.max((seen - cylinder(theta, phi)).abs());
            }
        }
        worst
    };
    let errors = [0.3, 0.1, 0.03, 0.01].map(|epsilon| (epsilon, worst(epsilon)));
    println!("thickness and worst error: {errors:.4?}");
    for (epsilon, error) in errors {
        assert!(error < 2.0 * f64::from(epsilon) + 2e-3, "{epsilon}: {error}");
    }
    assert!(errors.windows(2).all(|pair| pair[1].1 < pair[0].1), "{errors:?}");
}
