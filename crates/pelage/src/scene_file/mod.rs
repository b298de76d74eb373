//! A scene as it is described: what a TOML file holds, and what command-line flags amount to. See `docs/scene.md`.
//!
//! Longer than most files here: it is the one list of all fields that a scene file may have.

mod cage;
mod geometry;
mod gltf;
mod groom;
mod growth;
mod source;
mod texel;
mod validate;

use std::path::{Path, PathBuf};

use pelage_skin::{Folds, Layout};
use pelage_tracer::{Lod, Opacity, Quality, Rays};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, de};

pub use cage::CageEntry;
pub use geometry::{GeometryEntry, SurfaceEntry};
pub(crate) use gltf::EXTENSION;
pub use groom::{BoxEntry, GroomEntry, ImageEntry, MaskEntry, RegionEntry, SphereEntry};
pub use growth::{ShareEntry, VarietyEntry};
pub use source::Source;
pub use texel::TexelEntry;

use crate::choices::{self, Background, Method};
use crate::error::{Error, Field, FieldError};
use crate::import::{Fault, Files, ImportOptions, Place, extension};
use crate::names;
use crate::output::Tone;
use crate::schema;
use crate::staging::View;

/// A whole scene. Every field has a default but the geometry.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
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
    /// Where in the file everything stands, for messages.
    #[serde(skip)]
    pub source: Source,
}

/// A skin on some of the meshes.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkinEntry {
    /// Names of meshes and materials that wear it; none means everything. One name, or a list.
    #[serde(default, deserialize_with = "name_or_names")]
    #[schemars(schema_with = "schema::names")]
    pub on: Vec<String>,
    /// What grows: one texel, or several, of which each copy holds one.
    #[serde(default = "fur", deserialize_with = "growth::one_or_more")]
    #[schemars(schema_with = "schema::one_or_more::<ShareEntry>")]
    pub texel: Vec<ShareEntry>,
    /// How copies differ.
    #[serde(default)]
    pub variety: VarietyEntry,
    /// Metres; by default 6 % of half the diagonal of the meshes that wear it.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height: Option<f32>,
    /// Tilts all of it the same way, as wind or weight would; a length of 1 tilts by 45°.
    #[serde(default)]
    #[schemars(inner(range(min = -50, max = 50)))]
    pub lean: [f32; 3],
    /// A mesh of the same faces where the boxes end, instead of a height along the normals. A path, or a table.
    #[serde(default, deserialize_with = "cage::deserialize")]
    #[schemars(schema_with = "schema::path_or::<CageEntry>")]
    pub cage: Option<CageEntry>,
    /// Whether copies of the texel go by texture coordinates or by faces.
    #[serde(default, deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Layout>")]
    pub layout: Layout,
    /// Copies of the texel per unit of texture coordinates (per face side where copies go by faces).
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tiling: Option<f32>,
    /// Width of a copy over its height, where there is no `tiling`; by default [`SkinEntry::ASPECT`].
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub aspect: Option<f32>,
    /// Multiplies the texel's colours; linear.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0)))]
    pub tint: [f32; 3],
    /// A vertex attribute of three numbers that multiplies them, as in `COLOR_0`; linear.
    #[serde(default)]
    pub vertex_color: Option<String>,
    /// Whether the colour of the surface below multiplies the texel's colours too.
    #[serde(default = "yes")]
    pub wears_material: bool,
    /// What is done with boxes that fold over in tight creases.
    #[serde(default, deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Folds>")]
    pub folds: Folds,
    /// What is done to its boxes, in this order.
    #[serde(default)]
    pub groom: Vec<GroomEntry>,
}

impl SkinEntry {
    /// The default aspect: the presets were made on a cube, and look fluffier when it is wider than high.
    pub const ASPECT: f32 = 1.5;

    /// The skin of one texel that is the same in all copies.
    pub fn of_texel(texel: TexelEntry) -> Self {
        Self { texel: vec![texel.into()], ..Self::default() }
    }

    /// How messages call texel `number` of the skin `skin`.
    pub(crate) fn texel_field(&self, skin: usize, number: usize) -> String {
        // A table that stands alone has no number.
        if self.texel.len() == 1 {
            format!("skin[{skin}].texel")
        } else {
            format!("skin[{skin}].texel[{number}]")
        }
    }

