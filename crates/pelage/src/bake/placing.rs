//! Where a model stands in the texel.

use glam::{DVec3, Vec3};

use super::BakeFault;
use crate::import::Up;

/// How a model is put into the texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fit {
    /// Scaled alike in all directions until its longest side fits, its middle in the middle.
    #[default]
    Cube,
    /// The same, but standing on the texel's floor.
    Floor,
    /// As it is: the model's unit cube is the texel, turned about its own middle so that up is w.
    Keep,
}

/// Model space to texel space: turned upright, scaled alike in all directions, moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placing {
    up: Up,
    scale: f64,
    offset: DVec3,
}

impl Placing {
    /// For a model within `bounds` (model space), leaving `margin` texel edges free on each side.
    pub(super) fn new(up: Up, fit: Fit, margin: f32, bounds: [Vec3; 2]) -> Result<Self, BakeFault> {
        let upright = Self { up, scale: 1.0, offset: DVec3::ZERO };
        if fit == Fit::Keep {
            // Turning (s, t, w) = (x, −z, y) leaves the unit cube behind by one in t.
            let offset = if up == Up::Y { DVec3::Y } else { DVec3::ZERO };
            return Ok(Self { offset, ..upright });
        }
        let [a, b] = bounds.map(|p| upright.exact(p));
        let (low, high) = (a.min(b), a.max(b));
        let longest = (high - low).max_element();
        let free = 1.0 - 2.0 * f64::from(margin);
        if !(longest > 0.0 && (free / longest).is_finite()) {
            return Err(BakeFault::NoArea);
        }
        let scale = free / longest;
        let mut offset = 0.5 - scale * 0.5 * (low + high);
        if fit == Fit::Floor {
            offset.z = -scale * low.z;
        }
        Ok(Self { up, scale, offset })
    }

    /// Texel edges a unit of the model.
    pub(super) fn scale(&self) -> f32 {
        self.scale as f32
    }

    /// A point of the model in texel space.
    pub(super) fn apply(&self, p: Vec3) -> Vec3 {
        self.exact(p).as_vec3()
    }

    fn exact(&self, p: Vec3) -> DVec3 {
        let p = p.as_dvec3();
        let upright = match self.up {
            Up::Y => DVec3::new(p.x, -p.z, p.y),
            Up::Z => p,
        };
        self.scale * upright + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_fits_and_stands() {
        // 4 wide, 2 high, 1 deep, far from the origin: the longest side becomes 1 − 2·0.1.
        let low = Vec3::new(100.0, 50.0, -7.0);
        let bounds = [low, low + Vec3::new(4.0, 2.0, 1.0)];
        let cube = Placing::new(Up::Y, Fit::Cube, 0.1, bounds).unwrap();
        assert!((cube.scale() - 0.2).abs() < 1e-6);
        // +Z of the model is −t: the front stands at the lower t.
        let front = cube.apply(low + Vec3::new(0.0, 0.0, 1.0));
        assert!((front - Vec3::new(0.1, 0.4, 0.3)).length() < 1e-5, "{front}");
        let floor = Placing::new(Up::Y, Fit::Floor, 0.1, bounds).unwrap();
        assert!((floor.apply(low) - Vec3::new(0.1, 0.6, 0.0)).length() < 1e-5);
        let flat = Placing::new(Up::Z, Fit::Cube, 0.0, bounds).unwrap();
        assert!((flat.apply(bounds[1]) - Vec3::new(1.0, 0.75, 0.625)).length() < 1e-5);
    }

    #[test]
    fn what_is_kept_stays_in_its_cube() {
        for (up, top) in [(Up::Y, Vec3::Y), (Up::Z, Vec3::Z)] {
            let placing = Placing::new(up, Fit::Keep, 0.3, [Vec3::ZERO; 2]).unwrap();
            assert_eq!(placing.apply(top).z, 1.0);
            assert_eq!(placing.apply(Vec3::splat(0.5)), Vec3::splat(0.5));
        }
        assert_eq!(Placing::new(Up::Y, Fit::Cube, 0.0, [Vec3::ONE; 2]), Err(BakeFault::NoArea));
    }
}
