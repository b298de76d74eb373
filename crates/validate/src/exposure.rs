//! How bright radiance is shown, so that a person can be asked what they see.

use glam::vec3;
use pelage::tracer::Film;

/// What the brightest parts come to in linear display values; what shines brighter still has room above.
const BRIGHT: f32 = 0.8;

/// The exposure at which 95 % of what is not black in `film` is shown at or below 0.8 (linear); 1 for a black film.
///
/// A quantile, because one highlight should not darken a whole picture.
pub fn exposure_of(film: &Film) -> f32 {
    let luminance = |pixel: &pelage::tracer::Pixel| pixel.color.dot(vec3(0.2126, 0.7152, 0.0722));
    let mut lit: Vec<f32> = film.pixels.iter().map(luminance).filter(|&y| y > 0.0).collect();
    if lit.is_empty() {
        return 1.0;
    }
    let place = (lit.len() - 1) * 95 / 100;
    let (_, &mut bright, _) = lit.select_nth_unstable_by(place, f32::total_cmp);
    let exposure = BRIGHT / bright;
    if exposure.is_finite() { exposure } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pelage::tracer::{Pixel, Rect};

    #[test]
    fn the_ninety_fifth_of_a_hundred() {
        // Greys 1 … 100 among black pixels, in no order: 5 of them are brighter than 95.
        let color =
            |i: u32| Vec3::splat(if i.is_multiple_of(2) { 0.0 } else { (i / 2 * 37 % 100 + 1) as f32 });
        let pixels = (0..200).map(|i| Pixel { color: color(i), alpha: 1.0, depth: f32::INFINITY }).collect();
        let film = Film { size: [20, 10], window: Rect::whole([20, 10]), pixels };
        assert!((exposure_of(&film) - 0.8 / 95.0).abs() < 1e-6);
        assert_eq!(exposure_of(&Film::new([2, 2], Rect::whole([2, 2]))), 1.0);
    }
}
