//! Films to picture files. A file appears whole or not at all.

mod aov;
mod exr;
mod png;

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::Vec3;
use pelage_tracer::Film;

pub use aov::{Aov, false_color};
pub use exr::{ExrOptions, write_exr, write_exr_with};
pub use png::{encode_png, write_png};

use crate::import::extension;

/// The picture formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB with straight alpha: to look at.
    Png,
    /// 32-bit linear radiance with premultiplied alpha and depth: to work on.
    Exr,
}

/// Why a picture was not written. The file of that name is what it was before.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The name ends in no known extension.
    #[error("{}: unknown picture format: expected .png or .exr", path.display())]
    Extension {
        /// The name asked for.
        path: PathBuf,
    },
    /// A folder stands there.
    #[error("{}: is a folder", path.display())]
    Folder {
        /// The name asked for.
        path: PathBuf,
    },
    /// The system refused, or the disk is full.
    #[error("{}: cannot be written: {source}", path.display())]
    Io {
        /// The name asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// What is to be written beside the film is not of its size.
    #[error("the layers have {pixels} pixels beside a film of {expected}")]
    Layers {
        /// How many pixels they hold.
        pixels: usize,
        /// How many the film has.
        expected: usize,
    },
    /// The film has not as many pixels as its window, or none.
    #[error("the film has {pixels} pixels for a window of {width}x{height}")]
    Film {
        /// How many pixels it holds.
        pixels: usize,
        /// Columns of the window.
        width: u32,
        /// Rows of the window.
        height: u32,
    },
}

/// How radiance becomes what a screen shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// What radiance is multiplied by first.
    pub exposure: f32,
    /// The curve that follows.
    pub tone: Tone,
}

impl Default for Display {
    fn default() -> Self {
        Self { exposure: 1.0, tone: Tone::Filmic }
    }
}

/// How what is brighter than the screen is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Cut off at 1.
    None,
    /// Unchanged up to 0.4, mid-grey included; above, a shoulder that nears 1 and never reaches it:
    /// y = 1 − 0.6 e^−(x − 0.4)/0.6, of the same value and slope at 0.4.
    #[default]
    Filmic,
}

impl Tone {
    const KNEE: f32 = 0.4;

    /// The curve at `x ≥ 0`, into `[0,1]`.
    pub fn apply(self, x: f32) -> f32 {
        match self {
            Self::Filmic if x > Self::KNEE => {
                let room = 1.0 - Self::KNEE;
                1.0 - room * (-(x - Self::KNEE) / room).exp()
            }
            _ => x.clamp(0.0, 1.0),
        }
    }

    /// The `x` at which the curve has the value `y` in `[0,1]`; finite even for 1.
    pub fn invert(self, y: f32) -> f32 {
        match self {
            Self::Filmic if y > Self::KNEE => {
                let room = 1.0 - Self::KNEE;
                // Half of an 8-bit step below 1, where the curve has no end.
                let left = (1.0 - y).max(0.5 / 255.0);
                Self::KNEE - room * (left / room).ln()
            }
            _ => y.clamp(0.0, 1.0),
        }
    }
}

impl Display {
    /// The linear value that a screen shows for `radiance`.
    pub fn show(&self, radiance: Vec3) -> Vec3 {
        (radiance * self.exposure).map(|x| if x > 0.0 { self.tone.apply(x) } else { 0.0 })
    }

    /// The sRGB bytes that a screen gets for `radiance`. [IEC 61966-2-1]
    pub fn srgb(&self, radiance: Vec3) -> [u8; 3] {
        self.show(radiance).to_array().map(|x| png::byte(png::linear_to_srgb(x)))
    }

    /// The radiance for which a screen shows the linear value `shown`.
    pub fn radiance_of(&self, shown: Vec3) -> Vec3 {
        shown.map(|y| self.tone.invert(y)) / self.exposure.max(f32::MIN_POSITIVE)
    }
}

/// The format that a file's name asks for, if the file could be created: for asking before a long rendering.
///
/// # Errors
/// An unknown extension, a folder of that name, or a folder that cannot be written to.
pub fn check_output(path: &Path) -> Result<Format, OutputError> {
    let format = match extension(path).as_str() {
        "png" => Format::Png,
        "exr" => Format::Exr,
        _ => return Err(OutputError::Extension { path: path.to_owned() }),
    };
    check_place(path)?;
    Ok(format)
}

/// Whether a file of this name, of any kind, could be created.
///
/// # Errors
/// A folder of that name, or a folder that cannot be written to.
pub fn check_place(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(OutputError::Folder { path: path.to_owned() });
    }
    let temporary = temporary(path);
    let tried = create(&temporary).and_then(|_| fs::remove_file(&temporary));
    tried.map_err(|source| OutputError::Io { path: path.to_owned(), source })
}

/// Writes a file beside `path`, makes sure that it is on the disk, and gives it the name: it appears whole or not
/// at all.
///
/// # Errors
/// What the system says; a file of that name is then what it was before.
pub fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let temporary = temporary(path);
    let attempt = || {
        let mut file = BufWriter::new(create(&temporary)?);
        write(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&temporary, path)
    };
    attempt().map_err(|source| {
        // Gone already if it could not be created; there is no more to be done about it here.
        let _ = fs::remove_file(&temporary);
        OutputError::Io { path: path.to_owned(), source }
    })
}

fn create(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// A name beside `path` that no other process uses.
fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

fn check(film: &Film) -> Result<(), OutputError> {
    let (pixels, width, height) = (film.pixels.len(), film.window.width, film.window.height);
    if pixels == 0 || pixels != film.window.area() {
        return Err(OutputError::Film { pixels, width, height });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shoulder_keeps_mid_grey_and_joins_smoothly() {
        let tone = Tone::Filmic;
        assert_eq!(tone.apply(0.18), 0.18);
        // Value and slope at the knee: (y(0.4 + h) − 0.4) / h → 1.
        let h = 1e-3;
        assert!((tone.apply(0.4 + h) - 0.4 - h).abs() < h * h);
        // 1 − 0.6 e^−1 = 0.779272…
        assert!((tone.apply(1.0) - 0.779_272_3).abs() < 1e-6);
        assert!(tone.apply(1e30) <= 1.0);
    }

    #[test]
    fn what_is_shown_can_be_asked_for() {
        for tone in [Tone::None, Tone::Filmic] {
            let display = Display { exposure: 2.5, tone };
            let shown = Vec3::new(0.02, 0.4, 0.9);
            assert!((display.show(display.radiance_of(shown)) - shown).abs().max_element() < 1e-6);
            assert!(display.radiance_of(Vec3::ONE).is_finite());
        }
    }
}
