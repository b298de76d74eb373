//! Everything that is wrong with a scene at once, and what is odd about it, without baking or rendering anything.

use std::path::{Path, PathBuf};

use crate::compile::{Dressed, Loaded};
use crate::error::{Error, FieldError};
use crate::import::Warning;
use crate::scene_file::SceneFile;

/// What was found in a scene.
#[derive(Debug, Default)]
pub struct Findings {
    /// What is wrong: with the text, its fields, the files that it refers to, the names, and the skins, in this order.
    pub errors: Vec<Error>,
    /// What can be rendered, but perhaps not as it was meant.
    pub remarks: Vec<FieldError>,
    /// What is odd in the files that it refers to.
    pub warnings: Vec<Warning>,
    /// How the texel is laid out on each mesh that wears a skin: its stretch and its seams.
    pub layouts: Vec<FieldError>,
    /// How many meshes there are.
    pub meshes: usize,
    /// How many boxes stand on them.
    pub boxes: usize,
}

impl Findings {
    /// Whether there is an error in an entry of the scene, as in `skin[0]`.
    fn is_wrong(&self, scene: &SceneFile, entry: &str) -> bool {
        let entry = scene.field(entry).name;
        let mut fields = self.errors.iter().filter_map(Error::field);
        fields.any(|field| field.name.starts_with(&entry)) || scene.source.is_spoilt(&entry)
    }
}

/// Reads a scene (or a mesh file, as it is dressed), the files that it refers to and the names that it names, and raises
/// its skins. References may lead to `allow_dirs` too, besides the folder of the scene.
pub fn check(path: &Path, allow_dirs: &[PathBuf]) -> Findings {
    let mut findings = Findings::default();
    let (scene, errors) = SceneFile::open_all(path);
    findings.errors = errors;
    let Some(mut scene) = scene else { return findings };
    scene.allow_dirs = allow_dirs.to_vec();
    // Without numbers that are wrong, an entry still has the names that the rest refers to.
    for i in 0..scene.geometry.len() {
        if findings.is_wrong(&scene, &format!("geometry[{i}]")) {
            scene.geometry[i] = scene.geometry[i].as_it_stands();
        }
    }
    let mut errors = Vec::new();
    let loaded = Loaded::load(scene.clone(), &mut |error| {
        errors.push(error);
        Ok(())
    });
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(error) => {
            findings.errors.push(error);
            return findings;
        }
    };
    // What is lacking only because it was wrong has been told of, and nobody knows the names in a file that could not be
    // read.
    let of_geometry = |error: &Error| error.field().is_some_and(|field| field.name.starts_with("geometry["));
    let unread = errors.iter().any(|error| of_geometry(error) || matches!(error, Error::Import(_)));
    let told = |error: &Error| {
        let spoilt = error.field().is_some_and(|field| scene.source.is_spoilt(&field.name));
        let text = error.to_string();
        spoilt || unread && names_something(error) || findings.errors.iter().any(|e| e.to_string() == text)
    };
    errors.retain(|error| !told(error));
    findings.errors.append(&mut errors);
    findings.meshes = loaded.imported.meshes.len();
    findings.warnings.clone_from(&loaded.imported.warnings);
    for i in 0..scene.skin.len() {
        if findings.is_wrong(&scene, &format!("skin[{i}]")) {
            continue;
        }
        match loaded.raise(i) {
            Ok(skins) => {
                findings.boxes += skins.iter().map(|dressed| dressed.skin.len()).sum::<usize>();
                for dressed in &skins {
                    findings.remarks.extend(remarks(dressed, &loaded, &scene));
                    let mesh = &loaded.imported.meshes[dressed.mesh].name;
                    let laid_out = format!("on `{mesh}`, {}", dressed.skin.distortion());
                    findings.layouts.push(scene.fault(format!("skin[{i}].layout"), laid_out));
                }
                if skins.is_empty() && !unread {
                    findings.remarks.push(scene.fault(format!("skin[{i}]"), "nothing wears it"));
                }
            }
            Err(error) => findings.errors.push(error),
        }
    }
    findings
}

/// Whether the error is that something of some name does not exist.
fn names_something(error: &Error) -> bool {
    matches!(error, Error::Field(FieldError { hint: Some(_), .. }))
}

/// What is odd about a skin on one mesh.
fn remarks(dressed: &Dressed, loaded: &Loaded, scene: &SceneFile) -> Vec<FieldError> {
    let skin = format!("skin[{}]", dressed.entry);
    let mesh = &loaded.imported.meshes[dressed.mesh].name;
    let report = &dressed.skin.report;
    let of_all = dressed.skin.len();
    let counts = [
        (report.mended(), "folds", "boxes were folded and have been mended"),
        (report.left_out(), "folds", "boxes are folded and left out"),
        (report.zero_area_uvs, "layout", "boxes have no usable texture coordinates, and go by their shape"),
        (report.mirrored, "layout", "boxes have mirrored texture coordinates"),
        (report.torn_vertices, "cage", "vertices have more than one top: boxes do not share all their walls"),
        (report.non_manifold_edges, "on", "edges have more than two faces"),
        (report.misoriented_edges, "on", "edges are between faces of opposite orientation"),
        (report.zero_area_faces.len(), "on", "faces have no area, and no box"),
        (report.duplicate_faces.len(), "on", "faces are there twice; the second has no box"),
    ];
    let counted = counts.into_iter().filter(|(count, ..)| *count > 0).map(|(count, field, what)| {
        scene.fault(format!("{skin}.{field}"), format!("on `{mesh}`, with {of_all} boxes, {count} {what}"))
    });
    let idle =
        dressed.effects.iter().enumerate().filter(|(_, effect)| effect.vertices == 0).map(|(step, _)| {
            scene.fault(
                format!("{skin}.groom[{step}]"),
                format!("changes nothing on `{mesh}`: does its mask hit anything?"),
            )
        });
    counted.chain(idle).collect()
}
