//! The grooms of a described scene: names and files become what masks hold.

use std::sync::Arc;

use pelage_geom::{MaterialId, Texture};
use pelage_skin::groom::{Mask, Region, Step};

use super::Note;
use super::dress::Selection;
use crate::error::Error;
use crate::import::{Files, ImportOptions, Imported, Textures};
use crate::names;
use crate::scene_file::{BoxEntry, ImageEntry, MaskEntry, RegionEntry, SceneFile, SphereEntry};

/// The steps of skin `index`, whose `selections` are what wears it.
pub(super) fn steps(
    file: &SceneFile,
    index: usize,
    selections: &[Selection],
    imported: &Imported,
    note: Note<'_>,
) -> Result<Vec<Step>, Error> {
    let resolver = Resolver { file, selections, imported };
    let mut steps = Vec::new();
    for (step, entry) in file.skin[index].groom.iter().enumerate() {
        let mut masks = Vec::new();
        for (i, mask) in entry.masks.iter().enumerate() {
            // A table that stands alone has no number.
            let number = if entry.masks.len() == 1 { String::new() } else { format!("[{i}]") };
            match resolver.mask(mask, &format!("skin[{index}].groom[{step}].where{number}")) {
                Ok(mask) => masks.push(mask),
                Err(error) => note(error)?,
            }
        }
        steps.push(Step { operation: entry.operation.clone(), masks });
    }
    Ok(steps)
}

struct Resolver<'a> {
    file: &'a SceneFile,
    selections: &'a [Selection],
    imported: &'a Imported,
}

