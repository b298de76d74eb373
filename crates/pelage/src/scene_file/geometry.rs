//! `geometry`: mesh files and surfaces.

use glam::Vec3;
use pelage_skin::tessellate::Bounds;
use schemars::JsonSchema;
use serde::Deserialize;

use super::{one, yes};
use crate::import::Up;

/// A mesh file or a surface, and where it stands: subdivided, scaled, turned, then moved.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GeometryEntry {
    /// A path relative to the scene file.
    #[serde(default)]
    pub file: Option<String>,
    /// A surface instead of a file.
    #[serde(default)]
    pub surface: Option<SurfaceEntry>,
    /// Patches of a surface along u and v; 32 each by default.
    #[serde(default)]
    #[schemars(inner(range(min = 1)))]
    pub patches: Option<[u32; 2]>,
    /// Errors that a surface must keep within, instead of `patches`.
    #[serde(default)]
    pub errors: Option<Bounds>,
    /// What a surface's mesh and its material are called; by default what kind it is.
    #[serde(default)]
    pub name: Option<String>,
    /// The colour of a surface's material; linear, 0.5 grey by default.
    #[serde(default)]
    pub color: Option<[f32; 3]>,
    /// How often Catmull and Clark's rule is applied.
    #[serde(default)]
    #[schemars(range(max = 10))]
    pub subdivide: u32,
    /// Degrees between two faces from which on their edge stays sharp when subdivided.
    #[serde(default = "flat")]
    #[schemars(range(min = 0, max = 180))]
    pub crease_angle: f32,
    /// The vertical axis of an OBJ file.
    #[serde(default)]
    pub up: Up,
    /// Metres in one unit of the file.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub unit: f32,
    /// Factor of its size.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: f32,
    /// Degrees about x, then y, then z.
    #[serde(default)]
    pub rotate: [f32; 3],
    /// Metres.
    #[serde(default)]
    pub translate: [f32; 3],
    /// Whether its own faces are seen, or only what grows on them.
    #[serde(default = "yes")]
    pub visible: bool,
}

/// A surface over two parameters. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum SurfaceEntry {
    /// A rectangle about the origin, facing +Y.
    Plane {
        /// Its sides along x and z.
        size: [f32; 2],
    },
    /// A sphere about the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A torus about the Y axis.
    Torus {
        /// Radius of the tube's axis.
        major: f32,
        /// Radius of the tube.
        minor: f32,
    },
    /// A bicubic Bézier patch.
    Bezier {
        /// 16 control points, row by row.
        #[schemars(with = "Vec<[f32; 3]>")]
        points: Vec<Vec3>,
    },
    /// A uniform bicubic B-spline surface.
    Bspline {
        /// Control points, row by row.
        #[schemars(with = "Vec<[f32; 3]>")]
        points: Vec<Vec3>,
        /// How many are in a row.
        columns: u32,
    },
    /// A rectangle with heights from an image: black is 0, white is `height`.
    Heightfield {
        /// A path relative to the scene file.
        image: String,
        /// Its sides along x and z.
        size: [f32; 2],
        /// Of white.
        height: f32,
    },
}

impl GeometryEntry {
    /// A file as it stands.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: Some(file.into()),
            surface: None,
            patches: None,
            errors: None,
            name: None,
            color: None,
            subdivide: 0,
            crease_angle: flat(),
            up: Up::Y,
            unit: 1.0,
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
            visible: true,
        }
    }
}

impl GeometryEntry {
    /// The same file or surface, as it stands.
    pub(crate) fn as_it_stands(&self) -> Self {
        let Self { file, surface, name, up, .. } = self.clone();
        Self { file, surface, name, up, ..Self::new("") }
    }
}

fn flat() -> f32 {
    180.0
}
