//! Models to the content of texels: any mesh with its materials and textures, and strands.
//!
//! ```no_run
//! use std::path::Path;
//! use pelage::bake::{ContentOptions, content, read};
//! use pelage::build;
//! use pelage::texel::BuildOptions;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let file = Path::new("leaf.glb");
//! let content = content(file, &read(file)?, &ContentOptions { resolution: 64, ..ContentOptions::default() }, &|_| {})?;
//! let options = BuildOptions { depth: 6, periodic: false, ..BuildOptions::standard() };
//! let leaf = build("leaf", content.geometry, &options, &|_| {})?;
//! # Ok(())
//! # }
//! ```
//!
//! | of the model | becomes |
//! |---|---|
//! | base colour, its texture, colours of vertices | one colour a triangle, which are cut until that shows them |
//! | alpha: mask, blend | cut away at the cutoff; holes smaller than a voxel |
//! | lines with a thickness | thin tubes |
//! | specular, roughness | one of each for the texel: means over the area, with a warning where they differ |
//! | emission | left out, with a warning: texels have no place for it |
//! | one-sided faces | seen from both sides, as everything in a texel |

mod assemble;
mod cut;
mod error;
mod extremes;
mod gloss;
mod paint;
mod placing;
mod strands;
mod tube;

use std::path::Path;

use pelage_geom::Mesh;
use pelage_texel::Geometry;

pub use error::{BakeError, BakeFault};
pub use placing::Fit;

use crate::import::{ImportError, ImportOptions, Imported, Place, Up, Warning, import};
use assemble::Assembly;
use gloss::Gloss;
use placing::Placing;
use strands::Thickness;

/// How a model becomes content.
#[derive(Clone, Debug, PartialEq)]
pub struct ContentOptions {
    /// Which axis of the model points away from the surface that the texel stands on.
    pub up: Up,
    /// How it is put into the texel.
    pub fit: Fit,
    /// What is left free on each side, in texel edges: 0 to 0.45. Only where it is scaled.
    pub margin: f32,
    /// Whether what leaves the texel on one side enters it on the other, in s and t.
    pub tile: bool,
    /// Voxels a side of the finest level that will be built, 2 to 512: how finely textures are followed.
    pub resolution: u32,
    /// Half the thickness of strands that have none of their own, in units of the model.
    pub radius: Option<f32>,
    /// The same at their ends; as at their beginnings where there is none.
    pub tip_radius: Option<f32>,
}

impl Default for ContentOptions {
    /// +Y up, in the middle of the cube with 2 % left free, for 256 voxels a side.
    fn default() -> Self {
        Self {
            up: Up::Y,
            fit: Fit::Cube,
            margin: 0.02,
            tile: false,
            resolution: 256,
            radius: None,
            tip_radius: None,
        }
    }
}

impl ContentOptions {
    fn validate(&self) -> Result<(), BakeFault> {
        let parameter = |field, value: f64, domain| Err(BakeFault::Parameter { field, value, domain });
        if !(0.0..=0.45).contains(&self.margin) {
            return parameter("margin", self.margin.into(), "0 to 0.45");
        }
        if !(2..=512).contains(&self.resolution) {
            return parameter("resolution", self.resolution.into(), "2 to 512");
        }
        for (field, radius) in [("radius", self.radius), ("tip_radius", self.tip_radius)] {
            if let Some(radius) = radius.filter(|&r| !(0.0..=Mesh::POSITION_LIMIT).contains(&r)) {
                return parameter(field, radius.into(), "0 or more");
            }
        }
        Ok(())
    }
}

/// What a texel can be built from, and what of the model it does not hold.
#[derive(Clone, Debug)]
pub struct Content {
    /// The triangles.
    pub geometry: Geometry,
    /// What was left out or read differently than it may have been meant.
    pub warnings: Vec<Warning>,
}

/// Reads a model with all that [`content`] can use.
///
/// # Errors
/// As [`import`] does.
pub fn read(file: &Path) -> Result<Imported, ImportError> {
    import(file, &ImportOptions { content: true, ..ImportOptions::default() })
}

/// Makes a model (read by [`read`] from `file`) into triangles of one colour each in the texel's cube. `progress` is
/// told the fraction done, from any thread. The same bits for any number of threads.
///
/// # Errors
/// Options out of their domain; nothing that could be seen in the texel; too much.
pub fn content(
    file: &Path,
    model: &Imported,
    options: &ContentOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Content, BakeError> {
    let fault = |fault| BakeError { file: file.to_owned(), fault };
    options.validate().map_err(fault)?;
    let thickness = Thickness::new(model, options).map_err(fault)?;
    let bounds = thickness.bounds(model).ok_or_else(|| fault(BakeFault::NoArea))?;
    let placing = Placing::new(options.up, options.fit, options.margin, bounds).map_err(fault)?;
    let assembly = Assembly::new(model, options, placing, thickness);
    let (pieces, areas) = assembly.pieces(progress).map_err(fault)?;
    let [a, b] = bounds.map(|p| placing.apply(p));
    let (low, high) = (a.min(b), a.max(b));
    let extent = assembly.extent();
    if pieces.triangles.is_empty() {
        let outside = low.cmpgt(extent.high).any() || high.cmplt(extent.low).any();
        return Err(fault(match (outside, pieces.cut) {
            (true, _) => BakeFault::Outside { low: low.to_array(), high: high.to_array() },
            (_, true) => BakeFault::CutAway,
            _ => BakeFault::NoArea,
        }));
    }
    let gloss = Gloss::new(&model.materials, &areas);
    let mut messages = gloss.warnings;
    // A rounding error beyond the cube is nothing.
    const SLACK: f32 = 1e-4;
    if low.cmplt(extent.low - SLACK).any() || high.cmpgt(extent.high + SLACK).any() {
        messages.push(format!(
            "what lies outside of the texel is cut off: it spans {low} to {high} in (s, t, w)"
        ));
    }
    let warning = |message| Warning { file: file.to_owned(), place: Place::File, message };
    Ok(Content {
        geometry: Geometry {
            triangles: pieces.triangles,
            colors: pieces.colors,
            specular: gloss.specular,
            roughness: gloss.roughness,
        },
        warnings: messages.into_iter().map(warning).collect(),
    })
}
