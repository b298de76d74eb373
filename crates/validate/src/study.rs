//! A scene validated: cone pictures against the reference, at every distance and under every light.

use std::time::Instant;

use pelage::compile::Prepared;
use pelage::output::Display;
use pelage::tracer::reference::{ReferenceError, ReferenceSettings};
use pelage::tracer::{Film, RenderError, SceneError};
use serde::Serialize;

use crate::flicker::flicker;
use crate::flip::{FlipMap, NORMAL_PPD, flip};
use crate::goals::{Goals, Miss};
use crate::measures::{MeasureError, mean_alpha, mean_radiance};
use crate::noise::{Halves, Worth};
use crate::rendering::{Rendering, push};
use crate::sight::{Sight, SightError};
use crate::station::{Distance, Station};
use crate::suns::Lights;

/// What a validation does.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The most pixels a side of what is rendered at each distance.
    pub size: u32,
    /// Samples a pixel of the reference, in two independent halves; 4 to 65536, even.
    pub samples: u32,
    /// From how far.
    pub distances: Vec<Distance>,
    /// Under which light.
    pub lights: Lights,
    /// Pixels a degree of the eye, for FLIP.
    pub ppd: f32,
    /// What is to be reached; `None` takes [`Goals::FUR`] where any texel is fur and [`Goals::STANDARD`] elsewhere.
    pub goals: Option<Goals>,
    /// Frames of the zoom that flicker is measured over; fewer than 2 leave it out.
    pub frames: u32,
    /// Bytes that the reference renderer may take for the explicit content.
    pub memory: u64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            size: 72,
            samples: 128,
            distances: Distance::STANDARD.to_vec(),
            lights: Lights::Standard,
            ppd: NORMAL_PPD,
            goals: None,
            frames: 6,
            memory: ReferenceSettings::default().memory,
        }
    }
}

