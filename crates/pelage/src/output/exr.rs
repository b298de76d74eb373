//! OpenEXR: the film as it is, and what it shows besides. [EXR]

use std::io;
use std::path::Path;

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, LineOrder, Text, Vec2, WritableImage,
};
use glam::Mat4;
use pelage_tracer::{Aovs, Camera, Film, Pixel};

use super::{Aov, OutputError, check, replace};

/// What an EXR file tells besides its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExrOptions {
    /// The camera, for the attribute `worldToCamera`.
    pub camera: Option<Camera>,
}

/// Writes `film` as one part with the 32-bit channels R, G, B, A (premultiplied, linear Rec. 709 radiance) and Z
/// (depth along the view axis; infinite where there is nothing).
///
/// The display window is the whole picture, the data window the part that was rendered. Compression is ZIP, lines
/// stand in increasing order, and the same film gives the same bytes.
///
/// # Errors
/// [`OutputError`]; a file of that name is then what it was before.
pub fn write_exr(film: &Film, path: &Path, options: &ExrOptions) -> Result<(), OutputError> {
    write(film, Vec::new(), path, options)
}

/// The same with some of `aovs`, of the same size, as further channels; [`Aov`] tells their names.
///
/// # Errors
/// As [`write_exr`], and layers of another size than the film's.
pub fn write_exr_with(
    film: &Film,
    aovs: &Aovs,
    wanted: &[Aov],
    path: &Path,
    options: &ExrOptions,
) -> Result<(), OutputError> {
    let expected = film.pixels.len();
    let lengths = [aovs.patch.len(), aovs.stretch.len(), aovs.normal.len()];
    if let Some(&pixels) = lengths.iter().find(|&&length| length != expected) {
        return Err(OutputError::Layers { pixels, expected });
    }
    let mut channels = Vec::new();
    for aov in Aov::ALL.into_iter().filter(|aov| wanted.contains(aov)) {
        let name = aov.name();
        match aov {
            Aov::Patch => channels.push(AnyChannel::new(name, FlatSamples::U32(aovs.patch.clone()))),
            Aov::Stretch => channels.push(AnyChannel::new(name, FlatSamples::F32(aovs.stretch.clone()))),
            Aov::Normal => channels.extend(["X", "Y", "Z"].into_iter().enumerate().map(|(axis, letter)| {
                let values = aovs.normal.iter().map(|n| n[axis]).collect();
                AnyChannel::new(format!("{name}.{letter}").as_str(), FlatSamples::F32(values))
            })),
        }
    }
    write(film, channels, path, options)
}

fn write(
    film: &Film,
    more: Vec<AnyChannel<FlatSamples>>,
    path: &Path,
    options: &ExrOptions,
) -> Result<(), OutputError> {
    check(film)?;
    let window = film.window;
    let size = Vec2(window.width as usize, window.height as usize);
    let channel = |name: &str, value: &dyn Fn(&Pixel) -> f32| {
        AnyChannel::new(name, FlatSamples::F32(film.pixels.iter().map(value).collect()))
    };
    let mut channels = more;
    channels.extend([
        channel("R", &|p| p.color.x),
        channel("G", &|p| p.color.y),
        channel("B", &|p| p.color.z),
        channel("A", &|p| p.alpha),
        channel("Z", &|p| p.depth),
    ]);
    let channels = AnyChannels::sort(channels.into());
    let attributes = LayerAttributes {
        layer_position: Vec2(window.x as i32, window.y as i32),
        software_name: Text::new_or_none(concat!("pelage ", env!("CARGO_PKG_VERSION"))),
        world_to_camera: options.camera.map(|camera| world_to_camera(&camera).to_cols_array()),
        ..LayerAttributes::default()
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        // Increasing, because the default order leaves the blocks as the compressing threads finish.
        line_order: LineOrder::Increasing,
    };
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, channels));
    let display = IntegerBounds::new((0, 0), (film.size[0] as usize, film.size[1] as usize));
    image.attributes = ImageAttributes::new(display);
    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    // Not on exr's own threads: the caller's pool is the only one there is.
    replace(path, |file| image.write().non_parallel().to_buffered(file).map_err(io::Error::other))
}

/// OpenEXR multiplies row vectors from the left: its rows are our columns, so that the order in memory is the same.
fn world_to_camera(camera: &Camera) -> Mat4 {
    let camera_to_world = Mat4::from_mat3(camera.orientation);
    camera_to_world.transpose() * Mat4::from_translation(-camera.position)
}
