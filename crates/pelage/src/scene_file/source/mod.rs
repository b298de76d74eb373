//! The text of a scene file as a tree whose every part knows where it stands: TOML and JSON alike.
//!
//! | file | does |
//! |---|---|
//! | `parse.rs` | text to tree |
//! | `read.rs` | tree to whatever derives serde's `Deserialize`, with the place of what does not fit |

pub(super) mod parse;
mod read;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use read::Misread;
use serde::Deserialize;

use crate::error::{Field, FieldError, Span};

/// What a scene was read from, so that messages can say where in it something stands. Nothing for a scene that was not
/// read from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    path: PathBuf,
    /// Unless it is a part of a binary file.
    text: Option<Arc<str>>,
    root: Arc<Node>,
    /// What the skins are called in messages, where they do not stand in a list of skins.
    labels: Vec<String>,
}

/// A value and where it stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Node {
    at: Range<usize>,
    value: Value,
    /// Whether it was wrong and is passed over when the rest is read.
    removed: bool,
}

#[derive(Clone, Debug, Default, PartialEq)]
enum Value {
    /// In the order of the file.
    Table(Vec<Entry>),
    List(Vec<Node>),
    Text(String),
    Whole(i128),
    Number(f64),
    Truth(bool),
    /// Of TOML.
    Date,
    /// `null` of JSON.
    #[default]
    Nothing,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key: String,
    at: Range<usize>,
    node: Node,
}

/// One step on the way from the root to a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

impl Source {
    /// The tree of a text: JSON where the name of the file ends in `.json`, else TOML.
    ///
    /// # Errors
    /// Everything that is no TOML (the first thing that is no JSON), each with its place.
    pub(crate) fn parse(text: &str, path: &Path) -> Result<Self, Vec<FieldError>> {
        let parsed = if crate::import::extension(path) == "json" {
            parse::json(text).map_err(|fault| vec![fault])
        } else {
            parse::toml(text)
        };
        let located = |(at, reason)| {
            let span = Some(Box::new(Span::of(text, at)));
            FieldError { field: Field { span, ..Field::whole(path) }, reason, hint: None }
        };
        let root = parsed.map_err(|faults| faults.into_iter().map(located).collect::<Vec<_>>())?;
        Ok(Self { path: path.to_owned(), text: Some(text.into()), root: Arc::new(root), labels: Vec::new() })
    }

    /// A list of skins that stand in different places of a file, each with what goes before the names of its fields.
    pub(super) fn of_skins(path: &Path, text: Option<&str>, skins: Vec<(String, Node)>) -> Self {
        let (labels, nodes) = skins.into_iter().unzip();
        let root = Node::table([("skin", Node { value: Value::List(nodes), ..Node::default() })]);
        Self { path: path.to_owned(), text: text.map(Into::into), root: Arc::new(root), labels }
    }

    /// What the tree describes.
    ///
    /// # Errors
    /// The first thing in it that is not of the right name or type.
    pub(crate) fn read<'a, T: Deserialize<'a>>(&'a self) -> Result<T, FieldError> {
        T::deserialize(&*self.root).map_err(|misread| self.error(&misread))
    }

    /// What the tree describes without everything that is wrong in it, which is passed over from now on, and the errors,
    /// in the order of the file. `None` if nothing is left.
    pub(crate) fn read_all<T: for<'a> Deserialize<'a>>(&mut self) -> (Option<T>, Vec<FieldError>) {
        /// So many mistakes are enough to tell of.
        const MOST: usize = 100;
        let mut errors = Vec::new();
        let mut read = None;
        while errors.len() < MOST {
            match T::deserialize(&*self.root) {
                Ok(whole) => {
                    read = Some(whole);
                    break;
                }
                Err(misread) => {
                    if !self.root.explains(&misread) {
                        errors.push(self.error(&misread));
                    }
                    if misread.steps.is_empty() {
                        break;
                    }
                    Arc::make_mut(&mut self.root).remove(&misread.steps);
                }
            }
        }
        errors.sort_by_key(|error| error.field.span.as_ref().map_or(0, |span| span.bytes.start));
        (read, errors)
    }

