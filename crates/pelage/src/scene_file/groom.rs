//! `[[skin.groom]]`: what is done to a skin's vectors, and where.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use glam::Vec3;
use pelage_skin::groom::{
    Channel, Clump, Comb, Noise, Operation, Part, Plane, Smooth, Swirl, Tilt, Turn, Wind,
};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::{Deserialize, Deserializer, de};

use super::name_or_names;
use crate::schema;

/// One operation and its masks, as in `{ scale = 0.5, where = { sphere = { … } } }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Fields")]
pub struct GroomEntry {
    /// What is done.
    pub operation: Operation,
    /// Where; the masks multiply, and without any it is everywhere.
    pub masks: Vec<MaskEntry>,
}

/// One thing that is done to the vectors of a skin, and where.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = schema::one_operation)]
struct Fields {
    /// Where: masks, whose weights multiply; everywhere without any.
    #[serde(default, rename = "where", deserialize_with = "one_or_more")]
    #[schemars(schema_with = "schema::one_or_more::<MaskEntry>")]
    masks: Vec<MaskEntry>,
    /// Multiplies lengths.
    #[schemars(range(max = 1000), extend("exclusiveMinimum" = 0))]
    scale: Option<f32>,
    /// Sets lengths, in metres.
    #[schemars(extend("exclusiveMinimum" = 0))]
    height: Option<f32>,
    tilt: Option<Tilt>,
    comb: Option<Comb>,
    part: Option<Part>,
    swirl: Option<Swirl>,
    noise: Option<Noise>,
    /// Bends them down; 1 is 45° on a wall.
    #[schemars(range(min = 0, max = 100))]
    gravity: Option<f32>,
    wind: Option<Wind>,
    trim: Option<Plane>,
    clump: Option<Clump>,
    smooth: Option<Smooth>,
    density: Option<f32>,
    /// Moves where they reach, in metres.
    #[serde(rename = "move")]
    #[schemars(with = "Option<[f32; 3]>")]
    moved: Option<Vec3>,
    turn: Option<Turn>,
}

impl JsonSchema for GroomEntry {
    fn schema_name() -> Cow<'static, str> {
        "Groom".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Fields::json_schema(generator)
    }
}

impl TryFrom<Fields> for GroomEntry {
    type Error = String;

    fn try_from(fields: Fields) -> Result<Self, String> {
        let Fields { masks, scale, height, tilt, comb, part, swirl, noise, gravity, .. } = fields;
        let Fields { wind, trim, clump, smooth, density, moved, turn, .. } = fields;
        let given: Vec<Operation> = [
            scale.map(Operation::Scale),
            height.map(Operation::Height),
            tilt.map(Operation::Tilt),
            comb.map(Operation::Comb),
            part.map(Operation::Part),
            swirl.map(Operation::Swirl),
            noise.map(Operation::Noise),
            gravity.map(Operation::Gravity),
            wind.map(Operation::Wind),
            trim.map(Operation::Trim),
            clump.map(Operation::Clump),
            smooth.map(Operation::Smooth),
            density.map(Operation::Density),
            moved.map(Operation::Move),
            turn.map(Operation::Turn),
        ]
        .into_iter()
        .flatten()
        .collect();
        match <[Operation; 1]>::try_from(given) {
            Ok([operation]) => Ok(Self { operation, masks }),
            Err(given) => Err(format!(
                "a step of a groom does one thing, as in `scale = 0.5`, and this one does {}",
                if given.is_empty() { "none".into() } else { given.len().to_string() }
            )),
        }
    }
}

/// Where a step acts, as in `{ sphere = { … }, invert = true }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "MaskFields")]
pub struct MaskEntry {
    /// Where its weight is 1.
    pub region: RegionEntry,
    /// Takes 1 minus the weight instead.
    pub invert: bool,
}

/// Where a mask is 1.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionEntry {
    /// A ball.
    Sphere(SphereEntry),
    /// A box along the axes.
    Box(BoxEntry),
    /// What wears one of these materials.
    Material(Vec<String>),
    /// Patches by their index.
    Patches(Vec<u32>),
    /// Vertices of the skin by their index.
    Vertices(Vec<u32>),
    /// A vertex attribute of a glTF file: `_LENGTH`, `COLOR_0.r`.
    Attribute(String),
    /// An image.
    Image(ImageEntry),
}

/// A ball that fades: all of the operation within `radius`, none beyond `radius + falloff`. Metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereEntry {
    /// Its centre.
    #[schemars(with = "[f32; 3]")]
    pub centre: Vec3,
    /// Not negative.
    pub radius: f32,
    /// Not negative.
    #[serde(default)]
    pub falloff: f32,
}