    /// Every texel that grows on it, with its weight, variants one by one.
    pub fn texels(&self) -> impl Iterator<Item = (TexelEntry, f32)> + '_ {
        self.texel.iter().flat_map(ShareEntry::texels)
    }
}

impl Default for SkinEntry {
    /// Long fur on everything.
    fn default() -> Self {
        Self {
            on: Vec::new(),
            texel: fur(),
            variety: VarietyEntry::default(),
            height: None,
            lean: [0.0; 3],
            cage: None,
            layout: Layout::Auto,
            tiling: None,
            aspect: None,
            tint: white(),
            vertex_color: None,
            wears_material: true,
            folds: Folds::default(),
            groom: Vec::new(),
        }
    }
}

/// From where the scene is seen.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
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
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov: f32,
}

/// A light. Units are those of KHR_lights_punctual.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
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
        #[schemars(range(min = 0, max = 90))]
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
        #[schemars(range(min = 0))]
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
        #[schemars(range(min = 0))]
        radius: f32,
    },
}

/// The light of the surroundings, in radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentEntry {
    /// From straight above; none by default.
    pub sky: [f32; 3],
    /// From straight below; none by default.
    pub ground: [f32; 3],
}

/// How a scene is rendered.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RenderEntry {
    /// Width and height in pixels.
    #[schemars(inner(range(min = 1)))]
    pub size: [u32; 2],
    /// The part to render: x0, x1, y0, y1 in pixels, the ends not included.
    pub crop: Option<[u32; 4]>,
    /// How the picture is made.
    #[serde(deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Method>")]
    pub method: Method,
    /// Samples a pixel of the reference method; by default as many as [`ReferenceSettings`](pelage_tracer::reference::ReferenceSettings) has.
    #[schemars(range(min = 1, max = 65536))]
    pub spp: Option<u32>,
    /// How much time the picture is worth.
    #[serde(deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Quality>")]
    pub quality: Quality,
    /// Rays a pixel; by default as many as the quality has.
    #[serde(deserialize_with = "choices::deserialize_some")]
    #[schemars(schema_with = "schema::choice::<Rays>")]
    pub rays: Option<Rays>,
    /// How cones go through bent boxes.
    #[serde(deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<pelage_tracer::Path>")]
    pub path: pelage_tracer::Path,
    /// Which level of detail they read.
    #[serde(deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Lod>")]
    pub lod: Lod,
    /// How depth becomes opacity.
    #[serde(deserialize_with = "choices::deserialize")]
    #[schemars(schema_with = "schema::choice::<Opacity>")]
    pub opacity: Opacity,
    /// Whether there are shadows.
    pub shadows: bool,
    /// Stops added to the automatic exposure.
    #[schemars(range(min = -60, max = 60))]
    pub exposure: f32,
    /// The curve of the brightest parts, in PNG.
    pub tone: Tone,
    /// What stands behind; by default the sky in PNG, nothing in EXR.
    #[serde(deserialize_with = "choices::deserialize_some")]
    #[schemars(schema_with = "schema::choice::<Background>")]
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
            quality: Quality::default(),
            rays: None,
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

