//! From where a coat is looked at: cameras along the scene's own line of view.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use pelage::compile::Prepared;
use pelage::geom::evenly;
use pelage::tracer::{Camera, Rect};

use crate::sight::Sight;

/// How far away a coat is looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distance {
    /// So near that a finest voxel is two pixels wide.
    Near,
    /// The median box is this many pixels wide.
    Box(f32),
    /// The first place beyond [`Distance::Box`] of the same width where the tracer reads half of one level and half of
    /// the next.
    Halfway(f32),
}

impl Distance {
    /// The distances that a coat is judged at.
    pub const STANDARD: [Self; 10] = [
        Self::Near,
        Self::Box(256.0),
        Self::Halfway(256.0),
        Self::Box(64.0),
        Self::Halfway(64.0),
        Self::Box(16.0),
        Self::Halfway(16.0),
        Self::Box(4.0),
        Self::Box(1.0),
        Self::Box(0.5),
    ];

    /// The width of a pixel at the target, in scene units.
    fn pixel(self, sight: &Sight) -> f32 {
        match self {
            Self::Near => sight.width_at(sight.depth as f32 + 1.0),
            Self::Box(pixels) => sight.box_width / pixels,
            Self::Halfway(pixels) => {
                // A hair of a level nearer, so that rounding does not skip a whole one.
                let level = sight.level(sight.box_width / pixels) + 1e-3;
                sight.width_at(((level - 0.5).floor() + 0.5).min(sight.depth as f32 - 0.5))
            }
        }
    }
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Near => f.write_str("near"),
            Self::Box(pixels) => write!(f, "{pixels}"),
            Self::Halfway(pixels) => write!(f, "{pixels}h"),
        }
    }
}

impl FromStr for Distance {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let (number, halfway) = word.strip_suffix('h').map_or((word, false), |number| (number, true));
        match number.parse::<f32>() {
            _ if word == "near" => Ok(Self::Near),
            Ok(pixels) if (1e-3..=1e5).contains(&pixels) => {
                Ok(if halfway { Self::Halfway(pixels) } else { Self::Box(pixels) })
            }
            _ => Err(format!("`{word}`: expected near, or the width of a box in pixels, like 64 or 64h")),
        }
    }
}

/// A camera, and the part of its picture that is rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    camera: Camera,
    /// The width of a pixel at the target, in scene units.
    pixel: f32,
    /// With fewer pixels than this it looks more than once.
    enough: usize,
    pub size: [u32; 2],
    /// The part that is rendered.
    pub crop: Rect,
    /// How many pixels wide the median box is at the target.
    pub box_pixels: f32,
    /// The continuous level that is read at the target, if there were any number of levels.
    pub level: f32,
}

/// A camera is at least this many heights of the coat away from the target: nearer, the view narrows instead.
const CLEARANCE: f32 = 4.0;

/// The most times that a station looks.
const MOST_LOOKS: usize = 16;

/// Pixels kept around what is seen of the coats.
const MARGIN: f32 = 2.0;

impl Station {
    /// The station of `distance`; at most `side` pixels a side are rendered.
    pub fn at(distance: Distance, sight: &Sight, prepared: &Prepared, side: u32) -> Self {
        Self::seeing(distance.pixel(sight), sight, prepared, side)
    }

    /// The cameras of this station: one where there are many pixels; where there are few, so many that they make up for
    /// it, each moved by another part of a pixel. What a handful of pixels shows is luck.
    pub fn looks(&self) -> Vec<Camera> {
        let count = (self.enough / self.crop.area()).clamp(1, MOST_LOOKS);
        (0..count)
            .map(|k| {
                let part = (evenly(k) - 0.5).as_vec2();
                let [right, up] = [self.camera.orientation.x_axis, self.camera.orientation.y_axis];
                let moved = self.pixel * (part.x * right + part.y * up);
                Camera { position: self.camera.position + moved, ..self.camera }
            })
            .collect()
    }

    /// Whether another station shows nearly the same: pixels as wide, to a tenth.
    pub fn is_like(&self, other: &Self) -> bool {
        (self.pixel / other.pixel - 1.0).abs() < 0.1
    }

    /// The frames of a slow zoom, a quarter of a level in all. Its middle is this station, or the nearest border between
    /// two levels if there is one within half a level, other than for a station that is halfway between two already.
    pub fn zoom(
        &self,
        frames: u32,
        distance: Distance,
        sight: &Sight,
        prepared: &Prepared,
        side: u32,
    ) -> Vec<Self> {
        let middle = match distance {
            Distance::Halfway(_) => self.level,
            _ if self.level > sight.depth as f32 + 0.5 || self.level < 0.5 => self.level,
            _ => self.level.round(),
        };
        let step = |k: u32| 0.25 * (k as f32 / (frames - 1).max(1) as f32 - 0.5);
        (0..frames).map(|k| Self::seeing(sight.width_at(middle + step(k)), sight, prepared, side)).collect()
    }