/// A box that fades over `falloff` beyond its faces. Metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxEntry {
    /// The smallest coordinates.
    #[schemars(with = "[f32; 3]")]
    pub min: Vec3,
    /// The largest.
    #[schemars(with = "[f32; 3]")]
    pub max: Vec3,
    /// Not negative.
    #[serde(default)]
    pub falloff: f32,
}

/// An image over the texture coordinates. Its numbers count as they are: half grey is one half.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageEntry {
    /// A path relative to the scene file.
    pub file: String,
    /// Which part of its colour.
    #[serde(default)]
    pub channel: Channel,
}

/// Where a step acts: one region.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = schema::one_region)]
struct MaskFields {
    sphere: Option<SphereEntry>,
    #[serde(rename = "box")]
    cuboid: Option<BoxEntry>,
    /// What wears one of these materials.
    #[serde(default, deserialize_with = "some_names")]
    #[schemars(schema_with = "schema::names")]
    material: Option<Vec<String>>,
    /// Boxes of the skin, by their index.
    patches: Option<Vec<u32>>,
    /// Vertices of the skin, by their index.
    vertices: Option<Vec<u32>>,
    /// A vertex attribute of a glTF file, as in `_LENGTH` or `COLOR_0.r`.
    attribute: Option<String>,
    /// Where an image over the texture coordinates is white.
    #[serde(default, deserialize_with = "image")]
    #[schemars(schema_with = "schema::path_or::<ImageEntry>")]
    image: Option<ImageEntry>,
    /// Takes 1 minus the weight.
    #[serde(default)]
    invert: bool,
}

impl JsonSchema for MaskEntry {
    fn schema_name() -> Cow<'static, str> {
        "Mask".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        MaskFields::json_schema(generator)
    }
}

impl TryFrom<MaskFields> for MaskEntry {
    type Error = &'static str;

    fn try_from(fields: MaskFields) -> Result<Self, &'static str> {
        let MaskFields { sphere, cuboid, material, patches, vertices, attribute, image, invert } = fields;
        let mut given = [
            sphere.map(RegionEntry::Sphere),
            cuboid.map(RegionEntry::Box),
            material.map(RegionEntry::Material),
            patches.map(RegionEntry::Patches),
            vertices.map(RegionEntry::Vertices),
            attribute.map(RegionEntry::Attribute),
            image.map(RegionEntry::Image),
        ]
        .into_iter()
        .flatten();
        match (given.next(), given.next()) {
            (Some(region), None) => Ok(Self { region, invert }),
            (None, _) => Err("a mask needs a region, as in `where = { material = \"Fur\" }`"),
            _ => Err("a mask has one region: several masks are a list, as in `where = [{ … }, { … }]`"),
        }
    }
}

impl GroomEntry {
    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its domain, and what it must be.
    pub(super) fn validate(&self) -> Result<(), (String, String)> {
        self.operation.validate().map_err(|(field, reason)| (field.to_owned(), reason.to_owned()))?;
        for mask in &self.masks {
            mask.region
                .validate()
                .map_err(|(field, reason)| (format!("where.{field}"), reason.to_owned()))?;
        }
        Ok(())
    }
}

impl RegionEntry {
    fn validate(&self) -> Result<(), (&'static str, &'static str)> {
        const LENGTH: &str = "must not be negative, and finite";
        const POINT: &str = "must be finite";
        let length = |x: f32| x >= 0.0 && x.is_finite();
        let checks = match self {
            Self::Sphere(s) => vec![
                (s.centre.is_finite(), "sphere.centre", POINT),
                (length(s.radius), "sphere.radius", LENGTH),
                (length(s.falloff), "sphere.falloff", LENGTH),
            ],
            Self::Box(b) => vec![
                (b.min.is_finite() && b.max.is_finite(), "box", POINT),
                (b.min.cmple(b.max).all(), "box", "`min` must not be above `max`"),
                (length(b.falloff), "box.falloff", LENGTH),
            ],
            Self::Material(names) => vec![(!names.is_empty(), "material", "must name a material")],
            Self::Patches(list) => vec![(!list.is_empty(), "patches", "must not be empty")],
            Self::Vertices(list) => vec![(!list.is_empty(), "vertices", "must not be empty")],
            Self::Attribute(name) => vec![(!name.is_empty(), "attribute", "must not be an empty name")],
            Self::Image(_) => Vec::new(),
        };
        match checks.into_iter().find(|(ok, ..)| !ok) {
            Some((_, field, reason)) => Err((field, reason)),
            None => Ok(()),
        }
    }
}

