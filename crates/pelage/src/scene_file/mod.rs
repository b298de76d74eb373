//! A scene as it is described: what a TOML file holds, and what command-line flags amount to. See `docs/scene.md`.
//!
//! Longer than most files here: it is the one list of all fields that a scene file may have.

mod cage;
mod geometry;
mod groom;
mod texel;
mod validate;

use std::path::{Path, PathBuf};

use pelage_skin::{Folds, Layout};
use pelage_tracer::{Lod, Opacity, Rays};
use serde::{Deserialize, Deserializer, de};

pub use cage::CageEntry;
pub use geometry::{GeometryEntry, SurfaceEntry};
pub use groom::{BoxEntry, GroomEntry, ImageEntry, MaskEntry, RegionEntry, SphereEntry};
pub use texel::TexelEntry;

use crate::choices::{self, Background, Method};
use crate::error::Error;
use crate::import::{Fault, Files, ImportOptions, Place, extension};
use crate::output::Tone;
use crate::staging::View;

/// A whole scene. Every field has a default but the geometry.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneFile {
    /// The file itself, for messages; references are relative to its folder.
    #[serde(skip)]
    pub path: PathBuf,
    /// Mesh files and surfaces.
    pub geometry: Vec<GeometryEntry>,
    /// What grows on them.
    pub skin: Vec<SkinEntry>,
    /// From where the scene is seen.
    pub camera: Option<CameraEntry>,
    /// Lights, besides those of the mesh files.
    pub light: Vec<LightEntry>,
    /// The light of the surroundings.
    pub environment: Option<EnvironmentEntry>,
    /// How it is rendered.
    pub render: RenderEntry,
    /// Folders, besides the scene's own, that references may lead to.
    #[serde(skip)]
    pub allow_dirs: Vec<PathBuf>,
}

/// A skin on some of the meshes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkinEntry {
    /// Names of meshes and materials that wear it; none means everything. One name, or a list.
    #[serde(default, deserialize_with = "names")]
    pub on: Vec<String>,
    /// What grows.
    #[serde(default)]
    pub texel: TexelEntry,
    /// Metres; by default 6 % of half the diagonal of the meshes that wear it.
    #[serde(default)]
    pub height: Option<f32>,
    /// Tilts all of it the same way, as wind or weight would; a length of 1 tilts by 45°.
    #[serde(default)]
    pub lean: [f32; 3],
    /// A mesh of the same faces where the boxes end, instead of a height along the normals. A path, or a table.
    #[serde(default, deserialize_with = "cage::deserialize")]
    pub cage: Option<CageEntry>,
    /// Whether copies of the texel go by texture coordinates or by faces.
    #[serde(default, deserialize_with = "choices::deserialize")]
    pub layout: Layout,
    /// Copies of the texel per unit of texture coordinates (per face side where copies go by faces).
    #[serde(default)]
    pub tiling: Option<f32>,
    /// Width of a copy over its height, where there is no `tiling`; by default [`SkinEntry::ASPECT`].
    #[serde(default)]
    pub aspect: Option<f32>,
    /// Multiplies the texel's colours; linear.
    #[serde(default = "white")]
    pub tint: [f32; 3],
    /// Whether the colour of the surface below multiplies the texel's colours too.
    #[serde(default = "yes")]
    pub wears_material: bool,
    /// What is done with boxes that fold over in tight creases.
    #[serde(default, deserialize_with = "choices::deserialize")]
    pub folds: Folds,
    /// What is done to its boxes, in this order.
    #[serde(default)]
    pub groom: Vec<GroomEntry>,
}

impl SkinEntry {
    /// The default aspect: the presets were made on a cube, and look fluffier when it is wider than high.
    pub const ASPECT: f32 = 1.5;
}

impl Default for SkinEntry {
    /// Long fur on everything.
    fn default() -> Self {
        Self {
            on: Vec::new(),
            texel: TexelEntry::default(),
            height: None,
            lean: [0.0; 3],
            cage: None,
            layout: Layout::Auto,
            tiling: None,
            aspect: None,
            tint: white(),
            wears_material: true,
            folds: Folds::default(),
            groom: Vec::new(),
        }
    }
}

