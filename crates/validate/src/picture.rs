//! Pictures read back from files, PNG and OpenEXR, as films.

use std::fs;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use glam::Vec3;
use image::{ImageFormat, ImageReader, Limits};
use pelage::import::srgb_to_linear;
use pelage::tracer::{Film, Pixel, Rect};

/// The largest picture that is read, in pixels: a comparison holds some ten copies of it.
pub const MAX_PIXELS: u64 = 32 << 20;

/// The largest file that is read, in bytes.
const MAX_BYTES: u64 = 1 << 30;

/// What the numbers of a picture file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// What a screen shows, in sRGB: exposed already (PNG).
    Display,
    /// Linear radiance (OpenEXR).
    Radiance,
}

/// A picture file read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear and premultiplied, whichever the file; without depth.
    pub film: Film,
    /// What the file's own numbers are.
    pub encoding: Encoding,
}

/// A picture file that cannot be read. The message is one line: file, reason.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct PictureError {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a picture file.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The system would not let us read it.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// A folder, a device or a pipe.
    #[error("is not a regular file")]
    NotRegular,
    /// The name ends in no known extension.
    #[error("unknown picture format: expected .png or .exr")]
    Extension,
    /// There is more of something than is read.
    #[error("{found} {what}; {limit} is the most")]
    Limit {
        /// What there is too much of.
        what: &'static str,
        /// How much there is.
        found: u64,
        /// The most.
        limit: u64,
    },
    /// The format's own rules are broken.
    #[error("the picture cannot be decoded: {0}")]
    Syntax(String),
    /// The data window lies outside of the display window.
    #[error("no pixel of its data window lies in its display window")]
    Nothing,
    /// A NaN or an infinity, which would be the whole of every mean.
    #[error("the pixel at column {x} and row {y} is not finite")]
    NotFinite {
        /// Its column.
        x: u32,
        /// Its row.
        y: u32,
    },
}

impl Picture {
    /// Reads a `.png` (8 or 16 bits, sRGB, straight alpha) or an `.exr` (linear, premultiplied; its first layer with
    /// the channels R, G, B and perhaps A).
    ///
    /// The display window of an OpenEXR file is the whole picture, its data window what the film holds of it.
    ///
    /// # Errors
    /// [`PictureError`]; among them pixels that are not finite, and more than [`MAX_PIXELS`].
    pub fn open(path: &Path) -> Result<Self, PictureError> {
        Self::read(path).map_err(|fault| PictureError { path: path.to_owned(), fault })
    }

    fn read(path: &Path) -> Result<Self, Fault> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let decode = match extension.as_str() {
            "png" => decode_png,
            "exr" => decode_exr,
            _ => return Err(Fault::Extension),
        };
        let about = fs::metadata(path)?;
        if !about.is_file() {
            return Err(Fault::NotRegular);
        }
        at_most("bytes", about.len(), MAX_BYTES)?;
        let picture = decode(&fs::read(path)?)?;
        let Film { window, pixels, .. } = &picture.film;
        let finite = |pixel: &Pixel| pixel.color.is_finite() && pixel.alpha.is_finite();
        match pixels.iter().position(|pixel| !finite(pixel)) {
            Some(i) => {
                let i = i as u32;
                Err(Fault::NotFinite { x: window.x + i % window.width, y: window.y + i / window.width })
            }
            None => Ok(picture),
        }
    }
}

/// The part `window` of what a film holds; `None` if it does not hold all of that, or it is nothing.
pub fn part(film: &Film, window: Rect) -> Option<Film> {
    let Rect { x, y, width, height } = window;
    let (last_x, last_y) = (x.checked_add(width.checked_sub(1)?)?, y.checked_add(height.checked_sub(1)?)?);
    film.get(x, y).and(film.get(last_x, last_y))?;
    let pixels = (y..=last_y).flat_map(|y| (x..=last_x).filter_map(move |x| film.get(x, y).copied()));
    Some(Film { size: film.size, window, pixels: pixels.collect() })
}

fn at_most(what: &'static str, found: u64, limit: u64) -> Result<(), Fault> {
    if found > limit { Err(Fault::Limit { what, found, limit }) } else { Ok(()) }
}

/// One line of what a decoder says.
fn syntax(error: impl ToString) -> Fault {
    Fault::Syntax(error.to_string().lines().next().unwrap_or_default().to_owned())
}

fn decode_png(bytes: &[u8]) -> Result<Picture, Fault> {
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let (width, height) = reader().into_dimensions().map_err(syntax)?;
    let pixels = u64::from(width) * u64::from(height);
    at_most("pixels", pixels, MAX_PIXELS)?;
    let mut reader = reader();
    let mut limits = Limits::default();
    // At most 8 bytes a pixel, twice over for what the decoder keeps beside its result.
    limits.max_alloc = Some(16 * pixels + (1 << 20));
    reader.limits(limits);
    let image = reader.decode().map_err(syntax)?;
    let pixel = |straight: [f32; 4]| {
        let [r, g, b, alpha] = straight;
        let color = alpha * Vec3::new(r, g, b).map(srgb_to_linear);
        Pixel { color, alpha, depth: f32::INFINITY }
    };
    let pixels = image.into_rgba32f().pixels().map(|p| pixel(p.0)).collect();
    let size = [width, height];
    Ok(Picture { film: Film { size, window: Rect::whole(size), pixels }, encoding: Encoding::Display })
}

