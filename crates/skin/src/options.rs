//! What a skin is asked to be.

use glam::Vec3;
use pelage_geom::Mesh;

use crate::SkinError;

/// How patches get their texel coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Layout {
    /// [`Layout::Uv`] where the mesh has texture coordinates, else [`Layout::PerPatch`].
    #[default]
    Auto,
    /// By the mesh's texture coordinates times [`SkinOptions::tiling`]: affine on each patch.
    Uv,
    /// By coordinates that are made for it, in metres: every connected piece is cut open where it shows least and laid
    /// flat, so that copies have the same size nearly everywhere ([`Skin::distortion`](crate::Skin::distortion) tells
    /// how nearly); [`SkinOptions::tiling`] is copies per metre. For meshes of up to 200 000 faces. \[LiuEtAl08\]
    Conformal,
    /// A whole number of copies on each quad. Where there is a triangle, every face of n corners becomes n
    /// quads, so that copies meet along whole sides everywhere.
    PerPatch,
}

/// What is done with folded boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Folds {
    /// Shorten the vectors of their vertices (of groomed ones, turn them back first) and check the neighbours
    /// again; leave out what cannot be mended.
    #[default]
    Mend,
    /// Leave them out, at full height everywhere else.
    LeaveOut,
    /// Fail with [`SkinError::Folded`].
    Refuse,
    /// Leave them as they are, named in the report: for a skin that is still to be groomed. One that holds a folded
    /// box must not be rendered.
    Keep,
}

/// How folded boxes are dealt with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mending {
    /// What is done with them.
    pub folds: Folds,
    /// Vectors are not shortened below this fraction of the length they were given; in (0, 1].
    pub shortest: f32,
    /// How often an undecided box is halved before it counts as folded.
    pub certificate_depth: u32,
}

impl Default for Mending {
    /// Folds are mended, down to 1/16 of the length.
    fn default() -> Self {
        Self { folds: Folds::Mend, shortest: 1.0 / 16.0, certificate_depth: 6 }
    }
}

impl Mending {
    /// Checks that every number is in its domain.
    ///
    /// # Errors
    /// [`SkinError::Option`].
    pub fn validate(&self) -> Result<(), SkinError> {
        match self.shortest {
            x if x > 0.0 && x <= 1.0 => Ok(()),
            value => Err(SkinError::Option { option: "shortest", value, expected: "it must be in (0, 1]" }),
        }
    }
}

/// Which faces a vertex on the border of the selection takes its vector from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Border {
    /// Only the selected ones: a rug lies upright on its table, whatever the table's sides do.
    #[default]
    Selected,
    /// All faces of the mesh: skins of two materials that meet on a smooth surface share their walls.
    Mesh,
}

/// How [`extrude`](crate::extrude) or [`cage`](crate::cage) makes a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SkinOptions {
    /// Length of the vertex vectors, in metres; positive, at most [`Mesh::POSITION_LIMIT`]. A cage has its own.
    pub height: f32,
    /// Tilts every vector the same way, as wind or weight would: its part across a vertex's unit normal is added
    /// to that normal (a length of 1 tilts by 45°, where it lies in the surface). Zero leaves them upright; a cage wants zero.
    pub lean: Vec3,
    /// Where texel coordinates come from.
    pub layout: Layout,
    /// Copies of the texel per unit of texture coordinates (per metre in [`Layout::Conformal`]; per patch side in
    /// [`Layout::PerPatch`], rounded to a whole number there). `None`: chart by chart, such that a copy is about `aspect` heights wide, rounded to
    /// a whole number above 1 so that coordinates that wrap stay continuous (one copy per side in `PerPatch`).
    pub tiling: Option<f32>,
    /// Width of a copy of the texel over its height, where `tiling` is `None`; positive.
    pub aspect: f32,
    /// Quads become two prisms where the distance between their diagonals exceeds this fraction of the square
    /// root of their area. `None`: never for this reason.
    pub split_nonplanar: Option<f32>,
    /// A quad's texture coordinates count as affine where the fourth corner is nearer than this to completing
    /// the parallelogram, in copies of the texel. The default is a quarter of a voxel of a texel of 128³.
    pub affine_tolerance: f32,
    /// Where vectors on the border of the selection come from.
    pub border: Border,
    /// What is done with folded boxes.
    pub folds: Folds,
    /// Vectors are not shortened below this fraction of the height; in (0, 1].
    pub shortest: f32,
    /// How often an undecided box is halved before it counts as folded.
    pub certificate_depth: u32,
}

impl Default for SkinOptions {
    /// Boxes 1 cm high, laid out by texture coordinates where there are any, folds mended.
    fn default() -> Self {
        Self {
            height: 0.01,
            lean: Vec3::ZERO,
            layout: Layout::Auto,
            tiling: None,
            aspect: 1.0,
            split_nonplanar: None,
            affine_tolerance: 1.0 / 512.0,
            border: Border::Selected,
            folds: Folds::Mend,
            shortest: Mending::default().shortest,
            certificate_depth: Mending::default().certificate_depth,
        }
    }
}

/// Beyond, a vector lies flat to within half a degree, and its square runs out of digits.
const MOST_LEAN: f32 = 100.0;

impl SkinOptions {
    /// The defaults at `height` metres.
    pub fn new(height: f32) -> Self {
        Self { height, ..Self::default() }
    }

    /// For checking a model: a folded box is an error.
    pub fn strict(height: f32) -> Self {
        Self { folds: Folds::Refuse, ..Self::new(height) }
    }

    /// One copy of the texel on each quad, whatever the texture coordinates.
    pub fn per_patch(height: f32) -> Self {
        Self { layout: Layout::PerPatch, ..Self::new(height) }
    }

    /// Checks that every number is in its domain.
    ///
    /// # Errors
    /// [`SkinError::Option`] for the first that is not.
    pub fn validate(&self) -> Result<(), SkinError> {
        const POSITIVE: &str = "it must be positive and finite";
        let positive = |x: f32| x > 0.0 && x.is_finite();
        let checks = [
            (
                "height",
                self.height,
                self.height > 0.0 && self.height <= Mesh::POSITION_LIMIT,
                "it must be positive and at most 1e12 m",
            ),
            ("lean", self.lean.length(), self.lean.length() <= MOST_LEAN, "a length of at most 100"),
            ("aspect", self.aspect, positive(self.aspect), POSITIVE),
            ("tiling", self.tiling.unwrap_or(1.0), self.tiling.is_none_or(positive), POSITIVE),
            (
                "split_nonplanar",
                self.split_nonplanar.unwrap_or(0.0),
                self.split_nonplanar.is_none_or(|x| x >= 0.0),
                "it must not be negative",
            ),
            (
                "affine_tolerance",
                self.affine_tolerance,
                self.affine_tolerance >= 0.0,
                "it must not be negative",
            ),
        ];
        match checks.into_iter().find(|&(_, _, ok, _)| !ok) {
            Some((option, value, _, expected)) => Err(SkinError::Option { option, value, expected }),
            None => self.mending().validate(),
        }
    }

    /// What of them is about folded boxes.
    pub fn mending(&self) -> Mending {
        let &Self { folds, shortest, certificate_depth, .. } = self;
        Mending { folds, shortest, certificate_depth }
    }
}
