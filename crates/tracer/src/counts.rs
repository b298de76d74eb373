//! What a rendering did, in numbers: what its time goes into.

use std::ops::AddAssign;

/// How often each step of the cone tracer was taken, over all rays and light cones of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays from the camera that were followed; glances at the corners of pixels are not counted.
    pub rays: u64,
    /// Cones towards lights and towards the sky, through the coats.
    pub light_cones: u64,
    /// Intervals of rays and cones inside boxes.
    pub passages: u64,
    /// Straight pieces of their curves.
    pub chords: u64,
    /// Walks of a chord through one level of a texel.
    pub walks: u64,
    /// Occupied cells that the walks met.
    pub cells: u64,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        let Self { rays, light_cones, passages, chords, walks, cells } = other;
        self.rays += rays;
        self.light_cones += light_cones;
        self.passages += passages;
        self.chords += chords;
        self.walks += walks;
        self.cells += cells;
    }
}
