//! *Tessellation*: surfaces become meshes of quads, as fine as asked or as bounds on their error ask. [seed §7]
//!
//! Two errors are measured, each relative and in metres:
//!
//! - The *arc error* of an edge is by how much it is shorter than the curve on the surface between the same two ends
//!   (at one constant parameter); relative, by that curve's length.
//! - The *area error* of a patch is by how much its area differs from that of the surface over the same parameters;
//!   relative, by the latter. The area of a patch is that of the bilinear surface through its corners.
//!
//! The [`Deviation`] of a mesh has the worst edge and the worst patch. Both fall with the square of the patches' size.
//!
//! All meshes conform: neighbouring patches share whole edges, and so their boxes whole walls.
//!
//! ```
//! use pelage_skin::tessellate::{Bounds, Parametric, adaptive, uniform};
//!
//! let torus = Parametric::Torus { major: 1.0, minor: 0.4 };
//! let coarse = uniform(&torus, 16, 8)?;
//! let fine = uniform(&torus, 32, 16)?;
//! assert!(fine.deviation().arc < 0.3 * coarse.deviation().arc);
//! let bounded = adaptive(&torus, &Bounds { arc: 0.01, ..Bounds::NONE })?;
//! assert!(bounded.deviation().arc <= 0.01);
//! # Ok::<(), pelage_skin::SkinError>(())
//! ```

mod catmull_clark;
mod grid;
mod normals;
mod parametric;

use pelage_geom::Mesh;

use catmull_clark::Limit;
pub use catmull_clark::{Subdivision, subdivide};
pub use grid::{adaptive, uniform};
pub use normals::smooth_normals;
pub use parametric::Parametric;

/// A mesh that stands for a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation {
    /// With texture coordinates in `[0,1]²`, where the surface has parameters.
    pub mesh: Mesh,
    surface: Surface,
}

/// What a mesh stands for.
#[derive(Clone, Debug, PartialEq)]
enum Surface {
    /// A surface, and the values of its parameters that have lines.
    Parametric(Parametric, [Vec<f64>; 2]),
    /// The limit of subdivision.
    Limit(Limit),
}

impl Tessellation {
    /// How far the mesh is from the surface. It takes some dozen times as long as the mesh did.
    pub fn deviation(&self) -> Deviation {
        match &self.surface {
            Surface::Parametric(surface, lines) => grid::deviation(surface, lines),
            Surface::Limit(limit) => limit.deviation(),
        }
    }
}

/// By how much a mesh differs from the surface that it stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The worst edge's arc error, relative.
    pub arc: f64,
    /// The worst edge's arc error, in metres.
    pub arc_metres: f64,
    /// The worst patch's area error, relative.
    pub area: f64,
    /// The worst patch's area error, in square metres.
    pub area_square_metres: f64,
    /// The area error of the whole surface, relative.
    pub total_area: f64,
}

/// What a deviation may be at most, and how many patches that may take.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Bounds {
    /// Of [`Deviation::arc`]; positive.
    pub arc: f64,
    /// Of [`Deviation::arc_metres`]; positive.
    pub arc_metres: f64,
    /// Of [`Deviation::area`]; positive.
    pub area: f64,
    /// Of [`Deviation::area_square_metres`]; positive.
    pub area_square_metres: f64,
    /// The most patches; more is an error.
    pub most_patches: usize,
}

impl Bounds {
    /// Whatever the surface's coarsest mesh has, and a million patches.
    pub const NONE: Self = Self {
        arc: f64::INFINITY,
        arc_metres: f64::INFINITY,
        area: f64::INFINITY,
        area_square_metres: f64::INFINITY,
        most_patches: 1_000_000,
    };

    /// Checks that every bound can be met.
    ///
    /// # Errors
    /// The first field that is not positive, and what it must be.
    pub fn validate(&self) -> Result<(), (&'static str, &'static str)> {
        let fields = [
            ("arc", self.arc),
            ("arc_metres", self.arc_metres),
            ("area", self.area),
            ("area_square_metres", self.area_square_metres),
        ];
        match fields.into_iter().find(|&(_, bound)| bound.is_nan() || bound <= 0.0) {
            Some((field, _)) => Err((field, "must be positive")),
            None if self.most_patches == 0 => Err(("most_patches", "must be positive")),
            None => Ok(()),
        }
    }
}

impl Default for Bounds {
    fn default() -> Self {
        Self::NONE
    }
}

/// Sums and extremes of errors, edge by edge and patch by patch.
#[derive(Default)]
struct Account {
    deviation: Deviation,
    surface: f64,
    mesh: f64,
}

impl Account {
    /// An edge of this length in place of a curve of that one.
    fn edge(&mut self, chord: f64, arc: f64) {
        let error = (arc - chord).max(0.0);
        self.deviation.arc = self.deviation.arc.max(relative(error, arc));
        self.deviation.arc_metres = self.deviation.arc_metres.max(error);
    }

    /// A patch of this area in place of one of that one.
    fn patch(&mut self, flat: f64, curved: f64) {
        let error = (curved - flat).abs();
        self.deviation.area = self.deviation.area.max(relative(error, curved));
        self.deviation.area_square_metres = self.deviation.area_square_metres.max(error);
        self.surface += curved;
        self.mesh += flat;
    }

    fn finish(self) -> Deviation {
        let total_area = relative((self.surface - self.mesh).abs(), self.surface);
        Deviation { total_area, ..self.deviation }
    }
}

fn relative(error: f64, whole: f64) -> f64 {
    if whole > 0.0 { error / whole } else { 0.0 }
}
