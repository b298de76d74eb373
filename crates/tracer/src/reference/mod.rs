//! The reference renderer: what the cone tracer's pictures are judged by.
//!
//! It shows the triangles that a texel was made from, carried into every box by the trilinear map T, and lit by shadow
//! rays; of a texel that is a density, the points at which rays through its image are stopped. It has nothing of the cone tracer but the scene, T, the opaque meshes and the material: no voxel, level, wall,
//! inverse, Jacobian or ellipsoid. What both show alike is therefore no common mistake. It is slow, and noisy at few
//! samples; its noise is white within a pixel's samples and independent between [seeds](ReferenceSettings::seed).
//!
//! ```text
//! Texel::source ─ content ─► triangles of a tile ─┐
//!                    box ─ carrier: lattice, T ───┴─ stream: many rays ─► hits ─ shade: shadow rays ─► Film
//! ```

mod carrier;
mod content;
mod expand;
mod fineness;
mod medium;
mod polygon;
mod sample;
mod shade;
mod stream;
mod world;

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::render::check;
use crate::scene::check_lighting;
use crate::{Camera, Environment, Film, Light, Pixel, Progress, Rect, RenderError, Scene, Settings};

pub use expand::{Carried, Expansion, Part};
pub use fineness::Fineness;
use sample::{Points, Use, flight};
use shade::{Seen, Shader, look};
use stream::{Query, Stream};
use world::World;

/// What may be chosen about a reference picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Width and height of the whole picture, in pixels.
    pub size: [u32; 2],
    /// The part to render; `None` is all.
    pub crop: Option<Rect>,
    /// Samples a pixel, 1 to 65536; each has a ray to every light and one to the sky.
    pub samples: u32,
    /// Which of the many independent sets of samples.
    pub seed: u32,
    /// Whether there are shadows.
    pub shadows: bool,
    /// Bytes that the explicit content of all texels may take. Boxes take none, however many there are.
    pub memory: u64,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self {
            size: Settings::default().size,
            crop: None,
            samples: 256,
            seed: 0,
            shadows: true,
            memory: 4 << 30,
        }
    }
}

/// All the light of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Lights with a place or a direction.
    pub lights: Vec<Light>,
    /// The light of the surroundings.
    pub environment: Environment,
}

/// Why there is no reference picture.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A setting, the camera or a light cannot be used.
    #[error("{field}: {reason}")]
    Setting {
        /// Which one.
        field: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A texel does not know what it was made from.
    #[error(
        "coat {coat}: the texel `{texel}` does not hold the geometry that it was made from: build it anew from its source"
    )]
    Source {
        /// Which coat.
        coat: usize,
        /// What the texel is called.
        texel: String,
    },
    /// What a texel was made from is not sound.
    #[error("coat {coat}: the source of the texel `{texel}`: {reason}")]
    Content {
        /// Which coat.
        coat: usize,
        /// What the texel is called.
        texel: String,
        /// What is wrong.
        reason: String,
    },
    /// A texel is a density: there are no triangles of it.
    #[error("coat {coat}: the texel `{texel}` is a density: it has no triangles")]
    Density {
        /// Which coat.
        coat: usize,
        /// What the texel is called.
        texel: String,
    },
    /// The explicit content is larger than the memory it may take.
    #[error("the explicit content of the texels takes at least {needed} bytes; {memory} are allowed")]
    Memory {
        /// How much it takes.
        needed: u64,
        /// How much it may take.
        memory: u64,
    },
    /// The progress callback asked to stop.
    #[error("cancelled after {done} of {total} tiles")]
    Cancelled {
        /// Tiles finished.
        done: usize,
        /// Tiles in all.
        total: usize,
        /// The finished tiles of each picture; the rest is empty.
        films: Vec<Film>,
    },
}

impl From<RenderError> for ReferenceError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Setting { field, reason } => Self::Setting { field: field.into(), reason },
            RenderError::Cancelled { done, total, film } => {
                Self::Cancelled { done, total, films: vec![*film] }
            }
        }
    }
}

/// How much of a pixel a flat triangle may be away from the curved one.
const FLATNESS: f64 = 1.0 / 20.0;

