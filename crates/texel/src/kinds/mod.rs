//! The kinds of content that grow by procedure, each in a file of its own.
//!
//! Every kind is a plain struct of parameters in texel edges, with its presets as constructors. It repeats in s and t,
//! and is the same bits from the same parameters.

mod blade;
mod clumps;
mod curve;
mod foliage;
mod fur;
mod grass;
mod hypertexture;
mod leaves;
mod moss;
mod needles;
mod parameter;
mod pile;
mod scatter;
mod sheet;
mod spheres;
mod tube;
mod variant;
mod within;

pub use foliage::Foliage;
pub use fur::Fur;
pub use grass::Grass;
pub use hypertexture::Hypertexture;
pub use leaves::Leaves;
pub use moss::Moss;
pub use needles::Needles;
pub use parameter::{Domain, Parameter, Value};
pub use pile::Pile;
pub use sheet::Sheet;
pub use spheres::Spheres;

use crate::{BuildError, Density, Geometry, Procedure};

/// Declares the kinds, once: [`Kind`], its presets, and what each variant answers by asking its parameters.
macro_rules! kinds {
    ($($(#[doc = $about:literal])+ $kind:ident $name:literal: $($preset:ident $what:literal),+;)+) => {
        /// Content that grows from a few numbers.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(
            feature = "serde",
            derive(serde::Serialize, serde::Deserialize),
            serde(rename_all = "lowercase")
        )]
        pub enum Kind {$(
            $(#[doc = $about])+
            $kind($kind),
        )+}

        const PRESET_COUNT: usize = [$($(stringify!($preset)),+),+].len();

        impl Kind {
            /// Every preset of every kind; the first of a kind is its default.
            pub const PRESETS: [Preset; PRESET_COUNT] = [$($(Preset {
                kind: $name,
                name: stringify!($preset),
                about: $what,
                make: || Self::$kind($kind::$preset()),
            }),+),+];

            /// What it is, in a sentence or two.
            pub fn about(&self) -> &'static str {
                match self {$(
                    Self::$kind(_) => $kind::ABOUT,
                )+}
            }

            /// What can be set of it, and what it is set to.
            pub fn parameters(&self) -> Vec<Parameter> {
                match self {$(
                    Self::$kind(kind) => kind.parameters(),
                )+}
            }

            fn procedure(&self) -> &dyn Procedure {
                match self {$(
                    Self::$kind(kind) => kind,
                )+}
            }
        }

        $(impl From<$kind> for Kind {
            fn from(kind: $kind) -> Self {
                Self::$kind(kind)
            }
        })+
    };
}

kinds! {
    /// Strands.
    Fur "fur":
        long "soft, in loose locks",
        short "smooth, hardly curled",
        plush "dense, even and matt, like velvet or a soft toy",
        fleece "tight crimped locks, like a lamb's",
        hair "few and thin";
    /// Blades.
    Grass "grass":
        meadow "tall and loose, some of it dry",
        lawn "dense, even and green",
        tussock "long narrow blades in tufts, much of it dry";
    /// Cushions of small shoots.
    Moss "moss":
        cushion "soft and rounded, as on a boulder or a roof",
        star "large separate shoots, like green stars from above";
    /// Carpet.
    Pile "pile":
        cut "cut pile of twisted yarn",
        loops "uncut loops in rows, in two colours",
        shag "long heavy yarn that lies over";
    /// Twigs with leaves.
    Foliage "foliage":
        shrub "a hedge of oval leaves",
        ivy "broad heart-shaped leaves",
        willow "long narrow leaves on twigs that hang over",
        autumn "a beech in October";
    /// Conifer shoots.
    Needles "needles":
        spruce "stiff short needles all around",
        fir "flat needles combed to both sides",
        pine "long needles in pairs";
    /// A soft shape that noise displaces.
    Hypertexture "hypertexture":
        calm "a ball with hardly any noise",
        rough "a ball that noise has made a rock",
        wild "a ball that noise tears apart",
        clouds "a layer of billows";
    /// Small flat leaves in mid-air.
    Leaves "leaves":
        green "a hedge in early summer";
    /// One plane.
    Sheet "sheet":
        tilted "rising along s like the slates of a roof";
    /// A lattice of balls.
    Spheres "spheres":
        lattice "eight, with gaps";
}

/// A named set of parameters of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The kind's name.
    pub kind: &'static str,
    /// Its own name among those of the kind.
    pub name: &'static str,
    /// What it is like, in a few words.
    pub about: &'static str,
    /// Makes it.
    pub make: fn() -> Kind,
}

impl Kind {
    /// Its density, if it is one: such a kind has no triangles.
    pub fn density(&self) -> Option<Density> {
        match self {
            Self::Hypertexture(hypertexture) => Some(hypertexture.density()),
            _ => None,
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
