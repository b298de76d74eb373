//! What grows on a skin, as it is described: a kind, one of its presets, and what is different from it.

use pelage_texel::{BuildError, Kind, Preset, Procedure};
use serde::de::{self, Error};
use serde::{Deserialize, Deserializer};

use crate::names;

/// What grows on a skin. In a scene file a table of one kind: `texel.grass = { preset = "lawn", count = 300 }`.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelEntry {
    /// The content.
    pub kind: Kind,
    /// Voxels a side: a power of two from 2 to 512.
    pub resolution: u32,
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
        Self { kind: kind.into(), resolution: 128 }
    }
}

impl TexelEntry {
    /// The content that `word` names: a kind (`grass`), or one of its presets (`fur:plush`).
    ///
    /// # Errors
    /// There is none of that name; the message says which there are.
    pub fn from_word(word: &str) -> Result<Self, String> {
        let (kind, name) = word.split_once(':').map_or((word, None), |(kind, name)| (kind, Some(name)));
        preset(kind, name).map(|preset| (preset.make)().into())
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its domain, and what is wrong with it.
    pub(super) fn fault(&self) -> Option<(&'static str, String)> {
        if !self.resolution.is_power_of_two() || !(2..=512).contains(&self.resolution) {
            return Some(("resolution", "must be a power of two from 2 to 512".into()));
        }
        match self.kind.validate() {
            Ok(()) => None,
            Err(BuildError::Parameter { field, value, domain }) => {
                Some((field, format!("is {value}, which is not in {domain}")))
            }
            Err(error) => Some(("count", error.to_string())),
        }
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

impl<'de> Deserialize<'de> for TexelEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = toml::Table::deserialize(deserializer)?;
        let mut kinds = table.into_iter();
        match (kinds.next(), kinds.next()) {
            (Some((kind, toml::Value::Table(fields))), None) => described(&kind, fields),
            (Some((kind, _)), None) => Err(format!("`{kind}` must be a table, as in `texel.{kind} = {{}}`")),
            _ => Err("a texel is of one kind, as in `texel.fur = {}`".into()),
        }
        .map_err(D::Error::custom)
    }
}

/// The preset that `fields` name, changed by the others.
fn described(kind: &str, mut fields: toml::Table) -> Result<TexelEntry, String> {
    let name: Option<String> = fields.remove("preset").map(|v| read("preset", v)).transpose()?;
    let TexelEntry { kind: from, resolution } = (preset(kind, name.as_deref())?.make)().into();
    let resolution =
        fields.remove("resolution").map(|v| read("resolution", v)).transpose()?.unwrap_or(resolution);
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
    Ok(TexelEntry { kind: read(kind, table.into())?, resolution })
}

/// A value as what it should be, or what is wrong with the field.
fn read<T: de::DeserializeOwned>(field: &str, value: toml::Value) -> Result<T, String> {
    value.try_into().map_err(|error: toml::de::Error| format!("{field}: {}", error.message()))
}

#[cfg(test)]
mod tests {
    use pelage_texel::{Fur, Grass};

    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        texel: TexelEntry,
    }

    fn parse(text: &str) -> Result<TexelEntry, String> {
        toml::from_str::<Holder>(text).map(|h| h.texel).map_err(|e| e.message().to_owned())
    }

    #[test]
    fn every_preset_is_read_back() {
        for Preset { kind, name, make } in Kind::PRESETS {
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
        assert_eq!(parse(text), Ok(TexelEntry { resolution: 64, ..fur.into() }));
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (text, message) in [
            ("texel.gras = {}", "there is no texel `gras`: did you mean `grass`?"),
            ("texel.fur = { preset = \"lung\" }", "there is no preset of fur `lung`: did you mean `long`?"),
            ("texel.leaves = { tlt = 1 }", "there is no field of leaves `tlt`: did you mean `tilt`?"),
            ("texel.fur = 3", "`fur` must be a table, as in `texel.fur = {}`"),
            ("texel = {}", "a texel is of one kind, as in `texel.fur = {}`"),
            ("texel = { fur = {}, grass = {} }", "a texel is of one kind, as in `texel.fur = {}`"),
            ("texel.fur = { count = -1 }", "count: invalid value: integer `-1`, expected u32"),
        ] {
            assert_eq!(parse(text), Err(message.to_owned()), "{text}");
        }
        for text in ["resolution = 1.5", "count = \"many\"", "tip_color = [1, 2]", "lean = 3", "preset = 1"] {
            let error = parse(&format!("texel.fur = {{ {text} }}")).unwrap_err();
            let field = text.split(' ').next().unwrap();
            assert!(error.contains(field) && !error.contains('\n'), "{error}");
        }
        for text in ["count = 0", "count = 1000000000", "clump = nan", "tip_color = [0, 0, 1.5]", "sides = 2"]
        {
            let (field, reason) = parse(&format!("texel.fur = {{ {text} }}")).unwrap().fault().unwrap();
            assert!(text.starts_with(field), "{field} {reason}");
        }
        let many = parse("texel.fur = { count = 1000000, segments = 32, sides = 16 }").unwrap();
        assert_eq!(
            many.fault(),
            Some(("count", "1024000000 triangles would grow, and at most 50000000 do".into()))
        );
    }
}