    fn error(&self, misread: &Misread) -> FieldError {
        let table = misread.steps.split_last().filter(|_| misread.unknown).map(|(_, table)| table);
        let steps = table.unwrap_or(&misread.steps);
        let span = misread.at.clone().and_then(|at| self.span(at));
        let field = Field { file: self.path.clone(), name: self.name(steps), span };
        FieldError { field, reason: misread.reason.clone(), hint: misread.hint.clone() }
    }

    /// The field of this name, as in `skin[0].height`. Its span is that of the innermost table in which it would stand,
    /// where it does not. Numbers of entries are those of the scene that was read, and become those of the file.
    pub(crate) fn field(&self, name: &str) -> Field {
        let (steps, at) = self.root.find(&steps_of(name));
        Field { file: self.path.clone(), name: self.name(&steps), span: at.and_then(|at| self.span(at)) }
    }

    fn span(&self, at: Range<usize>) -> Option<Box<Span>> {
        self.text.as_ref().map(|text| Box::new(Span::of(text, at)))
    }

    fn name(&self, steps: &[Step]) -> String {
        match steps {
            [Step::Key(skin), Step::Index(index), rest @ ..]
                if skin == "skin" && *index < self.labels.len() =>
            {
                let label = &self.labels[*index];
                // The label ends in what joins it to the name of a field.
                let end = label.rfind('.').filter(|_| rest.is_empty()).unwrap_or(label.len());
                format!("{}{}", &label[..end], name_of(rest))
            }
            steps => name_of(steps),
        }
    }

    /// Whether the field of this name, as messages have it, or a part of it was wrong and is passed over.
    pub(crate) fn is_spoilt(&self, name: &str) -> bool {
        let mut node = &*self.root;
        for step in steps_of(name) {
            match node.in_file(&step) {
                Some(next) if !next.removed => node = next,
                other => return other.is_some(),
            }
        }
        node.is_spoilt()
    }

    /// Passes over the field of this name, which no longer counts: something else has taken its place.
    pub(crate) fn forget(&mut self, name: &str) {
        if name == "skin" {
            self.labels.clear();
        }
        Arc::make_mut(&mut self.root).remove(&steps_of(name));
    }
}

/// How a tree is looked at and put together.
impl Node {
    /// A table of these.
    pub(super) fn table<const N: usize>(entries: [(&str, Self); N]) -> Self {
        let entry = |(key, node): (&str, Self)| Entry { key: key.to_owned(), at: node.at.clone(), node };
        Self { value: Value::Table(entries.into_iter().map(entry).collect()), ..Self::default() }
    }

    /// A text that stands where another value does.
    pub(super) fn text_at(text: &str, other: &Self) -> Self {
        Self { at: other.at.clone(), value: Value::Text(text.to_owned()), removed: false }
    }

    /// The same where another value stands.
    pub(super) fn at(mut self, other: &Self) -> Self {
        self.at = other.at.clone();
        if let Value::Table(entries) = &mut self.value {
            entries.iter_mut().for_each(|entry| entry.at = other.at.clone());
        }
        self
    }

    /// The value of this name in a table.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        self.entries().find(|(name, _)| *name == key).map(|(_, node)| node)
    }

    /// What a table holds.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&str, &Self)> {
        let entries = if let Value::Table(entries) = &self.value { &entries[..] } else { &[] };
        entries.iter().map(|entry| (entry.key.as_str(), &entry.node))
    }

    /// Adds to a table, or puts into it in place of what is called so.
    pub(super) fn put(&mut self, key: &str, node: Self) {
        if let Value::Table(entries) = &mut self.value {
            entries.retain(|entry| entry.key != key);
            entries.push(Entry { key: key.to_owned(), at: node.at.clone(), node });
        }
    }

    /// What the list of this name in a table holds.
    pub(super) fn list(&self, key: &str) -> &[Self] {
        match self.get(key).map(|node| &node.value) {
            Some(Value::List(nodes)) => nodes,
            _ => &[],
        }
    }

    /// The text of this name in a table.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        match self.get(key).map(|node| &node.value) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// The index of this name in a table.
    pub(super) fn index(&self, key: &str) -> Option<usize> {
        match self.get(key).map(|node| &node.value) {
            Some(Value::Whole(index)) => usize::try_from(*index).ok(),
            _ => None,
        }
    }
}

