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

    /// The texture in an image file's bytes.
    pub(crate) fn decode(&mut self, bytes: &[u8], files: &Files) -> Result<TextureId, Fault> {
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
        let image = reader.decode().map_err(syntax)?;
        let texture = Texture::new(width as usize, height as usize, linear(image))
            .ok_or_else(|| Fault::Syntax("the image has no pixels".into()))?;
        self.pixels += pixels;
        self.list.push(texture);
        Ok(TextureId(self.list.len() as u32 - 1))
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
