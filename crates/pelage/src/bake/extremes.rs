//! The smallest and largest values of a texture over a part of it: what tells whether a triangle has to be cut finer.

use glam::{Vec2, Vec3};
use pelage_geom::Texture;

/// Channel by channel, the smallest and the largest.
pub(super) type Range = [Vec3; 2];

/// The extremes of the blocks of 2, 4, 8 … pixels a side of a texture.
pub(super) struct Extremes<'a> {
    texture: &'a Texture,
    /// Blocks of `2^(1 + index)` pixels, row by row.
    levels: Vec<Blocks>,
}

struct Blocks {
    width: usize,
    height: usize,
    ranges: Vec<Range>,
}

impl<'a> Extremes<'a> {
    pub(super) fn new(texture: &'a Texture) -> Self {
        let [width, height] = texture.size();
        let pixels = texture.pixels();
        let mut levels = vec![halved(width, height, |x, y| [pixels[y * width + x]; 2])];
        while let Some(Blocks { width, height, ranges }) = levels.last().filter(|b| b.ranges.len() > 1) {
            levels.push(halved(*width, *height, |x, y| ranges[y * width + x]));
        }
        Self { texture, levels }
    }

    /// The texture itself.
    pub(super) fn texture(&self) -> &'a Texture {
        self.texture
    }

    /// The extremes of what [`Texture::sample`] may give at any point of the box between two corners (v upwards); possibly a
    /// little more, never less.
    pub(super) fn within(&self, low: Vec2, high: Vec2) -> Range {
        let [width, height] = self.texture.size();
        let columns = pixels(low.x, high.x, width);
        // Rows run downwards.
        let rows = pixels(1.0 - high.y, 1.0 - low.y, height);
        let longest = [&columns, &rows].into_iter().flatten().map(|[a, b]| b - a).max().unwrap_or(0);
        // At most five blocks a side: less of what lies beside the box is counted than with two.
        let level = (0..self.levels.len()).find(|level| longest >> level <= 3).unwrap_or(self.levels.len());
        let mut range = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        for row in rows.iter().flat_map(|[a, b]| a >> level..=b >> level) {
            for column in columns.iter().flat_map(|[a, b]| a >> level..=b >> level) {
                let [low, high] = self.block(level, column, row);
                range = [range[0].min(low), range[1].max(high)];
            }
        }
        range
    }

    /// The extremes of a block of `2^level` pixels.
    fn block(&self, level: usize, column: usize, row: usize) -> Range {
        match level.checked_sub(1).and_then(|level| self.levels.get(level)) {
            Some(blocks) => blocks.ranges[row * blocks.width + column],
            None => [self.texture.pixels()[row * self.texture.size()[0] + column]; 2],
        }
    }
}

fn halved(width: usize, height: usize, at: impl Fn(usize, usize) -> Range) -> Blocks {
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let block = |i: usize| {
        let [x, y] = [2 * (i % size[0]), 2 * (i / size[0])];
        let children = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let ranges = children.map(|(x, y)| at(x.min(width - 1), y.min(height - 1)));
        ranges.into_iter().fold(ranges[0], |a, b| [a[0].min(b[0]), a[1].max(b[1])])
    };
    Blocks { width: size[0], height: size[1], ranges: (0..size[0] * size[1]).map(block).collect() }
}

/// The pixels of a repeating row of `size` that interpolation between `low` and `high` touches: one stretch, or two
/// where it runs over the end.
fn pixels(low: f32, high: f32, size: usize) -> Vec<[usize; 2]> {
    let whole = vec![[0, size - 1]];
    // In f64: a coordinate may be many repetitions away.
    let [first, last] = [low, high].map(|x| (f64::from(x) * size as f64 - 0.5).floor());
    // Interpolation touches the next pixel as well; rounding of the coordinates may touch one more on either side.
    let count = last - first + 4.0;
    if count.is_nan() || count >= size as f64 {
        return whole;
    }
    let first = (first - 1.0).rem_euclid(size as f64) as usize % size;
    let last = first + count as usize - 1;
    if last < size { vec![[first, last]] } else { vec![[first, size - 1], [0, last - size]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_lies_between_the_extremes() {
        let (width, height) = (37, 21);
        // Any numbers will do: a multiplicative hash of the pixel.
        let pixel = |i: usize| Vec3::splat((i as u32).wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32);
        let texture = Texture::new(width, height, (0..width * height).map(pixel).collect()).unwrap();
        let extremes = Extremes::new(&texture);
        for trial in 0..2000_u32 {
            let part = |k: u32| (trial * 4 + k).wrapping_mul(2_246_822_519) as f32 / u32::MAX as f32;
            let low = Vec2::new(4.0 * part(0) - 2.0, 4.0 * part(1) - 2.0);
            let size = Vec2::new(part(2), part(3)).powf(3.0);
            let [least, most] = extremes.within(low, low + size);
            for k in 0..16_u32 {
                let at = low + size * Vec2::new((k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0);
                let sample = texture.sample(at, 0.0).x;
                assert!(sample >= least.x - 1e-5 && sample <= most.x + 1e-5, "{low} {size} {sample}");
            }
        }
    }

    #[test]
    fn a_flat_half_is_flat() {
        // White on the left, black on the right.
        let pixels = (0..64 * 64).map(|i| if i % 64 < 32 { Vec3::ONE } else { Vec3::ZERO }).collect();
        let texture = Texture::new(64, 64, pixels).unwrap();
        let extremes = Extremes::new(&texture);
        assert_eq!(extremes.within(Vec2::new(0.1, -3.0), Vec2::new(0.4, 7.0)), [Vec3::ONE; 2]);
        assert_eq!(extremes.within(Vec2::new(1.6, 0.2), Vec2::new(1.9, 0.3)), [Vec3::ZERO; 2]);
        assert_eq!(extremes.within(Vec2::new(0.4, 0.2), Vec2::new(0.6, 0.3)), [Vec3::ZERO, Vec3::ONE]);
    }
}
