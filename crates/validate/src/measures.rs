//! Two films compared, number by number.

use glam::{DVec3, Vec3};
use pelage::output::Display;
use pelage::tracer::{Film, Pixel, Rect};
use serde::Serialize;

/// Why two films cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureError {
    /// They are not parts of pictures of the same size.
    #[error("{}x{} pixels against {}x{} of the reference", test[0], test[1], reference[0], reference[1])]
    Size {
        /// Width and height of the test's whole picture.
        test: [u32; 2],
        /// Width and height of the reference's.
        reference: [u32; 2],
    },
    /// They hold different parts of the picture.
    #[error(
        "{}x{} pixels from column {} and row {} against {}x{} from column {} and row {} of the reference",
        test.width, test.height, test.x, test.y, reference.width, reference.height, reference.x, reference.y
    )]
    Window {
        /// The part that the test holds.
        test: Rect,
        /// The part that the reference holds.
        reference: Rect,
    },
    /// A film has not as many pixels as its window, or none.
    #[error("the film has {pixels} pixels for a window of {width}x{height}")]
    Film {
        /// How many pixels it holds.
        pixels: usize,
        /// Columns of its window.
        width: u32,
        /// Rows of its window.
        height: u32,
    },
}

/// The largest difference of any channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// |a − b|, in linear radiance.
    pub value: f64,
    /// The pixel's column in the whole picture.
    pub x: u32,
    /// Its row.
    pub y: u32,
}

/// How far a test a is from its reference b.
///
/// a and b are linear, premultiplied radiance, as over black; means are over the n pixels of the window and, for
/// colours, over the three channels, summed in `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Root mean square error √(mean (a − b)²), in radiance.
    pub rmse: f64,
    /// Relative mean square error, mean (a − b)²/(b² + ε), ε = 0.01 radiance². \[Rousselle12\]
    pub rel_mse: f64,
    /// Peak signal-to-noise ratio −10 log₁₀ mean (a′ − b′)² in dB, where a′ and b′ in `[0,1]` are the sRGB bytes / 255
    /// that a screen shows; `None` where these are the same.
    pub psnr: Option<f64>,
    /// Energy: mean a / mean b; `None` where the reference is black.
    pub energy_ratio: Option<f64>,
    /// Mean alpha of the test over that of the reference, less 1; `None` where the reference is empty.
    pub alpha_bias: Option<f64>,
    /// Mean alpha of the test less that of the reference.
    pub alpha_difference: f64,
    /// The largest difference of a channel, and the first pixel that has it.
    pub max_difference: Difference,
}

/// ε of [`Measures::rel_mse`], in radiance².
const REL_EPSILON: f64 = 0.01;

impl Measures {
    /// Compares two films of the same window; `display` says what a screen shows of them.
    ///
    /// # Errors
    /// Different sizes or windows; a film without its pixels.
    pub fn of(test: &Film, reference: &Film, display: &Display) -> Result<Self, MeasureError> {
        check(test, reference)?;
        let (mut squares, mut relative, mut shown) = (0.0, 0.0, 0.0);
        let mut largest = (0.0, 0);
        for (i, (a, b)) in test.pixels.iter().zip(&reference.pixels).enumerate() {
            let reference = b.color.as_dvec3();
            let difference = a.color.as_dvec3() - reference;
            squares += difference.length_squared();
            relative += (difference * difference / (reference * reference + REL_EPSILON)).element_sum();
            shown += (screen(a.color, display) - screen(b.color, display)).length_squared();
            let worst = difference.abs().max_element();
            if worst > largest.0 {
                largest = (worst, i as u32);
            }
        }
        let window = reference.window;
        let n = reference.pixels.len() as f64;
        let ratio = |a: f64, b: f64| (b > 0.0).then(|| a / b);
        let [alpha_a, alpha_b] = [test, reference].map(mean_alpha);
        let shown = shown / (3.0 * n);
        Ok(Self {
            rmse: (squares / (3.0 * n)).sqrt(),
            rel_mse: relative / (3.0 * n),
            psnr: (shown > 0.0).then(|| -10.0 * shown.log10()),
            energy_ratio: ratio(mean_radiance(test), mean_radiance(reference)),
            alpha_bias: ratio(alpha_a, alpha_b).map(|r| r - 1.0),
            alpha_difference: alpha_a - alpha_b,
            max_difference: Difference {
                value: largest.0,
                x: window.x + largest.1 % window.width,
                y: window.y + largest.1 / window.width,
            },
        })
    }
}

