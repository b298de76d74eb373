//! Materials of OBJ files.
//!
//! | keyword | becomes |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour and its texture (`-o` and `-s` move and scale the texture coordinates) |
//! | `Ks`; `Pr`, else `Ns` | specular albedo (the mean of the three), roughness: m = 2/α² − 2 read backwards |
//! | `Ke` | emission |
//! | `Pm` | a metal's base colour is its specular one: darkens the diffuse by 1 − metalness |
//! | `d`, else 1 − `Tr`; for content `map_d` | alpha, to be blended: of `map_d` the alpha channel, else how bright it is |
//!
//! Everything else (bump maps, …) is ignored. tobj reads these lines
//! after they have been checked: it panics on two numbers after `Kd`, and its errors name no line.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use glam::{Vec2, Vec3};
use pelage_geom::{Alpha, AlphaMode, Material, TextureId};

use super::guard::{number, split_keyword};
use crate::import::image::Textures;
use crate::import::{Fault, Files, ImportError, Place, Warning};

/// What a material is called whose name the file leaves out.
pub(super) const UNNAMED: &str = "unnamed";

/// The largest number in a library.
const LIMIT: f32 = 1e12;

/// A material, and how it moves the texture coordinates of the faces that wear it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) material: Material,
    pub(super) uv_scale: Vec2,
    pub(super) uv_offset: Vec2,
}

impl Default for Entry {
    /// What a file says nothing about is a light grey.
    fn default() -> Self {
        let material = Material { base_color: Vec3::splat(0.8), ..Material::default() };
        Self { material, uv_scale: Vec2::ONE, uv_offset: Vec2::ZERO }
    }
}

/// The materials of a library, in its order: as tobj has them, for its own use, and as they are kept.
pub(super) struct Library {
    pub(super) materials: Vec<tobj::Material>,
    /// The last one of each name.
    pub(super) by_name: HashMap<String, usize>,
    pub(super) entries: Vec<Entry>,
}

impl Library {
    /// A material of which only the name is known.
    pub(super) fn of_one(name: &str) -> Self {
        let material = tobj::Material { name: name.to_owned(), ..Default::default() };
        Self {
            entries: vec![entry(&material)],
            materials: vec![material],
            by_name: HashMap::from([(name.to_owned(), 0)]),
        }
    }
}

/// Reads a library and the textures that it names; those of alpha only for `content`.
pub(super) fn read(
    path: &Path,
    files: &Files,
    content: bool,
    textures: &mut Textures,
    warnings: &mut Vec<Warning>,
) -> Result<Library, ImportError> {
    let bytes = files.read(path).map_err(|e| e.at(path, Place::File))?;
    let mut checked = String::new();
    // Of each material, the lines of its textures: colour, alpha.
    let mut lines = Vec::new();
    for (index, line) in String::from_utf8_lossy(&bytes).lines().enumerate() {
        check(line, index + 1, &mut checked, &mut lines).map_err(|e| e.at(path, Place::Line(index + 1)))?;
    }
    let (materials, by_name) = tobj::load_mtl_buf(&mut checked.as_bytes())
        .map_err(|e| Fault::Syntax(e.to_string()).at(path, Place::File))?;
    let mut entries: Vec<_> = materials.iter().map(entry).collect();
    for ((entry, material), [color_line, alpha_line]) in entries.iter_mut().zip(&materials).zip(lines) {
        let mut kept = |opened: Result<Option<TextureId>, Fault>, line, name: &str| match opened {
            Ok(texture) => Ok(texture),
            Err(fault @ Fault::Limit { .. }) => Err(fault.at(path, Place::Line(line))),
            Err(fault) => {
                let message = format!("the texture `{name}` is left out: {fault}");
                warnings.push(Warning { file: path.to_owned(), place: Place::Line(line), message });
                Ok(None)
            }
        };
        if let Some(text) = material.dissolve_texture.as_ref().filter(|_| content) {
            let map = Map::parse(text);
            entry.material.alpha.texture = kept(textures.open_alpha(map.name, files), alpha_line, map.name)?;
            (entry.uv_offset, entry.uv_scale) = (map.offset, map.scale);
        }
        if let Some(text) = &material.diffuse_texture {
            let map = Map::parse(text);
            let texture = kept(textures.open(map.name, files).map(Some), color_line, map.name)?;
            if texture.is_some() {
                entry.material.base_color_texture = texture;
                (entry.uv_offset, entry.uv_scale) = (map.offset, map.scale);
            }
        }
    }
    Ok(Library { materials, by_name, entries })
}