/// What a step leads to.
enum Part<'a> {
    /// Which step it is in the file, where that stands, and the value.
    Present(Step, &'a Range<usize>, &'a Node),
    Removed,
}

impl Node {
    /// What a step leads to. A value stands for a list that holds only it, as serde's attributes allow.
    fn child(&self, step: &Step) -> Option<Part<'_>> {
        match (&self.value, step) {
            (Value::Table(entries), Step::Key(key)) => {
                let entry = entries.iter().find(|entry| entry.key == *key)?;
                let step = Step::Key(key.clone());
                Some(if entry.node.removed {
                    Part::Removed
                } else {
                    Part::Present(step, &entry.at, &entry.node)
                })
            }
            (Value::List(nodes), Step::Index(index)) => {
                let (i, node) = nodes.iter().enumerate().filter(|(_, node)| !node.removed).nth(*index)?;
                Some(Part::Present(Step::Index(i), &node.at, node))
            }
            // What one table does not name, one of a list that holds no other does not name either.
            (Value::List(nodes), Step::Key(_)) => match &nodes[..] {
                [only] => only.child(step),
                _ => None,
            },
            (_, Step::Index(0)) => Some(Part::Present(Step::Index(0), &self.at, self)),
            _ => None,
        }
    }

    /// The way in the file to what is reached so in what was read, and where it stands.
    fn find(&self, wanted: &[Step]) -> (Vec<Step>, Option<Range<usize>>) {
        let (mut node, mut at) = (self, None);
        let mut steps = Vec::new();
        for step in wanted {
            let (step, key, child) = match node.child(step) {
                Some(Part::Present(step, key, child)) => (step, key, child),
                // What took its place does not stand here.
                Some(Part::Removed) => {
                    at = None;
                    break;
                }
                None => break,
            };
            // Of a table its name, or its header; of anything else what it is.
            let table = matches!(child.value, Value::Table(_));
            at = Some(if table { key.clone() } else { child.at.clone() });
            node = child;
            steps.push(step);
        }
        steps.extend_from_slice(wanted.get(steps.len()..).unwrap_or_default());
        (steps, at)
    }

    /// What a step leads to, removed or not.
    fn in_file(&self, step: &Step) -> Option<&Self> {
        match (&self.value, step) {
            (Value::Table(entries), Step::Key(key)) => {
                entries.iter().find(|entry| entry.key == *key).map(|entry| &entry.node)
            }
            (Value::List(nodes), Step::Index(index)) => nodes.get(*index),
            _ => None,
        }
    }

    /// Whether a misreading is only what something removed has left.
    fn explains(&self, misread: &Misread) -> bool {
        let mut node = self;
        for step in &misread.steps {
            let Some(next) = node.in_file(step) else { return false };
            node = next;
        }
        match (&node.value, &misread.missing) {
            (Value::Table(entries), Some(name)) => {
                entries.iter().any(|entry| entry.node.removed && entry.key == *name)
            }
            (Value::Table(entries), None) => entries.iter().any(|entry| entry.node.removed),
            (Value::List(nodes), _) => nodes.iter().any(|node| node.removed),
            _ => false,
        }
    }

    fn is_spoilt(&self) -> bool {
        self.removed
            || match &self.value {
                Value::Table(entries) => entries.iter().any(|entry| entry.node.is_spoilt()),
                Value::List(nodes) => nodes.iter().any(Self::is_spoilt),
                _ => false,
            }
    }

    fn remove(&mut self, steps: &[Step]) {
        let Some((first, rest)) = steps.split_first() else {
            self.removed = true;
            return;
        };
        match (&mut self.value, first) {
            (Value::Table(entries), Step::Key(key)) => {
                // Of keys that stand there twice, both.
                for entry in entries.iter_mut().filter(|entry| entry.key == *key) {
                    entry.node.remove(rest);
                }
            }
            (Value::List(nodes), Step::Index(index)) => {
                if let Some(node) = nodes.get_mut(*index) {
                    node.remove(rest);
                }
            }
            _ => {}
        }
    }
}