fn decode_exr(bytes: &[u8]) -> Result<Picture, Fault> {
    // The header first: a small file may ask for a large picture.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(syntax)?;
    for header in &meta.headers {
        let [data, display] = [header.layer_size, header.shared_attributes.display_window.size];
        for size in [data, display] {
            at_most("pixels", size.0 as u64 * size.1 as u64, MAX_PIXELS)?;
        }
    }
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![Pixel::EMPTY; size.area()]),
            |(width, pixels), at, (r, g, b, alpha): (f32, f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] =
                    Pixel { color: Vec3::new(r, g, b), alpha, depth: f32::INFINITY };
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(syntax)?;
    let display = image.attributes.display_window;
    let layer = image.layer_data;
    let (width, data) = layer.channel_data.pixels;
    // The data window, relative to the display window, which is the picture; cut where it reaches outside.
    let position = layer.attributes.layer_position;
    let side = |offset: i64, data: usize, whole: usize| {
        let [start, end] = [offset, offset + data as i64].map(|x| x.clamp(0, whole as i64));
        (start, end, (start - offset) as usize)
    };
    let offset = [
        i64::from(position.0) - i64::from(display.position.0),
        i64::from(position.1) - i64::from(display.position.1),
    ];
    let (x0, x1, skip_x) = side(offset[0], layer.size.0, display.size.0);
    let (y0, y1, skip_y) = side(offset[1], layer.size.1, display.size.1);
    if x0 >= x1 || y0 >= y1 {
        return Err(Fault::Nothing);
    }
    let window = Rect { x: x0 as u32, y: y0 as u32, width: (x1 - x0) as u32, height: (y1 - y0) as u32 };
    let rows = data.chunks_exact(width).skip(skip_y).take(window.height as usize);
    let pixels = rows.flat_map(|row| &row[skip_x..skip_x + window.width as usize]).copied().collect();
    let size = [display.size.0 as u32, display.size.1 as u32];
    Ok(Picture { film: Film { size, window, pixels }, encoding: Encoding::Radiance })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage::output::{Display, ExrOptions, Tone, write_exr, write_png};

    /// A window that does not begin at the corner, in radiance that bytes and floats can hold.
    fn film() -> Film {
        let window = Rect { x: 3, y: 1, width: 5, height: 4 };
        let mut film = Film::new([10, 7], window);
        for (i, pixel) in film.pixels.iter_mut().enumerate() {
            let alpha = (i % 6) as f32 / 5.0;
            *pixel = Pixel { color: alpha * Vec3::new(0.1, 0.5, 0.05 * i as f32), alpha, depth: i as f32 };
        }
        film
    }

    #[test]
    fn an_exr_comes_back_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let film = film();
        write_exr(&film, &path, &ExrOptions::default()).expect("written");
        let picture = Picture::open(&path).expect("read");
        assert_eq!((picture.encoding, picture.film.size), (Encoding::Radiance, [10, 7]));
        assert_eq!(picture.film.window, film.window);
        for (a, b) in picture.film.pixels.iter().zip(&film.pixels) {
            assert_eq!((a.color, a.alpha), (b.color, b.alpha));
        }
    }

    #[test]
    fn a_png_comes_back_to_a_byte() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let film = film();
        write_png(&film, &path, &Display { exposure: 1.0, tone: Tone::None }).expect("written");
        let picture = Picture::open(&path).expect("read");
        // A PNG holds the window alone.
        assert_eq!((picture.encoding, picture.film.size), (Encoding::Display, [5, 4]));
        for (a, b) in picture.film.pixels.iter().zip(&film.pixels) {
            // Half a step of 8 bits is .5/255 in sRGB; the curve's slope there is at most 2.4/1.055.
            let step = 0.5 / 255.0 * 2.4 / 1.055 + 1e-6;
            assert!((a.alpha - b.alpha).abs() < 1e-6);
            assert!((a.color - b.color).abs().max_element() < step, "{a:?} {b:?}");
        }
    }

    #[test]
    fn parts_of_a_film() {
        let film = film();
        let window = Rect { x: 4, y: 3, width: 4, height: 2 };
        let cut = part(&film, window).expect("inside");
        assert_eq!((cut.pixels.len(), cut.get(7, 4)), (8, film.get(7, 4)));
        for outside in [Rect { x: 2, ..window }, Rect { width: 5, ..window }, Rect { height: 0, ..window }] {
            assert!(part(&film, outside).is_none(), "{outside:?}");
        }
        assert!(part(&film, Rect { x: u32::MAX, ..window }).is_none());
    }

    #[test]
    fn files_that_are_no_pictures() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, bytes: &[u8], message: &str| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).expect("written");
            let said = Picture::open(&path).expect_err("refused").to_string();
            assert!(said.contains(message), "{said}");
            assert!(said.starts_with(&path.display().to_string()) && !said.contains('\n'), "{said}");
        };
        refused("a.gif", b"", "unknown picture format");
        refused("a.png", b"no picture", "cannot be decoded");
        refused("a.exr", b"\x76\x2f\x31\x01\x02\0\0\0", "cannot be decoded");
        // A header that asks for 10⁵ × 10⁵ pixels, with its checksum, and the beginning of no data.
        let head = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\x01\x86\xa0\0\x01\x86\xa0\x08\x06\0\0\0\xa8\x52\x0b\xc8";
        let bomb = [head.as_slice(), b"\0\0\0\0IDAT\x35\xaf\x06\x1e"].concat();
        refused("b.png", &bomb, "10000000000 pixels; 33554432 is the most");
        let mut film = film();
        film.pixels[7].color.y = f32::NAN;
        let path = folder.path().join("nan.exr");
        write_exr(&film, &path, &ExrOptions::default()).expect("written");
        let said = Picture::open(&path).expect_err("refused").to_string();
        // The third pixel of the window's second row, the window being at (3, 1).
        assert!(said.ends_with("the pixel at column 5 and row 2 is not finite"), "{said}");
        assert!(Picture::open(folder.path()).is_err());
    }
}
