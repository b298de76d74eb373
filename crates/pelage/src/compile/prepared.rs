//! A scene that can be rendered, and what becomes of its film.

use std::ops::ControlFlow;
use std::path::Path;

use glam::Vec3;
use pelage_tracer::reference::{self, ReferenceError, ReferenceSettings};
use pelage_tracer::{
    Aovs, Camera, Environment, Film, Progress, Rect, RenderError, Scene, Settings, render, render_aovs,
};

use crate::choices::Background;
use crate::compose::{Backdrop, over};
use crate::error::Error;
use crate::import::srgb_to_linear;
use crate::output::{
    Aov, Display, ExrOptions, Format, OutputError, Tone, false_color, write_exr, write_exr_with, write_png,
};

/// A scene that can be rendered.
pub struct Prepared {
    /// What is seen.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
    /// How.
    pub settings: Settings,
    /// How the explicit geometry is rendered in place of voxels, where that was asked for.
    pub reference: Option<ReferenceSettings>,
    /// How radiance is shown.
    pub display: Display,
    /// The light of the surroundings, which may be the background too.
    pub environment: Environment,
    /// What was asked to stand behind; `None` leaves it to the format.
    pub background: Option<Background>,
}

impl Prepared {
    /// Renders the film; [`render`] or [`reference::render`] with what was described.
    ///
    /// # Errors
    /// Settings out of their domain; for a reference, texels without source; a stop, with the partial film.
    pub fn render(&self, progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Result<Film, Error> {
        let Some(settings) = &self.reference else {
            return Ok(render(&self.scene, &self.camera, &self.settings, progress)?);
        };
        reference::render(&self.scene, &self.camera, settings, progress).map_err(|error| match error {
            // One kind of partial picture for both.
            ReferenceError::Cancelled { done, total, films } => {
                let empty = || Film::new(settings.size, settings.crop.unwrap_or(Rect::whole(settings.size)));
                let film = Box::new(films.into_iter().next().unwrap_or_else(empty));
                RenderError::Cancelled { done, total, film }.into()
            }
            error => error.into(),
        })
    }

    /// Writes the film, its background behind it: a PNG as a screen shows it, an EXR as linear radiance.
    ///
    /// # Errors
    /// [`OutputError`]; a file of that name is then what it was before.
    pub fn write(&self, film: &Film, path: &Path, format: Format) -> Result<(), OutputError> {
        let film = over(film, &self.camera, &self.backdrop(format));
        match format {
            Format::Png => write_png(&film, path, &self.display),
            Format::Exr => write_exr(&film, path, &ExrOptions { camera: Some(self.camera) }),
        }
    }

    /// Looks at what the picture shows besides its colour.
    ///
    /// # Errors
    /// Settings out of their domain.
    pub fn aovs(&self) -> Result<Aovs, Error> {
        Ok(render_aovs(&self.scene, &self.camera, &self.settings)?)
    }

    /// Writes the film as [`Prepared::write`] does to an EXR file, and some of `aovs` as further channels.
    ///
    /// # Errors
    /// [`OutputError`]; a file of that name is then what it was before.
    pub fn write_with(
        &self,
        film: &Film,
        aovs: &Aovs,
        wanted: &[Aov],
        path: &Path,
    ) -> Result<(), OutputError> {
        let film = over(film, &self.camera, &self.backdrop(Format::Exr));
        write_exr_with(&film, aovs, wanted, path, &ExrOptions { camera: Some(self.camera) })
    }

    /// Writes one of `aovs` in false colours, as a PNG file.
    ///
    /// # Errors
    /// [`OutputError`]; a file of that name is then what it was before.
    pub fn write_false_color(&self, aovs: &Aovs, which: Aov, path: &Path) -> Result<(), OutputError> {
        write_png(&false_color(aovs, which), path, &Display { exposure: 1.0, tone: Tone::None })
    }

    fn backdrop(&self, format: Format) -> Backdrop {
        match (self.background, format) {
            (Some(Background::Sky), _) | (None, Format::Png) => Backdrop::Sky(self.environment),
            (Some(Background::None), _) | (None, Format::Exr) => Backdrop::Transparent,
            (Some(Background::Color(srgb)), format) => {
                let linear = Vec3::from(srgb.map(|x| srgb_to_linear(f32::from(x) / 255.0)));
                Backdrop::Color(match format {
                    // So that the screen shows just this colour, whatever the exposure.
                    Format::Png => self.display.radiance_of(linear),
                    Format::Exr => linear,
                })
            }
        }
    }
}
