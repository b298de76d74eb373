//! Flicker: what changes from frame to frame and should not, or should and does not.

use pelage::tracer::Film;

use crate::noise::Halves;

/// Flicker of the frames `test` over those of the reference: the root mean square, over changes from frame to frame,
/// pixels and channels, of (the test's change − the reference's change), in radiance.
///
/// What both show alike does not count, and a picture that stands still while the reference moves flickers as much as
/// one that moves while it stands: blur does not win. The noise of the reference is subtracted: its changes have the
/// variance of both their frames. 0 for fewer than two frames.
pub(crate) fn flicker(test: &[Film], reference: &[Halves]) -> f64 {
    let frames: Vec<_> = test.iter().zip(reference).collect();
    let squares: f64 = frames
        .windows(2)
        .map(|pair| {
            let [(a, ra), (b, rb)] = [pair[0], pair[1]];
            let changes = (a.pixels.iter().zip(&b.pixels)).zip(ra.mean.pixels.iter().zip(&rb.mean.pixels));
            let sum: f64 = changes
                .map(|((a, b), (ra, rb))| {
                    let [test, reference] =
                        [(a, b), (ra, rb)].map(|(a, b)| b.color.as_dvec3() - a.color.as_dvec3());
                    (test - reference).length_squared()
                })
                .sum();
            sum / (3 * a.pixels.len().max(1)) as f64 - ra.variance() - rb.variance()
        })
        .sum();
    (squares / frames.len().saturating_sub(1).max(1) as f64).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pelage::tracer::{Pixel, Rect};

    fn grey(color: f32) -> Film {
        let pixel = Pixel { color: Vec3::splat(color), alpha: 1.0, depth: 1.0 };
        Film { size: [2, 2], window: Rect::whole([2, 2]), pixels: vec![pixel; 4] }
    }

    fn still(colors: &[f32]) -> Vec<Halves> {
        colors.iter().map(|&c| Halves::new(grey(c), grey(c))).collect()
    }

    #[test]
    fn the_same_changes_are_no_flicker() {
        let colors = [0.1, 0.4, 0.2, 0.8];
        let films = |offset: f32| colors.map(|c| grey(c + offset)).to_vec();
        assert_eq!(flicker(&films(0.0), &still(&colors)), 0.0);
        // A constant error is seen elsewhere, not here.
        assert!(flicker(&films(0.5), &still(&colors)) < 1e-7);
        assert_eq!(flicker(&films(0.0)[..1], &still(&colors[..1])), 0.0);
    }

    #[test]
    fn too_much_and_too_little_change_weigh_the_same() {
        // Changes of ±.3 against none, and none against ±.3.
        let (moving, standing) = ([0.2, 0.5, 0.2], [0.2; 3]);
        let films = |colors: [f32; 3]| colors.map(grey).to_vec();
        assert!((flicker(&films(moving), &still(&standing)) - 0.3).abs() < 1e-7);
        assert!((flicker(&films(standing), &still(&moving)) - 0.3).abs() < 1e-7);
    }

    #[test]
    fn noise_of_the_reference_does_not_count() {
        // Halves .1 apart: the mean has the variance .0025 by pixel, a change .005, and the test stands .3 off it:
        // √(.09 − .005).
        let reference: Vec<Halves> = [0.5, 0.5].map(|c| Halves::new(grey(c - 0.05), grey(c + 0.05))).into();
        let measured = flicker(&[grey(0.2), grey(0.5)], &reference);
        assert!((measured - 0.085_f64.sqrt()).abs() < 1e-6, "{measured}");
    }
}