fn some_names<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<String>>, D::Error> {
    name_or_names(deserializer).map(Some)
}

/// Reads a path, or a table.
fn image<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<ImageEntry>, D::Error> {
    struct Image;
    impl<'de> de::Visitor<'de> for Image {
        type Value = ImageEntry;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a path, or a table with `file` and `channel`")
        }

        fn visit_str<E: de::Error>(self, file: &str) -> Result<ImageEntry, E> {
            Ok(ImageEntry { file: file.to_owned(), channel: Channel::default() })
        }

        fn visit_map<A: de::MapAccess<'de>>(self, table: A) -> Result<ImageEntry, A::Error> {
            ImageEntry::deserialize(MapAccessDeserializer::new(table))
        }
    }
    deserializer.deserialize_any(Image).map(Some)
}

/// Reads one table, or a list of them.
fn one_or_more<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct OneOrMore<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> de::Visitor<'de> for OneOrMore<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a table or a list of tables")
        }

        fn visit_map<A: de::MapAccess<'de>>(self, table: A) -> Result<Vec<T>, A::Error> {
            T::deserialize(MapAccessDeserializer::new(table)).map(|one| vec![one])
        }

        fn visit_seq<A: de::SeqAccess<'de>>(self, list: A) -> Result<Vec<T>, A::Error> {
            Vec::deserialize(SeqAccessDeserializer::new(list))
        }
    }
    deserializer.deserialize_any(OneOrMore(PhantomData))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pelage_skin::groom::Field;

    use super::super::Source;
    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        groom: Vec<GroomEntry>,
    }

    fn parse(text: &str) -> Result<GroomEntry, String> {
        let source = Source::parse(&format!("[[groom]]\n{text}\n"), Path::new("s.toml")).expect("TOML");
        source.read::<Holder>().map(|mut h| h.groom.remove(0)).map_err(|e| e.to_string())
    }

    #[test]
    fn operations_and_masks_are_read() {
        assert_eq!(parse("scale = 0.5"), Ok(GroomEntry { operation: Operation::Scale(0.5), masks: vec![] }));
        let comb = parse("comb = { along = { away_from = [1, 2, 3] } }").map(|entry| entry.operation);
        let along = Field::AwayFrom(Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(comb, Ok(Operation::Comb(Comb { along, angle: 60.0 })));
        let masks = |text: &str| parse(&format!("gravity = 1\nwhere = {text}")).map(|entry| entry.masks);
        let material = RegionEntry::Material(vec!["Head".into()]);
        assert_eq!(
            masks("{ material = 'Head', invert = true }"),
            Ok(vec![MaskEntry { region: material.clone(), invert: true }])
        );
        let image = RegionEntry::Image(ImageEntry { file: "a.png".into(), channel: Channel::Red });
        assert_eq!(
            masks("[{ material = ['Head'] }, { image = { file = 'a.png', channel = 'red' } }]"),
            Ok([material, image].map(|region| MaskEntry { region, invert: false }).into())
        );
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (text, message) in [
            ("", "a step of a groom does one thing, as in `scale = 0.5`, and this one does none"),
            (
                "scale = 1\ngravity = 1",
                "a step of a groom does one thing, as in `scale = 0.5`, and this one does 2",
            ),
            ("scal = 1", "there is no field `scal`: did you mean `scale`?"),
            ("tilt = { angle = 3 }", "the field `towards` is missing"),
            ("tilt = { towards = [1, 0], angle = 3 }", "found a list of 2: expected a list of 3 numbers"),
            ("gravity = 1\nwhere = {}", "a mask needs a region, as in `where = { material = \"Fur\" }`"),
            ("gravity = 1\nwhere = 3", "found 3: expected a table or a list of tables"),
            ("gravity = 1\nwhere = { patches = [1], vertices = [2] }", "a mask has one region: "),
            ("comb = { along = { up = 1 } }", "there is no kind `up`: did you mean `uv`?"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(&format!(": {message}")), "{text}: {error}");
        }
        for (text, field) in [
            ("scale = 0", "scale"),
            ("smooth = { steps = 1001 }", "smooth.steps"),
            ("gravity = 1\nwhere = { sphere = { centre = [0, 0, 0], radius = -1 } }", "where.sphere.radius"),
            ("gravity = 1\nwhere = { box = { min = [0, 0, 0], max = [1, -1, 1] } }", "where.box"),
            ("gravity = 1\nwhere = { patches = [] }", "where.patches"),
        ] {
            assert_eq!(parse(text).unwrap().validate().unwrap_err().0, field, "{text}");
        }
    }
}
