//! A station's pictures under every light, by the cone tracer and by the reference renderer.

use std::ops::ControlFlow;

use pelage::compile::Prepared;
use pelage::tracer::reference::{Lighting, ReferenceSettings, render_under};
use pelage::tracer::{Camera, Film, Rect, Settings, render};

use crate::noise::Halves;
use crate::station::Station;
use crate::study::{Plan, StudyError};
use crate::suns::Situation;

/// More seeds than one look uses.
const SEEDS: u32 = 1 << 16;

/// Renders a scene under several lights.
pub(crate) struct Rendering<'a> {
    pub prepared: &'a mut Prepared,
    pub plan: &'a Plan,
    pub situations: &'a [Situation],
}

impl Rendering<'_> {
    /// The cone picture under each light.
    pub fn cones(&mut self, station: &Station) -> Result<Vec<Film>, StudyError> {
        let settings = Settings {
            size: station.size,
            crop: Some(station.crop),
            shadows: true,
            ..self.prepared.settings
        };
        let mut films = Vec::new();
        for situation in self.situations {
            self.prepared.scene.set_lighting(situation.lighting.clone())?;
            let go_on = |_| ControlFlow::Continue(());
            let look = |camera: &Camera| render(&self.prepared.scene, camera, &settings, &go_on);
            let looks = station.looks().iter().map(look).collect::<Result<Vec<_>, _>>()?;
            films.push(stacked(&looks));
        }
        Ok(films)
    }

    /// The reference with so many samples under each light.
    pub fn reference(&self, station: &Station, samples: u32, seed: u32) -> Result<Vec<Film>, StudyError> {
        let settings = |seed| ReferenceSettings {
            size: station.size,
            crop: Some(station.crop),
            samples,
            seed,
            shadows: true,
            memory: self.plan.memory,
        };
        let lightings: Vec<Lighting> = self.situations.iter().map(|s| s.lighting.clone()).collect();
        let go_on = |_| ControlFlow::Continue(());
        let mut looks = vec![Vec::new(); lightings.len()];
        for (k, camera) in (0..).zip(station.looks()) {
            // Seeds of other looks stay clear of those of other films.
            let settings = settings(seed + SEEDS * k);
            push(&mut looks, render_under(&self.prepared.scene, &camera, &settings, &lightings, &go_on)?);
        }
        Ok(looks.iter().map(|looks| stacked(looks)).collect())
    }

    /// The reference under each light, in two halves of the seeds `seed` and `seed + 1`.
    pub fn references(&self, station: &Station, samples: u32, seed: u32) -> Result<Vec<Halves>, StudyError> {
        let half = (samples / 2).max(1);
        let [first, second] = [seed, seed + 1].map(|seed| self.reference(station, half, seed));
        Ok(first?.into_iter().zip(second?).map(|(a, b)| Halves::new(a, b)).collect())
    }
}

/// Films of the same window, one under another.
fn stacked(films: &[Film]) -> Film {
    let Rect { width, height, .. } = films.first().map_or(Rect::whole([0, 0]), |film| film.window);
    let size = [width, height * films.len() as u32];
    let pixels = films.iter().flat_map(|film| &film.pixels).copied().collect();
    Film { size, window: Rect::whole(size), pixels }
}

/// Adds a frame to each sequence.
pub(crate) fn push<T>(sequences: &mut [Vec<T>], frames: Vec<T>) {
    for (sequence, frame) in sequences.iter_mut().zip(frames) {
        sequence.push(frame);
    }
}
