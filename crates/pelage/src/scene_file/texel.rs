//! What grows on a skin, as it is described: a kind, one of its presets, and what is different from it; or a texel file.

use std::fmt;
use std::path::PathBuf;

use pelage_texel::{BuildError, Kind, Preset, Procedure, Value};
use serde::de::{self, DeserializeSeed, Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::names;

/// What grows on a skin. In a scene file a table of one kind, `texel.grass = { preset = "lawn", count = 300 }`, or of a
/// texel file, `texel.file = "lawn.texel"`.
#[derive(Clone, Debug, PartialEq)]
pub enum TexelEntry {
    /// Content that a procedure grows, and a texel that is built of it.
    Grown {
        /// The content.
        kind: Kind,
        /// Voxels a side: a power of two from 2 to 512.
        resolution: u32,
    },
    /// The texel in the file of this path, relative to the scene file.
    File(String),
    /// The texel in the file of this path, which no scene file refers to: it may stand anywhere.
    Given(PathBuf),
}

impl Default for TexelEntry {
    /// Long fur.
    fn default() -> Self {
        Kind::default().into()
    }
}

impl<K: Into<Kind>> From<K> for TexelEntry {
    /// 128 voxels a side of it.
    fn from(kind: K) -> Self {
        Self::Grown { kind: kind.into(), resolution: 128 }
    }
}

impl TexelEntry {
    /// The content that `word` names: a kind (`grass`), one of its presets (`fur:plush`), or a file (`lawn.texel`).
    ///
    /// # Errors
    /// There is none of that name; the message says which there are.
    pub fn from_word(word: &str) -> Result<Self, String> {
        if word.ends_with(".texel") {
            return Ok(Self::Given(word.into()));
        }
        let (kind, name) = word.split_once(':').map_or((word, None), |(kind, name)| (kind, Some(name)));
        preset(kind, name).map(|preset| (preset.make)().into())
    }

    /// Content that a procedure grows: the settings, by name, are the fields of the kind's table in a scene file and their
    /// values, as they are written there. Of colours and pairs the brackets may be left out.
    ///
    /// # Errors
    /// The name or value that cannot be, and what could.
    pub fn grown(kind: &str, settings: &[(String, String)]) -> Result<Self, String> {
        let mut fields = toml::Table::new();
        for (name, text) in settings {
            if fields.insert(name.clone(), written(name, text)?).is_some() {
                return Err(format!("{kind}.{name} is set twice"));
            }
        }
        let entry = described(kind, fields)?;
        entry.fault().map_or(Ok(entry), |(field, reason)| Err(format!("{field} {reason}")))
    }

    /// The resolution, where it can still be chosen: a file has its own.
    pub fn resolution_mut(&mut self) -> Option<&mut u32> {
        match self {
            Self::Grown { resolution, .. } => Some(resolution),
            Self::File(_) | Self::Given(_) => None,
        }
    }

    /// The variant that is `count` after its own, or what grows from the seed that is, of kinds that have no variants; itself
    /// where there is no seed.
    pub(super) fn variant_after(&self, count: u32) -> Self {
        let Self::Grown { kind, resolution } = self else { return self.clone() };
        let varied = || {
            let mut table = toml::Table::try_from(kind).ok()?;
            let fields = table.get_mut(kind.name())?.as_table_mut()?;
            let field = if fields.contains_key("variant") { "variant" } else { "seed" };
            let number = fields.get_mut(field)?;
            *number = number.as_integer()?.wrapping_add(count.into()).max(0).into();
            table.try_into().ok()
        };
        Self::Grown { kind: varied().unwrap_or_else(|| kind.clone()), resolution: *resolution }
    }

    /// The texel of the kind that a key of a table names, from the key's value.
    pub(super) fn of_kind<'de, A: MapAccess<'de>>(kind: &str, table: &mut A) -> Result<Self, A::Error> {
        match kind {
            "file" => table.next_value().map(Self::File),
            kind => table.next_value_seed(Fields::of(kind).map_err(A::Error::custom)?),
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its domain, as in `fur.length`, and what is wrong with it.
    pub(super) fn fault(&self) -> Option<(String, String)> {
        let Self::Grown { kind, resolution } = self else { return None };
        let (field, reason) = if !resolution.is_power_of_two() || !(2..=512).contains(resolution) {
            ("resolution", "must be a power of two from 2 to 512".into())
        } else {
            match kind.validate() {
                Ok(()) => return None,
                Err(BuildError::Parameter { field, value, domain }) => {
                    (field, format!("is {value}, which is not in {domain}"))
                }
                Err(error) => ("count", error.to_string()),
            }
        };
        Some((format!("{}.{field}", kind.name()), reason))
    }
}

/// A preset of a kind; its default one where none is named.
fn preset(kind: &str, name: Option<&str>) -> Result<Preset, String> {
    let of_kind = || Kind::PRESETS.into_iter().filter(|preset| preset.kind == kind);
    if of_kind().next().is_none() {
        return Err(names::unknown("texel", kind, Kind::PRESETS.iter().map(|preset| preset.kind)));
    }
    let found = of_kind().find(|preset| name.is_none_or(|name| preset.name == name));
    found.ok_or_else(|| {
        names::unknown(&format!("preset of {kind}"), name.unwrap_or_default(), of_kind().map(|p| p.name))
    })
}

/// One of a few words.
pub(super) struct OneOf<'a>(pub &'a str, pub Vec<&'static str>);

impl<'de> DeserializeSeed<'de> for OneOf<'_> {
    type Value = String;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<String, D::Error> {
        let word = String::deserialize(deserializer)?;
        let Self(what, words) = self;
        if words.contains(&word.as_str()) {
            Ok(word)
        } else {
            Err(D::Error::custom(names::unknown(what, &word, words.into_iter())))
        }
    }
}

/// The fields of a kind. They are read one by one, so that a message can say which one is wrong, and where it is.
struct Fields {
    kind: Kind,
}

impl Fields {
    fn of(kind: &str) -> Result<Self, String> {
        Ok(Self { kind: (preset(kind, None)?.make)() })
    }
}

impl<'de> DeserializeSeed<'de> for Fields {
    type Value = TexelEntry;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<TexelEntry, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Fields {
    type Value = TexelEntry;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a table, as in `texel.{} = {{}}`", self.kind.name())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<TexelEntry, A::Error> {
        let kind = self.kind.name();
        let parameters = self.kind.parameters();
        let known = || parameters.iter().map(|p| p.name).chain(["preset", "resolution"]).collect();
        let what = format!("field of {kind}");
        let mut fields = toml::Table::new();
        while let Some(name) = table.next_key_seed(OneOf(&what, known()))? {
            let value = match parameters.iter().find(|p| p.name == name).map(|p| p.value) {
                Some(Value::Number(_)) => table.next_value::<f32>()?.into(),
                Some(Value::Pair(_)) => table.next_value::<[f32; 2]>()?.to_vec().into(),
                Some(Value::Color(_)) => table.next_value::<[f32; 3]>()?.to_vec().into(),
                None if name == "preset" => {
                    let presets = Kind::PRESETS.iter().filter(|preset| preset.kind == kind).map(|p| p.name);
                    table.next_value_seed(OneOf(&format!("preset of {kind}"), presets.collect()))?.into()
                }
                Some(Value::Whole(_)) | None => table.next_value_seed(Whole)?,
            };
            if fields.insert(name.clone(), value).is_some() {
                return Err(A::Error::custom(format!("`{name}` is there twice")));
            }
        }
        described(kind, fields).map_err(A::Error::custom)
    }
}

/// A whole number that is not negative.
struct Whole;

impl<'de> DeserializeSeed<'de> for Whole {
    type Value = toml::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<toml::Value, D::Error> {
        let whole = u64::deserialize(deserializer)?;
        i64::try_from(whole).map(Into::into).map_err(|_| D::Error::custom(format!("{whole} is too large")))
    }
}

/// The preset that `fields` name, changed by the others.
fn described(kind: &str, mut fields: toml::Table) -> Result<TexelEntry, String> {
    let name: Option<String> = fields.remove("preset").map(|v| read("preset", v)).transpose()?;
    let from = (preset(kind, name.as_deref())?.make)();
    let resolution: Option<u32> = fields.remove("resolution").map(|v| read("resolution", v)).transpose()?;
    // Field by field, so that a message can name the one that is wrong.
    let mut table = toml::Table::try_from(&from).map_err(|error| error.to_string())?;
    for (field, value) in fields {
        let Some(parameters) = table.get_mut(kind).and_then(toml::Value::as_table_mut) else {
            return Err(format!("`{kind}` has no fields"));
        };
        if !parameters.contains_key(&field) {
            let known = parameters.keys().map(String::as_str).chain(["preset", "resolution"]);
            return Err(names::unknown(&format!("field of {kind}"), &field, known));
        }
        parameters.insert(field.clone(), value);
        read::<Kind>(&field, table.clone().into())?;
    }
    let mut entry = TexelEntry::from(read::<Kind>(kind, table.into())?);
    if let (Some(chosen), Some(standard)) = (resolution, entry.resolution_mut()) {
        *standard = chosen;
    }
    Ok(entry)
}

/// A value from a command line: as in a scene file, but words need no quotes and lists no brackets.
fn written(field: &str, text: &str) -> Result<toml::Value, String> {
    let number =
        |text: &str| text.trim().parse::<toml::Value>().ok().filter(|v| v.is_integer() || v.is_float());
    let list = text.trim().trim_start_matches('[').trim_end_matches(']');
    if let Some(value) = number(text) {
        Ok(value)
    } else if field == "preset" {
        Ok(toml::Value::String(text.into()))
    } else {
        let numbers: Option<Vec<toml::Value>> = list.split(',').map(number).collect();
        numbers
            .map(toml::Value::Array)
            .ok_or_else(|| format!("{field}: `{text}` is no number, and no numbers with commas between"))
    }
}

/// A value as what it should be, or what is wrong with the field.
fn read<T: de::DeserializeOwned>(field: &str, value: toml::Value) -> Result<T, String> {
    value.try_into().map_err(|error: toml::de::Error| format!("{field}: {}", error.message()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pelage_texel::{Domain, Fur, Grass};

    use super::super::{ShareEntry, Source};
    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        texel: ShareEntry,
    }

    fn parse(text: &str) -> Result<TexelEntry, String> {
        let source = Source::parse(text, Path::new("s.toml")).expect("TOML");
        source.read::<Holder>().map(|h| h.texel.texel).map_err(|e| e.to_string())
    }

    #[test]
    fn every_preset_is_read_back() {
        for Preset { kind, name, make, .. } in Kind::PRESETS {
            let entry = TexelEntry::from(make());
            assert_eq!(parse(&format!("texel.{kind} = {{ preset = \"{name}\" }}")), Ok(entry.clone()));
            assert_eq!(TexelEntry::from_word(&format!("{kind}:{name}")), Ok(entry.clone()));
            assert_eq!(entry.fault(), None, "{kind}:{name}");
        }
        assert_eq!(parse("texel.fur = {}"), Ok(TexelEntry::default()));
        assert_eq!(TexelEntry::from_word("grass"), Ok(Grass::meadow().into()));
    }

    #[test]
    fn fields_change_the_preset() {
        let text = "[texel.fur]\npreset = \"plush\"\nresolution = 64\ncount = 7\ntip_color = [1, 0.5, 0]\nlength = 1";
        let fur = Fur { count: 7, tip_color: glam::Vec3::new(1.0, 0.5, 0.0), length: 1.0, ..Fur::plush() };
        assert_eq!(parse(text), Ok(TexelEntry::Grown { kind: fur.into(), resolution: 64 }));
    }

    #[test]
    fn files_are_texels_too() {
        assert_eq!(parse("texel = { file = \"a/lawn.texel\" }"), Ok(TexelEntry::File("a/lawn.texel".into())));
        assert_eq!(TexelEntry::from_word("/a/lawn.texel"), Ok(TexelEntry::Given("/a/lawn.texel".into())));
    }

    #[test]
    fn settings_are_fields() {
        let grown = |kind: &str, settings: &[(&str, &str)]| {
            let owned = settings.iter().map(|(name, text)| (name.to_string(), text.to_string()));
            TexelEntry::grown(kind, &owned.collect::<Vec<_>>())
        };
        let fur = Fur { count: 7, tip_color: glam::Vec3::new(1.0, 0.5, 0.0), length: 1.0, ..Fur::plush() };
        let settings = [
            ("preset", "plush"),
            ("resolution", "64"),
            ("count", "7"),
            ("tip_color", "1, 0.5,0"),
            ("length", "1"),
            ("lean", "[0,0.0]"),
        ];
        assert_eq!(grown("fur", &settings), Ok(TexelEntry::Grown { kind: fur.into(), resolution: 64 }));
        for (kind, name, text, message) in [
            ("gras", "count", "1", "there is no texel `gras`: did you mean `grass`?"),
            ("moss", "preset", "stars", "there is no preset of moss `stars`: did you mean `star`?"),
            ("moss", "lenth", "1", "there is no field of moss `lenth`: did you mean `length`?"),
            ("pile", "twist", "much", "twist: `much` is no number, and no numbers with commas between"),
            ("pile", "twist", "33", "pile.twist is 33, which is not in -32 to 32"),
            ("pile", "resolution", "100", "pile.resolution must be a power of two from 2 to 512"),
        ] {
            assert_eq!(grown(kind, &[(name, text)]), Err(message.to_owned()), "{kind} {name} {text}");
        }
        for (name, text) in [("twig_color", "1,0"), ("leaves", "1.5"), ("length", "1,2"), ("length", "nan")] {
            let error = grown("foliage", &[(name, text)]).unwrap_err();
            assert!(error.contains(name) && !error.contains('\n'), "{error}");
        }
        assert_eq!(grown("fur", &[("seed", "1"), ("seed", "2")]), Err("fur.seed is set twice".into()));
    }

    #[test]
    fn every_field_is_told_of() {
        for Preset { kind, name, make, .. } in Kind::PRESETS {
            let content = make();
            let table = toml::Table::try_from(&content).unwrap();
            let fields = table[kind].as_table().unwrap();
            let parameters = content.parameters();
            let mut told: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
            told.sort_unstable();
            let mut named: Vec<&str> = fields.keys().map(String::as_str).collect();
            named.sort_unstable();
            assert_eq!(told, named, "{kind}");
            // What is told of each is how it is set: the whole preset can be made by its settings.
            let settings: Vec<_> = parameters
                .iter()
                .map(|parameter| (parameter.name.into(), parameter.value.to_string()))
                .collect();
            assert_eq!(TexelEntry::grown(kind, &settings), Ok(content.clone().into()), "{kind}:{name}");
            // And the domain is where it is refused.
            for parameter in parameters.iter().filter(|parameter| parameter.domain != Domain::ANY) {
                let beyond = match parameter.value {
                    Value::Whole(_) => format!("{}", parameter.domain.hi + 1.0),
                    Value::Number(_) => format!("{:?}", parameter.domain.hi + 0.5),
                    Value::Pair(_) => format!("0,{:?}", parameter.domain.hi + 0.5),
                    Value::Color(_) => "0,0,1.5".into(),
                };
                let error = TexelEntry::grown(kind, &[(parameter.name.into(), beyond)]).unwrap_err();
                assert!(error.starts_with(&format!("{kind}.{} is ", parameter.name)), "{error}");
                assert!(error.ends_with(parameter.domain.name), "{error}");
            }
        }
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (text, message) in [
            ("texel.gras = {}", "there is no texel `gras`: did you mean `grass`?"),
            ("texel.fur = { preset = \"lung\" }", "there is no preset of fur `lung`: did you mean `long`?"),
            ("texel.leaves = { tlt = 1 }", "there is no field of leaves `tlt`: did you mean `tilt`?"),
            ("texel.fur = 3", "found 3: expected a table, as in `texel.fur = {}`"),
            ("texel.file = 3", "found 3: expected a string"),
            ("texel = { file = \"a.texel\", fur = {} }", "a texel is of one kind, as in `texel.fur = {}`"),
            ("texel = {}", "a texel is of one kind, as in `texel.fur = {}`"),
            ("texel = { fur = {}, grass = {} }", "a texel is of one kind, as in `texel.fur = {}`"),
            (
                "texel.fur = { count = -1 }",
                "count: found -1: expected a whole number, not negative and not too large",
            ),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with("s.toml:1:") && error.ends_with(message), "{text}: {error}");
        }
        for text in ["resolution = 1.5", "count = \"many\"", "tip_color = [1, 2]", "lean = 3", "preset = 1"] {
            let error = parse(&format!("texel.fur = {{ {text} }}")).unwrap_err();
            let field = text.split(' ').next().unwrap();
            assert!(error.contains(field) && !error.contains('\n'), "{error}");
        }
        for text in ["count = 0", "count = 1000000000", "clump = nan", "tip_color = [0, 0, 1.5]", "sides = 2"]
        {
            let (field, reason) = parse(&format!("texel.fur = {{ {text} }}")).unwrap().fault().unwrap();
            assert!(field.strip_prefix("fur.").is_some_and(|f| text.starts_with(f)), "{field} {reason}");
        }
        let many = parse("texel.fur = { count = 1000000, segments = 32, sides = 16 }").unwrap();
        assert_eq!(
            many.fault(),
            Some(("fur.count".into(), "1024000000 triangles would grow, and at most 50000000 do".into()))
        );
    }
}
