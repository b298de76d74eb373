//! Colour images: PNG, JPEG and Radiance HDR to linear textures. The only room that decodes pictures.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::LazyLock;

use glam::Vec3;
use image::{DynamicImage, ImageReader, Limits};
use pelage_geom::{Texture, TextureId};

use super::{Fault, Files};

/// The textures of one import: each image is decoded once, however many materials name it.
#[derive(Default)]
pub(crate) struct Textures {
    pub(crate) list: Vec<Texture>,
    /// What is wrong is kept too, so that it is not found out again for each material.
    by_path: HashMap<PathBuf, Result<TextureId, String>>,
    alpha_by_path: HashMap<PathBuf, Result<Option<TextureId>, String>>,
    pixels: u64,
}

impl Textures {
    /// The texture in the file that `reference` leads to.
    pub(crate) fn open(&mut self, reference: &str, files: &Files) -> Result<TextureId, Fault> {
        let path = files.resolve(reference)?;
        if let Some(known) = self.by_path.get(&path) {
            return known.clone().map_err(Fault::Syntax);
        }
        let decoded = files.read(&path).and_then(|bytes| self.decode(&bytes, files));
        self.by_path.insert(path, decoded.as_ref().map(|&id| id).map_err(ToString::to_string));
        decoded
    }

    /// The numbers in the file that `reference` leads to, from 0 to 1, which are not light: for masks.
    pub(crate) fn open_values(&self, reference: &str, files: &Files) -> Result<Texture, Fault> {
        let path = files.resolve(reference)?;
        let image = self.read(&files.read(&path)?, files)?.to_rgb32f();
        let (width, height) = image.dimensions();
        let pixels = image.pixels().map(|c| Vec3::from(c.0).map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 }));
        Texture::new(width as usize, height as usize, pixels.collect())
            .ok_or_else(|| Fault::Syntax("the image has no pixels".into()))
    }

    /// The alpha, else the brightness, in the file that `reference` leads to; `None` where all is opaque.
    pub(crate) fn open_alpha(&mut self, reference: &str, files: &Files) -> Result<Option<TextureId>, Fault> {
        let path = files.resolve(reference)?;
        if let Some(known) = self.alpha_by_path.get(&path) {
            return known.clone().map_err(Fault::Syntax);
        }
        let decoded = files.read(&path).and_then(|bytes| self.decode_alpha(&bytes, files, true));
        self.alpha_by_path.insert(path, decoded.as_ref().map(|&id| id).map_err(ToString::to_string));
        decoded
    }

    /// The texture in an image file's bytes.
    pub(crate) fn decode(&mut self, bytes: &[u8], files: &Files) -> Result<TextureId, Fault> {
        let image = self.read(bytes, files)?;
        let [width, height] = [image.width(), image.height()];
        self.add(width, height, linear(image))
    }

    /// The alpha of an image, as a grey texture: its alpha channel, or how bright it is where it has none and
    /// `or_brightness` asks for that. `None` where there is neither, or where all is opaque.
    pub(crate) fn decode_alpha(
        &mut self,
        bytes: &[u8],
        files: &Files,
        or_brightness: bool,
    ) -> Result<Option<TextureId>, Fault> {
        let image = self.read(bytes, files)?;
        let [width, height] = [image.width(), image.height()];
        let alpha: Vec<f32> = if image.color().has_alpha() {
            image.to_rgba32f().pixels().map(|c| c.0[3].clamp(0.0, 1.0)).collect()
        } else if or_brightness {
            image.to_luma32f().pixels().map(|c| c.0[0].clamp(0.0, 1.0)).collect()
        } else {
            return Ok(None);
        };
        if alpha.iter().all(|&a| a == 1.0) {
            return Ok(None);
        }
        self.add(width, height, alpha.into_iter().map(Vec3::splat).collect()).map(Some)
    }

    /// Keeps a texture.
    fn add(&mut self, width: u32, height: u32, pixels: Vec<Vec3>) -> Result<TextureId, Fault> {
        let texture = Texture::new(width as usize, height as usize, pixels)
            .ok_or_else(|| Fault::Syntax("the image has no pixels".into()))?;
        self.pixels += u64::from(width) * u64::from(height);
        self.list.push(texture);
        Ok(TextureId(self.list.len() as u32 - 1))
    }

    /// Decodes an image, if it and all so far are not too large.
    fn read(&self, bytes: &[u8], files: &Files) -> Result<DynamicImage, Fault> {
        let syntax = |e: image::ImageError| Fault::Syntax(format!("the image cannot be decoded: {e}"));
        let reader = || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(Fault::Io);
        let (width, height) = reader()?.into_dimensions().map_err(syntax)?;
        let pixels = u64::from(width) * u64::from(height);
        let cap = |what, found, limit| {
            if found > limit { Err(Fault::Limit { what, found, limit }) } else { Ok(()) }
        };
        cap("pixels of the image", pixels, files.limits.image_pixels)?;
        cap("pixels of all images", self.pixels + pixels, files.limits.total_pixels)?;
        let mut reader = reader()?;
        let mut limits = Limits::default();
        // At most 16 bytes a pixel, twice over for what a decoder keeps beside its result.
        limits.max_alloc = Some(32 * pixels + (1 << 20));
        reader.limits(limits);
        reader.decode().map_err(syntax)
    }
}

/// Linear Rec. 709 pixels. Integer formats hold sRGB, floating ones are linear already. Alpha is dropped.
fn linear(image: DynamicImage) -> Vec<Vec3> {
    match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            // An infinite or negative radiance would poison every mean that it enters.
            let tame =
                |c: &image::Rgb<f32>| Vec3::from(c.0).map(|x| if x > 0.0 { x.min(65504.0) } else { 0.0 });
            image.to_rgb32f().pixels().map(tame).collect()
        }
        DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)
        | DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_) => image
            .to_rgb16()
            .pixels()
            .map(|c| Vec3::from(c.0.map(|x| srgb_to_linear(f32::from(x) / 65535.0))))
            .collect(),
        _ => image.to_rgb8().pixels().map(|c| Vec3::from(c.0.map(|x| SRGB[usize::from(x)]))).collect(),
    }
}

static SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// The sRGB transfer function's inverse, over `[0,1]`. [IEC 61966-2-1]
pub fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
