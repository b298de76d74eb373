//! Colour textures, filtered by a MIP pyramid. \[Williams83\]

use glam::{Vec2, Vec3};

/// An index into a scene's textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// A linear RGB image with its MIP levels, repeated in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Finest first, each half the last (rounded up), down to one pixel.
    levels: Vec<Image>,
}

#[derive(Clone, Debug, PartialEq)]
struct Image {
    width: usize,
    height: usize,
    /// Row by row, the first row at v = 1.
    pixels: Vec<Vec3>,
}

impl Texture {
    /// Makes a texture from linear RGB `pixels`, row by row from the top.
    ///
    /// Returns `None` if a side is zero or `pixels` has not `width * height` entries.
    pub fn new(width: usize, height: usize, pixels: Vec<Vec3>) -> Option<Self> {
        if width == 0 || height == 0 || pixels.len() != width.checked_mul(height)? {
            return None;
        }
        let mut levels = vec![Image { width, height, pixels }];
        while let Some(half) = levels.last().and_then(Image::halved) {
            levels.push(half);
        }
        Some(Self { levels })
    }

    /// Width and height of the finest level, in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The pixels of the finest level, row by row from the top.
    pub fn pixels(&self) -> &[Vec3] {
        &self.levels[0].pixels
    }

    /// The colour at `uv` (v upwards), averaged over about `footprint` in units of uv: bilinear within a level,
    /// linear between two.
    pub fn sample(&self, uv: Vec2, footprint: f32) -> Vec3 {
        let size = self.levels[0].width.max(self.levels[0].height) as f32;
        let last = (self.levels.len() - 1) as f32;
        let level = (footprint * size).max(1.0).log2().clamp(0.0, last);
        let fine = level.floor();
        let colour = self.levels[fine as usize].bilinear(uv);
        if level > fine {
            colour.lerp(self.levels[fine as usize + 1].bilinear(uv), level - fine)
        } else {
            colour
        }
    }

    /// The mean colour of the whole texture.
    pub fn mean(&self) -> Vec3 {
        self.levels.last().map_or(Vec3::ZERO, |image| image.pixels[0])
    }
}

impl Image {
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let at =
            |x: usize, y: usize| self.pixels[y.min(self.height - 1) * self.width + x.min(self.width - 1)];
        let mean = |i: usize| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        Some(Self { width, height, pixels: (0..width * height).map(mean).collect() })
    }

    fn bilinear(&self, uv: Vec2) -> Vec3 {
        // Pixel centres lie at half integers.
        let wrap = |x: f32| x - x.floor();
        let x = wrap(uv.x) * self.width as f32 - 0.5;
        let y = wrap(1.0 - uv.y) * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let at = |dx: i64, dy: i64| {
            let column = (x0 as i64 + dx).rem_euclid(self.width as i64) as usize;
            let row = (y0 as i64 + dy).rem_euclid(self.height as i64) as usize;
            self.pixels[row * self.width + column]
        };
        let (fx, fy) = (x - x0, y - y0);
        at(0, 0).lerp(at(1, 0), fx).lerp(at(0, 1).lerp(at(1, 1), fx), fy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_run_downwards_and_levels_average() {
        // Two rows: white above, black below. v = 0.75 is the centre of the upper row.
        let t =
            Texture::new(2, 2, vec![Vec3::ONE, Vec3::ONE, Vec3::ZERO, Vec3::ZERO]).expect("a 2 × 2 image");
        assert_eq!(t.sample(Vec2::new(0.25, 0.75), 0.0), Vec3::ONE);
        assert_eq!(t.sample(Vec2::new(0.25, 0.25), 0.0), Vec3::ZERO);
        // Halfway between the centres, and anywhere for a footprint of the whole texture: the mean.
        assert_eq!(t.sample(Vec2::new(0.6, 0.5), 0.0), Vec3::splat(0.5));
        assert_eq!(t.sample(Vec2::new(0.1, 0.9), 1.0), Vec3::splat(0.5));
        assert_eq!(t.mean(), Vec3::splat(0.5));
    }

    #[test]
    fn refuses_a_wrong_length() {
        assert!(Texture::new(2, 2, vec![Vec3::ONE; 3]).is_none());
        assert!(Texture::new(0, 2, vec![]).is_none());
    }
}
