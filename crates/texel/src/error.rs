//! What can be wrong with the input of a build, and with a texel.

/// Why a texel cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// There is nothing to build from: the source is [`Source::Unknown`](crate::Source::Unknown).
    #[error("the source is unknown: there is nothing to build from")]
    Sourceless,
    /// A corner is NaN or infinite.
    #[error("triangle {triangle}: corner {corner} is not a finite number")]
    NonFinite {
        /// Index in [`Geometry::triangles`](crate::Geometry::triangles).
        triangle: usize,
        /// 0, 1 or 2.
        corner: usize,
    },
    /// A triangle lies further than [`Geometry::REACH`](crate::Geometry::REACH) tiles from the texel.
    #[error("triangle {triangle} lies more than {reach} tiles away from the texel")]
    OutOfReach {
        /// Index in [`Geometry::triangles`](crate::Geometry::triangles).
        triangle: usize,
        /// The limit, in tiles.
        reach: f32,
    },
    /// There is not one colour a triangle.
    #[error("{triangles} triangles, but {colors} colours: there must be one each")]
    ColorCount {
        /// Length of [`Geometry::triangles`](crate::Geometry::triangles).
        triangles: usize,
        /// Length of [`Geometry::colors`](crate::Geometry::colors).
        colors: usize,
    },
    /// An albedo is not in `[0, 1]`.
    #[error("triangle {triangle}: its colour is not an albedo in [0, 1]")]
    Color {
        /// Index in [`Geometry::colors`](crate::Geometry::colors).
        triangle: usize,
    },
    /// A number of the material or of the options is out of its domain.
    #[error("{field} is {value}, which is not in {domain}")]
    Parameter {
        /// The field's name.
        field: &'static str,
        /// What it holds.
        value: f64,
        /// What it may hold.
        domain: &'static str,
    },
    /// A kind would grow more triangles than are grown.
    #[error("{count} triangles would grow, and at most {most} do")]
    Heavy {
        /// How many.
        count: u64,
        /// The limit.
        most: u64,
    },
    /// More triangles, or more of them together in cells, than 32-bit indices can name.
    #[error("{count} {what} are more than a texel can index")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
    },
}

/// What breaks the invariants of a frozen texel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TexelError {
    /// The lists of a level do not fit each other.
    #[error("level {level}: {what}")]
    Structure {
        /// Which level.
        level: u32,
        /// What does not fit.
        what: &'static str,
    },
    /// A number of the material is not in `[0, 1]`.
    #[error("{field} is not in [0, 1]")]
    Material {
        /// Which field of [`Texel`](crate::Texel).
        field: &'static str,
    },
    /// A cell is occupied and none of its children is, or the reverse.
    #[error("level {level}: cell ({}, {}, {}) and its children disagree on being occupied", cell[0], cell[1], cell[2])]
    Orphan {
        /// Level of the parent.
        level: u32,
        /// The parent.
        cell: [u32; 3],
    },
    /// A voxel holds a number out of its domain.
    #[error("level {level}, voxel {voxel}: {field} is out of its domain")]
    Voxel {
        /// Which level.
        level: u32,
        /// Which voxel of it.
        voxel: u32,
        /// Which field of [`Voxel`](crate::Voxel).
        field: &'static str,
    },
}
