//! The flags of `pelage render`, and the scene that they describe.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use pelage::choices::{Background, Choice, Method};
use pelage::import::Up;
use pelage::output::{Aov, Tone};
use pelage::scene_file::{CameraEntry, SceneFile, SkinEntry, TexelEntry};
use pelage::skin::Folds;
use pelage::staging::View;
use pelage::tracer::{Lod, Opacity, Path as BoxPath, Quality, Rays};
use pelage::{Error, Field, FieldError};

use crate::run_args::{AllowArgs, RunArgs};

const EXAMPLES: &str = "\
Examples:
  pelage render bunny.obj -o bunny.png
      Long fur on everything, seen from the front, under a sun and a sky.
  pelage render teddy.glb -o teddy.png --texel fur:plush --on Body --on Ears --tint 0.8,0.5,0.3
      Fur on two meshes (or materials) of a file, with its own camera and lights.
  pelage render fluff.toml -o fluff.exr --size 1920x1080 --crop 0,960,0,1080
      A scene file, as linear radiance; only the left half.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct RenderArgs {
    /// The scene: .toml, .gltf, .glb or .obj
    scene: PathBuf,

    /// The picture: .png (8-bit sRGB) or .exr (32-bit linear radiance with alpha and depth)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// What grows: a kind (grass) or preset (fur:plush) that `pelage texel kinds` lists, a texel file (x.texel), or none
    /// [default: fur on a mesh file, what a .toml says]
    #[arg(long, value_parser = texel, help_heading = "Skin")]
    texel: Option<TexelArg>,

    /// How high it grows, in metres [default: 6 % of half the diagonal of what it grows on]
    #[arg(long, value_parser = positive, allow_hyphen_values = true, help_heading = "Skin")]
    height: Option<f32>,

    /// Tilts it all the same way: 0,-0.5,0 lets it hang; a length of 1 tilts by 45°
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = list::<3, f32>,
        allow_hyphen_values = true,
        help_heading = "Skin"
    )]
    lean: Option<[f32; 3]>,

    /// Only on the mesh or material of this name; may be repeated
    #[arg(long, value_name = "NAME", value_parser = name, help_heading = "Skin")]
    on: Vec<String>,

    /// Copies of the texel per unit of texture coordinates (per face side where there are none)
    #[arg(long, value_parser = positive, allow_hyphen_values = true, help_heading = "Skin")]
    tiling: Option<f32>,

    /// Multiplies its colour; linear
    #[arg(
        long,
        value_name = "R,G,B",
        value_parser = list::<3, f32>,
        allow_hyphen_values = true,
        help_heading = "Skin"
    )]
    tint: Option<[f32; 3]>,

    /// Voxels a side of the texel, a power of two [default: 128]
    #[arg(long, value_name = "N", value_parser = whole, allow_hyphen_values = true, help_heading = "Skin")]
    resolution: Option<u32>,

    /// What is done with boxes that fold over: mend, leave-out or refuse [default: mend]
    #[arg(long, value_parser = choice::<Folds>, help_heading = "Skin")]
    folds: Option<Folds>,

    /// Width and height in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true, help_heading = "Picture")]
    size: Option<[u32; 2]>,

    /// Render only this part, in pixels, the ends not included
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = list::<4, u32>, help_heading = "Picture")]
    crop: Option<[u32; 4]>,

    /// How it is rendered: cone, or reference (the explicit geometry: slow, to compare with) [default: cone]
    #[arg(long, value_parser = choice::<Method>, help_heading = "Picture")]
    method: Option<Method>,

    /// Samples a pixel of the reference method, 1 to 65536 [default: 256]
    #[arg(long, value_name = "N", value_parser = whole, allow_hyphen_values = true, help_heading = "Picture")]
    spp: Option<u32>,

    /// How much time the picture is worth: draft, normal or high [default: normal]
    #[arg(long, value_parser = choice::<Quality>, help_heading = "Picture")]
    quality: Option<Quality>,

    /// Rays a pixel: 1, 4, 16, or adaptive: one where it says all, else 4 [default: by the quality: 1, adaptive, 16]
    #[arg(long, value_parser = choice::<Rays>, help_heading = "Picture")]
    rays: Option<Rays>,

    /// Through bent boxes: curved or straight [default: curved]
    #[arg(long, value_parser = choice::<BoxPath>, help_heading = "Picture")]
    path: Option<BoxPath>,

    /// Level of detail: auto, sharp, smooth or a level from 0 to 12 [default: auto]
    #[arg(long, value_parser = choice::<Lod>, allow_hyphen_values = true, help_heading = "Picture")]
    lod: Option<Lod>,

    /// How depth becomes opacity: exponential or linear [default: exponential]
    #[arg(long, value_parser = choice::<Opacity>, help_heading = "Picture")]
    opacity: Option<Opacity>,

    /// Light everything as if nothing were in the way
    #[arg(long, help_heading = "Picture")]
    no_shadows: bool,

    /// Stops added to the automatic exposure (PNG)
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, help_heading = "Picture")]
    exposure: Option<f32>,

    /// The curve of the brightest parts: filmic or none (PNG) [default: filmic]
    #[arg(long, value_parser = choice::<Tone>, help_heading = "Picture")]
    tone: Option<Tone>,

    /// Besides the colour, in an EXR file: patch, stretch or normal, several with commas between; in a PNG file
    /// instead of the colour, one of them in false colours
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = choice::<Aov>, help_heading = "Picture")]
    pub aov: Vec<Aov>,

    /// What stands behind: sky, none or #rrggbb [default: sky in PNG, none in EXR]
    #[arg(long, value_parser = choice::<Background>, help_heading = "Picture")]
    background: Option<Background>,

    /// The camera of this name in the file [default: the first, if there is one]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["view", "zoom"], help_heading = "Camera")]
    camera: Option<String>,

    /// Frame everything from this direction, in degrees: around from the front, above the horizon [default: 30,18]
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION",
        value_parser = list::<2, f32>,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    view: Option<[f32; 2]>,

    /// Frame everything, this much larger
    #[arg(long, value_parser = positive, help_heading = "Camera")]
    zoom: Option<f32>,

    /// The vertical axis of an OBJ file: y or z [default: y]
    #[arg(long, value_parser = choice::<Up>, help_heading = "Input")]
    up: Option<Up>,

    /// Metres in one unit of the mesh files [default: 1]
    #[arg(long, value_parser = positive, help_heading = "Input")]
    unit: Option<f32>,

    #[command(flatten)]
    allow: AllowArgs,

    #[command(flatten)]
    pub run: RunArgs,

    /// Tell times, counts and memory: text on stderr or json on stdout
    #[arg(
        long,
        value_name = "FORMAT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "text",
        help_heading = "Run"
    )]
    pub stats: Option<StatsFormat>,
}

