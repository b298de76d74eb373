//! FLIP: how much of a difference a person sees. The only room that names `nv_flip`. [Andersson20]

use nv_flip::{FlipImageFloat, FlipImageRgb8, magma_lut};
use pelage::output::Display;
use pelage::tracer::Film;

use crate::measures::{MeasureError, check};

/// Pixels a degree of a 0.7 m wide screen of 3840 pixels seen from 0.7 m, as in \[Andersson20\].
pub const NORMAL_PPD: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// What a person sees of a difference, pixel by pixel.
pub struct FlipMap {
    map: FlipImageFloat,
}

/// Compares two films as they look on a screen, over black, at `ppd` pixels a degree of the eye.
///
/// The films are shown as `display` says (the same for both), in sRGB bytes, and their difference in filtered colour
/// and in edges and points goes from 0, none, to 1, black for white. \[Andersson20\], its LDR variant.
///
/// # Errors
/// Different sizes or windows; a film without its pixels.
pub fn flip(test: &Film, reference: &Film, display: &Display, ppd: f32) -> Result<FlipMap, MeasureError> {
    check(test, reference)?;
    let [test, reference] = [test, reference].map(|film| {
        let bytes: Vec<u8> = film.pixels.iter().flat_map(|pixel| display.srgb(pixel.color)).collect();
        FlipImageRgb8::with_data(film.window.width, film.window.height, &bytes)
    });
    Ok(FlipMap { map: nv_flip::flip(reference, test, ppd) })
}

impl FlipMap {
    /// The difference of each pixel, in `[0,1]`, row by row.
    pub fn values(&self) -> Vec<f32> {
        self.map.to_vec()
    }

    /// The mean over all pixels, in `[0,1]`: the one number that stands for all.
    pub fn mean(&self) -> f64 {
        let values = self.values();
        values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len().max(1) as f64
    }

    /// sRGB bytes in the colours of the map *magma*: black for 0, pale yellow for 1.
    pub fn colors(&self) -> Vec<[u8; 3]> {
        let bytes = self.map.apply_color_lut(&magma_lut()).to_vec();
        bytes.as_chunks().0.to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pelage::output::Tone;
    use pelage::tracer::{Pixel, Rect};

    const LINEAR: Display = Display { exposure: 1.0, tone: Tone::None };

    fn film(color: impl Fn(usize, usize) -> f32) -> Film {
        let size = [48, 32];
        let pixel =
            |i: usize| Pixel { color: Vec3::splat(color(i % 48, i / 48)), alpha: 1.0, depth: f32::INFINITY };
        Film { size, window: Rect::whole(size), pixels: (0..48 * 32).map(pixel).collect() }
    }

    fn mean(a: &Film, b: &Film) -> f64 {
        flip(a, b, &LINEAR, NORMAL_PPD).expect("alike").mean()
    }

    #[test]
    fn nothing_differs_from_itself() {
        let stripes = film(|x, y| if (x / 3 + y) % 2 == 0 { 0.2 } else { 0.7 });
        assert_eq!(mean(&stripes, &stripes), 0.0);
    }

    #[test]
    fn uniform_greys_by_the_paper() {
        // Greys have no edges and no hue: the difference is that of lightness alone, by HyAB |ΔL*|, to the power
        // q_c = .7, against the largest, c = the .7th power of the HyAB distance of green and blue in Hunt-adjusted
        // L*a*b*: 41.2760 in full. Below p_c c (p_c = .4) it maps linearly to [0, p_t = .95], above to the rest.
        let expected = |lightness: f64| {
            let (error, most, p_c, p_t) = (lightness.powf(0.7), 41.2760, 0.4, 0.95);
            if error < p_c * most {
                p_t / (p_c * most) * error
            } else {
                p_t + (error - p_c * most) / (most - p_c * most) * (1.0 - p_t)
            }
        };
        // L* = 116 Y^⅓ − 16 for Y above (6/29)³; black is 0, white 100.
        let lightness = |y: f64| 116.0 * y.cbrt() - 16.0;
        let [black, grey, white] = [0.0, 0.215_861, 1.0].map(|y| film(move |_, _| y));
        // .215861 is the byte 128.
        let cases = [(&black, &white, 100.0), (&grey, &white, 100.0 - lightness(0.215_861))];
        for (a, b, difference) in cases {
            let (measured, expected) = (mean(a, b), expected(difference));
            println!("FLIP {measured:.5}, by hand {expected:.5}");
            assert!((measured - expected).abs() < 2e-3);
            assert_eq!(measured, mean(b, a));
        }
    }

    #[test]
    fn magma_goes_from_black_to_pale_yellow() {
        let map = flip(&film(|x, _| if x < 24 { 0.0 } else { 1.0 }), &film(|_, _| 0.0), &LINEAR, NORMAL_PPD)
            .expect("alike");
        let colors = map.colors();
        assert_eq!(colors.len(), 48 * 32);
        let (same, other) = (colors[0], colors[47]);
        assert!(same.iter().all(|&x| x < 8) && other[0] > 240 && other[1] > 200, "{same:?} {other:?}");
    }
}