/// About this many rays go on their way together: enough to share what they read, few enough to stay in the cache.
const TOGETHER: usize = 1 << 15;

/// Renders the explicit content of `scene` as `camera` sees it, under the scene's own light.
///
/// Runs on the rayon pool that it is called in. The picture is the same, bit for bit, for any number of threads, and a
/// crop is the same as that part of the whole. `progress` is called after each tile, from any thread;
/// [`ControlFlow::Break`] stops the rendering.
///
/// # Errors
/// Settings that cannot be used, texels without source, content that is too large, and cancellation, which keeps what
/// is finished.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &ReferenceSettings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Film, ReferenceError> {
    let films = render_under(scene, camera, settings, &[scene.lighting()], progress)?;
    films.into_iter().next().ok_or_else(no_lighting)
}

/// Renders a picture under each of `lightings`, whatever the light of the scene; what is seen is found only once.
///
/// # Errors
/// As [`render`], no lighting at all, and lights that cannot be used.
pub fn render_under(
    scene: &Scene,
    camera: &Camera,
    settings: &ReferenceSettings,
    lightings: &[Lighting],
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Vec<Film>, ReferenceError> {
    let window =
        check(camera, &Settings { size: settings.size, crop: settings.crop, ..Settings::default() })?;
    if !(1..=Points::MOST).contains(&settings.samples) {
        let reason = format!("{} a pixel; from 1 to {} are possible", settings.samples, Points::MOST);
        return Err(ReferenceError::Setting { field: "samples".into(), reason });
    }
    if lightings.is_empty() {
        return Err(no_lighting());
    }
    for (i, lighting) in lightings.iter().enumerate() {
        check_lighting(&lighting.lights, &lighting.environment).map_err(|error| ReferenceError::Setting {
            field: format!("lightings[{i}]"),
            reason: error.to_string(),
        })?;
    }
    let world = World::new(scene, Fineness::of_pixel(camera, settings.size[1], FLATNESS), settings.memory)?;

    // The picture does not depend on how it is shared out.
    let side = (TOGETHER / settings.samples as usize).isqrt().clamp(4, 32) as u32;
    let columns = window.width.div_ceil(side);
    let total = columns as usize * window.height.div_ceil(side) as usize;
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let tiles: Vec<Option<(Rect, Vec<Vec<Pixel>>)>> = (0..total as u32)
        .into_par_iter()
        .map_init(Buffers::default, |buffers, i| {
            let (x, y) = (window.x + i % columns * side, window.y + i / columns * side);
            let tile = Rect {
                x,
                y,
                width: side.min(window.x + window.width - x),
                height: side.min(window.y + window.height - y),
            };
            let pixels = render_tile(&world, camera, settings, lightings, tile, buffers, &stop)?;
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if progress(Progress { done, total }).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
            Some((tile, pixels))
        })
        .collect();

    let mut films = vec![Film::new(settings.size, window); lightings.len()];
    for (tile, pictures) in tiles.into_iter().flatten() {
        for (film, pixels) in films.iter_mut().zip(&pictures) {
            film.paste(tile, pixels);
        }
    }
    let done = done.into_inner();
    if done < total { Err(ReferenceError::Cancelled { done, total, films }) } else { Ok(films) }
}

fn no_lighting() -> ReferenceError {
    ReferenceError::Setting { field: "lightings".into(), reason: "there is none".into() }
}

/// Asks for single samples of pictures, and not for pictures.
pub(crate) struct Judge<'a>(World<'a>);

impl<'a> Judge<'a> {
    /// For pictures of `size` pixels of a scene.
    pub(crate) fn new(scene: &'a Scene, camera: &Camera, size: [u32; 2]) -> Result<Self, ReferenceError> {
        let memory = ReferenceSettings::default().memory;
        World::new(scene, Fineness::of_pixel(camera, size[1], FLATNESS), memory).map(Self)
    }