/// How `--stats` tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StatsFormat {
    /// For people, on stderr.
    Text,
    /// For programs, on stdout.
    Json,
}

#[derive(Clone, Debug, PartialEq)]
enum TexelArg {
    None,
    Grown(TexelEntry),
}

impl RenderArgs {
    /// The scene that file and flags describe together.
    pub fn scene(&self) -> Result<SceneFile, Error> {
        let mut scene = SceneFile::open(&self.scene)?;
        scene.allow_dirs.clone_from(&self.allow.allow_dir);
        for geometry in &mut scene.geometry {
            set(&mut geometry.up, self.up);
            set(&mut geometry.unit, self.unit);
        }
        self.skins(&mut scene.skin)?;
        if self.texel.is_some() || !self.on.is_empty() {
            scene.forget("skin");
        }
        self.camera(&mut scene.camera);
        if self.camera.is_some() {
            scene.forget("camera");
        }
        let render = &mut scene.render;
        set(&mut render.size, self.size);
        set(&mut render.quality, self.quality);
        render.rays = self.rays.or(render.rays.filter(|_| self.quality.is_none()));
        set(&mut render.path, self.path);
        set(&mut render.lod, self.lod);
        set(&mut render.opacity, self.opacity);
        set(&mut render.exposure, self.exposure);
        set(&mut render.tone, self.tone);
        set(&mut render.method, self.method);
        if self.method == Some(Method::Cone) {
            // Samples that the file asks for are the other method's.
            render.spp = None;
        }
        render.spp = self.spp.or(render.spp);
        if render.method == Method::Reference {
            self.only_for_cones()?;
        }
        let render = &mut scene.render;
        render.crop = self.crop.or(render.crop);
        render.background = self.background.or(render.background);
        render.shadows &= !self.no_shadows;
        // The file alone makes sense: what does not now is none of its text.
        scene
            .validate()
            .map_err(|error| FieldError { field: Field { span: None, ..error.field }, ..error })?;
        Ok(scene)
    }

    /// Refuses flags that mean nothing to the reference renderer.
    fn only_for_cones(&self) -> Result<(), FieldError> {
        let flags = [
            ("--quality", self.quality.is_some()),
            ("--rays", self.rays.is_some()),
            ("--path", self.path.is_some()),
            ("--lod", self.lod.is_some()),
            ("--opacity", self.opacity.is_some()),
            ("--resolution", self.resolution.is_some()),
        ];
        match flags.into_iter().find(|&(_, given)| given) {
            Some((flag, _)) => Err(misplaced(
                &self.scene,
                flag,
                "means nothing to --method reference, which traces no cones",
            )),
            None => Ok(()),
        }
    }

