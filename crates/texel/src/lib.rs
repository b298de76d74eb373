//! Builds, freezes and walks texels: cubes of volumetric texture with data at every level of detail.
//!
//! A texel is the cube `[0, 1]³` in (s, t, w), w away from the surface, usually periodic in s and t. Level l
//! has `2^l` voxels a side, 0 to its depth. Content comes as triangles ([`Geometry`], one's own or grown by a
//! [`Procedure`] such as [`Fur`]); [`build()`] measures every level from them, never from the level below; the result is frozen
//! ([`Texel`]) and only walked ([`Level::walk`]).
//!
//! ```text
//! Geometry ─ voxelise ─► triangles a cell ─ region, raster, coverage ─► Voxel ─ bricks ─► Level ─ traverse
//! ```
//!
//! Sources are cited by the keys of `REFERENCES.md`.
#![warn(missing_docs)]

mod balance;
mod bearings;
mod bricks;
mod build;
mod calibrate;
mod compact;
mod coverage;
mod dark;
mod density;
mod error;
mod exposure;
#[cfg(feature = "file")]
pub mod file;
mod flat;
mod four;
mod grid;
mod kinds;
mod line;
mod octree;
mod opacity;
mod openness;
mod packed;
mod palette;
mod procedure;
mod random;
mod raster;
mod reflectance;
mod region;
mod sample;
mod scatterer;
mod sightline;
mod silhouette;
mod source;
mod surfel;
mod surroundings;
mod thinning;
mod traverse;
mod voxel;
mod voxelise;

pub use balance::{Balance, Shown};
pub use build::{BuildOptions, build, build_exact};
pub use density::Density;
pub use error::{BuildError, TexelError};
pub use four::{Samples, SurfelsX4};
pub use kinds::{
    Domain, Foliage, Fur, Grass, Hypertexture, Kind, Leaves, Moss, Needles, Parameter, Pile, Preset, Sheet,
    Spheres, Value,
};
pub use line::{Crossing, Line};
pub use octree::{Level, Texel};
pub use procedure::{Geometry, Procedure};
pub use reflectance::{Bend, Lit, Reflectance};
pub use scatterer::{Scatterer, Scatterers};
pub use source::Source;
pub use surfel::Surfel;
pub use traverse::{Step, Walk};
pub use voxel::Voxel;
