//! How far a picture is from its reference, and a scene's cone pictures from what its geometry shows.
//!
//! | | |
//! |---|---|
//! | [`Picture`] | a picture file read back, as a film |
//! | [`Measures`] | two films compared: root mean square error, energy, alpha … |
//! | [`exposure_of`] | how bright radiance is shown, so that a person can be asked |
//! | [`flip`] | how much of the difference a person sees |
//! | [`panels`] | test, reference and their difference side by side |
//! | [`study`] | a scene validated at every distance and under every light, as a [`Plan`] says |
//! | [`Goals`] | what it must reach |
//! | [`table()`], [`page()`] | what was found, to read |
//!
//! Everywhere the *test* comes first and the *reference* second; ratios are test over reference.
#![warn(missing_docs)]

mod exposure;
mod flicker;
mod flip;
mod goals;
mod measures;
mod noise;
mod page;
mod panels;
mod picture;
mod rendering;
mod sight;
mod station;
mod study;
mod suns;
mod table;

pub use exposure::exposure_of;
pub use flip::{FlipMap, NORMAL_PPD, flip};
pub use goals::{Goals, Miss};
pub use measures::{Difference, MeasureError, Measures};
pub use noise::Worth;
pub use page::page;
pub use panels::{AS_IT_IS, panels};
pub use picture::{Encoding, Fault, MAX_PIXELS, Picture, PictureError, part};
pub use sight::SightError;
pub use station::Distance;
pub use study::{Cell, Found, Pictures, Plan, Study, StudyError, study};
pub use suns::Lights;
pub use table::table;
