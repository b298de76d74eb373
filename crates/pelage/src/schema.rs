//! What a scene file may hold, as a JSON Schema. Most of it comes from the structs that scene files are read into, and
//! what they say of themselves; here is what serde's attributes do not tell.

use std::borrow::Cow;

use pelage_texel::{Domain, Kind, Parameter, Preset, Procedure, Value as ParameterValue};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};

use crate::choices::Choice;
use crate::scene_file::{SceneFile, ShareEntry};

/// The JSON Schema (draft 2020-12) of scene files, TOML and JSON alike.
pub fn schema() -> Value {
    let generator = SchemaGenerator::new(SchemaSettings::draft2020_12());
    let mut schema = generator.into_root_schema_for::<SceneFile>();
    schema.insert("title".into(), "A scene of pelage".into());
    schema.insert("required".into(), json!(["geometry"]));
    schema.to_value()
}

/// A word, or a number where the word is one.
pub(crate) fn choice<C: Choice>(_: &mut SchemaGenerator) -> Schema {
    let words = C::WORDS.iter().map(|word| Value::from(*word));
    let numbers = C::WORDS.iter().filter_map(|word| word.parse::<u64>().ok()).map(Value::from);
    let listed: Vec<Value> = words.chain(numbers).collect();
    if C::EXPECTED.contains('#') {
        json_schema!({ "anyOf": [{ "enum": listed }, { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" }] })
    } else {
        json_schema!({ "enum": listed })
    }
}

/// A name, or a list of them.
pub(crate) fn names(_: &mut SchemaGenerator) -> Schema {
    let name = json!({ "type": "string", "minLength": 1 });
    json_schema!({ "anyOf": [name, { "type": "array", "items": name }] })
}

/// A table, or a list of them.
pub(crate) fn one_or_more<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let one = generator.subschema_for::<T>();
    json_schema!({ "anyOf": [one, { "type": "array", "items": one }] })
}

/// A path, or a table that holds one.
pub(crate) fn path_or<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [{ "type": "string" }, generator.subschema_for::<T>()] })
}

/// A step of a groom does one thing.
pub(crate) fn one_operation(schema: &mut Schema) {
    one_besides(schema, "where");
}

/// A mask has one region.
pub(crate) fn one_region(schema: &mut Schema) {
    one_besides(schema, "invert");
}

/// Asks for just one of the properties that are not `optional`.
fn one_besides(schema: &mut Schema, optional: &str) {
    let Some(Value::Object(properties)) = schema.get("properties") else { return };
    let one_of = properties.keys().filter(|name| *name != optional).map(|name| json!({ "required": [name] }));
    let one_of = one_of.collect();
    schema.insert("oneOf".into(), Value::Array(one_of));
}

impl JsonSchema for ShareEntry {
    fn schema_name() -> Cow<'static, str> {
        "Texel".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for Preset { kind, make, .. } in Kind::PRESETS {
            if !properties.contains_key(kind) {
                properties.insert(kind.into(), of_kind(&make()));
            }
        }
        let file =
            json!({ "type": "string", "description": "A texel file: a path relative to the scene file." });
        properties.insert("file".into(), file);
        let one_of: Vec<Value> = properties.keys().map(|name| json!({ "required": [name] })).collect();
        let weight = "How many copies it stands in: as great a part as its weight is of all.";
        let variants = "How many of its variants are grown.";
        properties.insert(
            "weight".into(),
            json!({ "type": "number", "minimum": 0, "default": 1, "description": weight }),
        );
        properties.insert(
            "variants".into(),
            json!({ "type": "integer", "minimum": 1, "maximum": 64, "default": 1, "description": variants }),
        );
        json_schema!({
            "type": "object",
            "description": "What grows: a table of one kind, or of a texel file.",
            "properties": properties,
            "additionalProperties": false,
            "oneOf": one_of,
        })
    }
}

/// The fields of a kind.
fn of_kind(kind: &Kind) -> Value {
    let presets = || Kind::PRESETS.into_iter().filter(|preset| preset.kind == kind.name());
    let names: Vec<&str> = presets().map(|preset| preset.name).collect();
    let about: Vec<String> = presets().map(|preset| format!("{}: {}", preset.name, preset.about)).collect();
    let mut properties = Map::new();
    properties.insert("preset".into(), json!({ "enum": names, "description": about.join("; ") }));
    let resolutions: Vec<u32> = (1..=9).map(|depth| 1 << depth).collect();
    let sides = "Voxels a side.";
    properties
        .insert("resolution".into(), json!({ "enum": resolutions, "default": 128, "description": sides }));
    for parameter in kind.parameters() {
        properties.insert(parameter.name.into(), of_parameter(&parameter));
    }
    json!({
        "type": "object",
        "description": kind.about(),
        "properties": properties,
        "additionalProperties": false,
    })
}

