//! What became of a mesh on its way to a skin: plain numbers and indices, for people and for tests.

use core::fmt;

use glam::Vec3;

/// What was done with a folded box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The vectors of its vertices were shortened until it was valid. It is this patch of the skin.
    Mended {
        /// Its index in [`Skin::patches`](crate::Skin::patches).
        patch: u32,
    },
    /// It is not in the skin.
    LeftOut,
    /// Nothing yet: the box is only being reported.
    Found {
        /// Its index in the patches that were checked.
        patch: u32,
    },
}

/// A folded box: one whose Jacobian determinant is not positive throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fold {
    /// The face of the mesh that it stands on.
    pub face: u32,
    /// Box coordinates of a point where the determinant is not positive, or could not be decided.
    pub at: Vec3,
    /// The determinant there, in cubic metres per unit of box volume, at full height.
    pub determinant: f32,
    /// What was done.
    pub outcome: Outcome,
}

impl fmt::Display for Fold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { face, at, determinant, outcome } = self;
        match outcome {
            Outcome::Mended { patch } => write!(f, "patch {patch} (face {face}), mended: ")?,
            Outcome::LeftOut => write!(f, "the box on face {face}, left out: ")?,
            Outcome::Found { patch } => write!(f, "patch {patch} (face {face}): ")?,
        }
        write!(f, "det J = {determinant:.3e} m³ at (u, v, w) = ({:.3}, {:.3}, {:.3})", at.x, at.y, at.z)
    }
}

/// What [`extrude`](crate::extrude) or [`cage`](crate::cage) met and did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Boxes on quads, in the finished skin.
    pub boxes: usize,
    /// Prisms on triangles, in the finished skin.
    pub prisms: usize,
    /// Vertices of the mesh merged into an earlier one at exactly the same position.
    pub welded_vertices: usize,
    /// Vertices of a cage's base that have more than one top: the boxes around them do not share all their walls.
    pub torn_vertices: usize,
    /// Vertices of the mesh that no face uses.
    pub isolated_vertices: usize,
    /// Faces of the mesh without area (or with fewer than three distinct corners); they get no box.
    pub zero_area_faces: Vec<u32>,
    /// Faces of the mesh that repeat an earlier one, corner by corner; they get no box.
    pub duplicate_faces: Vec<u32>,
    /// Edges of the selected surface with one face: its border.
    pub open_edges: usize,
    /// Edges with more than two faces; all the boxes there share one wall.
    pub non_manifold_edges: usize,
    /// Edges whose two faces run along them in the same direction, so that one of the faces is inside out.
    pub misoriented_edges: usize,
    /// Whether every n-gon was split into n quads, because there are triangles and no texture coordinates.
    pub refined: bool,
    /// Quads that became two prisms because their texture coordinates are not affine.
    pub split_by_uvs: usize,
    /// Quads that became two prisms because they are less planar than was asked for.
    pub split_nonplanar: usize,
    /// Quads that became two prisms because a corner is concave or has no angle.
    pub split_concave: usize,
    /// Patches whose texel is mirrored (the lattice turns the other way than the surface).
    pub mirrored: usize,
    /// Patches whose texture coordinates have no area (or span more copies than an `f32` can tell apart), and whose
    /// lattice comes from their shape instead.
    pub zero_area_uvs: usize,
    /// Vertices of the skin whose faces' normals cancel; they follow the first of those faces.
    pub cancelled_normals: Vec<u32>,
    /// Vertices of the skin turned from the mean normal so that all their faces see them from outside.
    pub turned_normals: usize,
    /// Vertices of the skin whose vectors were shortened.
    pub mended_vertices: usize,
    /// The shortest of them, as a fraction of the length it had; 1 where none was shortened.
    pub shortest: f32,
    /// Vertices of a groomed skin whose vectors were turned back towards what they were before grooming.
    pub turned_back: usize,
    /// Boxes of a groomed skin that its density left out.
    pub thinned: usize,
    /// Every box that was folded at full height, and those spoilt by the mending of a neighbour.
    pub folds: Vec<Fold>,
    /// Copies of the texel per unit of texture coordinates (per patch side without them); where each chart has its
    /// own, that of their mean density.
    pub tiling: f32,
    /// Mean side of a copy of the texel on the base surface, in metres.
    pub copy_width: f32,
}

impl Report {
    /// How many folded boxes are not in the skin.
    pub fn left_out(&self) -> usize {
        self.folds.iter().filter(|f| f.outcome == Outcome::LeftOut).count()
    }

    /// How many folded boxes were mended.
    pub fn mended(&self) -> usize {
        self.folds.iter().filter(|f| matches!(f.outcome, Outcome::Mended { .. })).count()
    }
}

impl fmt::Display for Report {
    /// One line of what there is, then one line for each thing worth knowing; ends without a line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} boxes, {} prisms; a texel is {:.4} m wide", self.boxes, self.prisms, self.copy_width)?;
        if self.refined {
            write!(f, "\ntriangles without texture coordinates: every face of n corners became n quads")?;
        }
        let mut note = |count: usize, what: &str| match count {
            0 => Ok(()),
            n => write!(f, "\n{n} {what}"),
        };
        note(self.mended(), "folded boxes mended")?;
        note(self.left_out(), "folded boxes left out")?;
        note(self.mended_vertices, "vertex vectors shortened")?;
        note(self.turned_back, "vertex vectors turned back")?;
        note(self.thinned, "boxes left out by the density")?;
        note(self.turned_normals, "vertex vectors turned to be seen by all their faces")?;
        note(self.cancelled_normals.len(), "vertices where the normals of the faces cancel")?;
        note(self.zero_area_faces.len(), "faces without area left out")?;
        note(self.duplicate_faces.len(), "duplicate faces left out")?;
        note(self.welded_vertices, "coincident vertices welded")?;
        note(self.torn_vertices, "vertices with more than one top")?;
        note(self.isolated_vertices, "vertices without a face")?;
        note(self.open_edges, "open edges")?;
        note(self.non_manifold_edges, "edges with more than two faces")?;
        note(self.misoriented_edges, "edges between faces of opposite orientation")?;
        note(self.split_by_uvs, "quads split because their texture coordinates are not affine")?;
        note(self.split_nonplanar, "quads split because they are not planar")?;
        note(self.split_concave, "quads split because they are not convex")?;
        note(self.mirrored, "patches with mirrored texture coordinates")?;
        note(self.zero_area_uvs, "patches without usable texture coordinates")
    }
}
