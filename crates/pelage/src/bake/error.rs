//! Why a model cannot become the content of a texel.

use std::path::PathBuf;

/// Why a model cannot become the content of a texel. The message is one line: file, where in it, reason.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {fault}", file.display())]
pub struct BakeError {
    /// The model's file.
    pub file: PathBuf,
    /// What is wrong.
    pub fault: BakeFault,
}

/// What is wrong with a model, or with how it is to be baked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakeFault {
    /// A number of the options is out of its domain.
    #[error("{field} is {value}, which is not in {domain}")]
    Parameter {
        /// The field of [`ContentOptions`](super::ContentOptions).
        field: &'static str,
        /// What it holds.
        value: f64,
        /// What it may hold.
        domain: &'static str,
    },
    /// There are lines, and nothing says how thick they are.
    #[error("strands have no thickness of their own ({count} of them): give them a radius")]
    Radius {
        /// How many strands.
        count: usize,
    },
    /// All of it is one point, or its faces are.
    #[error("nothing in it has any area")]
    NoArea,
    /// Alpha leaves nothing.
    #[error("all of it is transparent or cut away: nothing is left")]
    CutAway,
    /// It is kept where it is, and lies elsewhere.
    #[error("none of it lies in the unit cube: it spans {} to {}, in (s, t, w)", point(low), point(high))]
    Outside {
        /// The smallest coordinates, in (s, t, w).
        low: [f32; 3],
        /// The largest.
        high: [f32; 3],
    },
    /// It is kept where it is and wraps, from further away than a fine voxel can be told.
    #[error("{what} reaches {distance} tiles away from the unit cube, and {limit} is the most that wraps")]
    Far {
        /// Which mesh, or the strands.
        what: String,
        /// How far, in tiles.
        distance: f32,
        /// The most.
        limit: f32,
    },
    /// There is too much.
    #[error("{what}: more than {limit} triangles, as finely as the resolution asks for")]
    Triangles {
        /// The mesh, or the strands, in which the limit was passed.
        what: String,
        /// The limit.
        limit: usize,
    },
}

fn point(p: &[f32; 3]) -> String {
    format!("({}, {}, {})", p[0], p[1], p[2])
}