    /// A station with pixels `pixel` scene units wide at the target, which is in the middle of its picture.
    fn seeing(pixel: f32, sight: &Sight, prepared: &Prepared, side: u32) -> Self {
        let size = prepared.settings.size;
        let rows = size[1] as f32;
        let tangent = (0.5 * prepared.camera.vertical_fov).tan();
        let distance = (0.5 * pixel * rows / tangent).max(CLEARANCE * sight.reach);
        let vertical_fov = 2.0 * (0.5 * pixel * rows / distance).atan();
        let eye = sight.target - distance * sight.direction;
        let up = prepared.camera.orientation.y_axis;
        let camera = Camera::look_at(eye, sight.target, up, vertical_fov);
        Self {
            camera,
            pixel,
            // A quarter of the pixels that there may be.
            enough: (side as usize).pow(2) / 4,
            size,
            crop: crop(&camera, size, sight.bounds, side),
            box_pixels: sight.box_width / pixel,
            level: sight.level(pixel),
        }
    }
}

/// The middle of the picture, at most `side` pixels a side, less what no part of `bounds` can be seen in.
fn crop(camera: &Camera, size: [u32; 2], bounds: [Vec3; 2], side: u32) -> Rect {
    let scale = 0.5 * size[1] as f32 / (0.5 * camera.vertical_fov).tan();
    let axes = camera.orientation.transpose();
    // From the middle of the picture, in pixels; everywhere if a corner is behind the eye.
    let corners: Vec<Option<[f32; 2]>> = (0..8)
        .map(|i| {
            let corner = Vec3::new(bounds[i & 1].x, bounds[i >> 1 & 1].y, bounds[i >> 2].z);
            let p = axes * (corner - camera.position);
            (p.z < 0.0).then(|| [scale * p.x / -p.z, -scale * p.y / -p.z])
        })
        .collect();
    let range = |axis: usize| {
        let places = || corners.iter().map(|corner| corner.map(|c| c[axis]));
        let low = places().map(|x| x.unwrap_or(f32::NEG_INFINITY)).fold(f32::INFINITY, f32::min);
        let high = places().map(|x| x.unwrap_or(f32::INFINITY)).fold(f32::NEG_INFINITY, f32::max);
        let middle = 0.5 * size[axis] as f32;
        let half = 0.5 * side.min(size[axis]) as f32;
        let first = (middle + (low - MARGIN).max(-half)).floor().clamp(0.0, size[axis] as f32 - 1.0) as u32;
        let last = (middle + (high + MARGIN).min(half)).ceil().clamp(0.0, size[axis] as f32) as u32;
        (first, last.max(first + 1) - first)
    };
    let ((x, width), (y, height)) = (range(0), range(1));
    Rect { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_back() {
        for distance in Distance::STANDARD {
            assert_eq!(distance.to_string().parse(), Ok(distance));
        }
        for bad in ["", "far", "0", "-1", "nan", "inf", "1e9", "h", "64hh"] {
            assert!(bad.parse::<Distance>().is_err(), "{bad}");
        }
    }

    #[test]
    fn the_window_holds_what_is_seen() {
        // 90° of view and 100 rows: 50 pixels to a unit at depth 1, 5 at depth 10. A cube of side 2 around the target
        // at distance 10 reaches to 50/9 = 5.6 pixels from the middle, and 2 pixels are kept around it.
        let camera =
            Camera::look_at(Vec3::new(0.0, 0.0, 10.0), Vec3::ZERO, Vec3::Y, std::f32::consts::FRAC_PI_2);
        let cube = [Vec3::NEG_ONE, Vec3::ONE];
        assert_eq!(crop(&camera, [200, 100], cube, 96), Rect { x: 92, y: 42, width: 16, height: 16 });
        // No more than asked for, and all of that if something is behind the eye.
        assert_eq!(crop(&camera, [200, 100], cube, 8), Rect { x: 96, y: 46, width: 8, height: 8 });
        let behind = [Vec3::NEG_ONE, Vec3::new(1.0, 1.0, 11.0)];
        assert_eq!(crop(&camera, [200, 100], behind, 50), Rect { x: 75, y: 25, width: 50, height: 50 });
        // Off to the right, nothing is left of the middle; never nothing at all.
        let right = [Vec3::new(3.0, -1.0, -1.0), Vec3::new(4.0, 1.0, 1.0)];
        let window = crop(&camera, [200, 100], right, 8);
        assert!(window.x >= 100 && window.width >= 1, "{window:?}");
    }
}
