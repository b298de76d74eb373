//! The tops of caged skins: read as geometry is, and put where the mesh below stands.

use std::collections::BTreeMap;

use pelage_geom::Mesh;

use super::dress::Selection;
use super::read;
use crate::error::Error;
use crate::import::Imported;
use crate::names;
use crate::scene_file::{CageEntry, SceneFile};

/// Gives each of the `selections` of skin `index` its top. `origins` has, by mesh of `imported`, the entry of the
/// geometry that it comes from; what is worth a warning in the cage's file is added to `imported`.
pub(super) fn put_on(
    selections: &mut [Selection],
    file: &SceneFile,
    index: usize,
    entry: &CageEntry,
    imported: &mut Imported,
    origins: &[usize],
) -> Result<(), Error> {
    let field = format!("skin[{index}].cage");
    let mut placed = BTreeMap::new();
    for origin in selections.iter().map(|s| origins[s.mesh]) {
        if placed.contains_key(&origin) {
            continue;
        }
        let mut part = read(file, &entry.file, &file.geometry[origin], &field)?;
        // Placed twice, it would say twice the same.
        if placed.is_empty() {
            imported.warnings.append(&mut part.warnings);
        }
        placed.insert(origin, part.meshes);
    }
    let fail = |reason: String| file.fault(&field, reason);
    let mut taken = BTreeMap::new();
    for selection in selections {
        let (origin, below) = (origins[selection.mesh], &imported.meshes[selection.mesh].name);
        let meshes = &placed[&origin];
        let found = match (&meshes[..], &entry.mesh) {
            ([_], None) => 0,
            (_, name) => {
                let name = name.as_ref().unwrap_or(below);
                one_called(name, meshes).map_err(|reason| fail(format!("in `{}`, {reason}", entry.file)))?
            }
        };
        if let Some(other) = taken.insert((origin, found), below) {
            let reason = format!("is for one mesh, but `{other}` and `{below}` wear it: name one in `on`");
            return Err(fail(reason).into());
        }
        selection.top = Some(meshes[found].clone());
    }
    Ok(())
}

/// Which is the one mesh of this name.
fn one_called(name: &str, meshes: &[Mesh]) -> Result<usize, String> {
    let mut found = meshes.iter().enumerate().filter(|(_, mesh)| mesh.name == name);
    match (found.next(), found.count()) {
        (Some((i, _)), 0) => Ok(i),
        (Some(_), more) => Err(format!("{} meshes are called `{name}`", more + 1)),
        (None, _) => Err(names::unknown("mesh", name, meshes.iter().map(|m| m.name.as_str()))),
    }
}
