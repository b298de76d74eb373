//! From a scene to a picture: tiles on the current rayon pool, each pixel a pure function of its place.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::{Mat3, Vec2, Vec3};
use pelage_geom::Cone;
use rayon::prelude::*;

use crate::cone::composite::View;
use crate::cone::edges::ONLY;
use crate::cone::march::Beam;
use crate::cone::shade::Shader;
use crate::{Camera, Counts, Film, Pixel, Rays, Rect, Scene, Settings};

/// Tiles are this many pixels a side: small enough to share out, large enough that neighbours share what they read.
const TILE: u32 = 16;

/// How far a rendering is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Tiles finished.
    pub done: usize,
    /// Tiles in all.
    pub total: usize,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The progress callback asked to stop; the tiles that were finished are in the film.
    #[error("cancelled after {done} of {total} tiles")]
    Cancelled {
        /// Tiles finished.
        done: usize,
        /// Tiles in all.
        total: usize,
        /// The finished tiles; the rest is empty.
        film: Box<Film>,
    },
    /// A setting or the camera cannot be used.
    #[error("{field}: {reason}")]
    Setting {
        /// Which one.
        field: &'static str,
        /// What is wrong with it.
        reason: String,
    },
}

/// The largest picture that is rendered, in pixels.
pub const MAX_PIXELS: u64 = 64 << 20;

/// Renders `scene` as `camera` sees it.
///
/// Runs on the rayon pool that it is called in. The picture is the same, bit for bit, for any number of threads, and
/// a crop is the same as that part of the whole. `progress` is called after each tile, from any thread;
/// [`ControlFlow::Break`] stops the rendering.
///
/// # Errors
/// Settings that cannot be used, and cancellation, which keeps what is finished.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Film, RenderError> {
    render_counted(scene, camera, settings, progress).map(|(film, _)| film)
}

/// As [`render`], and tells what was done for it. Counts are no part of the picture: they may differ with the number
/// of threads.
///
/// # Errors
/// Those of [`render`].
pub fn render_counted(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<(Film, Counts), RenderError> {
    let window = check(camera, settings)?;
    let tiles = tiles(window);
    let total = tiles.len();
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));

    let tiles: Vec<Option<(Rect, Vec<Pixel>, Counts)>> = tiles
        .into_par_iter()
        .map_init(Default::default, |(view, shader): &mut (View, Shader), tile| {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let pixels = (0..tile.area() as u32)
                .map(|p| {
                    let at = [tile.x + p % tile.width, tile.y + p / tile.width];
                    pixel(scene, camera, settings, at, view, shader)
                })
                .collect();
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if progress(Progress { done, total }).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
            let mut counts = view.take_counts();
            counts += shader.take_counts();
            Some((tile, pixels, counts))
        })
        .collect();

    let mut film = Film::new(settings.size, window);
    let mut counts = Counts::default();
    for (tile, pixels, of_tile) in tiles.into_iter().flatten() {
        film.paste(tile, &pixels);
        counts += of_tile;
    }
    let done = done.into_inner();
    if done < total {
        return Err(RenderError::Cancelled { done, total, film: Box::new(film) });
    }
    Ok((film, counts))
}

/// The tiles of a window along a curve that stays close to where it was (Morton's), so that a thread's next tile shares
/// with its last ones what lies between the light and both.
fn tiles(window: Rect) -> Vec<Rect> {
    let (columns, rows) = (window.width.div_ceil(TILE), window.height.div_ceil(TILE));
    let mut places: Vec<[u32; 2]> = (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y])).collect();
    let bits = |n: u32| (0..32).filter(|i| n >> i & 1 != 0).fold(0_u64, |all, i| all | 1 << (2 * i));
    places.sort_by_cached_key(|&[x, y]| bits(x) | bits(y) << 1);
    let tile = |[x, y]: [u32; 2]| {
        let (x, y) = (x * TILE, y * TILE);
        let (width, height) = (TILE.min(window.width - x), TILE.min(window.height - y));
        Rect { x: window.x + x, y: window.y + y, width, height }
    };
    places.into_iter().map(tile).collect()
}

/// The part of the picture to render, if everything can be used.
pub(crate) fn check(camera: &Camera, settings: &Settings) -> Result<Rect, RenderError> {
    let bad = |field, reason: String| Err(RenderError::Setting { field, reason });
    let [width, height] = settings.size;
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MAX_PIXELS {
        return bad("size", format!("{width}x{height} pixels; from 1 to {MAX_PIXELS} in all are possible"));
    }
    let window = settings.crop.unwrap_or(Rect::whole(settings.size));
    let ends = |start: u32, length: u32| start.checked_add(length);
    if window.area() == 0
        || ends(window.x, window.width).is_none_or(|end| end > width)
        || ends(window.y, window.height).is_none_or(|end| end > height)
    {
        let Rect { x, y, width: w, height: h } = window;
        let part = format!("{w}x{h} pixels from column {x} and row {y} are not inside");
        return bad("crop", format!("{part} a picture of {width}x{height} pixels"));
    }
    let axes = camera.orientation;
    if !(camera.position.is_finite() && (axes.transpose() * axes).abs_diff_eq(Mat3::IDENTITY, 1e-3)) {
        return bad(
            "camera",
            "its place is not finite, or its axes are not unit vectors at right angles".into(),
        );
    }
    if !(camera.vertical_fov > 0.0 && camera.vertical_fov < std::f32::consts::PI) {
        return bad(
            "camera",
            format!("an angle of view of {} radians; it must lie in (0, π)", camera.vertical_fov),
        );
    }
    let positive = |x: f32| x > 0.0 && x.is_finite();
    if !positive(settings.path_tolerance) {
        return bad("path_tolerance", format!("{} voxels; it must be positive", settings.path_tolerance));
    }
    if !(settings.min_transmittance >= 0.0 && settings.min_transmittance < 1.0) {
        return bad("min_transmittance", format!("{}; it must lie in [0, 1)", settings.min_transmittance));
    }
    Ok(window)
}

