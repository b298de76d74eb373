//! PNG: what a screen shows.

use std::io;
use std::path::Path;

use glam::Vec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use pelage_tracer::{Film, Pixel};

use super::{Display, OutputError, check, replace};

/// Writes the window of `film` as RGBA, 8 bits, sRGB, straight alpha. The same film gives the same bytes.
///
/// # Errors
/// [`OutputError`]; a file of that name is then what it was before.
pub fn write_png(film: &Film, path: &Path, display: &Display) -> Result<(), OutputError> {
    check(film)?;
    replace(path, |file| encode_png(film, display, file))
}

/// Writes what [`write_png`] does to any place.
///
/// # Errors
/// What `to` says; a film that has not as many pixels as its window.
pub fn encode_png(film: &Film, display: &Display, to: impl io::Write) -> io::Result<()> {
    check(film).map_err(io::Error::other)?;
    let bytes: Vec<u8> = film.pixels.iter().flat_map(|pixel| rgba(pixel, display)).collect();
    PngEncoder::new(to)
        .write_image(&bytes, film.window.width, film.window.height, ExtendedColorType::Rgba8)
        .map_err(io::Error::other)
}

fn rgba(pixel: &Pixel, display: &Display) -> [u8; 4] {
    let alpha = if pixel.alpha > 0.0 { pixel.alpha.min(1.0) } else { 0.0 };
    // The curve bends, so it belongs to the colour itself, not to its product with alpha.
    let straight = if alpha > 0.0 { pixel.color / alpha } else { Vec3::ZERO };
    let [r, g, b] = display.srgb(straight);
    [r, g, b, byte(alpha)]
}

pub(super) fn byte(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}

/// The sRGB transfer function, over `[0,1]`. [IEC 61966-2-1]
pub(super) fn linear_to_srgb(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Tone;

    #[test]
    fn straight_srgb_bytes() {
        let display = Display { exposure: 2.0, tone: Tone::None };
        let pixel = |color, alpha| Pixel { color: Vec3::splat(color), alpha, depth: 1.0 };
        // 0.107 / ½ · 2 = 0.428 → 1.055 · 0.428^(1/2.4) − 0.055 = 0.6858 → 174.9.
        assert_eq!(rgba(&pixel(0.107, 0.5), &display), [175, 175, 175, 128]);
        assert_eq!(rgba(&pixel(9.0, 1.0), &display), [255; 4]);
        assert_eq!(rgba(&pixel(f32::NAN, 1.0), &display), [0, 0, 0, 255]);
        assert_eq!(rgba(&Pixel::EMPTY, &display), [0; 4]);
    }
}
