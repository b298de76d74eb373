//! The core mathematics of `pelage`: trilinear boxes, walls against rays, Jacobian inversion, ellipsoids of
//! normals, cones, and the meshes, materials and textures that the other crates exchange.
//!
//! # Conventions
//!
//! - Scene space is right-handed, +Y up, in metres. Colours are linear, Rec. 709 primaries.
//! - Box coordinates `(u, v, w)` run over `[0,1]³`, `w` away from the surface. Corner `i` of a box has
//!   `u = i & 1`, `v = i >> 1 & 1`, `w = i >> 2 & 1`; the papers call the eight corners A to H in that order.
//! - Jacobians are the usual ones: their *columns* are ∂T/∂u, ∂T/∂v, ∂T/∂w, so that `dX = J dU`.
//! - Where a ray meets things is decided in `f64`; what is stored is `f32`.
//!
//! Sources are cited by the keys of `REFERENCES.md`.
#![warn(missing_docs)]

pub mod material;
pub mod mesh;
pub mod texture;
pub mod trilinear;

pub use glam;
pub use material::{Material, MaterialId};
pub use mesh::{Face, Mesh, MeshError};
pub use texture::{Texture, TextureId};
pub use trilinear::{DTrilinear, Trilinear};