/// Passes a statement on, if it is one of those above; `lines` has an element for each material so far.
fn check(line: &str, index: usize, checked: &mut String, lines: &mut Vec<[usize; 2]>) -> Result<(), Fault> {
    let (keyword, rest) = split_keyword(line);
    let mut words = rest.split_whitespace();
    let first = words.next().unwrap_or_default();
    // Writing to a string cannot fail.
    let _ = match (keyword, lines.last_mut()) {
        ("newmtl", _) => {
            lines.push([index; 2]);
            writeln!(checked, "newmtl {}", if rest.is_empty() { UNNAMED } else { rest })
        }
        // Three numbers, or one for all three; none negative.
        ("Kd" | "Ks" | "Ke", Some(_)) => {
            let [r, g, b] = [first, words.next().unwrap_or(first), words.next().unwrap_or(first)];
            for word in [r, g, b] {
                number(word, LIMIT)?;
            }
            writeln!(checked, "{keyword} {r} {g} {b}")
        }
        ("Ns" | "Pr" | "Pm" | "d" | "Tr", Some(_)) => {
            number(first, LIMIT)?;
            writeln!(checked, "{keyword} {first}")
        }
        ("map_Kd", Some([line, _])) | ("map_d", Some([_, line])) if !rest.is_empty() => {
            *line = index;
            writeln!(checked, "{keyword} {rest}")
        }
        _ => Ok(()),
    };
    Ok(())
}

/// A material without its texture.
fn entry(source: &tobj::Material) -> Entry {
    let mut entry = Entry::default();
    let material = &mut entry.material;
    material.name.clone_from(&source.name);
    let color = |c: [f32; 3]| Vec3::from(c).max(Vec3::ZERO);
    // tobj keeps what is not Wavefront's own as text.
    let further = |key: &str| source.unknown_param.get(key).and_then(|word| word.parse::<f32>().ok());
    if let Some(diffuse) = source.diffuse {
        material.base_color = color(diffuse).min(Vec3::ONE);
    }
    if let Some(metalness) = further("Pm") {
        material.base_color *= 1.0 - metalness.clamp(0.0, 0.99);
    }
    if let Some(specular) = source.specular {
        material.specular = (color(specular).element_sum() / 3.0).min(1.0);
    }
    if let Some(emissive) = source.emissive {
        material.emissive = color(emissive);
    }
    let alpha = source.dissolve.or(further("Tr").map(|transparency| 1.0 - transparency)).unwrap_or(1.0);
    if alpha < 1.0 || source.dissolve_texture.is_some() {
        material.alpha = Alpha { mode: AlphaMode::Blend, factor: alpha.clamp(0.0, 1.0), texture: None };
    }
    // m = 2/α² − 2 with α = roughness².
    let of_exponent = |m: f32| (2.0 / (m.max(0.0) + 2.0)).powf(0.25);
    if let Some(roughness) = further("Pr").or(source.shininess.map(of_exponent)) {
        material.roughness = roughness.clamp(0.01, 1.0);
    }
    entry
}

/// A texture reference, with the offset and the scale that the options before it ask for.
struct Map<'a> {
    name: &'a str,
    offset: Vec2,
    scale: Vec2,
}

impl<'a> Map<'a> {
    fn parse(text: &'a str) -> Self {
        let mut rest = text;
        let (mut offset, mut scale) = (Vec2::ZERO, Vec2::ONE);
        while rest.starts_with('-') {
            let (option, after) = split_word(rest);
            let arguments = match option {
                "-o" | "-s" | "-t" => 3,
                "-mm" => 2,
                "-blendu" | "-blendv" | "-cc" | "-clamp" | "-bm" | "-boost" | "-texres" | "-imfchan"
                | "-type" => 1,
                _ => break, // a file whose name begins with a dash
            };
            rest = after;
            let mut values = [None; 3];
            for value in values.iter_mut().take(arguments) {
                let (word, after) = split_word(rest);
                *value = word.parse::<f32>().ok().filter(|x| x.abs() <= 1e6);
                // The second and third numbers of a vector may be missing, and the name must not be taken for one.
                if arguments == 3 && value.is_none() {
                    break;
                }
                rest = after;
            }
            let vector = |default: f32| Vec2::new(values[0].unwrap_or(default), values[1].unwrap_or(default));
            match option {
                "-o" => offset = vector(0.0),
                "-s" => scale = vector(1.0),
                _ => {}
            }
        }
        Self { name: rest, offset, scale }
    }
}

fn split_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}
