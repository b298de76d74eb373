//! Test, reference and what a person sees of their difference, side by side.

use glam::Vec3;
use pelage::import::srgb_to_linear;
use pelage::output::{Display, Tone};
use pelage::tracer::{Film, Pixel, Rect};

use crate::flip::FlipMap;

/// How the film of [`panels`] is written so that each byte is what it should be.
pub const AS_IT_IS: Display = Display { exposure: 1.0, tone: Tone::None };

/// One film of three panels, `test | reference | map`, opaque, to be written by
/// [`write_png`](pelage::output::write_png) with [`AS_IT_IS`]. The first two are over black, shown as `display` says.
///
/// All three have the window of `reference`; pixels that a film lacks are empty.
pub fn panels(test: &Film, reference: &Film, map: &FlipMap, display: &Display) -> Film {
    let Rect { width, height, .. } = reference.window;
    let size = [3 * width, height];
    let opaque = |srgb: [u8; 3]| {
        let color = Vec3::from(srgb.map(|x| srgb_to_linear(f32::from(x) / 255.0)));
        Pixel { color, alpha: 1.0, depth: f32::INFINITY }
    };
    let shown = |film: &Film| film.pixels.iter().map(|p| opaque(display.srgb(p.color))).collect::<Vec<_>>();
    let colors: Vec<Pixel> = map.colors().into_iter().map(opaque).collect();
    let mut film = Film::new(size, Rect::whole(size));
    for (i, panel) in [shown(test), shown(reference), colors].iter().enumerate() {
        film.paste(Rect { x: i as u32 * width, y: 0, width, height }, panel);
    }
    film
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flip::{NORMAL_PPD, flip};

    #[test]
    fn three_panels_and_their_bytes() {
        let window = Rect { x: 1, y: 1, width: 2, height: 1 };
        let film = |color: f32| {
            let pixel = Pixel { color: Vec3::splat(color), alpha: 0.5, depth: 1.0 };
            Film { size: [8, 8], window, pixels: vec![pixel; 2] }
        };
        let display = Display { exposure: 2.0, tone: Tone::Filmic };
        let (a, b) = (film(0.05), film(0.1));
        let map = flip(&a, &b, &display, NORMAL_PPD).expect("alike");
        let three = panels(&a, &b, &map, &display);
        assert_eq!(three.size, [6, 1]);
        let bytes: Vec<[u8; 3]> = three.pixels.iter().map(|p| AS_IT_IS.srgb(p.color)).collect();
        let [left, middle] = [0.05, 0.1].map(|x| display.srgb(Vec3::splat(x)));
        assert_eq!(bytes[..4], [left, left, middle, middle]);
        assert_eq!(bytes[4..], map.colors());
        assert!(three.pixels.iter().all(|p| p.alpha == 1.0));
    }
}
