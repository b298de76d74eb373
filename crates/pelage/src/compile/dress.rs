//! Which faces wear which skin, and the raising of its boxes.

use glam::Vec3;
use pelage_geom::{Face, Mesh};
use pelage_skin::groom::{Effect, GroomOptions, groom};
use pelage_skin::{Folds, Layout, Mending, Skin, SkinError, SkinOptions, cage, extrude, mean_height};

use super::Loaded;
use crate::error::Error;
use crate::import::Imported;
use crate::scene_file::{SceneFile, SkinEntry};

/// The faces of a mesh that wear a skin.
#[derive(Clone, Debug)]
pub(super) struct Selection {
    pub(super) mesh: usize,
    /// By face.
    selected: Vec<bool>,
    /// Where the boxes end, if not at a height along the normals.
    pub(super) top: Option<Mesh>,
}

/// A skin on a mesh.
#[derive(Clone, Debug)]
pub struct Dressed {
    /// Which entry of [`SceneFile::skin`] it comes from.
    pub entry: usize,
    /// Which mesh of [`Imported::meshes`] it stands on.
    pub mesh: usize,
    /// Its boxes, and the report of their making.
    pub skin: Skin,
    /// What each step of its groom did.
    pub effects: Vec<Effect>,
}

impl Loaded {
    /// Raises the boxes of each skin on each mesh that wears it, and grooms them.
    ///
    /// # Errors
    /// What [`extrude`], [`cage`] and [`groom`] refuse.
    pub fn extrude(&self) -> Result<Vec<Dressed>, Error> {
        let skins: Result<Vec<_>, Error> = (0..self.dressed.len()).map(|entry| self.raise(entry)).collect();
        Ok(skins?.into_iter().flatten().collect())
    }

    /// The same of one skin.
    pub(crate) fn raise(&self, entry: usize) -> Result<Vec<Dressed>, Error> {
        let mut skins = Vec::new();
        if let (Some(skin), Some(selections)) = (self.file.skin.get(entry), self.dressed.get(entry)) {
            let bounds = selections.iter().filter_map(|s| self.imported.meshes[s.mesh].bounds());
            let common_height = skin.height.unwrap_or_else(|| height_for(bounds));
            let (steps, folds_in_the_end) = (&self.grooms[entry], skin.folds);
            let aspect = skin.aspect.unwrap_or(SkinEntry::ASPECT);
            let painted = skin.vertex_color.as_ref();
            for Selection { mesh, selected, top } in selections {
                let on = &self.imported.meshes[*mesh];
                let selected = |face: usize| selected[face];
                let height = top.as_ref().map_or(common_height, |top| mean_height(on, top, &selected));
                let per_patch = match skin.layout {
                    Layout::PerPatch => true,
                    Layout::Conformal => false,
                    Layout::Auto | Layout::Uv => on.uvs.is_none(),
                };
                let by_faces = || per_patch.then(|| copies_per_side(on, aspect * height));
                let options = SkinOptions {
                    tiling: skin.tiling.or_else(by_faces),
                    aspect,
                    layout: skin.layout,
                    lean: skin.lean.into(),
                    // What is folded at first need not be in the end.
                    folds: if steps.is_empty() { skin.folds } else { Folds::Keep },
                    ..SkinOptions::new(height)
                };
                let made = match top {
                    None => extrude(on, &selected, &options),
                    Some(top) => cage(on, top, &selected, &options),
                };
                let fault = |source| {
                    let (part, source) = part_of(source);
                    Error::Skin {
                        field: self.file.field(&format!("skin[{entry}]{part}")),
                        source: Box::new(source),
                    }
                };
                let mut skin = made.map_err(fault)?;
                let mut effects = Vec::new();
                if !steps.is_empty() {
                    let mending = Mending { folds: folds_in_the_end, ..Mending::default() };
                    let options = GroomOptions { mending, ..GroomOptions::default() };
                    let groomed = groom(&skin, steps, &options).map_err(fault)?;
                    (skin, effects) = (groomed.skin, groomed.effects);
                }
                if let Some(name) = painted {
                    skin.colors = Some(self.painted(entry, &on.name, name, &skin)?);
                }
                skins.push(Dressed { entry, mesh: *mesh, skin, effects });
            }
        }
        Ok(skins)
    }