impl Resolver<'_> {
    fn mask(&self, entry: &MaskEntry, field: &str) -> Result<Mask, Error> {
        let region = match &entry.region {
            &RegionEntry::Sphere(SphereEntry { centre, radius, falloff }) => {
                Region::Sphere { centre, radius, falloff }
            }
            &RegionEntry::Box(BoxEntry { min, max, falloff }) => Region::Box { min, max, falloff },
            RegionEntry::Patches(list) => Region::Patches(list.clone()),
            RegionEntry::Vertices(list) => Region::Vertices(list.clone()),
            RegionEntry::Material(names) => Region::Materials(self.materials(names, field)?),
            RegionEntry::Attribute(name) => Region::Attribute(self.attribute(name, field)?),
            RegionEntry::Image(entry) => {
                Region::Image { texture: self.image(entry, field)?, channel: entry.channel }
            }
        };
        Ok(Mask { region, invert: entry.invert })
    }

    fn fail(&self, field: String, reason: String) -> Error {
        self.file.fault(field, reason).into()
    }

    fn materials(&self, wanted: &[String], field: &str) -> Result<Vec<MaterialId>, Error> {
        let materials = &self.imported.materials;
        let mut found = Vec::new();
        for name in wanted {
            let before = found.len();
            let called = materials.iter().enumerate().filter(|(_, m)| m.name == *name);
            found.extend(called.map(|(i, _)| MaterialId(i as u32)));
            if found.len() == before {
                let known = materials.iter().map(|m| m.name.as_str());
                return Err(self.file.unknown(format!("{field}.material"), "material", name, known).into());
            }
        }
        Ok(found)
    }

    /// An attribute that every mesh below the skin has.
    fn attribute(&self, name: &str, field: &str) -> Result<String, Error> {
        for selection in self.selections {
            let mesh = &self.imported.meshes[selection.mesh];
            if !mesh.attributes.iter().any(|a| a.name == name) {
                let known = mesh.attributes.iter().map(|a| a.name.as_str());
                let unknown = names::unknown("vertex attribute", name, known);
                return Err(
                    self.fail(format!("{field}.attribute"), format!("on mesh `{}`, {unknown}", mesh.name))
                );
            }
        }
        Ok(name.to_owned())
    }

    fn image(&self, entry: &ImageEntry, field: &str) -> Result<Arc<Texture>, Error> {
        let path = &self.file.path;
        if let Some(mesh) =
            self.selections.iter().map(|s| &self.imported.meshes[s.mesh]).find(|m| m.uvs.is_none())
        {
            let reason = format!("needs texture coordinates, and mesh `{}` has none", mesh.name);
            return Err(self.fail(format!("{field}.image"), reason));
        }
        let files = Files::around(path, &self.file.allow_dirs, ImportOptions::default().limits)?;
        let texture = Textures::default().open_values(&entry.file, &files);
        let at = |fault| self.file.referred(&format!("{field}.image"), &entry.file, fault);
        Ok(Arc::new(texture.map_err(at)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::Loaded;

    /// A plane of 4 × 4 patches, an image that is white on its right half, a file that is no image.
    fn loaded(groom: &str) -> Result<Loaded, Error> {
        let folder = tempfile::tempdir().expect("a folder");
        let image = image::GrayImage::from_fn(64, 1, |x, _| image::Luma([if x < 32 { 0 } else { 255 }]));
        image.save(folder.path().join("right.png")).expect("an image");
        std::fs::write(folder.path().join("not.png"), "not").expect("a file");
        let scene = format!(
            "geometry = [{{ surface = {{ plane = {{ size = [4, 4] }} }}, patches = [4, 4], name = 'Lawn' }}]\n\
             [[skin]]\nheight = 0.2\n{groom}"
        );
        Loaded::new(SceneFile::parse(&scene, &folder.path().join("scene.toml"))?)
    }

    fn lengths(groom: &str) -> Vec<(f32, f32)> {
        let skins = loaded(groom).and_then(|scene| scene.extrude()).expect("a skin");
        let skin = &skins[0].skin;
        skin.base.iter().zip(&skin.top).map(|(b, t)| (b.x, b.distance(*t))).collect()
    }

    #[test]
    fn steps_are_done_in_their_order_where_their_masks_say() {
        let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
        let steps =
            "[[skin.groom]]\nscale = 0.5\n[[skin.groom]]\nheight = 0.3\nwhere = { image = 'right.png' }\n";
        for (x, length) in lengths(steps) {
            // In the middle and at the ends, where the image repeats, the image is half white.
            let expected = if x < -1.5 || x.abs() < 0.5 || x > 1.5 {
                0.2
            } else if x > 0.0 {
                0.3
            } else {
                0.1
            };
            assert!(near(length, expected), "{x} {length}");
        }
        let by_material = "[[skin.groom]]\nscale = 0.5\nwhere = { material = 'Lawn', invert = true }\n";
        assert!(lengths(by_material).iter().all(|(_, length)| near(*length, 0.2)));
    }

    #[test]
    fn masks_that_name_nothing_are_named() {
        for (mask, message) in [
            (
                "{ material = 'Law' }",
                "skin[0].groom[0].where.material: there is no material `Law`: did you mean `Lawn`?",
            ),
            (
                "{ attribute = '_LENGTH' }",
                "skin[0].groom[0].where.attribute: on mesh `Lawn`, there is no vertex attribute `_LENGTH`",
            ),
            (
                "{ image = 'no.png' }",
                "skin[0].groom[0].where.image: refers to `no.png`, which cannot be read",
            ),
            (
                "{ image = '../a.png' }",
                "skin[0].groom[0].where.image: refers to `../a.png`, which is outside",
            ),
            ("{ image = 'not.png' }", "skin[0].groom[0].where.image: `not.png`: the image cannot be decoded"),
            ("{ patches = [16] }", "skin[0].groom[0]: mask: patch 16 does not exist: there are 16"),
            (
                "{ sphere = { centre = [0, 0, 0], radius = -1 } }",
                "skin[0].groom[0].where.sphere.radius: must not be",
            ),
            ("{ ball = 1 }", "scene.toml:6:11: skin[0].groom[0].where: there is no field `ball`: there are"),
        ] {
            let scene = loaded(&format!("[[skin.groom]]\nscale = 2\nwhere = {mask}\n"));
            let error = scene.and_then(|scene| scene.extrude()).expect_err(mask).to_string();
            assert!(error.contains(message) && !error.contains('\n'), "{mask}: {error}");
        }
    }
}
