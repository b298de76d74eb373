//! A picture in memory: linear, premultiplied, with alpha and depth.

use glam::Vec3;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub x: u32,
    /// First row; rows run downwards.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// The whole of a picture.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// How many pixels it has.
    pub fn area(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// One pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Radiance of what stands in front of the background, times its alpha; linear Rec. 709.
    pub color: Vec3,
    /// How much of the background is hidden, in `[0,1]`.
    pub alpha: f32,
    /// Depth along the view axis at which half of what is visible lies in front, in scene units; infinite where
    /// there is nothing.
    pub depth: f32,
}

impl Pixel {
    /// Nothing at all.
    pub const EMPTY: Self = Self { color: Vec3::ZERO, alpha: 0.0, depth: f32::INFINITY };
}

/// A finished picture, or a crop of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// The whole picture's width and height.
    pub size: [u32; 2],
    /// Which part of it `pixels` holds.
    pub window: Rect,
    /// Row by row from the top of `window`.
    pub pixels: Vec<Pixel>,
}

impl Film {
    /// An empty film for `window` of a picture of `size`.
    pub fn new(size: [u32; 2], window: Rect) -> Self {
        Self { size, window, pixels: vec![Pixel::EMPTY; window.area()] }
    }

    /// The pixel at column `x` and row `y` of the whole picture, if the window holds it.
    pub fn get(&self, x: u32, y: u32) -> Option<&Pixel> {
        let (dx, dy) = (x.checked_sub(self.window.x)?, y.checked_sub(self.window.y)?);
        (dx < self.window.width && dy < self.window.height)
            .then(|| &self.pixels[dy as usize * self.window.width as usize + dx as usize])
    }

    /// Lays `pixels`, row by row, over the part `tile` of the picture; what lies outside the window is dropped.
    pub fn paste(&mut self, tile: Rect, pixels: &[Pixel]) {
        for (i, &pixel) in pixels.iter().enumerate().take(tile.area()) {
            let (x, y) = (tile.x + i as u32 % tile.width, tile.y + i as u32 / tile.width);
            let Some((dx, dy)) = x.checked_sub(self.window.x).zip(y.checked_sub(self.window.y)) else {
                continue;
            };
            if dx < self.window.width && dy < self.window.height {
                self.pixels[dy as usize * self.window.width as usize + dx as usize] = pixel;
            }
        }
    }
}
