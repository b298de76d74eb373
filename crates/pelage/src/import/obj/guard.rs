//! What tobj is shown of an OBJ file.
//!
//! tobj names no lines, lets NaN pass, lends a corner without texture coordinates those of its neighbour, and
//! opens whatever `mtllib` names. So each line is checked here, and what is left is written out anew in one plain
//! form: finite numbers, indices that exist and count from 1, libraries that are already read.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;
use pelage_geom::Mesh;

use super::lines::Lines;
use super::mtl::{self, Library};
use crate::import::image::{Textures, srgb_to_linear};
use crate::import::{Fault, Files, ImportError, ImportOptions, Place, Warning};

/// An OBJ file of which every line has been checked.
pub(super) struct Guard<'a> {
    path: &'a Path,
    files: &'a Files,
    options: &'a ImportOptions,
    has_objects: bool,
    /// Whether vertices have colours behind their positions, and these are wanted.
    has_colors: bool,
    /// The statements for tobj. Its first texture coordinate is NaN and its first normal zero: they stand for
    /// none. An object's name is the number of its line, a space, and its name; `mtllib` names an index of
    /// `libraries`.
    pub(super) text: String,
    pub(super) libraries: Vec<Library>,
    pub(super) textures: Textures,
    pub(super) warnings: Vec<Warning>,
    /// What `l` elements say, where that is wanted.
    pub(super) lines: Lines,
    positions: usize,
    uvs: usize,
    normals: usize,
    faces: u64,
    opened: HashSet<PathBuf>,
    materials: HashSet<String>,
    fans: Noted,
    ignored: BTreeMap<String, Noted>,
}

/// How often something was met, and where first.
#[derive(Default)]
struct Noted {
    count: usize,
    first_line: usize,
}

impl Noted {
    fn note(&mut self, line: usize) {
        if self.count == 0 {
            self.first_line = line;
        }
        self.count += 1;
    }
}

impl<'a> Guard<'a> {
    /// Checks the file's lines and reads its material libraries.
    pub(super) fn check(
        path: &'a Path,
        files: &'a Files,
        options: &'a ImportOptions,
    ) -> Result<Self, ImportError> {
        let bytes = files.read(path).map_err(|e| e.at(path, Place::File))?;
        let source = String::from_utf8_lossy(&bytes);
        let mut guard = Self {
            path,
            files,
            options,
            has_objects: source.lines().any(|l| l.trim_start().starts_with("o ")),
            has_colors: options.content && source.lines().any(|l| color_of(l).is_some()),
            text: "vt nan nan\nvn 0 0 0\n".to_owned(),
            libraries: Vec::new(),
            textures: Textures::default(),
            warnings: Vec::new(),
            lines: Lines::default(),
            positions: 0,
            uvs: 0,
            normals: 0,
            faces: 0,
            opened: HashSet::new(),
            materials: HashSet::new(),
            fans: Noted::default(),
            ignored: BTreeMap::new(),
        };
        let mut lines = source.lines().enumerate();
        while let Some((index, mut line)) = lines.next() {
            let mut joined = String::new();
            // A backslash at the end joins the next line to this one.
            while let Some(head) = line.trim_end().strip_suffix('\\') {
                joined.push_str(head);
                joined.push(' ');
                line = lines.next().map_or("", |(_, next)| next);
            }
            if !joined.is_empty() {
                joined.push_str(line);
                line = &joined;
            }
            guard.statement(line, index + 1).map_err(|fault| fault.at(path, Place::Line(index + 1)))?;
        }
        guard.conclude();
        Ok(guard)
    }

