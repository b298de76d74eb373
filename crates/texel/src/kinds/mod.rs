//! The kinds of content that grow by procedure, each in a file of its own.
//!
//! Every kind is a plain struct of parameters in texel edges, with its presets as constructors. It repeats in s and t,
//! and is the same bits from the same parameters.

mod domain;
mod fur;
mod grass;
mod leaves;
mod scatter;
mod sheet;
mod spheres;

pub use fur::Fur;
pub use grass::Grass;
pub use leaves::Leaves;
pub use sheet::Sheet;
pub use spheres::Spheres;

use crate::{BuildError, Geometry, Procedure};

/// Content that grows from a few numbers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Kind {
    /// Strands.
    Fur(Fur),
    /// Blades.
    Grass(Grass),
    /// Small flat leaves in mid-air.
    Leaves(Leaves),
    /// One plane.
    Sheet(Sheet),
    /// A lattice of balls.
    Spheres(Spheres),
}

/// A named set of parameters of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The kind's name.
    pub kind: &'static str,
    /// Its own name among those of the kind.
    pub name: &'static str,
    /// Makes it.
    pub make: fn() -> Kind,
}

impl Kind {
    /// Every preset of every kind; the first of a kind is its default.
    pub const PRESETS: [Preset; 9] = [
        Preset { kind: "fur", name: "long", make: || Self::Fur(Fur::long()) },
        Preset { kind: "fur", name: "short", make: || Self::Fur(Fur::short()) },
        Preset { kind: "fur", name: "plush", make: || Self::Fur(Fur::plush()) },
        Preset { kind: "fur", name: "hair", make: || Self::Fur(Fur::hair()) },
        Preset { kind: "grass", name: "meadow", make: || Self::Grass(Grass::meadow()) },
        Preset { kind: "grass", name: "lawn", make: || Self::Grass(Grass::lawn()) },
        Preset { kind: "leaves", name: "green", make: || Self::Leaves(Leaves::green()) },
        Preset { kind: "sheet", name: "tilted", make: || Self::Sheet(Sheet::tilted()) },
        Preset { kind: "spheres", name: "lattice", make: || Self::Spheres(Spheres::lattice()) },
    ];

    fn procedure(&self) -> &dyn Procedure {
        match self {
            Self::Fur(fur) => fur,
            Self::Grass(grass) => grass,
            Self::Leaves(leaves) => leaves,
            Self::Sheet(sheet) => sheet,
            Self::Spheres(spheres) => spheres,
        }
    }
}

impl Default for Kind {
    /// Long fur.
    fn default() -> Self {
        Self::Fur(Fur::long())
    }
}

impl Procedure for Kind {
    fn name(&self) -> &'static str {
        self.procedure().name()
    }

    fn validate(&self) -> Result<(), BuildError> {
        self.procedure().validate()
    }

    fn geometry(&self) -> Geometry {
        self.procedure().geometry()
    }
}

impl From<Fur> for Kind {
    fn from(fur: Fur) -> Self {
        Self::Fur(fur)
    }
}

impl From<Grass> for Kind {
    fn from(grass: Grass) -> Self {
        Self::Grass(grass)
    }
}

impl From<Leaves> for Kind {
    fn from(leaves: Leaves) -> Self {
        Self::Leaves(leaves)
    }
}

impl From<Sheet> for Kind {
    fn from(sheet: Sheet) -> Self {
        Self::Sheet(sheet)
    }
}

impl From<Spheres> for Kind {
    fn from(spheres: Spheres) -> Self {
        Self::Spheres(spheres)
    }
}
