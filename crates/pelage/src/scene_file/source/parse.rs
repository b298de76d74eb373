//! TOML and JSON to a tree of values that know where they stand.

use std::ops::Range;

use jsonc_parser::ast;
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, CommentCollectionStrategy, ParseOptions, parse_to_ast};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Entry, Node, Value};

/// A place in the text, and what is wrong there.
type Fault = (Range<usize>, String);

/// # Errors
/// Everything that is no TOML.
pub(super) fn toml(text: &str) -> Result<Node, Vec<Fault>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let fault =
            |error: &toml::de::Error| (error.span().unwrap_or_default(), error.message().replace('\n', ", "));
        return Err(errors.iter().map(fault).collect());
    }
    let at = table.span();
    Ok(Node { at, value: of_table(table.get_ref()), removed: false })
}

fn of_table(table: &DeTable<'_>) -> Value {
    let entry = |(key, value): (&Spanned<_>, _)| {
        let text: &std::borrow::Cow<'_, str> = key.get_ref();
        Entry { key: text.to_string(), at: key.span(), node: of_toml(value) }
    };
    let mut entries: Vec<Entry> = table.iter().map(entry).collect();
    // The parser sorts them by name.
    entries.sort_by_key(|entry| entry.at.start);
    Value::Table(entries)
}

fn of_toml(value: &Spanned<DeValue<'_>>) -> Node {
    let plain = |digits: &str| digits.replace('_', "");
    let node = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => {
            let whole = i128::from_str_radix(&plain(number.as_str()), number.radix());
            whole.map_or(Value::Number(f64::NAN), Value::Whole)
        }
        DeValue::Float(number) => Value::Number(plain(number.as_str()).parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => Value::Truth(*truth),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(list) => Value::List(list.iter().map(of_toml).collect()),
        DeValue::Table(table) => of_table(table),
    };
    Node { at: value.span(), value: node, removed: false }
}

/// # Errors
/// The first thing that is no JSON.
pub(in super::super) fn json(text: &str) -> Result<Node, Fault> {
    // serde_json has the better messages, and a limit to how deep a file may be; the other parser tells places.
    if let Err(error) = serde_json::from_str::<serde_json::Value>(text) {
        let line_start: usize =
            text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
        let byte = (line_start + error.column().saturating_sub(1)).min(text.len());
        let at = (0..=byte).rev().find(|&at| text.is_char_boundary(at)).unwrap_or_default();
        let message = error.to_string();
        let reason = message.split(" at line ").next().unwrap_or_default();
        return Err((at..at, reason.to_owned()));
    }
    let collect = CollectOptions { comments: CommentCollectionStrategy::Off, tokens: false };
    let parsed = parse_to_ast(text, &collect, &ParseOptions::default()).map_err(|error| {
        let at = error.range();
        (at.start..at.end, error.kind().to_string())
    })?;
    Ok(parsed.value.as_ref().map(of_json).unwrap_or_default())
}

fn of_json(value: &ast::Value<'_>) -> Node {
    let node = match value {
        ast::Value::StringLit(text) => Value::Text(text.value.to_string()),
        ast::Value::NumberLit(number) => match number.value.parse() {
            Ok(whole) => Value::Whole(whole),
            Err(_) => Value::Number(number.value.parse().unwrap_or(f64::NAN)),
        },
        ast::Value::BooleanLit(truth) => Value::Truth(truth.value),
        ast::Value::NullKeyword(_) => Value::Nothing,
        ast::Value::Array(list) => Value::List(list.elements.iter().map(of_json).collect()),
        ast::Value::Object(object) => {
            let entry = |property: &ast::ObjectProp<'_>| {
                let at = property.name.range();
                let key = property.name.as_str().to_owned();
                Entry { key, at: at.start..at.end, node: of_json(&property.value) }
            };
            Value::Table(object.properties.iter().map(entry).collect())
        }
    };
    let at = value.range();
    Node { at: at.start..at.end, value: node, removed: false }
}