/// As in `skin[0].height`.
fn name_of(steps: &[Step]) -> String {
    let mut name = String::new();
    for step in steps {
        match step {
            Step::Key(key) if name.is_empty() => name.push_str(key),
            Step::Key(key) => name.extend([".", key]),
            Step::Index(index) => name.push_str(&format!("[{index}]")),
        }
    }
    name
}

fn steps_of(name: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    for part in name.split('.').filter(|part| !part.is_empty()) {
        let (key, indices) = part.split_once('[').unwrap_or((part, ""));
        steps.push(Step::Key(key.to_owned()));
        steps
            .extend(indices.split('[').filter_map(|i| i.trim_end_matches(']').parse().ok()).map(Step::Index));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str, name: &str) -> Source {
        Source::parse(text, Path::new(name)).expect("a text")
    }

    #[test]
    fn fields_have_places() {
        let toml = source(
            "a = 1\n[[skin]]\n[[skin]]\n\"héight\" = 2\nlean = [1, \"x\"]\ntexel.fur.count = 3\n",
            "s.toml",
        );
        let place = |source: &Source, name: &str| source.field(name).span.map(|s| (s.line, s.column));
        assert_eq!(place(&toml, "a"), Some((1, 5)));
        assert_eq!(place(&toml, "skin[1].héight"), Some((4, 12)));
        assert_eq!(place(&toml, "skin[1].lean[1]"), Some((5, 12)));
        assert_eq!(place(&toml, "skin[1].texel.fur.count"), Some((6, 19)));
        // What is not there would be in its table.
        assert_eq!(place(&toml, "skin[1].texel.fur.clump"), Some((6, 7)));
        assert_eq!(place(&toml, "skin[1].folds").map(|(line, _)| line), Some(3));
        assert_eq!(place(&toml, "render.size"), None);
        let json = source("{ \"skin\": [\n{ \"lean\": [0, 1] }] }", "s.json");
        assert_eq!(place(&json, "skin[0].lean[1]"), Some((2, 15)));
        assert_eq!(place(&json, "skin[0].lean"), Some((2, 11)));
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Part {
        need: u32,
        #[serde(default)]
        size: [f32; 2],
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Whole {
        #[serde(default)]
        part: Vec<Part>,
    }

    #[test]
    fn mistakes_are_all_found_and_the_rest_is_read() {
        let text = "other = 1\n[[part]]\nneed = -1\n[[part]]\nneed = 2\nsize = [1, 2, 3]\n\
                    [[part]]\nneed = 3\nsize = [1, '2']\n[[part]]\nsize = [5, 6]\n[[part]]\nneed = 5\n";
        let mut source = source(text, "s.toml");
        let (whole, errors) = source.read_all::<Whole>();
        let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
        assert_eq!(
            errors,
            [
                "s.toml:1:1: there is no field `other`: there are `part`",
                "s.toml:3:8: part[0].need: found -1: expected a whole number, not negative and not too large",
                "s.toml:6:8: part[1].size: found a list of 3: expected a list of 2",
                "s.toml:9:12: part[2].size[1]: found \"2\": expected a number",
                "s.toml:10:1: part[3]: the field `need` is missing",
            ]
        );
        let part = |need, size| Part { need, size };
        assert_eq!(whole, Some(Whole { part: [2, 3, 5].map(|need| part(need, [0.0; 2])).into() }));
        // Of those that were read, the third is the fifth of the file.
        assert_eq!(source.field("part[2].need").name, "part[4].need");
        assert!(source.is_spoilt("part[0]") && !source.is_spoilt("part[4]"));
    }
}
