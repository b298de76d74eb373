//! What a user may choose about a rendering.

use pelage_geom::Footprint;

use crate::Rect;

/// How a cone goes through a bent box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Path {
    /// Along the true curve, in chords (the default).
    #[default]
    Curved,
    /// Straight from entry to exit in texel space: the paper's *parcours linéaire*, kept to compare with.
    Straight,
}

/// Which level of the texel a cone reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lod {
    /// From the cone's footprint, blended between two levels.
    Footprint(Footprint),
    /// Always the level with `2^n` voxels a side (or the texel's finest).
    Level(u32),
}

impl Default for Lod {
    fn default() -> Self {
        Self::Footprint(Footprint::Auto)
    }
}

/// How optical depth τ becomes opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Opacity {
    /// 1 − e^−τ (the default).
    #[default]
    Exponential,
    /// min(1, τ), the paper's. [seed §6.1a]
    Linear,
}

/// Rays a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Rays {
    /// One cone where it says all: in coats whose voxels are as wide as it and hold many strands, and where there is
    /// nothing; four rays at edges, on opaque surfaces, and where single strands show (the default).
    #[default]
    Adaptive,
    /// One, through the centre.
    One,
    /// 2 × 2, on a rotated grid.
    Four,
    /// 4 × 4.
    Sixteen,
}

impl Rays {
    /// How many, at most.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Adaptive | Self::Four => 4,
            Self::Sixteen => 16,
        }
    }
}

/// How much time a picture is worth. What each costs and how far it is from the best is told in
/// docs/notes/performance.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Quality {
    /// To place lights and cameras: one ray a pixel, four of its voxels lit.
    Draft,
    /// To look at (the default): one cone or four rays, eight voxels.
    #[default]
    Normal,
    /// To keep: sixteen rays, sixteen voxels.
    High,
}

/// Everything that a user may choose about a rendering. The defaults are what looks right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the whole picture, in pixels.
    pub size: [u32; 2],
    /// The part to render; `None` is all.
    pub crop: Option<Rect>,
    /// Rays a pixel; their voxels are merged before shading.
    pub rays: Rays,
    /// Through the boxes, curved or straight.
    pub path: Path,
    /// Which level.
    pub lod: Lod,
    /// How depth becomes opacity.
    pub opacity: Opacity,
    /// How far a chord may leave the true curve, in voxels of the level in use.
    pub path_tolerance: f32,
    /// A ray ends where it has less than this transmittance left: the most that any pixel can lose by it.
    pub min_transmittance: f32,
    /// Normals taken of each visible voxel's ellipsoid.
    pub normals: u32,
    /// At most this many voxels of a pixel are lit: the heavy ones, and of the others, in order of distance, those that
    /// stand for equal parts of what is seen.
    pub lit_voxels: u32,
    /// Whether voxels and surfaces are shadowed.
    pub shadows: bool,
}

impl Settings {
    /// The defaults, at a quality.
    pub fn of(quality: Quality) -> Self {
        let (rays, lit_voxels) = match quality {
            Quality::Draft => (Rays::One, 4),
            Quality::Normal => (Rays::Adaptive, 8),
            Quality::High => (Rays::Sixteen, 16),
        };
        Self {
            size: [1280, 720],
            crop: None,
            rays,
            path: Path::Curved,
            lod: Lod::default(),
            opacity: Opacity::Exponential,
            path_tolerance: 0.05,
            min_transmittance: 1.0 / 512.0,
            normals: 8,
            lit_voxels,
            shadows: true,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::of(Quality::Normal)
    }
}
