//! What a cone picture must reach to be called as good as its geometry.

use serde::Serialize;

/// The goals of a scene. All are limits for each distance and light on its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Goals {
    /// Largest |alpha bias|.
    pub alpha_bias: f64,
    /// Largest energy error where a box is [`Goals::wide`] pixels or wider.
    pub energy_wide: f64,
    /// Largest energy error where a box is narrower.
    pub energy_narrow: f64,
    /// Largest mean FLIP.
    pub flip: f64,
    /// Fewest samples a pixel with which the reference renderer errs as much, where a box is wider than
    /// [`Goals::wide`] pixels.
    pub samples_near: f64,
    /// The same, where it is as wide or narrower.
    pub samples_far: f64,
    /// Most flicker, in that of the reference at 16 samples a pixel.
    pub flicker: f64,
    /// Pixels of a wide box.
    pub wide: f32,
}

impl Goals {
    /// Goals for any texel.
    pub const STANDARD: Self = Self {
        alpha_bias: 0.01,
        energy_wide: 0.02,
        energy_narrow: 0.04,
        flip: 0.10,
        samples_near: 8.0,
        samples_far: 16.0,
        flicker: 1.0,
        wide: 64.0,
    };

    /// Goals for fur, whose strands are thinner than any voxel.
    pub const FUR: Self = Self { alpha_bias: 0.015, flip: 0.15, ..Self::STANDARD };

    /// The largest energy error where a box is `width` pixels wide.
    pub fn energy(&self, width: f32) -> f64 {
        if self.is_wide(width) { self.energy_wide } else { self.energy_narrow }
    }

    /// The fewest samples where a box is `width` pixels wide.
    pub fn samples(&self, width: f32) -> f64 {
        let as_wide_or_narrower = width <= self.wide * (1.0 + Self::SLACK);
        if as_wide_or_narrower { self.samples_far } else { self.samples_near }
    }

    fn is_wide(&self, width: f32) -> bool {
        width >= self.wide * (1.0 - Self::SLACK)
    }

    /// Widths are computed: part of a width by which they may be off.
    const SLACK: f32 = 1e-3;
}

/// A goal that was missed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Miss {
    /// Which measure.
    pub measure: &'static str,
    /// What it is.
    pub value: f64,
    /// What it should be at most, or at least for samples.
    pub goal: f64,
}

impl Miss {
    /// A miss if `value` is over `goal`, or not a number.
    pub(crate) fn over(measure: &'static str, value: f64, goal: f64) -> Option<Self> {
        // Written so that a NaN is a miss.
        let kept = value <= goal;
        (!kept).then_some(Self { measure, value, goal })
    }

    /// A miss if `value` is under `goal`, or not a number.
    pub(crate) fn under(measure: &'static str, value: f64, goal: f64) -> Option<Self> {
        let kept = value >= goal;
        (!kept).then_some(Self { measure, value, goal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_four_pixels_are_wide_and_already_far() {
        let g = Goals::STANDARD;
        assert_eq!([g.energy(256.0), g.energy(63.999), g.energy(45.0)], [0.02, 0.02, 0.04]);
        assert_eq!([g.samples(256.0), g.samples(64.001), g.samples(0.5)], [8.0, 16.0, 16.0]);
    }

    #[test]
    fn what_is_no_number_is_missed() {
        assert!(
            Miss::over("flip", f64::NAN, 0.1).is_some() && Miss::under("samples", f64::NAN, 8.0).is_some()
        );
        assert!(Miss::over("flip", 0.1, 0.1).is_none() && Miss::under("samples", 8.0, 8.0).is_none());
    }
}
