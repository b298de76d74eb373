//! Turns a mesh into a *skin*: trilinear boxes standing on its quads, prisms on its triangles, each knowing
//! where in the periodic lattice of a texel it lies. [Neyret98 §3] [seed §4.3]
//!
//! ```
//! use pelage_skin::{SkinOptions, extrude, surface};
//!
//! let torus = surface::torus(1.0, 0.4, 48, 24);
//! let skin = extrude(&torus, &|_face| true, &SkinOptions::new(0.05))?;
//! assert_eq!(skin.len(), 48 * 24);
//! assert_eq!(skin.report.left_out(), 0);
//! # Ok::<(), pelage_skin::SkinError>(())
//! ```
//!
//! # How a skin is made
//!
//! | stage | room |
//! |---|---|
//! | if there is no mesh yet, a surface is made one | [`tessellate`] |
//! | the selected faces, welded, without the degenerate ones | `polygon` |
//! | texture coordinates made for it, if asked for | `conformal` |
//! | without texture coordinates and with triangles: every n-gon becomes n quads | `refine` |
//! | one vector a vertex, from the faces around it; or from a second mesh | `normals`, `cage` |
//! | quads and triangles become patches; texel coordinates | `dressing` |
//! | every box is certified; folded ones are mended, left out or refused | `validate`, `settle` |
//! | how much the texel is stretched, and where its seams are | `distortion` |
//! | the vectors are groomed, if they are to be | [`groom`] |
//! | positions or vectors move, frame after frame | `update` |
//!
//! Neighbouring patches name the same vertices, so that the wall between their boxes has the same four corner
//! points, to the last bit, seen from either side.
#![warn(missing_docs)]

mod border;
mod cage;
mod charts;
mod conformal;
mod disjoint;
mod distortion;
mod dressing;
mod error;
mod extrude;
pub mod groom;
mod normals;
mod options;
mod outline;
mod patch;
mod polygon;
mod quad;
mod refine;
mod report;
mod settle;
pub mod surface;
pub mod tessellate;
mod update;
mod validate;

pub use cage::{cage, mean_height};
pub use distortion::{Chart, Distortion};
pub use error::SkinError;
pub use extrude::extrude;
pub use options::{Border, Folds, Layout, Mending, SkinOptions};
pub use outline::Outline;
pub use patch::{Anchor, Lattice, Patch, Skin};
pub use report::{Fold, Outcome, Report};
pub use update::Motion;