    /// The colours by vertex that the attribute `name` holds.
    fn painted(&self, entry: usize, mesh: &str, name: &str, skin: &Skin) -> Result<Vec<Vec3>, Error> {
        let values = |component: &str| {
            let whole = format!("{name}.{component}");
            skin.attributes.iter().find(|a| a.name == whole).map(|a| a.values.as_slice())
        };
        let (Some(r), Some(g), Some(b)) = (values("r"), values("g"), values("b")) else {
            let known = skin.attributes.iter().filter_map(|a| a.name.strip_suffix(".b"));
            let field = format!("skin[{entry}].vertex_color");
            let what = format!("vertex attribute of three numbers on mesh `{mesh}`, called");
            return Err(self.file.unknown(field, &what, name, known).into());
        };
        let color = |((r, g), b): ((&f32, &f32), &f32)| Vec3::new(*r, *g, *b).max(Vec3::ZERO);
        Ok(r.iter().zip(g).zip(b).map(color).collect())
    }
}

/// The field of a skin that an error is about, and the error.
fn part_of(error: SkinError) -> (String, SkinError) {
    let part = match error {
        SkinError::Groom { step, reason } => return (format!(".groom[{step}]"), *reason),
        SkinError::Top(_)
        | SkinError::CageFaces { .. }
        | SkinError::CageCorners { .. }
        | SkinError::CageVertices { .. } => ".cage",
        SkinError::NoUvs { .. } | SkinError::ConformalSize { .. } => ".layout",
        SkinError::NothingSelected { .. } => ".on",
        SkinError::Folded { .. } | SkinError::StillFolded { .. } => ".folds",
        _ => "",
    };
    (part.into(), error)
}

/// The faces that a skin's names select, by mesh.
pub(super) fn select(
    file: &SceneFile,
    index: usize,
    skin: &SkinEntry,
    imported: &Imported,
) -> Result<Vec<Selection>, Error> {
    let Imported { meshes, materials, .. } = imported;
    let wears = |mesh: &Mesh, name: &str| {
        mesh.name == name
            || mesh.faces.iter().any(|f| materials.get(f.material.0 as usize).is_some_and(|m| m.name == name))
    };
    for name in &skin.on {
        if !meshes.iter().any(|mesh| wears(mesh, name)) {
            let known =
                meshes.iter().map(|m| m.name.as_str()).chain(materials.iter().map(|m| m.name.as_str()));
            return Err(file.unknown(format!("skin[{index}].on"), "mesh or material", name, known).into());
        }
    }
    let selected = |mesh: &Mesh| -> Vec<bool> {
        let whole = skin.on.is_empty() || skin.on.contains(&mesh.name);
        let by_material: Vec<bool> = materials.iter().map(|m| skin.on.contains(&m.name)).collect();
        mesh.faces.iter().map(|f| whole || by_material.get(f.material.0 as usize) == Some(&true)).collect()
    };
    Ok(meshes
        .iter()
        .enumerate()
        .map(|(i, mesh)| Selection { mesh: i, selected: selected(mesh), top: None })
        .filter(|s| s.selected.contains(&true))
        .collect())
}

/// 6 % of half the diagonal around the meshes that wear a skin: fur that is seen as fur, and no more.
fn height_for(bounds: impl Iterator<Item = [Vec3; 2]>) -> f32 {
    let around = bounds.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)]);
    around.map_or(0.0, |[lo, hi]| 0.06 * 0.5 * (hi - lo).length()).max(f32::MIN_POSITIVE)
}

/// How many copies of the texel, `width` metres wide, go along the side of a face of a mesh without texture
/// coordinates: a whole number, by the mean of all faces. Where there is a triangle, every n-gon becomes n quads.
fn copies_per_side(mesh: &Mesh, width: f32) -> f32 {
    let quads: usize = if mesh.faces.iter().all(Face::is_quad) {
        mesh.faces.len()
    } else {
        mesh.faces.iter().map(|face| face.corners().len()).sum()
    };
    ((mesh.area() / quads as f32).sqrt() / width).round().max(1.0)
}
