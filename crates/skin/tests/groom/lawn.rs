//! A plane of boxes to be groomed, and how to look at it.

use pelage_geom::glam::Vec3;
use pelage_skin::groom::{GroomOptions, Operation, Step, groom};
use pelage_skin::{Folds, Mending, Skin, SkinOptions, extrude, surface};

/// 16 × 16 boxes, 0.1 m high, on a square of 2 m about the origin in the plane y = 0.
pub fn lawn() -> Skin {
    extrude(&surface::plane(2.0, 16, 16), &|_| true, &SkinOptions::new(0.1)).unwrap()
}

/// The vectors after one operation everywhere, with where they stand.
pub fn after(skin: &Skin, operation: Operation) -> Vec<(Vec3, Vec3)> {
    let groomed = groom(skin, &[Step::everywhere(operation)], &keeping()).unwrap();
    strands(&groomed.skin)
}

pub fn strands(skin: &Skin) -> Vec<(Vec3, Vec3)> {
    skin.base.iter().zip(&skin.top).map(|(b, t)| (*b, *t - *b)).collect()
}

/// Nothing is mended, so that what an operation did is seen.
pub fn keeping() -> GroomOptions {
    GroomOptions { mending: Mending { folds: Folds::Keep, ..Mending::default() }, ..GroomOptions::default() }
}

pub fn refusing() -> GroomOptions {
    GroomOptions {
        mending: Mending { folds: Folds::Refuse, ..Mending::default() },
        ..GroomOptions::default()
    }
}

/// Degrees.
pub fn from_normal(vector: Vec3) -> f32 {
    vector.angle_between(Vec3::Y).to_degrees()
}

pub fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}