/// Whether the films can be compared pixel by pixel.
pub(crate) fn check(test: &Film, reference: &Film) -> Result<(), MeasureError> {
    if test.size != reference.size {
        return Err(MeasureError::Size { test: test.size, reference: reference.size });
    }
    if test.window != reference.window {
        return Err(MeasureError::Window { test: test.window, reference: reference.window });
    }
    for film in [test, reference] {
        let (pixels, Rect { width, height, .. }) = (film.pixels.len(), film.window);
        if pixels == 0 || pixels != film.window.area() {
            return Err(MeasureError::Film { pixels, width, height });
        }
    }
    Ok(())
}

/// Mean over pixels and channels, 0 for a film without pixels.
pub(crate) fn mean_radiance(film: &Film) -> f64 {
    mean(film, |pixel| pixel.color.as_dvec3().element_sum() / 3.0)
}

/// Mean over pixels, 0 for a film without pixels.
pub(crate) fn mean_alpha(film: &Film) -> f64 {
    mean(film, |pixel| f64::from(pixel.alpha))
}

fn mean(film: &Film, of: impl Fn(&Pixel) -> f64) -> f64 {
    film.pixels.iter().map(of).sum::<f64>() / film.pixels.len().max(1) as f64
}

/// The sRGB values that a screen shows, in steps of 1/255.
fn screen(radiance: Vec3, display: &Display) -> DVec3 {
    DVec3::from(display.srgb(radiance).map(f64::from)) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage::output::Tone;

    const LINEAR: Display = Display { exposure: 1.0, tone: Tone::None };

    fn film(pixels: &[(f32, f32)]) -> Film {
        let pixel =
            |&(color, alpha): &(f32, f32)| Pixel { color: Vec3::splat(color), alpha, depth: f32::INFINITY };
        let window = Rect { x: 4, y: 2, width: 2, height: pixels.len() as u32 / 2 };
        Film { size: [16, 16], window, pixels: pixels.iter().map(pixel).collect() }
    }

    #[test]
    fn four_pixels_by_hand() {
        let b = film(&[(0.5, 1.0), (0.2, 0.5), (0.0, 0.0), (0.3, 1.0)]);
        let a = film(&[(0.4, 1.0), (0.2, 0.5), (0.0, 0.0), (0.6, 0.75)]);
        let m = Measures::of(&a, &b, &LINEAR).expect("alike");
        // Differences −.1, 0, 0, .3: mean square .1/4 = .025; relative .01/.26 + .09/.10 over four.
        assert!((m.rmse - 0.025_f64.sqrt()).abs() < 1e-7);
        assert!((m.rel_mse - (0.01 / 0.26 + 0.09 / 0.10) / 4.0).abs() < 1e-6, "{}", m.rel_mse);
        // Sums 1.2 over 1.0; alphas 2.25 over 2.5.
        assert!((m.energy_ratio.expect("light") - 1.2).abs() < 1e-6);
        assert!((m.alpha_bias.expect("matter") + 0.1).abs() < 1e-12);
        assert!((m.alpha_difference + 0.25 / 4.0).abs() < 1e-12);
        // The fourth pixel of a window of two columns at (4, 2).
        assert!((m.max_difference.value - 0.3).abs() < 1e-7);
        assert_eq!((m.max_difference.x, m.max_difference.y), (5, 3));
    }

    #[test]
    fn the_signal_is_what_a_screen_shows() {
        // Radiance 2 and 1 are both white on a screen: nothing differs there. Black for white is 0 dB.
        let white = film(&[(1.0, 1.0); 4]);
        let psnr = |color: f32| Measures::of(&film(&[(color, 1.0); 4]), &white, &LINEAR).expect("alike").psnr;
        assert_eq!(psnr(2.0), None);
        assert_eq!(psnr(0.0), Some(0.0));
        // .215861 is the byte 128, white 255, −20 log₁₀(127/255) = 6.0548 dB.
        assert!((psnr(0.215_861).expect("different") - 6.0548).abs() < 1e-3);
    }

    #[test]
    fn nothing_has_no_ratio() {
        let black = film(&[(0.0, 0.0); 2]);
        let m = Measures::of(&film(&[(0.1, 0.1); 2]), &black, &LINEAR).expect("alike");
        assert_eq!((m.energy_ratio, m.alpha_bias), (None, None));
        assert!((m.alpha_difference - 0.1).abs() < 1e-7);
    }

    #[test]
    fn what_is_not_alike() {
        let a = film(&[(0.0, 0.0); 4]);
        let of = |b: &Film| Measures::of(&a, b, &LINEAR).expect_err("refused").to_string();
        assert_eq!(of(&Film { size: [16, 9], ..a.clone() }), "16x16 pixels against 16x9 of the reference");
        let moved = Rect { x: 0, ..a.window };
        let said = of(&Film { window: moved, ..a.clone() });
        assert!(said.starts_with("2x2 pixels from column 4 and row 2 against"), "{said}");
        let short = Film { pixels: vec![], ..a.clone() };
        assert!(matches!(of(&short).as_str(), "the film has 0 pixels for a window of 2x2"));
    }
}