    fn statement(&mut self, statement: &str, line: usize) -> Result<(), Fault> {
        let (keyword, name) = split_keyword(statement);
        // Numbers may be followed by a comment; names may contain a `#`.
        let rest = name.split('#').next().unwrap_or_default();
        match keyword {
            "" | "s" => {}
            comment if comment.starts_with('#') => {}
            "v" => self.vertex(rest)?,
            "vt" => {
                self.numbers::<2>(keyword, rest, 1, Mesh::POSITION_LIMIT)?;
                self.uvs += 1;
            }
            "vn" => {
                self.numbers::<3>(keyword, rest, 3, Mesh::POSITION_LIMIT)?;
                self.normals += 1;
            }
            "f" => self.face(rest, line)?,
            "l" if self.options.content => self.line(rest)?,
            "g" if self.has_objects => {}
            // Its line tells an object from another one of the same name.
            "o" | "g" => self.pass("o", format_args!("{line} {name}")),
            "usemtl" => self.material(name, line),
            "mtllib" => self.library(name, line)?,
            other => self.ignored.entry(other.chars().take(32).collect()).or_default().note(line),
        }
        Ok(())
    }

    fn pass(&mut self, keyword: &str, rest: impl std::fmt::Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{keyword} {rest}");
    }

    /// Passes on the first `N` numbers, of which `needed` must be there; the others are zero. Returns them.
    fn numbers<const N: usize>(
        &mut self,
        keyword: &str,
        text: &str,
        needed: usize,
        limit: f32,
    ) -> Result<[f32; N], Fault> {
        self.text.push_str(keyword);
        let mut words = text.split_whitespace();
        let mut numbers = [0.0; N];
        for (i, value) in numbers.iter_mut().enumerate() {
            let word = match words.next() {
                Some(word) => word,
                None if i < needed => {
                    return Err(Fault::Syntax(format!("expected {needed} numbers, found {i}")));
                }
                None => "0",
            };
            *value = number(word, limit)?;
            self.text.push(' ');
            self.text.push_str(word);
        }
        self.text.push('\n');
        Ok(numbers)
    }

    fn vertex(&mut self, text: &str) -> Result<(), Fault> {
        // In the file's unit and in metres.
        let limit = Mesh::POSITION_LIMIT / self.options.unit.max(1.0);
        let position = self.numbers::<3>("v", text, 3, limit)?;
        self.positions += 1;
        if self.has_colors {
            let mut color = [1.0; 3];
            for (value, word) in color.iter_mut().zip(color_of(text).into_iter().flatten()) {
                *value = number(word, 1e6)?.clamp(0.0, 1.0);
            }
            let color = color.map(srgb_to_linear);
            self.text.pop();
            let _ = writeln!(self.text, " {} {} {}", color[0], color[1], color[2]);
            self.lines.colors.push(color.into());
        }
        if self.options.content {
            self.lines.positions.push(Vec3::from(position));
        }
        Ok(())
    }

    fn line(&mut self, text: &str) -> Result<(), Fault> {
        let mut vertices = Vec::new();
        for word in text.split_whitespace() {
            let position = index(word.split('/').next(), "vertex", self.positions)?;
            let named =
                position.checked_sub(1).ok_or_else(|| Fault::Syntax(format!("`{word}` names no vertex")))?;
            vertices.push(named as u32);
        }
        if vertices.len() < 2 {
            return Err(Fault::Syntax(format!("a line needs two vertices, this has {}", vertices.len())));
        }
        let segments = self.lines.add(&vertices);
        self.count_faces(segments)
    }

    fn face(&mut self, text: &str, line: usize) -> Result<(), Fault> {
        self.text.push('f');
        let mut corners = 0;
        for word in text.split_whitespace() {
            let mut parts = word.split('/');
            let position = index(parts.next(), "vertex", self.positions)?;
            if position == 0 {
                return Err(Fault::Syntax(format!("`{word}` names no vertex")));
            }
            // What is missing becomes 1, which stands for none.
            let uv = 1 + index(parts.next(), "texture coordinate", self.uvs)?;
            let normal = 1 + index(parts.next(), "normal", self.normals)?;
            let _ = write!(self.text, " {position}/{uv}/{normal}");
            corners += 1;
        }
        self.text.push('\n');
        if corners < 3 {
            return Err(Fault::Syntax(format!("a face needs three corners, this has {corners}")));
        }
        if corners > 4 {
            self.fans.note(line);
        }
        self.count_faces(if corners == 4 { 1 } else { corners - 2 })
    }

    fn count_faces(&mut self, more: usize) -> Result<(), Fault> {
        self.faces += more as u64;
        let limit = self.options.limits.faces;
        if self.faces > limit {
            return Err(Fault::Limit { what: "faces", found: self.faces, limit });
        }
        Ok(())
    }

