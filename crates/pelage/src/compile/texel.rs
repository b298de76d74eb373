//! What grows on each skin: read from its file, or built.

use std::path::PathBuf;
use std::sync::Arc;

use pelage_texel::{BuildError, BuildOptions, Kind, Procedure, Texel};

use super::{Loaded, Note, resolve};
use crate::build::build;
use crate::choices::Method;
use crate::error::Error;
use crate::scene_file::{SceneFile, TexelEntry};
use crate::texel_file::read_texel;

/// A texel, and what of the scene file it is.
pub(super) type Known = (TexelEntry, Arc<Texel>);

/// The texels that are in files; the same file is read once.
pub(super) fn read_all(file: &SceneFile, note: Note<'_>) -> Result<Vec<Known>, Error> {
    let mut known: Vec<Known> = Vec::new();
    for (i, skin) in file.skin.iter().enumerate() {
        for (k, share) in skin.texel.iter().enumerate() {
            if matches!(share.texel, TexelEntry::Grown { .. }) || find(&known, &share.texel).is_some() {
                continue;
            }
            match read_one(file, &share.texel, &format!("{}.file", skin.texel_field(i, k))) {
                Ok(texel) => known.push((share.texel.clone(), texel)),
                Err(error) => note(error)?,
            }
        }
    }
    Ok(known)
}

/// The texel in the file that `field` refers to.
fn read_one(file: &SceneFile, entry: &TexelEntry, field: &str) -> Result<Arc<Texel>, Error> {
    let path = match entry {
        TexelEntry::File(reference) => {
            resolve(file, reference, field)?;
            file.path.with_file_name(reference)
        }
        TexelEntry::Given(path) => path.clone(),
        TexelEntry::Grown { .. } => PathBuf::new(),
    };
    Ok(Arc::new(read_texel(&path)?.texel))
}

fn find<'a>(known: &'a [Known], texel: &TexelEntry) -> Option<&'a Arc<Texel>> {
    known.iter().find(|(entry, _)| entry == texel).map(|(_, texel)| texel)
}

impl Loaded {
    /// The texels of each skin, in the order of [`SkinEntry::texels`](crate::scene_file::SkinEntry::texels): those of its files, and
    /// those that are built, equal ones once. `progress` is told the fraction done. For the reference method nothing is
    /// built, as in [`Loaded::unbaked`].
    ///
    /// # Errors
    /// Numbers of a texel out of their domain.
    pub fn bake(&self, progress: &(dyn Fn(f32) + Sync)) -> Result<Vec<Vec<Arc<Texel>>>, Error> {
        if self.file.render.method == Method::Reference {
            return self.unbaked();
        }
        let count: usize = self.file.skin.iter().map(|skin| skin.texels().count()).sum();
        self.grown(&|number, kind, resolution| {
            let options = BuildOptions { depth: resolution.ilog2(), ..BuildOptions::standard() };
            build(kind.name(), kind.clone(), &options, &|f| progress((number as f32 + f) / count as f32))
        })
    }

    /// The texels of each skin with what they are made from and, unless they come from a file, no voxels: all that
    /// explicit geometry needs, in no time.
    ///
    /// # Errors
    /// Numbers of a texel out of their domain.
    pub fn unbaked(&self) -> Result<Vec<Vec<Arc<Texel>>>, Error> {
        self.grown(&|_, kind, _| Texel::unbaked(kind.name(), kind.clone()))
    }

    /// The texels of each skin: of its files, or what `make` makes of how many were there before, kind and resolution.
    fn grown(
        &self,
        make: &dyn Fn(usize, &Kind, u32) -> Result<Texel, BuildError>,
    ) -> Result<Vec<Vec<Arc<Texel>>>, Error> {
        let mut known = self.texels.clone();
        let mut number = 0;
        let mut texels = Vec::with_capacity(self.file.skin.len());
        for (i, skin) in self.file.skin.iter().enumerate() {
            let mut of_skin = Vec::new();
            for (k, share) in skin.texel.iter().enumerate() {
                for (entry, _) in share.texels() {
                    let texel = match (find(&known, &entry), &entry) {
                        (Some(same), _) => same.clone(),
                        (None, TexelEntry::Grown { kind, resolution }) => {
                            let field = || self.file.field(&skin.texel_field(i, k));
                            let made = make(number, kind, *resolution);
                            Arc::new(made.map_err(|source| Error::Texel { field: field(), source })?)
                        }
                        // Read with the scene: there is no other.
                        (None, TexelEntry::File(_) | TexelEntry::Given(_)) => continue,
                    };
                    number += 1;
                    known.push((entry, texel.clone()));
                    of_skin.push(texel);
                }
            }
            texels.push(of_skin);
        }
        Ok(texels)
    }
}
