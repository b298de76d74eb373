//! Fur and other volumetric textures on any mesh, rendered by a multithreaded CPU cone tracer.
//!
//! x
#![warn(missing_docs)]

pub mod choices;
pub mod compile;
pub mod compose;
mod error;
pub mod import;
mod names;
pub mod output;
pub mod scene_file;
pub mod staging;

pub use pelage_geom as geom;
pub use pelage_skin as skin;
pub use pelage_texel as texel;
pub use pelage_tracer as tracer;

pub use error::{Blame, Error, FieldError};