/// Why a scene cannot be validated.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// There is nothing to look at.
    #[error(transparent)]
    Sight(#[from] SightError),
    /// There is no reference.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// There is no cone picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A light cannot be used.
    #[error(transparent)]
    Light(#[from] SceneError),
    /// Pictures that should be alike are not.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

/// What was found out about a scene. Its JSON keys are kept.
#[derive(Serialize)]
pub struct Study {
    /// What it is called.
    pub scene: String,
    /// What was to be reached.
    pub goals: Goals,
    /// Samples a pixel of the reference.
    pub samples: u32,
    /// Pixels a degree of the eye, for FLIP.
    pub ppd: f32,
    /// What radiance was multiplied by to be shown.
    pub exposure: f32,
    /// One for each distance.
    pub distances: Vec<Found>,
    /// Goals that were missed, in all.
    pub misses: usize,
    /// How long it took.
    pub seconds: f64,
}

/// What was found at one distance.
#[derive(Serialize)]
pub struct Found {
    /// `near`, or how many pixels wide a box was asked to be, `h` for halfway between two levels; `=` between two that
    /// come to the same.
    pub distance: String,
    /// How many pixels wide the median box is at the target.
    pub box_pixels: f32,
    /// The continuous level that is read at the target: voxels a side are 2^level.
    pub level: f32,
    /// Columns and rows that were compared.
    pub window: [u32; 2],
    /// Pictures of so many pixels, one under another, each from a part of a pixel aside: far away there are few pixels.
    pub looks: usize,
    /// Mean alpha of the cone picture over that of the reference, less 1; `None` where the reference is empty.
    pub alpha_bias: Option<f64>,
    /// One for each light.
    pub lights: Vec<Cell>,
    /// Goals of the distance itself that were missed.
    pub misses: Vec<Miss>,
}

/// What was found at one distance under one light.
#[derive(Serialize)]
pub struct Cell {
    /// Which light.
    pub light: &'static str,
    /// (Mean radiance − the reference's) / the reference's, or for light from behind / the larger of that and the
    /// reference's under the light from the side; `None` where that is black.
    pub energy_error: Option<f64>,
    /// Root mean square error, the noise of the reference subtracted.
    pub rmse: f64,
    /// Mean FLIP, the noise of the reference included.
    pub flip: f64,
    /// At how many samples the reference renderer errs as much; `None` where its samples do not vary.
    pub worth: Option<Worth>,
    /// Flicker over a slow zoom, in radiance; `None` if it was left out.
    pub flicker: Option<f64>,
    /// Flicker of the reference renderer at 16 samples over the same zoom.
    pub flicker_of_16: Option<f64>,
    /// Goals that were missed.
    pub misses: Vec<Miss>,
    /// Cone picture, reference, and what a person sees of their difference.
    #[serde(skip)]
    pub pictures: Pictures,
}

/// The pictures of a cell.
pub struct Pictures {
    /// By the cone tracer.
    pub cone: Film,
    /// By the reference renderer.
    pub reference: Film,
    /// FLIP of one against the other.
    pub map: FlipMap,
    /// How they are shown.
    pub display: Display,
}

/// Validates `prepared`, called `name`. `progress` is told the fraction done.
///
/// The scene's light is what it was before when this returns, its light other than [`Lights::Scene`] in between.
///
/// # Errors
/// [`StudyError`].
pub fn study(
    name: &str,
    prepared: &mut Prepared,
    plan: &Plan,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Study, StudyError> {
    let own = prepared.scene.lighting();
    let result = study_under(name, prepared, plan, progress);
    prepared.scene.set_lighting(own)?;
    result
}

fn study_under(
    name: &str,
    prepared: &mut Prepared,
    plan: &Plan,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Study, StudyError> {
    let begun = Instant::now();
    let sight = Sight::of(prepared)?;
    let situations = plan.lights.situations(&prepared.scene, &sight, prepared.camera.orientation.y_axis);
    let display = plan.lights.display(&prepared.display, &situations, sight.target);
    let mut texels = prepared.scene.coats().iter().flat_map(|coat| &coat.texels.texels);
    let furry = texels.any(|(texel, _)| texel.name.contains("fur"));
    let goals = plan.goals.unwrap_or(if furry { Goals::FUR } else { Goals::STANDARD });
    let mut rendering = Rendering { prepared, plan, situations: &situations };
    let mut stations: Vec<(String, Distance, Station)> = Vec::new();
    for &distance in &plan.distances {
        let station = Station::at(distance, &sight, rendering.prepared, plan.size);
        match stations.iter_mut().find(|(_, _, other)| other.is_like(&station)) {
            Some((name, _, _)) => *name = format!("{name}={distance}"),
            None => stations.push((distance.to_string(), distance, station)),
        }
    }
    let mut distances = Vec::new();
    let count = stations.len() as f32;
    for (i, (name, distance, station)) in stations.into_iter().enumerate() {
        let part = |f: f32| progress((i as f32 + f) / count);
        let judged = judge(&mut rendering, &station, &goals, &display, &|f| part(0.8 * f))?;
        let mut found = Found { distance: name, ..judged };
        if plan.frames > 1 {
            // A quarter of the pixels: they are many enough over all frames.
            let zoom = station.zoom(plan.frames, distance, &sight, rendering.prepared, plan.size.div_ceil(2));
            let measured = flickers(&mut rendering, &zoom, &|f| part(0.8 + 0.2 * f))?;
            for (cell, (cone, of_16)) in found.lights.iter_mut().zip(measured) {
                (cell.flicker, cell.flicker_of_16) = (Some(cone), Some(of_16));
                cell.misses.extend(Miss::over("flicker", cone, goals.flicker * of_16));
            }
        }
        distances.push(found);
    }
    let misses =
        |found: &Found| found.misses.len() + found.lights.iter().map(|c| c.misses.len()).sum::<usize>();
    Ok(Study {
        scene: name.to_owned(),
        goals,
        samples: plan.samples,
        ppd: plan.ppd,
        exposure: display.exposure,
        misses: distances.iter().map(misses).sum(),
        distances,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

/// Samples of the reference renderer whose errors are measured, as far as they are well below those of the reference.
const LADDER: [u32; 5] = [1, 4, 16, 64, 256];

/// Samples that flicker is compared with.
const FLICKER_SAMPLES: u32 = 16;

/// How many times fewer samples the references of a zoom's frames have: what noise adds is subtracted.
const FRAME_SAVING: u32 = 4;

/// Everything at one distance but its name and flicker.
fn judge(
    rendering: &mut Rendering,
    station: &Station,
    goals: &Goals,
    display: &Display,
    progress: &dyn Fn(f32),
) -> Result<Found, StudyError> {
    let plan = rendering.plan;
    let cones = rendering.cones(station)?;
    progress(0.1);
    let references = rendering.references(station, plan.samples, 0)?;
    progress(0.7);
    let mut ladder = vec![Vec::new(); cones.len()];
    for (seed, samples) in (2..).zip(LADDER).filter(|&(_, n)| 4 * n < plan.samples) {
        let films = rendering.reference(station, samples, seed)?;
        for (rungs, (film, reference)) in ladder.iter_mut().zip(films.iter().zip(&references)) {
            rungs.push((samples, reference.square_error(film)));
        }
    }
    for (rungs, reference) in ladder.iter_mut().zip(&references) {
        // One of the halves has twice the variance of their mean.
        rungs.push((plan.samples / 2, 2.0 * reference.variance()));
    }
    progress(1.0);

    let (alpha, alpha_reference) = match (cones.first(), references.first()) {
        (Some(cone), Some(reference)) => (mean_alpha(cone), mean_alpha(&reference.mean)),
        _ => (0.0, 0.0),
    };
    let alpha_bias = (alpha_reference > 0.0).then(|| alpha / alpha_reference - 1.0);
    let energies: Vec<f64> = references.iter().map(|r| mean_radiance(&r.mean)).collect();
    let mut cells = Vec::new();
    for (i, (cone, reference)) in cones.into_iter().zip(references).enumerate() {
        let situation = &rendering.situations[i];
        let judge = situation.judged_by.map_or(energies[i], |other| energies[i].max(energies[other]));
        let energy_error = (judge > 0.0).then(|| (mean_radiance(&cone) - energies[i]) / judge);
        let map = flip(&cone, &reference.mean, display, plan.ppd)?;
        let error = reference.square_error(&cone);
        // Twice the standard error of a mean of squares over as many pixels.
        let floor = reference.variance() * (8.0 / cone.pixels.len() as f64).sqrt();
        let worth = Worth::of(error, &ladder[i], floor);
        let width = station.box_pixels;
        let misses = [
            energy_error.and_then(|e| Miss::over("energy", e.abs(), goals.energy(width))),
            Miss::over("flip", map.mean(), goals.flip),
            worth.and_then(|w| Miss::under("samples", w.samples, goals.samples(width))),
        ];
        cells.push(Cell {
            light: situation.name,
            energy_error,
            rmse: error.max(0.0).sqrt(),
            flip: map.mean(),
            worth,
            flicker: None,
            flicker_of_16: None,
            misses: misses.into_iter().flatten().collect(),
            pictures: Pictures { cone, reference: reference.mean, map, display: *display },
        });
    }
    let miss = alpha_bias.and_then(|bias| Miss::over("alpha", bias.abs(), goals.alpha_bias));
    Ok(Found {
        distance: String::new(),
        box_pixels: station.box_pixels,
        level: station.level,
        window: [station.crop.width, station.crop.height],
        looks: station.looks().len(),
        alpha_bias,
        lights: cells,
        misses: miss.into_iter().collect(),
    })
}

/// Flicker over a zoom under each light: of the cone pictures, and of the reference renderer at 16 samples.
fn flickers(
    rendering: &mut Rendering,
    zoom: &[Station],
    progress: &dyn Fn(f32),
) -> Result<Vec<(f64, f64)>, StudyError> {
    let count = rendering.situations.len();
    let [mut cones, mut of_16] = [vec![Vec::new(); count], vec![Vec::new(); count]];
    let mut references: Vec<Vec<Halves>> = (0..count).map(|_| Vec::new()).collect();
    let samples = (rendering.plan.samples / FRAME_SAVING).max(2 * FLICKER_SAMPLES);
    for (k, frame) in zoom.iter().enumerate() {
        // New seeds for each frame, as in a film.
        let seed = 16 + 4 * k as u32;
        push(&mut cones, rendering.cones(frame)?);
        push(&mut references, rendering.references(frame, samples, seed)?);
        push(&mut of_16, rendering.reference(frame, FLICKER_SAMPLES, seed + 2)?);
        progress((k + 1) as f32 / zoom.len() as f32);
    }
    let measured = cones.iter().zip(&of_16).zip(&references);
    Ok(measured
        .map(|((cone, of_16), reference)| (flicker(cone, reference), flicker(of_16, reference)))
        .collect())
}