fn fur() -> Vec<ShareEntry> {
    vec![TexelEntry::default().into()]
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

/// One name or a list of names.
fn name_or_names<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<String>, D::Error> {
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

    /// Reads a scene: TOML, or the same in JSON where the name ends in `.json`; or a mesh file (`.obj`, `.gltf`, `.glb`),
    /// with the skins that a glTF file says it wears, or else with long fur on all of it.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML or JSON (with its line), or does not describe a scene (with the field).
    pub fn open(path: &Path) -> Result<Self, Error> {
        match extension(path).as_str() {
            "toml" | "json" => Self::parse(&Self::text(path)?, path),
            "obj" => Ok(Self { skin: vec![SkinEntry::default()], ..Self::of_mesh(path) }),
            "gltf" | "glb" => {
                let mut scene = gltf::dress(Self::of_mesh(path))?;
                if scene.skin.is_empty() {
                    scene.skin.push(SkinEntry::default());
                }
                Ok(scene)
            }
            _ => {
                let expected = ".toml, .json, .gltf, .glb or .obj";
                Err(Fault::Extension { expected }.at(path, Place::File).into())
            }
        }
    }

    /// Reads a scene, or the mesh file that it is, with as much of it as makes sense, and everything that does not.
    pub(crate) fn open_all(path: &Path) -> (Option<Self>, Vec<Error>) {
        if !is_text(path) {
            return match Self::open(path) {
                Ok(scene) => (Some(scene), Vec::new()),
                Err(error) => (None, vec![error]),
            };
        }
        match Self::text(path) {
            Ok(text) => {
                let (scene, faults) = Self::parse_all(&text, path);
                (scene, faults.into_iter().map(Error::from).collect())
            }
            Err(error) => (None, vec![error]),
        }
    }

    /// The text of a file.
    fn text(path: &Path) -> Result<String, Error> {
        let files = Files::around(path, &[], ImportOptions::default().limits)?;
        let bytes = files.read(path).map_err(|fault| fault.at(path, Place::File))?;
        Ok(String::from_utf8(bytes).map_err(|e| {
            Fault::Syntax("is not UTF-8 text".into()).at(path, Place::Byte(e.utf8_error().valid_up_to()))
        })?)
    }

    /// Reads the text of a scene; `path` is what references are relative to, and tells TOML from JSON.
    ///
    /// # Errors
    /// As [`SceneFile::open`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let source = Source::parse(text, path)
            .map_err(|faults| faults.into_iter().next().unwrap_or_else(|| nothing(path)))?;
        let scene = Self { path: path.to_owned(), ..source.read()? };
        let scene = Self { source, ..scene };
        scene.validate()?;
        Ok(scene)
    }

    /// Reads as much of the text of a scene as makes sense, and everything that does not.
    pub(crate) fn parse_all(text: &str, path: &Path) -> (Option<Self>, Vec<FieldError>) {
        let mut source = match Source::parse(text, path) {
            Ok(source) => source,
            Err(faults) => return (None, faults),
        };
        let (scene, mut faults) = source.read_all::<Self>();
        let Some(scene) = scene else { return (None, faults) };
        let scene = Self { path: path.to_owned(), source, ..scene };
        // What lacks something that was wrong has been told of.
        faults.extend(scene.faults().into_iter().filter(|fault| !scene.source.is_spoilt(&fault.field.name)));
        (Some(scene), faults)
    }

    /// The field of this name, as in `skin[0].height`, and where it stands in the file.
    pub fn field(&self, name: &str) -> Field {
        let field = self.source.field(name);
        Field { file: self.path.clone(), ..field }
    }

    /// Says that a field is no longer what the file says: messages do not point at it.
    pub fn forget(&mut self, name: &str) {
        self.source.forget(name);
    }

    /// A field that does not make sense.
    pub(crate) fn fault(&self, field: impl AsRef<str>, reason: impl Into<String>) -> FieldError {
        FieldError { field: self.field(field.as_ref()), reason: reason.into(), hint: None }
    }

    /// A field that names what does not exist.
    pub(crate) fn unknown<'a>(
        &self,
        field: impl AsRef<str>,
        kind: &str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> FieldError {
        FieldError {
            hint: Some(names::nearest(name, known)),
            ..self.fault(field, names::missing(kind, name))
        }
    }

    /// A file that a field refers to as `reference` and that cannot be used.
    pub(crate) fn referred(&self, field: &str, reference: &str, fault: Fault) -> Error {
        Error::Referred { field: self.field(field), fault: fault.of(reference) }
    }
}

/// Whether the scene is described by a text of its own, and is not a mesh file.
fn is_text(path: &Path) -> bool {
    matches!(extension(path).as_str(), "toml" | "json")
}

fn nothing(path: &Path) -> FieldError {
    FieldError { field: Field::whole(path), reason: "cannot be read".into(), hint: None }
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
        let (path, source) = (of_toml.path.clone(), of_toml.source.clone());
        assert_eq!(SceneFile { path, source, ..of_json }, of_toml);
        let error =
            SceneFile::parse("{\n\"skim\": 3\n}", Path::new("s.json")).expect_err("no scene").to_string();
        assert_eq!(error, "s.json:2:1: there is no field `skim`: did you mean `skin`?");
        let error = SceneFile::parse("{\n", Path::new("s.json")).expect_err("no scene").to_string();
        assert!(error.starts_with("s.json:") && !error.contains('\n'), "{error}");
    }
}
