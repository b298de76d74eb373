//! A multithreaded CPU cone tracer for volumetric textures.
//!
//! [`Scene::new`] compiles a [`Description`]; [`render`] makes a [`Film`] of it. The main path runs from
//! [`render`] through `cone`: a pixel's rays collect what they see, what is seen twice is merged, then lit.
//! [`mod@reference`] makes the same picture from explicit geometry, to judge it by. No file, no format, no printing.
#![warn(missing_docs)]

mod accel;
mod aov;
mod balance;
mod camera;
mod cone;
mod counts;
mod film;
mod hash;
mod light;
pub mod reference;
mod render;
mod scene;
mod settings;
mod surface;
mod variety;

pub use aov::{Aovs, render_aovs};
pub use balance::balance;
pub use camera::Camera;
pub use counts::Counts;
pub use film::{Film, Pixel, Rect};
pub use light::{Environment, Incoming, Light};
pub use render::{MAX_PIXELS, Progress, RenderError, render, render_counted};
pub use scene::{Coat, Description, Scene, SceneError};
pub use settings::{Lod, Opacity, Path, Quality, Rays, Settings};
pub use variety::Variety;
