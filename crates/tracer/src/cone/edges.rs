//! Whether one cone is enough for a pixel: where a voxel has many strands in it and no edge goes through the pixel.
//!
//! A cone reads voxels that are as wide as itself: what is smaller is in their opacity. Several rays are for what voxels
//! do not know: the edges of opaque surfaces and of coats, and strands that are wider than the pixel. Edges are looked for
//! at the corners of pixels, which neighbours share: one glance a pixel.

use glam::{DVec3, Vec3};
use pelage_geom::{Cone, MaterialId, Ray};

use super::lod::lambda;
use super::passages::BoxPassage;
use super::path::LocalRay;
use crate::surface::SurfaceHit;
use crate::{Lod, Scene, Settings};

/// How wide the cone of a pixel's only ray is, in pixels: a quarter of a level coarser, for three more rays that soften
/// nothing. At 1 the picture is a tenth further off, at √2 as near as at this. [docs/notes/performance.md]
pub(crate) const ONLY: f64 = 1.19;

/// One cone is enough where its continuous level λ is between these. Above, voxels hold few strands, whose edges show;
/// below, boxes are smaller than pixels, and one ray meets one of several.
const LEVELS: [f32; 2] = [0.0, 3.0];

/// What there is along a ray, at a glance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glance {
    surface: Option<Place>,
    /// From where to where it is in the first coat without a gap; distances, scene units.
    coat: Option<[f64; 2]>,
    /// Whether it comes through a box that stands where its skin ends.
    at_border: bool,
}

/// A place on an opaque surface.
#[derive(Clone, Copy, Debug)]
struct Place {
    t: f64,
    point: DVec3,
    normal: Vec3,
    material: MaterialId,
}

impl Glance {
    /// Of a ray that ends at `surface` and goes through boxes, in order of entry.
    pub fn new(scene: &Scene, surface: Option<SurfaceHit>, passages: &[BoxPassage]) -> Self {
        let coat = passages.first().map(|first| {
            let [enter, mut leave] = first.t;
            for next in &passages[1..] {
                if next.t[0] > leave {
                    break;
                }
                leave = leave.max(next.t[1]);
            }
            [enter, leave]
        });
        let place = |hit: SurfaceHit| Place {
            t: hit.t,
            point: hit.point,
            normal: hit.geometric_normal,
            material: hit.material,
        };
        let at_border = passages.iter().any(|passage| scene.open_sides(passage.patch).is_some());
        Self { surface: surface.map(place), coat, at_border }
    }

    /// Whether a surface is behind the coat, or there is neither: elsewhere alpha is what gets through a coat, and of that one
    /// ray in a few voxels says too little.
    pub fn is_backed(&self) -> bool {
        self.surface.is_some() == self.coat.is_some()
    }

    /// Whether no edge is between it and another glance, from the same point in a direction beside its own: `width` (scene
    /// units at distance 1) is how far beside.
    pub fn continues(&self, other: &Self, width: f64) -> bool {
        let coats = match (self.coat, other.coat) {
            (Some(a), Some(b)) => a[0] < b[1] && b[0] < a[1],
            (a, b) => a.is_none() && b.is_none(),
        };
        coats
            && !(self.at_border || other.at_border)
            && match (&self.surface, &other.surface) {
                (Some(a), Some(b)) => is_one_surface(a, b, width),
                (a, b) => a.is_none() && b.is_none(),
            }
    }
}

/// Whether two points are of one surface that is flat, as good as.
fn is_one_surface(a: &Place, b: &Place, width: f64) -> bool {
    let off = (b.point - a.point).dot(a.normal.as_dvec3()).abs();
    a.material == b.material && off < width * a.t && a.normal.dot(b.normal) > FLAT
}

/// The cosine between the normals of what is still flat: 25°.
const FLAT: f32 = 0.9;

/// Whether a ray reads nothing but levels of which one cone is enough.
pub(super) fn are_mixed(
    scene: &Scene,
    settings: &Settings,
    ray: &Ray,
    cone: &Cone,
    passages: &[BoxPassage],
) -> bool {
    // A level that was asked for does not fit the pixel.
    matches!(settings.lod, Lod::Footprint(_))
        && passages.iter().all(|passage| {
            let (_, patch) = scene.patch(passage.patch);
            let local = LocalRay::new(&scene.hexahedron(passage.patch).map(), patch.lattice, ray);
            let jacobian = local.texel_jacobian(&local.end(passage, 0));
            let level = lambda(settings.lod, &jacobian, local.direction(), cone, passage.t[0]);
            (LEVELS[0]..LEVELS[1]).contains(&level)
        })
}

/// What was seen at corners of pixels lately.
pub(crate) struct Corners {
    slots: Vec<Option<([u32; 2], Glance)>>,
}

/// More corners a side than a tile has.
const SIDE: u32 = 32;

impl Default for Corners {
    fn default() -> Self {
        Self { slots: vec![None; (SIDE * SIDE) as usize] }
    }
}

impl Corners {
    /// Where a corner is kept.
    fn slot([x, y]: [u32; 2]) -> usize {
        (y % SIDE * SIDE + x % SIDE) as usize
    }

    /// What there is at the corner above and to the left of a pixel, if it was looked at lately.
    pub(super) fn at(&self, corner: [u32; 2]) -> Option<Glance> {
        self.slots[Self::slot(corner)].filter(|(at, _)| *at == corner).map(|(_, glance)| glance)
    }

    /// Keeps what there is at a corner.
    pub(super) fn keep(&mut self, corner: [u32; 2], glance: Glance) -> Glance {
        self.slots[Self::slot(corner)] = Some((corner, glance));
        glance
    }
}