    fn material(&mut self, name: &str, line: usize) {
        let name = if name.is_empty() { mtl::UNNAMED } else { name };
        if self.materials.insert(name.to_owned()) {
            self.warn(line, format!("the material `{name}` is in no material library: a light grey instead"));
            self.hand_over(Library::of_one(name));
        }
        self.pass("usemtl", name);
        self.lines.material = Some(name.to_owned());
    }

    fn library(&mut self, names: &str, line: usize) -> Result<(), Fault> {
        // One name with spaces is more common than several names.
        let whole = self.files.resolve(names);
        let paths = match whole {
            Err(Fault::Io(_)) if names.contains(' ') => {
                names.split_whitespace().map(|n| (n, self.files.resolve(n))).collect()
            }
            whole => vec![(names, whole)],
        };
        for (name, path) in paths {
            // Once each, however often the file names it.
            if path.as_ref().is_ok_and(|p| !self.opened.insert(p.clone())) {
                continue;
            }
            let read = path.and_then(|p| {
                mtl::read(&p, self.files, self.options.content, &mut self.textures, &mut self.warnings)
                    .map_err(|e| match e {
                        // A missing library costs colours; a broken one is for its author to mend.
                        ImportError {
                            place: Place::File,
                            fault: fault @ (Fault::Io(_) | Fault::NotRegular),
                            ..
                        } => fault,
                        other => Fault::Syntax(other.to_string()),
                    })
            });
            match read {
                Ok(library) => self.hand_over(library),
                Err(fault @ (Fault::Io(_) | Fault::NotRegular | Fault::Outside(_))) => {
                    self.warn(line, format!("the material library `{name}` is left out: {fault}"));
                }
                Err(fault) => return Err(fault),
            }
        }
        Ok(())
    }

    fn hand_over(&mut self, library: Library) {
        self.materials.extend(library.by_name.keys().cloned());
        self.pass("mtllib", self.libraries.len());
        self.libraries.push(library);
    }

    fn warn(&mut self, line: usize, message: String) {
        self.warnings.push(Warning { file: self.path.to_owned(), place: Place::Line(line), message });
    }

    fn conclude(&mut self) {
        if self.fans.count > 0 {
            let message = format!("{} polygons of more than four corners cut into fans", self.fans.count);
            self.warn(self.fans.first_line, message);
        }
        for (keyword, noted) in std::mem::take(&mut self.ignored) {
            self.warn(noted.first_line, format!("`{keyword}` is not supported ({} times)", noted.count));
        }
    }
}

/// A line's first word, and what follows it.
pub(super) fn split_keyword(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (keyword, rest.trim_start())
}

/// The three words behind the position of a `v` statement, with or without its keyword, if there are: its colour, which
/// is sRGB as on a screen. (One word is a weight, which nobody uses.)
fn color_of(statement: &str) -> Option<[&str; 3]> {
    let text = statement.split('#').next().unwrap_or_default().trim();
    let mut words = text.strip_prefix("v ").unwrap_or(text).split_whitespace().skip(3);
    let color = [words.next()?, words.next()?, words.next()?];
    Some(color)
}

/// A number of at most this size.
pub(super) fn number(word: &str, limit: f32) -> Result<f32, Fault> {
    match word.parse::<f32>() {
        Ok(x) if x.abs() <= limit => Ok(x),
        _ => Err(Fault::NotANumber(word.to_owned())),
    }
}

/// The index, from 1, that OBJ counts from 1 or backwards from −1. Zero where the part is missing or empty.
fn index(part: Option<&str>, what: &'static str, count: usize) -> Result<usize, Fault> {
    let Some(text) = part.filter(|t| !t.is_empty()) else { return Ok(0) };
    let index: i64 = text.parse().map_err(|_| Fault::NotANumber(text.to_owned()))?;
    let found = if index < 0 { (count as i64).saturating_add(index).saturating_add(1) } else { index };
    match usize::try_from(found) {
        Ok(found) if (1..=count).contains(&found) => Ok(found),
        _ => Err(Fault::Index { what, index, count }),
    }
}
