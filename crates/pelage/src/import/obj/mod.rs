//! Wavefront OBJ. \[OBJ\]
//!
//! tobj reads the file, after [`guard`] has checked every line of it; this room alone names tobj.
//!
//! An `o` begins a mesh; a `g` does so only in a file without any `o`, because groups often cut one surface into
//! parts, and a skin must not be cut there. Quads stay quads; larger polygons become fans, with a warning. For content,
//! `l` elements are strands, and three numbers behind a vertex its colour.

mod guard;
mod lines;
mod mtl;

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};
use pelage_geom::MaterialId;

use super::weld::{Corner, Welder};
use super::{Fault, Files, ImportError, ImportOptions, Imported, Place, Up, Warning};
use guard::Guard;
use mtl::Entry;

pub(crate) fn read(path: &Path, files: &Files, options: &ImportOptions) -> Result<Imported, ImportError> {
    let Guard { text, libraries, textures, warnings, lines, .. } = Guard::check(path, files, options)?;
    // Nothing is merged or cut by tobj: indices of their own for positions, texture coordinates and normals.
    let plain = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let library = |name: &Path| {
        let index = name.to_str().and_then(|name| name.parse::<usize>().ok());
        let library = index.and_then(|i| libraries.get(i)).ok_or(tobj::LoadError::OpenFileFailed)?;
        Ok((library.materials.clone(), library.by_name.clone()))
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &plain, library)
        .map_err(|e| Fault::Syntax(e.to_string()).at(path, Place::File))?;

    // Of materials of one name the last; without one, a light grey behind all others.
    let mut named = HashMap::new();
    let mut before = 0;
    for library in &libraries {
        named.extend(library.by_name.iter().map(|(name, i)| (name.clone(), before + i)));
        before += library.entries.len();
    }
    let strands = lines.strands(
        |p| upright(options.up, p.to_array()) * options.unit,
        |name| MaterialId(name.and_then(|name| named.get(name)).map_or(before, |&i| i) as u32),
    );
    let mut entries: Vec<_> = libraries.into_iter().flat_map(|library| library.entries).collect();
    let has_bare_strands = strands.iter().any(|strand| strand.material.0 as usize == before);
    if models.iter().any(|model| model.mesh.material_id.is_none()) || has_bare_strands {
        entries.push(Entry::default());
    }
    let mut imported = Imported { textures: textures.list, strands, warnings, ..Imported::default() };
    // tobj makes a model of each stretch of one material; an object is as many as follow each other.
    for object in models.chunk_by(|a, b| a.name == b.name) {
        let name = object[0].name.split_once(' ').map_or("", |(_line, name)| name);
        let mut welder = Welder::new(name, options.content);
        for model in object {
            // Without a material: the last one.
            let id = model.mesh.material_id.unwrap_or(entries.len() - 1);
            weld(&mut welder, &model.mesh, &entries[id], MaterialId(id as u32), options);
        }
        if welder.is_empty() {
            continue;
        }
        let (mesh, lost) = welder.finish();
        let normals = lost.normals && !options.content;
        for (_, what) in [(lost.uvs, "texture coordinates"), (normals, "normals")].iter().filter(|l| l.0) {
            let message =
                format!("mesh `{}`: only some faces have usable {what}, which are left out", mesh.name);
            imported.warnings.push(Warning { file: path.to_owned(), place: Place::File, message });
        }
        imported.meshes.push(mesh);
    }
    imported.materials = entries.into_iter().map(|e| e.material).collect();
    Ok(imported)
}

/// Adds a model's polygons, brought into scene space.
fn weld(
    welder: &mut Welder,
    mesh: &tobj::Mesh,
    entry: &Entry,
    material: MaterialId,
    options: &ImportOptions,
) {
    let positions = mesh.positions.as_chunks::<3>().0;
    let uvs = mesh.texcoords.as_chunks::<2>().0;
    let normals = mesh.normals.as_chunks::<3>().0;
    let colors = mesh.vertex_color.as_chunks::<3>().0;
    let indices = mesh.indices.iter().zip(&mesh.texcoord_indices).zip(&mesh.normal_indices);
    let mut corners = indices.map(|((&position, &uv), &normal)| Corner {
        position: upright(options.up, positions[position as usize]) * options.unit,
        uv: Some(Vec2::from(uvs[uv as usize]))
            .filter(|uv| !uv.is_nan())
            .map(|uv| uv * entry.uv_scale + entry.uv_offset),
        normal: Some(upright(options.up, normals[normal as usize])),
        color: colors.get(position as usize).map(|&rgb| Vec3::from(rgb).extend(1.0)),
    });
    // Where all polygons are triangles, tobj does not say so of each.
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    let arities = mesh.face_arities.iter().copied().chain(std::iter::repeat_n(3, triangles));
    let mut polygon = Vec::new();
    for arity in arities {
        polygon.clear();
        polygon.extend(corners.by_ref().take(arity as usize));
        welder.polygon(&polygon, material);
    }
}

/// A vector of the file with +Y up.
fn upright(up: Up, [x, y, z]: [f32; 3]) -> Vec3 {
    match up {
        Up::Y => Vec3::new(x, y, z),
        Up::Z => Vec3::new(x, z, -y),
    }
}