fn pixel(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    [x, y]: [u32; 2],
    view: &mut View,
    shader: &mut Shader,
) -> Pixel {
    let background = see(scene, camera, settings, [x, y], view);
    view.merge();

    let mut color = shader.surfaces(scene, settings, &view.surfaces);
    let alpha = (1.0 - background).clamp(0.0, 1.0);
    let depth = view.median_depth(camera.forward(), alpha);
    view.choose(settings.lit_voxels as usize);
    let (_, cone) = camera.cone(Vec2::new(x as f32, y as f32) + 0.5, settings.size);
    shader.begin(&view.voxels, cone);
    color += view.voxels.iter().map(|v| v.weight * shader.voxel(scene, settings, v)).sum::<Vec3>();

    Pixel { color, alpha, depth }
}

/// Follows the rays of a pixel: what they see is in `view` then. Returns what gets through to the background.
pub(crate) fn see(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    [x, y]: [u32; 2],
    view: &mut View,
) -> f32 {
    view.clear();
    let corner = Vec2::new(x as f32, y as f32);
    if settings.rays == Rays::Adaptive {
        let (ray, pixel) = camera.cone(corner + 0.5, settings.size);
        let cone = Cone { width: pixel.width, spread: ONLY * pixel.spread };
        let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let through = |[x, y]: [u32; 2]| camera.cone(Vec2::new(x as f32, y as f32), settings.size).0;
        let beam = Beam { ray: &ray, cone: &cone, settings };
        if let Some(background) = view.trace_alone(scene, beam, corners, through, &pixel) {
            return background;
        }
    }
    let offsets = offsets(settings.rays);
    let share = 1.0 / offsets.len() as f32;
    let mut background = 0.0;
    for &offset in offsets {
        let (ray, cone) = camera.cone(corner + Vec2::from_array(offset), settings.size);
        background += view.trace(scene, settings, &ray, &cone, share);
    }
    background
}

/// Where in a pixel its rays go.
fn offsets(rays: Rays) -> &'static [[f32; 2]] {
    // Rotated grids: as many different columns and rows as rays, so that nearly level edges are smooth too.
    const FOUR: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];
    const SIXTEEN: [[f32; 2]; 16] = {
        let mut points = [[0.0; 2]; 16];
        let mut i = 0;
        while i < 16 {
            let (column, row) = ((i % 4) as f32, (i / 4) as f32);
            points[i] = [(column + (row + 0.5) / 4.0) / 4.0, (row + (3.0 - column + 0.5) / 4.0) / 4.0];
            i += 1;
        }
        points
    };
    match rays {
        Rays::One => &[[0.5, 0.5]],
        Rays::Adaptive | Rays::Four => &FOUR,
        Rays::Sixteen => &SIXTEEN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_window_once() {
        let window = Rect { x: 5, y: 7, width: 70, height: 33 };
        let tiles = tiles(window);
        let mut covered = vec![0; window.area()];
        for tile in &tiles {
            for (x, y) in (0..tile.area() as u32).map(|i| (i % tile.width, i / tile.width)) {
                covered[((tile.y - 7 + y) * 70 + tile.x - 5 + x) as usize] += 1;
            }
        }
        assert!(covered.iter().all(|&count| count == 1));
        // The first four are the corner of the window.
        assert_eq!(
            tiles[..4].iter().map(|t| [t.x - 5, t.y - 7]).collect::<Vec<_>>(),
            [[0, 0], [16, 0], [0, 16], [16, 16]]
        );
    }

    #[test]
    fn ray_patterns_are_latin_and_centred() {
        for rays in [Rays::One, Rays::Four, Rays::Sixteen] {
            let points = offsets(rays);
            let n = points.len();
            assert_eq!(n, rays.count());
            for axis in [0, 1] {
                let mut rows: Vec<usize> = points.iter().map(|p| (p[axis] * n as f32) as usize).collect();
                rows.sort_unstable();
                assert_eq!(rows, (0..n).collect::<Vec<_>>());
                let mean: f32 = points.iter().map(|p| p[axis]).sum::<f32>() / n as f32;
                assert!((mean - 0.5).abs() < 1e-6);
            }
        }
    }
}
