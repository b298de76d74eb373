//! Materials of OBJ files.
//!
//! | keyword | becomes |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour and its texture (`-o` and `-s` move and scale the texture coordinates) |
//! | `Ks`, `Ns`; `Pr` | specular albedo (the mean of the three), roughness: m = 2/α² − 2 read backwards |
//! | `Ke` | emission |
//! | `Pm` | a metal's base colour is its specular one: darkens the diffuse by 1 − metalness |
//!
//! Everything else (bump maps, transparency, …) is ignored: none of it hides geometry.

use glam::{Vec2, Vec3};
use pelage_geom::{Material, TextureId};

use super::image::Textures;
use super::{Fault, Files, ImportError, Place, Warning};
use std::path::Path;

/// A material, and how it moves the texture coordinates of the faces that wear it.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) material: Material,
    pub(crate) uv_scale: Vec2,
    pub(crate) uv_offset: Vec2,
}

/// The materials of a library, in its order.
pub(crate) fn read(
    path: &Path,
    files: &Files,
    textures: &mut Textures,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Entry>, ImportError> {
    let bytes = files.read(path).map_err(|e| e.at(path, Place::File))?;
    let mut entries: Vec<Entry> = Vec::new();
    let mut metalness = 0.0;
    for (index, line) in String::from_utf8_lossy(&bytes).lines().enumerate() {
        let place = Place::Line(index + 1);
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            metalness = 0.0;
            let material = Material {
                name: rest.to_owned(),
                base_color: Vec3::splat(0.8),
                two_sided: true,
                ..Material::default()
            };
            entries.push(Entry { material, uv_scale: Vec2::ONE, uv_offset: Vec2::ZERO });
            continue;
        }
        let Some(entry) = entries.last_mut() else { continue };
        let material = &mut entry.material;
        match keyword {
            "Kd" => material.base_color = color(rest, path, &place)?.min(Vec3::ONE) * (1.0 - metalness),
            "Ks" => material.specular = (color(rest, path, &place)?.dot(Vec3::ONE) / 3.0).min(1.0),
            "Ke" => material.emissive = color(rest, path, &place)?,
            // m = 2/α² − 2 with α = roughness².
            "Ns" => {
                material.roughness =
                    (2.0 / (number(rest, path, &place)?.max(0.0) + 2.0)).powf(0.25).clamp(0.01, 1.0);
            }
            "Pr" => material.roughness = number(rest, path, &place)?.clamp(0.01, 1.0),
            "Pm" => {
                let pm = number(rest, path, &place)?.clamp(0.0, 0.99);
                material.base_color *= (1.0 - pm) / (1.0 - metalness);
                metalness = pm;
            }
            "map_Kd" => match map(rest, files, textures) {
                Ok((texture, offset, scale)) => {
                    material.base_color_texture = Some(texture);
                    (entry.uv_offset, entry.uv_scale) = (offset, scale);
                }
                Err(fault @ Fault::Limit { .. }) => return Err(fault.at(path, place)),
                Err(fault) => warnings.push(Warning {
                    file: path.to_owned(),
                    place,
                    message: format!("the texture `{rest}` is left out: {fault}"),
                }),
            },
            _ => {}
        }
    }
    Ok(entries)
}

fn number(text: &str, path: &Path, place: &Place) -> Result<f32, ImportError> {
    let first = text.split_whitespace().next().unwrap_or_default();
    match first.parse::<f32>() {
        Ok(x) if x.abs() <= 1e12 => Ok(x),
        _ => Err(Fault::NotANumber(first.to_owned()).at(path, place.clone())),
    }
}

/// Three numbers, or one for all three; none negative.
fn color(text: &str, path: &Path, place: &Place) -> Result<Vec3, ImportError> {
    let mut words = text.split_whitespace();
    let red = number(words.next().unwrap_or_default(), path, place)?;
    let mut next = || words.next().map_or(Ok(red), |word| number(word, path, place));
    Ok(Vec3::new(red, next()?, next()?).max(Vec3::ZERO))
}

/// A texture reference behind its options, with the offset and the scale that these ask for.
fn map(text: &str, files: &Files, textures: &mut Textures) -> Result<(TextureId, Vec2, Vec2), Fault> {
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
    Ok((textures.open(rest, files)?, offset, scale))
}

fn split_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}
