//! Puts a background behind a film.

use glam::{Vec2, Vec3};
use pelage_tracer::{Camera, Environment, Film};

/// What is seen where there is nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// Nothing: alpha stays.
    Transparent,
    /// The same radiance everywhere.
    Color(Vec3),
    /// The radiance of the surroundings in the direction of each pixel's centre.
    Sky(Environment),
}

/// The film over a background: opaque unless that is [`Backdrop::Transparent`]. Depth stays.
pub fn over(film: &Film, camera: &Camera, backdrop: &Backdrop) -> Film {
    let mut film = film.clone();
    if *backdrop == Backdrop::Transparent {
        return film;
    }
    let window = film.window;
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        let (dx, dy) = (i % window.width as usize, i / window.width as usize);
        let behind = match backdrop {
            Backdrop::Transparent => Vec3::ZERO,
            Backdrop::Color(radiance) => *radiance,
            Backdrop::Sky(environment) => {
                let centre =
                    Vec2::new((window.x as usize + dx) as f32 + 0.5, (window.y as usize + dy) as f32 + 0.5);
                let (ray, _) = camera.cone(centre, film.size);
                environment.radiance(ray.direction.as_vec3())
            }
        };
        pixel.color += (1.0 - pixel.alpha) * behind;
        pixel.alpha = 1.0;
    }
    film
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_tracer::{Pixel, Rect};

    #[test]
    fn over_a_colour_and_the_sky() {
        let size = [2, 2];
        let mut film = Film::new(size, Rect { x: 1, y: 0, width: 1, height: 2 });
        film.pixels[0] = Pixel { color: Vec3::splat(0.25), alpha: 0.5, depth: 3.0 };
        let camera = Camera::look_at(Vec3::ZERO, -Vec3::Z, Vec3::Y, 1.0);
        let plain = over(&film, &camera, &Backdrop::Color(Vec3::X));
        // ¼ + (1 − ½) · 1 in red, ¼ elsewhere.
        assert_eq!(plain.pixels[0], Pixel { color: Vec3::new(0.75, 0.25, 0.25), alpha: 1.0, depth: 3.0 });
        let environment = Environment { sky: Vec3::ONE, ground: Vec3::ZERO };
        let sky = over(&film, &camera, &Backdrop::Sky(environment));
        // The upper row sees more sky than the lower, by the same amount above and below ½.
        let [above, below] = [(sky.pixels[0].color.x - 0.25) * 2.0, sky.pixels[1].color.x];
        assert!(above > 0.55 && (above + below - 1.0).abs() < 1e-5, "{above} {below}");
        assert_eq!(over(&film, &camera, &Backdrop::Transparent), film);
    }
}
