//! Wavefront OBJ. [OBJ]
//!
//! Read line by line here rather than by a crate: each number and index has to be checked with its line in hand,
//! and a reader that is preceded by such a check has nothing left to do.
//!
//! An `o` begins a mesh; a `g` does so only in a file without any `o`, because groups often cut one surface into
//! parts, and a skin must not be cut there. Quads stay quads; larger polygons become fans, with a warning.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use pelage_geom::{Material, MaterialId, Mesh};

use super::image::Textures;
use super::mtl;
use super::weld::{Corner, Welder};
use super::{Fault, Files, ImportError, ImportOptions, Imported, Place, Up, Warning};

pub(crate) fn read(path: &Path, files: &Files, options: &ImportOptions) -> Result<Imported, ImportError> {
    let bytes = files.read(path).map_err(|e| e.at(path, Place::File))?;
    let text = String::from_utf8_lossy(&bytes);
    let has_objects = text.lines().any(|l| l.trim_start().starts_with("o "));
    let mut reader = Reader::new(path, files, options, has_objects);
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let mut joined = String::new();
        let mut line = line;
        // A backslash at the end joins the next line to this one.
        while let Some(head) = line.trim_end().strip_suffix('\\') {
            joined.push_str(head);
            joined.push(' ');
            line = lines.next().map_or("", |(_, next)| next);
        }
        if joined.is_empty() {
            reader.line(line, index + 1)?;
        } else {
            reader.line(&(joined + line), index + 1)?;
        }
    }
    Ok(reader.finish())
}

struct Reader<'a> {
    path: &'a Path,
    files: &'a Files,
    options: &'a ImportOptions,
    has_objects: bool,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    mesh: Welder,
    meshes: Vec<Mesh>,
    libraries: HashSet<PathBuf>,
    entries: Vec<mtl::Entry>,
    by_name: HashMap<String, MaterialId>,
    material: Option<MaterialId>,
    textures: Textures,
    faces: u64,
    corners: Vec<Corner>,
    fans: Noted,
    ignored: BTreeMap<String, Noted>,
    warnings: Vec<Warning>,
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

impl<'a> Reader<'a> {
    fn new(path: &'a Path, files: &'a Files, options: &'a ImportOptions, has_objects: bool) -> Self {
        Self {
            path,
            files,
            options,
            has_objects,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            mesh: Welder::default(),
            meshes: Vec::new(),
            libraries: HashSet::new(),
            entries: Vec::new(),
            by_name: HashMap::new(),
            material: None,
            textures: Textures::default(),
            faces: 0,
            corners: Vec::new(),
            fans: Noted::default(),
            ignored: BTreeMap::new(),
            warnings: Vec::new(),
        }
    }

    fn line(&mut self, line: &str, number: usize) -> Result<(), ImportError> {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        // Numbers may be followed by a comment; names may contain a `#`.
        let named = matches!(keyword, "o" | "g" | "usemtl" | "mtllib");
        let rest = if named { rest } else { rest.split('#').next().unwrap_or_default() }.trim();
        self.statement(keyword, rest, number).map_err(|fault| fault.at(self.path, Place::Line(number)))
    }

    fn statement(&mut self, keyword: &str, rest: &str, line: usize) -> Result<(), Fault> {
        match keyword {
            "" | "s" => {}
            comment if comment.starts_with('#') => {}
            "v" => {
                let [x, y, z] = numbers::<3>(rest, 3)?;
                let upright = match self.options.up {
                    Up::Y => Vec3::new(x, y, z),
                    Up::Z => Vec3::new(x, z, -y),
                };
                let position = upright * self.options.unit;
                if position.abs().max_element() > Mesh::POSITION_LIMIT {
                    return Err(Fault::NotANumber(rest.to_owned()));
                }
                self.positions.push(position);
            }
            "vt" => {
                let [u, v] = numbers::<2>(rest, 1)?;
                self.uvs.push(Vec2::new(u, v));
            }
            "vn" => {
                let [x, y, z] = numbers::<3>(rest, 3)?;
                self.normals.push(match self.options.up {
                    Up::Y => Vec3::new(x, y, z),
                    Up::Z => Vec3::new(x, z, -y),
                });
            }
            "f" => self.face(rest, line)?,
            "o" => self.begin(rest),
            "g" if !self.has_objects => self.begin(rest),
            "g" => {}
            "usemtl" => self.use_material(rest, line),
            "mtllib" => self.library(rest, line)?,
            other => self.ignored.entry(other.chars().take(32).collect()).or_default().note(line),
        }
        Ok(())
    }

    fn face(&mut self, rest: &str, line: usize) -> Result<(), Fault> {
        self.corners.clear();
        for word in rest.split_whitespace() {
            let mut parts = word.split('/');
            let position = index(parts.next(), "vertex", self.positions.len())?
                .ok_or_else(|| Fault::Syntax(format!("`{word}` names no vertex")))?;
            let uv = index(parts.next(), "texture coordinate", self.uvs.len())?;
            let normal = index(parts.next(), "normal", self.normals.len())?;
            self.corners.push(Corner {
                position: self.positions[position],
                uv: uv.map(|i| self.uvs[i]),
                normal: normal.map(|i| self.normals[i]),
            });
        }
        if self.corners.len() < 3 {
            return Err(Fault::Syntax(format!(
                "a face needs three corners, this has {}",
                self.corners.len()
            )));
        }
        if self.corners.len() > 4 {
            self.fans.note(line);
        }
        let material = match self.material {
            Some(material) => material,
            None => self.default_material(),
        };
        if let Some(entry) = self.entries.get(material.0 as usize) {
            for uv in self.corners.iter_mut().filter_map(|c| c.uv.as_mut()) {
                *uv = *uv * entry.uv_scale + entry.uv_offset;
            }
        }
        self.faces += self.mesh.polygon(&self.corners, material) as u64;
        let limit = self.options.limits.faces;
        if self.faces > limit {
            return Err(Fault::Limit { what: "faces", found: self.faces, limit });
        }
        Ok(())
    }