    /// `--texel` and `--on` stand in for the skins of the file; the other flags change each skin there is.
    fn skins(&self, skins: &mut Vec<SkinEntry>) -> Result<(), FieldError> {
        match &self.texel {
            Some(TexelArg::None) => skins.clear(),
            Some(TexelArg::Grown(texel)) => {
                *skins = vec![SkinEntry::of_texel(texel.clone())];
            }
            None if !self.on.is_empty() => *skins = vec![SkinEntry::default()],
            None => {}
        }
        let flags = [
            ("--on", !self.on.is_empty()),
            ("--height", self.height.is_some()),
            ("--lean", self.lean.is_some()),
            ("--tiling", self.tiling.is_some()),
            ("--tint", self.tint.is_some()),
            ("--resolution", self.resolution.is_some()),
            ("--folds", self.folds.is_some()),
        ];
        if let Some((flag, _)) = flags.into_iter().find(|&(_, given)| given && skins.is_empty()) {
            return Err(misplaced(&self.scene, flag, "there is no skin for it to change"));
        }
        for skin in skins {
            if let Some(wanted) = self.resolution {
                set_resolution(skin, wanted, &self.scene)?;
            }
            set(&mut skin.tint, self.tint);
            set(&mut skin.lean, self.lean);
            set(&mut skin.folds, self.folds);
            skin.height = self.height.or(skin.height);
            if self.tiling.is_some() {
                // The flag decides how wide a copy is, whatever the file said.
                (skin.tiling, skin.aspect) = (self.tiling, None);
            }
            if !self.on.is_empty() {
                skin.on.clone_from(&self.on);
            }
        }
        Ok(())
    }

    fn camera(&self, camera: &mut Option<CameraEntry>) {
        if let Some(name) = &self.camera {
            *camera = Some(CameraEntry::Named(name.clone()));
        } else if self.view.is_some() || self.zoom.is_some() {
            let mut view = match camera {
                Some(CameraEntry::Framed(view)) => *view,
                _ => View::default(),
            };
            if let Some([azimuth, elevation]) = self.view {
                (view.azimuth, view.elevation) = (azimuth, elevation);
            }
            set(&mut view.zoom, self.zoom);
            *camera = Some(CameraEntry::Framed(view));
        }
    }
}

/// A flag that makes no sense with this scene.
fn misplaced(scene: &Path, flag: &str, reason: &str) -> FieldError {
    let field = Field { name: flag.to_owned(), ..Field::whole(scene) };
    FieldError { field, reason: reason.to_owned(), hint: None }
}

/// Builds the texels of a skin so fine; those from files are as fine as they are.
pub fn set_resolution(skin: &mut SkinEntry, wanted: u32, scene: &Path) -> Result<(), FieldError> {
    let mut grown: Vec<&mut u32> = skin.texel.iter_mut().filter_map(|s| s.texel.resolution_mut()).collect();
    if grown.is_empty() {
        return Err(misplaced(
            scene,
            "--resolution",
            "means nothing to a texel from a file, which has its own",
        ));
    }
    grown.iter_mut().for_each(|resolution| **resolution = wanted);
    Ok(())
}

fn set<T>(field: &mut T, flag: Option<T>) {
    if let Some(value) = flag {
        *field = value;
    }
}

/// A choice that has a word.
pub fn choice<C: Choice>(word: &str) -> Result<C, String> {
    C::parse(word)
}

fn texel(word: &str) -> Result<TexelArg, String> {
    if word == "none" { Ok(TexelArg::None) } else { TexelEntry::from_word(word).map(TexelArg::Grown) }
}

/// A positive number.
pub fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a positive number".into()),
    }
}

fn whole(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "expected a whole number".into())
}

/// More threads than this only cost memory, and the stacks of very many bring the program down.
const MOST_THREADS: usize = 256;

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|&n| n <= MOST_THREADS);
    count.ok_or_else(|| format!("expected a whole number from 0 to {MOST_THREADS}"))
}

fn name(text: &str) -> Result<String, String> {
    if text.is_empty() { Err("a name has at least one letter".into()) } else { Ok(text.into()) }
}

/// Width and height in pixels, as in `1280x720`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |side: &str| side.parse::<u32>().ok().filter(|&n| n > 0);
    text.split_once('x')
        .and_then(|(width, height)| Some([parse(width)?, parse(height)?]))
        .ok_or_else(|| "expected width x height in pixels, like 1280x720".into())
}

/// `N` numbers with commas between.
pub fn list<const N: usize, T: std::str::FromStr>(text: &str) -> Result<[T; N], String> {
    let numbers: Option<Vec<T>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers with commas between"))
}