    /// A sample of each of `pixels`: how many of them see anything, and their radiance under each of `lightings`.
    pub(crate) fn samples_under(
        &self,
        camera: &Camera,
        size: [u32; 2],
        pixels: &[[u32; 2]],
        lightings: &[Lighting],
    ) -> (usize, Vec<Vec<Vec3>>) {
        let Buffers { mut stream, mut shader, mut queries } = Buffers::default();
        let settings = ReferenceSettings { size, ..ReferenceSettings::default() };
        ask(&mut queries, camera, &settings, pixels, 0..1);
        // Told apart by their places, since one pixel may be asked for twice.
        let places: Vec<[u32; 2]> = (0..pixels.len() as u32).map(|i| [i, 0]).collect();
        let seen = look(&self.0, &mut stream, &mut queries, &places, 0..1);
        let under = |lighting| {
            let each = shader.light(&self.0, &mut stream, lighting, settings.seed, settings.shadows, &seen);
            let mut radiance = vec![Vec3::ZERO; pixels.len()];
            seen.iter().zip(each).for_each(|(seen, of_it)| radiance[seen.pixel[0] as usize] = of_it);
            radiance
        };
        (seen.len(), lightings.iter().map(under).collect())
    }
}

/// The rays through samples of pixels, sample by sample.
fn ask(
    queries: &mut Vec<Query>,
    camera: &Camera,
    settings: &ReferenceSettings,
    pixels: &[[u32; 2]],
    samples: Range<u32>,
) {
    queries.clear();
    for sample in samples {
        for &pixel in pixels {
            let point = Points::new(pixel, settings.seed, Use::Pixel).get(sample);
            let corner = Vec2::new(pixel[0] as f32, pixel[1] as f32);
            let (ray, _) = camera.cone(corner + point, settings.size);
            let flight = flight(pixel, settings.seed, Use::Pixel, sample);
            queries.push(Query { ray, end: f64::INFINITY, flight, hit: None });
        }
    }
}

/// What a thread reuses from tile to tile.
#[derive(Default)]
struct Buffers {
    stream: Stream,
    shader: Shader,
    queries: Vec<Query>,
}

/// The pixels of a tile, row by row, under each lighting; `None` if asked to stop.
fn render_tile(
    world: &World,
    camera: &Camera,
    settings: &ReferenceSettings,
    lightings: &[Lighting],
    tile: Rect,
    buffers: &mut Buffers,
    stop: &AtomicBool,
) -> Option<Vec<Vec<Pixel>>> {
    let pixels: Vec<[u32; 2]> =
        (0..tile.area() as u32).map(|i| [tile.x + i % tile.width, tile.y + i / tile.width]).collect();
    let in_tile = |[x, y]: [u32; 2]| ((y - tile.y) * tile.width + x - tile.x) as usize;
    let mut sums = vec![vec![DVec3::ZERO; pixels.len()]; lightings.len()];
    let mut depths = vec![Vec::new(); pixels.len()];
    let together = (TOGETHER / pixels.len()).max(1) as u32;
    let mut begin = 0;
    while begin < settings.samples {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let samples = begin..settings.samples.min(begin.saturating_add(together));
        begin = samples.end;
        let Buffers { stream, shader, queries } = buffers;
        ask(queries, camera, settings, &pixels, samples.clone());
        let seen: Vec<Seen> = look(world, stream, queries, &pixels, samples);
        for s in &seen {
            depths[in_tile(s.pixel)].push(s.depth(camera));
        }
        for (sums, lighting) in sums.iter_mut().zip(lightings) {
            let radiance = shader.light(world, stream, lighting, settings.seed, settings.shadows, &seen);
            for (s, radiance) in seen.iter().zip(radiance) {
                sums[in_tile(s.pixel)] += radiance.as_dvec3();
            }
        }
    }
    let share = f64::from(settings.samples).recip();
    let seen: Vec<(f32, f32)> = depths
        .into_iter()
        .map(|mut depths| {
            let alpha = depths.len() as f32 * share as f32;
            let half = depths.len().div_ceil(2).saturating_sub(1);
            depths.sort_unstable_by(f32::total_cmp);
            (alpha, depths.get(half).copied().unwrap_or(f32::INFINITY))
        })
        .collect();
    let picture = |sums: Vec<DVec3>| {
        let pixels = sums.iter().zip(&seen);
        pixels.map(|(sum, &(alpha, depth))| Pixel { color: (share * *sum).as_vec3(), alpha, depth }).collect()
    };
    Some(sums.into_iter().map(picture).collect())
}