/// From where the scene is seen.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraEntry {
    /// From a place to another.
    LookAt(LookAt),
    /// From a direction, at the distance that fits everything in.
    Framed(View),
    /// As the camera of this name in a mesh file.
    Named(String),
}

/// A camera by two points.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookAt {
    /// Where the eye is, in metres.
    pub eye: [f32; 3],
    /// What is in the middle of the picture.
    pub target: [f32; 3],
    /// What is upwards in the picture.
    #[serde(default = "upwards")]
    pub up: [f32; 3],
    /// Vertical angle of view in degrees.
    #[serde(default = "thirty")]
    pub fov: f32,
}

/// A light. Units are those of KHR_lights_punctual.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum LightEntry {
    /// The sun.
    Directional {
        /// The way the light travels.
        direction: [f32; 3],
        /// Lux, by colour.
        illuminance: [f32; 3],
        /// Degrees under which it is seen.
        #[serde(default = "sun_angle")]
        angle: f32,
    },
    /// A small sphere.
    Point {
        /// Metres.
        position: [f32; 3],
        /// Candela, by colour.
        intensity: [f32; 3],
        /// Metres.
        #[serde(default)]
        radius: f32,
    },
    /// A sphere that shines into a cone.
    Spot {
        /// Metres.
        position: [f32; 3],
        /// The cone's axis.
        direction: [f32; 3],
        /// Candela on the axis, by colour.
        intensity: [f32; 3],
        /// Degrees from the axis within which it is full.
        #[serde(default)]
        inner: f32,
        /// Degrees from the axis beyond which there is none.
        #[serde(default = "forty_five")]
        outer: f32,
        /// Metres.
        #[serde(default)]
        radius: f32,
    },
}

/// The light of the surroundings, in radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentEntry {
    /// From straight above; none by default.
    pub sky: [f32; 3],
    /// From straight below; none by default.
    pub ground: [f32; 3],
}

/// How a scene is rendered.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderEntry {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The part to render: x0, x1, y0, y1 in pixels, the ends not included.
    pub crop: Option<[u32; 4]>,
    /// How the picture is made.
    #[serde(deserialize_with = "choices::deserialize")]
    pub method: Method,
    /// Samples a pixel of the reference method; by default as many as [`ReferenceSettings`](pelage_tracer::reference::ReferenceSettings) has.
    pub spp: Option<u32>,
    /// Rays a pixel.
    #[serde(deserialize_with = "choices::deserialize")]
    pub rays: Rays,
    /// How cones go through bent boxes.
    #[serde(deserialize_with = "choices::deserialize")]
    pub path: pelage_tracer::Path,
    /// Which level of detail they read.
    #[serde(deserialize_with = "choices::deserialize")]
    pub lod: Lod,
    /// How depth becomes opacity.
    #[serde(deserialize_with = "choices::deserialize")]
    pub opacity: Opacity,
    /// Whether there are shadows.
    pub shadows: bool,
    /// Stops added to the automatic exposure.
    pub exposure: f32,
    /// The curve of the brightest parts, in PNG.
    pub tone: Tone,
    /// What stands behind; by default the sky in PNG, nothing in EXR.
    #[serde(deserialize_with = "choices::deserialize_some")]
    pub background: Option<Background>,
}

impl Default for RenderEntry {
    fn default() -> Self {
        let settings = pelage_tracer::Settings::default();
        Self {
            size: settings.size,
            crop: None,
            method: Method::default(),
            spp: None,
            rays: settings.rays,
            path: settings.path,
            lod: settings.lod,
            opacity: settings.opacity,
            shadows: settings.shadows,
            exposure: 0.0,
            tone: Tone::default(),
            background: None,
        }
    }
}

fn one() -> f32 {
    1.0
}
fn white() -> [f32; 3] {
    [1.0; 3]
}
fn yes() -> bool {
    true
}
fn upwards() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}
fn thirty() -> f32 {
    30.0
}
fn forty_five() -> f32 {
    45.0
}
fn sun_angle() -> f32 {
    0.53
}

