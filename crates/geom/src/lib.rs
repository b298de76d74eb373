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

pub mod bounds;
pub mod cone;
pub mod ellipsoid;
pub mod hash;
pub mod hexahedron;
pub mod inverse;
pub mod lanes;
pub mod material;
pub mod mesh;
pub mod paper;
pub mod ray;
pub mod spread;
pub mod symmetric;
pub mod texture;
pub mod trilinear;
pub mod wall;

pub use bounds::{Certificate, certify, certify_map};
pub use cone::{Cone, Footprint, texel_footprint};
pub use ellipsoid::{Ellipsoid, VisibleNormals};
pub use glam;
pub use hexahedron::{Hexahedron, Passage, Passages};
pub use inverse::InverseError;
pub use lanes::Vec3x4;
pub use material::{Alpha, AlphaMode, Material, MaterialId};
pub use mesh::{Attribute, Face, Mesh, MeshError};
pub use ray::Ray;
pub use spread::evenly;
pub use symmetric::Symmetric3;
pub use texture::{Texture, TextureId};
pub use trilinear::{DTrilinear, Trilinear};
pub use wall::{RayFrame, RaySpace, WallHit, WallHits, wall_hits};