    fn begin(&mut self, name: &str) {
        let finished = std::mem::replace(&mut self.mesh, Welder::new(name));
        self.keep(finished);
    }

    fn keep(&mut self, welder: Welder) {
        if welder.is_empty() {
            return;
        }
        let (mesh, lost) = welder.finish();
        for (_, what) in [(lost.uvs, "texture coordinates"), (lost.normals, "normals")].iter().filter(|l| l.0)
        {
            let message =
                format!("mesh `{}`: only some faces have usable {what}, which are left out", mesh.name);
            self.warnings.push(Warning { file: self.path.to_owned(), place: Place::File, message });
        }
        self.meshes.push(mesh);
    }

    fn material_named(&mut self, name: &str) -> MaterialId {
        if let Some(&id) = self.by_name.get(name) {
            return id;
        }
        let material =
            Material { name: name.to_owned(), base_color: Vec3::splat(0.8), ..Material::default() };
        self.add(mtl::Entry { material, uv_scale: Vec2::ONE, uv_offset: Vec2::ZERO })
    }

    fn default_material(&mut self) -> MaterialId {
        let id = self.material_named("");
        self.material = Some(id);
        id
    }

    fn add(&mut self, entry: mtl::Entry) -> MaterialId {
        let id = MaterialId(self.entries.len() as u32);
        self.by_name.insert(entry.material.name.clone(), id);
        self.entries.push(entry);
        id
    }

    fn use_material(&mut self, name: &str, line: usize) {
        if !self.by_name.contains_key(name) {
            self.warn(line, format!("the material `{name}` is in no material library: a light grey instead"));
        }
        self.material = Some(self.material_named(name));
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
            if path.as_ref().is_ok_and(|p| !self.libraries.insert(p.clone())) {
                continue;
            }
            let read = path.and_then(|p| {
                mtl::read(&p, self.files, &mut self.textures, &mut self.warnings).map_err(|e| match e {
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
                Ok(entries) => {
                    for entry in entries {
                        self.add(entry);
                    }
                }
                Err(fault @ (Fault::Io(_) | Fault::NotRegular | Fault::Outside(_))) => {
                    self.warn(line, format!("the material library `{name}` is left out: {fault}"));
                }
                Err(fault) => return Err(fault),
            }
        }
        Ok(())
    }

    fn warn(&mut self, line: usize, message: String) {
        self.warnings.push(Warning { file: self.path.to_owned(), place: Place::Line(line), message });
    }

    fn finish(mut self) -> Imported {
        let last = std::mem::take(&mut self.mesh);
        self.keep(last);
        if self.fans.count > 0 {
            let message = format!("{} polygons of more than four corners cut into fans", self.fans.count);
            self.warn(self.fans.first_line, message);
        }
        for (keyword, noted) in std::mem::take(&mut self.ignored) {
            self.warn(noted.first_line, format!("`{keyword}` is not supported ({} times)", noted.count));
        }
        Imported {
            meshes: self.meshes,
            materials: self.entries.into_iter().map(|e| e.material).collect(),
            textures: self.textures.list,
            warnings: self.warnings,
            ..Imported::default()
        }
    }
}

/// The first `N` numbers of a line, at least `needed` of them; the others are zero, further ones are ignored.
fn numbers<const N: usize>(text: &str, needed: usize) -> Result<[f32; N], Fault> {
    let mut found = [0.0; N];
    let mut words = text.split_whitespace();
    for (i, value) in found.iter_mut().enumerate() {
        match words.next().map(|word| (word, word.parse::<f32>())) {
            Some((_, Ok(x))) if x.abs() <= Mesh::POSITION_LIMIT => *value = x,
            Some((word, _)) => return Err(Fault::NotANumber(word.to_owned())),
            None if i < needed => {
                return Err(Fault::Syntax(format!("expected {needed} numbers, found {i}")));
            }
            None => break,
        }
    }
    Ok(found)
}

/// An index as OBJ counts them: from 1, or backwards from −1. Nothing where the part is missing or empty.
fn index(part: Option<&str>, what: &'static str, count: usize) -> Result<Option<usize>, Fault> {
    let Some(text) = part.filter(|t| !t.is_empty()) else { return Ok(None) };
    let index: i64 = text.parse().map_err(|_| Fault::NotANumber(text.to_owned()))?;
    let resolved = if index > 0 { index - 1 } else { count as i64 + index };
    // Zero resolves to `count`, which is out of range like every other bad index.
    usize::try_from(resolved).ok().filter(|&i| i < count).map(Some).ok_or(Fault::Index { what, index, count })
}
