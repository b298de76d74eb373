//! What can be wrong with a skin or with what it is asked for.

use pelage_geom::MeshError;

use crate::Fold;

/// Why there is no skin, or why one is unusable; each variant says where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SkinError {
    /// The mesh itself is unusable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// No face was selected, or only faces without area.
    #[error(
        "mesh `{mesh}`: none of its {faces} faces can wear a skin ({zero_area} of those selected have no area)"
    )]
    NothingSelected {
        /// The mesh's name.
        mesh: String,
        /// How many faces it has.
        faces: usize,
        /// How many of the selected ones have no area.
        zero_area: usize,
    },
    /// [`Layout::Uv`](crate::Layout::Uv) was asked for on a mesh without texture coordinates.
    #[error("mesh `{mesh}` has no texture coordinates to lay the texel out by")]
    NoUvs {
        /// The mesh's name.
        mesh: String,
    },
    /// [`Layout::Conformal`](crate::Layout::Conformal) was asked for on a mesh that would take very long and much memory.
    #[error("mesh `{mesh}`: {faces} faces are too many to be laid out conformally; {most} is the most")]
    ConformalSize {
        /// The mesh's name.
        mesh: String,
        /// How many of its faces are to be laid out.
        faces: usize,
        /// How many may be.
        most: usize,
    },
    /// An option is out of its domain.
    #[error("skin option `{option}` is {value}: {expected}")]
    Option {
        /// The field of [`SkinOptions`](crate::SkinOptions).
        option: &'static str,
        /// What it holds.
        value: f32,
        /// What it should hold.
        expected: &'static str,
    },
    /// Boxes are folded and [`Folds::Refuse`](crate::Folds::Refuse) was asked for.
    #[error("mesh `{mesh}`: {count} boxes are folded; the first is {first}")]
    Folded {
        /// The mesh's name.
        mesh: String,
        /// How many boxes are folded.
        count: usize,
        /// The first of them.
        first: Fold,
    },
    /// The top mesh of a [`cage`](crate::cage) is unusable.
    #[error("top of the cage: {0}")]
    Top(MeshError),
    /// The two meshes of a cage have not the same number of faces, as far as they have, their corners agree.
    #[error("mesh `{base}` has {base_faces} faces and the top of its cage, `{top}`, has {top_faces}: \
             face {} is in one of them only", base_faces.min(top_faces))]
    CageFaces {
        /// The base's name.
        base: String,
        /// The top's name.
        top: String,
        /// How many faces the base has.
        base_faces: usize,
        /// How many the top has.
        top_faces: usize,
    },
    /// A face is a quad in one mesh of a cage and a triangle in the other.
    #[error(
        "face {face} has {base_corners} corners in mesh `{base}` and {top_corners} in the top of its cage, `{top}`"
    )]
    CageCorners {
        /// The base's name.
        base: String,
        /// The top's name.
        top: String,
        /// The first such face.
        face: usize,
        /// How many corners it has in the base.
        base_corners: usize,
        /// How many in the top.
        top_corners: usize,
    },
    /// Neither mesh of a cage can be the other with some vertices merged: their faces join differently.
    #[error(
        "face {face} joins other faces at corner {corner} in mesh `{base}` than in the top of its cage, `{top}`"
    )]
    CageVertices {
        /// The base's name.
        base: String,
        /// The top's name.
        top: String,
        /// The first such face.
        face: usize,
        /// Which of its corners.
        corner: usize,
    },
    /// A number of a surface, or of how it is to be tessellated, is out of its domain.
    #[error("{surface}: {field} {expected}")]
    Surface {
        /// Its kind.
        surface: &'static str,
        /// Which field.
        field: &'static str,
        /// What it must be.
        expected: &'static str,
    },
    /// A surface would need more patches than are allowed.
    #[error("{surface}: at least {patches} patches would be needed, and at most {most} are allowed")]
    TooFine {
        /// Its kind.
        surface: &'static str,
        /// How many it has got to.
        patches: usize,
        /// How many it may have.
        most: usize,
    },
    /// A step of a groom makes no sense.
    #[error("groom[{step}]: {reason}")]
    Groom {
        /// Which step, counted from 0.
        step: usize,
        /// What is wrong with it.
        reason: Box<SkinError>,
    },
    /// A number of an operation is out of its domain.
    #[error("{field}: {reason}")]
    Operation {
        /// As in `tilt.angle`.
        field: &'static str,
        /// What it must be.
        reason: &'static str,
    },
    /// A mask cannot be evaluated.
    #[error("mask: {reason}")]
    Mask {
        /// Why.
        reason: String,
    },
    /// A mask asks for a vertex attribute that the mesh has not.
    #[error("mask: the mesh has no vertex attribute `{name}`")]
    NoAttribute {
        /// Its name.
        name: String,
    },
    /// Boxes of a skin that was groomed or moved are folded, and [`Folds::Refuse`](crate::Folds::Refuse) was asked for
    /// or they cannot be mended.
    #[error("{count} boxes are folded; the first is {first}")]
    StillFolded {
        /// How many boxes are folded.
        count: usize,
        /// The first of them.
        first: Fold,
    },
    /// More vertices or patches than 32-bit indices can name.
    #[error("mesh `{mesh}`: the skin may need {count} {what}, more than 32-bit indices can name")]
    TooLarge {
        /// The mesh's name.
        mesh: String,
        /// `vertices` or `patches`.
        what: &'static str,
        /// How many at most.
        count: usize,
    },
    /// A list of the skin has another length than the one it goes with.
    #[error("skin: `{list}` has {length} entries where {expected} are needed")]
    Length {
        /// `top`, `uvs`, `attributes`, or what was given to [`Skin::update`](crate::Skin::update).
        list: &'static str,
        /// Its length.
        length: usize,
        /// The length it should have.
        expected: usize,
    },
    /// A patch names a vertex that does not exist.
    #[error("skin, patch {patch}: vertex index {index} is out of range ({count} vertices)")]
    IndexOutOfRange {
        /// Which patch.
        patch: usize,
        /// The index it names.
        index: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A base or top point is NaN or infinite.
    #[error("skin, vertex {vertex}: its base or its top is not a usable number")]
    NonFinite {
        /// Which vertex.
        vertex: usize,
    },
    /// A lattice is not finite, or flattens the patch onto a line.
    #[error("skin, patch {patch}: its texel coordinates are singular or not finite")]
    Lattice {
        /// Which patch.
        patch: usize,
    },
    /// A box of a finished skin is folded.
    #[error("skin: {0}")]
    FoldedBox(Fold),
}