/// A message of serde's, with the types of the file instead of those of this program.
fn plain(message: &str) -> String {
    let Some((found, expected)) = message.split_once(", expected ") else { return message.to_owned() };
    let plain = match expected {
        "f32" => "a number".to_owned(),
        "u32" | "u64" => "a whole number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a boolean" => "true or false".to_owned(),
        _ if expected.starts_with("struct ") || expected.starts_with("enum ") => "a table".to_owned(),
        _ => expected.replace("an array of length ", "a list of "),
    };
    format!("{found}, expected {plain}")
}

/// One name or a list of names.
fn names<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<String>, D::Error> {
    struct Names;
    impl<'de> de::Visitor<'de> for Names {
        type Value = Vec<String>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("a name or a list of names")
        }

        fn visit_str<E: de::Error>(self, name: &str) -> Result<Vec<String>, E> {
            Ok(vec![name.to_owned()])
        }

        fn visit_seq<A: de::SeqAccess<'de>>(self, mut list: A) -> Result<Vec<String>, A::Error> {
            let mut names = Vec::new();
            while let Some(name) = list.next_element()? {
                names.push(name);
            }
            Ok(names)
        }
    }
    deserializer.deserialize_any(Names)
}

impl SceneFile {
    /// The scene of a single mesh file, with nothing growing on it.
    pub fn of_mesh(path: &Path) -> Self {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { path: path.to_owned(), geometry: vec![GeometryEntry::new(file)], ..Self::default() }
    }

    /// Reads a scene: TOML, or the same in JSON where the name ends in `.json`.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML or JSON (with its line), or does not describe a scene (with the field).
    pub fn open(path: &Path) -> Result<Self, Error> {
        let limits = ImportOptions::default().limits;
        let files = Files::around(path, &[], limits)?;
        let bytes = files.read(path).map_err(|fault| fault.at(path, Place::File))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            Fault::Syntax("is not UTF-8 text".into()).at(path, Place::Byte(e.utf8_error().valid_up_to()))
        })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a scene; `path` is what references are relative to, and tells TOML from JSON.
    ///
    /// # Errors
    /// As [`SceneFile::open`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let at = |line: usize, message: &str| Fault::Syntax(plain(message)).at(path, Place::Line(line));
        let mut scene: Self = if extension(path) == "json" {
            serde_json::from_str(text).map_err(|e| {
                // The line is told as the place.
                at(e.line(), e.to_string().split(" at line ").next().unwrap_or_default())
            })?
        } else {
            toml::from_str(text).map_err(|e| {
                let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
                let line = before.matches('\n').count() + 1;
                at(line, e.message().split('\n').next().unwrap_or_default())
            })?
        };
        scene.path = path.to_owned();
        scene.validate()?;
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_says_the_same_as_toml() {
        let toml = "geometry = [{ file = 'a.obj', scale = 2 }]\n[[skin]]\non = 'Body'\nheight = 1\n\
                    texel.fur = { preset = 'short', count = 9 }\n[[skin.groom]]\ngravity = 1\n\
                    where = { material = 'Body', invert = true }\n[render]\nrays = 4\nlod = 3\nsize = [8, 8]\n";
        let json = r#"{
            "geometry": [{ "file": "a.obj", "scale": 2 }],
            "skin": [{
                "on": "Body", "height": 1, "texel": { "fur": { "preset": "short", "count": 9 } },
                "groom": [{ "gravity": 1, "where": { "material": "Body", "invert": true } }]
            }],
            "render": { "rays": 4, "lod": 3, "size": [8, 8] }
        }"#;
        let of_toml = SceneFile::parse(toml, Path::new("s.toml")).expect("a scene");
        let of_json = SceneFile::parse(json, Path::new("s.json")).expect("a scene");
        assert_eq!(SceneFile { path: of_toml.path.clone(), ..of_json }, of_toml);
        let error =
            SceneFile::parse("{\n\"skim\": 3\n}", Path::new("s.json")).expect_err("no scene").to_string();
        assert!(error.starts_with("s.json:2: unknown field `skim`, expected one of"), "{error}");
        let error = SceneFile::parse("{\n", Path::new("s.json")).expect_err("no scene").to_string();
        assert!(error.starts_with("s.json:") && !error.contains('\n'), "{error}");
    }
}