fn of_parameter(parameter: &Parameter) -> Value {
    let Domain { lo, hi, .. } = parameter.domain;
    let number = json!({ "type": "number", "minimum": lo, "maximum": hi });
    let list =
        |length: usize| json!({ "type": "array", "items": number, "minItems": length, "maxItems": length });
    let mut schema = match parameter.value {
        ParameterValue::Whole(_) if parameter.domain == Domain::ANY => {
            json!({ "type": "integer", "minimum": 0 })
        }
        ParameterValue::Whole(_) => json!({ "type": "integer", "minimum": lo as u64, "maximum": hi as u64 }),
        ParameterValue::Number(_) => number,
        ParameterValue::Pair(_) => list(2),
        ParameterValue::Color(_) => list(3),
    };
    let unit = if parameter.unit.is_empty() { String::new() } else { format!(" In {}.", parameter.unit) };
    schema["description"] = format!("{}{unit}", parameter.meaning).into();
    schema
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::*;

    fn scenes(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        let scene = |path: &PathBuf| path.extension().is_some_and(|e| e == "toml" || e == "json");
        files.into_iter().filter(scene).chain(folders.iter().flat_map(|folder| scenes(folder))).collect()
    }

    /// What is wrong with a scene by the schema.
    fn faults(scenes: &[Value]) -> Vec<Result<(), String>> {
        let (mut compiler, mut schemas) = (boon::Compiler::new(), boon::Schemas::new());
        compiler.add_resource("scene", schema()).expect("a resource");
        let schema = compiler.compile("scene", &mut schemas).expect("a schema");
        scenes.iter().map(|scene| schemas.validate(scene, schema).map_err(|e| e.to_string())).collect()
    }

    fn parsed(text: &str) -> Value {
        toml::from_str(text).expect("TOML")
    }

    #[test]
    fn every_scene_of_ours_fits() {
        let scenes = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets"));
        assert!(scenes.len() > 30);
        let read = |path: &PathBuf| parsed(&fs::read_to_string(path).expect("the scene"));
        let parsed: Vec<Value> = scenes.iter().map(read).collect();
        for (path, fault) in scenes.iter().zip(faults(&parsed)) {
            assert_eq!(fault, Ok(()), "{}", path.display());
        }
    }

    /// What the parser accepts fits, and what it refuses does not.
    #[test]
    fn it_accepts_what_the_parser_does() {
        let surface = "geometry = [{ surface.sphere.radius = 1 }]\n";
        for (text, right) in [
            ("", true),
            ("[[skin]]\non = 'a'\ntexel.fur = {}\nlayout = 'per-patch'", true),
            (
                "[[skin]]\non = ['a', 'b']\ntexel = [{ fur.preset = 'plush', weight = 2 }, { grass = {}, variants = 3 }]",
                true,
            ),
            ("[[skin]]\ncage = 'a.obj'\n[[skin.groom]]\nscale = 2\nwhere.image = 'a.png'", true),
            (
                "[[skin]]\ncage.file = 'a.obj'\n[[skin.groom]]\ncomb.along.uv = [1, 0]\nwhere = [{ patches = [1] }]",
                true,
            ),
            (
                "[render]\nrays = 16\nlod = 3\nbackground = '#a0b1c2'\ntone = 'none'\ncrop = [0, 1, 0, 1]",
                true,
            ),
            ("[camera.framed]\nazimuth = 3", true),
            (
                "[[light]]\nspot = { position = [0, 1, 2], direction = [0, -1, 0], intensity = [1, 1, 1] }",
                true,
            ),
            ("lights = 3", false),
            ("[[skin]]\nheigth = 1", false),
            ("[[skin]]\nheight = 0", false),
            ("[[skin]]\nheight = 'tall'", false),
            ("[[skin]]\nlean = [1, 2]", false),
            ("[[skin]]\nlayout = 'UV'", false),
            ("[[skin]]\ntexel.fur.clump = 1.5", false),
            ("[[skin]]\ntexel.fur.count = 0.5", false),
            ("[[skin]]\ntexel.fur.preset = 'lung'", false),
            ("[[skin]]\ntexel.fur.resolution = 100", false),
            ("[[skin]]\ntexel.gras = {}", false),
            ("[[skin]]\ntexel = { fur = {}, grass = {} }", false),
            ("[[skin]]\n[[skin.groom]]\n", false),
            ("[[skin]]\n[[skin.groom]]\nscale = 1\ngravity = 1", false),
            ("[[skin]]\n[[skin.groom]]\nscale = 1\nwhere = {}", false),
            ("[[skin]]\n[[skin.groom]]\ntilt.angle = 1", false),
            ("[render]\nrays = 5", false),
            ("[render]\nbackground = 'red'", false),
            ("[camera]\nnamed = 'a'\nframed = {}", false),
        ] {
            let text = format!("{surface}{text}");
            let accepted = SceneFile::parse(&text, Path::new("s.toml"));
            assert_eq!(accepted.is_ok(), right, "{text}: {accepted:?}");
            let fault = &faults(&[parsed(&text)])[0];
            assert_eq!(fault.is_ok(), right, "{text}: {fault:?}");
        }
        assert!(faults(&[json!({})])[0].is_err());
    }
}
