//! What a pixel shows besides its colour: which box, how much the texel is stretched there, which way the surface
//! faces. For looking at a skin and for compositing; without light, so it takes a part of a picture's time.

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::cone::composite::View;
use crate::render::{check, see};
use crate::{Camera, Rect, RenderError, Scene, Settings};

/// Arbitrary output variables: for each pixel of a picture, what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// The whole picture's width and height.
    pub size: [u32; 2],
    /// Which part of it the lists hold, row by row from its top.
    pub window: Rect,
    /// The number of the box that covers the most of the pixel, among all boxes of the scene, coat by coat;
    /// [`Aovs::NO_PATCH`] where no box covers any.
    pub patch: Vec<u32>,
    /// The mean stretch ([`Skin::stretch`](pelage_skin::Skin::stretch)) of the boxes seen, by how much they cover; 0
    /// without any.
    pub stretch: Vec<f32>,
    /// The mean normal of what is seen, unit length, scene space: of a box that of the surface it stands on. Zero where
    /// there is nothing.
    pub normal: Vec<Vec3>,
}

/// One pixel of [`Aovs`].
#[derive(Clone, Copy)]
struct Seen {
    patch: u32,
    stretch: f32,
    normal: Vec3,
}

impl Aovs {
    /// Where no box is seen.
    pub const NO_PATCH: u32 = u32::MAX;
}

/// Looks at `scene` as [`render`](crate::render()) does, and notes what is seen. The same bits for any number of threads.
///
/// # Errors
/// Settings that cannot be used.
pub fn render_aovs(scene: &Scene, camera: &Camera, settings: &Settings) -> Result<Aovs, RenderError> {
    let window = check(camera, settings)?;
    let seen: Vec<Seen> = (0..window.height)
        .into_par_iter()
        .map_init(View::default, |view, row| {
            let pixel = |column| [window.x + column, window.y + row];
            (0..window.width)
                .map(|column| look(scene, camera, settings, pixel(column), view))
                .collect::<Vec<_>>()
        })
        .flatten_iter()
        .collect();
    Ok(Aovs {
        size: settings.size,
        window,
        patch: seen.iter().map(|s| s.patch).collect(),
        stretch: seen.iter().map(|s| s.stretch).collect(),
        normal: seen.iter().map(|s| s.normal).collect(),
    })
}

fn look(scene: &Scene, camera: &Camera, settings: &Settings, pixel: [u32; 2], view: &mut View) -> Seen {
    see(scene, camera, settings, pixel, view);
    // By box, so that a box's voxels follow each other.
    view.voxels.sort_by_key(|voxel| voxel.key);
    let mut seen = Seen { patch: Aovs::NO_PATCH, stretch: 0.0, normal: Vec3::ZERO };
    let (mut most, mut all) = (0.0, 0.0);
    for voxels in view.voxels.chunk_by(|a, b| a.key.patch == b.key.patch) {
        let (patch, weight) = (voxels[0].key.patch, voxels.iter().map(|v| v.weight).sum::<f32>());
        let (coat, _) = scene.patch(patch);
        let stretch = coat.skin.stretch(scene.patch_index(patch));
        if stretch.is_finite() {
            seen.stretch += weight * stretch;
            all += weight;
        }
        seen.normal += weight * outwards(scene, patch);
        if weight > most {
            (most, seen.patch) = (weight, patch);
        }
    }
    if all > 0.0 {
        seen.stretch /= all;
    }
    // Surfaces are seen from both sides.
    let towards = |normal: Vec3, direction: Vec3| if normal.dot(direction) > 0.0 { -normal } else { normal };
    seen.normal += view.surfaces.iter().map(|s| s.weight * towards(s.hit.normal, s.direction)).sum::<Vec3>();
    seen.normal = seen.normal.normalize_or_zero();
    seen
}

/// The normal of the surface below a box, at its middle.
fn outwards(scene: &Scene, patch: u32) -> Vec3 {
    let jacobian = scene.hexahedron(patch).map().jacobian(glam::DVec3::new(0.5, 0.5, 0.0));
    let Mat3 { x_axis, y_axis, .. } = jacobian.as_mat3();
    x_axis.cross(y_axis).normalize_or_zero()
}
