//! What grows on each skin: read from its file, or built.

use std::sync::Arc;

use pelage_texel::{BuildError, BuildOptions, Kind, Procedure, Texel, build};

use super::{Loaded, resolve};
use crate::choices::Method;
use crate::error::Error;
use crate::scene_file::{SceneFile, TexelEntry};
use crate::texel_file::read_texel;

/// The texel of each skin, where it is in a file; the same file is read once.
pub(super) fn read_all(file: &SceneFile) -> Result<Vec<Option<Arc<Texel>>>, Error> {
    let mut texels: Vec<Option<Arc<Texel>>> = Vec::new();
    for (i, skin) in file.skin.iter().enumerate() {
        let path = match &skin.texel {
            TexelEntry::Grown { .. } => None,
            TexelEntry::Given(path) => Some(path.clone()),
            TexelEntry::File(reference) => {
                resolve(file, reference, &format!("skin[{i}].texel.file"))?;
                Some(file.path.with_file_name(reference))
            }
        };
        let texel = match (earlier(file, i), path) {
            (Some(same), _) => texels[same].clone(),
            (None, Some(path)) => Some(Arc::new(read_texel(&path)?.texel)),
            (None, None) => None,
        };
        texels.push(texel);
    }
    Ok(texels)
}

/// The first skin on which the same grows, if it comes before this one.
fn earlier(file: &SceneFile, skin: usize) -> Option<usize> {
    file.skin[..skin].iter().position(|earlier| earlier.texel == file.skin[skin].texel)
}

impl Loaded {
    /// The texel of each skin: that of its file, or one that is built, equal ones once. `progress` is told the fraction
    /// done. For the reference method nothing is built, as in [`Loaded::unbaked`].
    ///
    /// # Errors
    /// Numbers of a texel out of their domain.
    pub fn bake(&self, progress: &(dyn Fn(f32) + Sync)) -> Result<Vec<Arc<Texel>>, Error> {
        if self.file.render.method == Method::Reference {
            return self.unbaked();
        }
        let count = self.file.skin.len() as f32;
        self.texels(&|skin, kind, resolution| {
            let options = BuildOptions { depth: resolution.ilog2(), ..BuildOptions::standard() };
            build(kind.name(), kind.clone(), &options, &|f| progress((skin as f32 + f) / count))
        })
    }

    /// The texel of each skin with what it is made from and, unless it comes from a file, no voxels: all that explicit
    /// geometry needs, in no time.
    ///
    /// # Errors
    /// Numbers of a texel out of their domain.
    pub fn unbaked(&self) -> Result<Vec<Arc<Texel>>, Error> {
        self.texels(&|_, kind, _| Texel::unbaked(kind.name(), kind.clone()))
    }

    /// The texel of each skin: of its file, or what `make` makes of its number, kind and resolution.
    fn texels(
        &self,
        make: &dyn Fn(usize, &Kind, u32) -> Result<Texel, BuildError>,
    ) -> Result<Vec<Arc<Texel>>, Error> {
        let mut texels: Vec<Arc<Texel>> = Vec::new();
        for (i, skin) in self.file.skin.iter().enumerate() {
            let texel = match (&self.texels[i], earlier(&self.file, i), &skin.texel) {
                (Some(read), _, _) => read.clone(),
                (None, Some(same), _) => texels[same].clone(),
                (None, None, entry) => {
                    let made = match entry {
                        TexelEntry::Grown { kind, resolution } => make(i, kind, *resolution),
                        TexelEntry::File(_) | TexelEntry::Given(_) => Err(BuildError::Sourceless),
                    };
                    let field = || format!("{}: skin[{i}].texel", self.file.path.display());
                    Arc::new(made.map_err(|source| Error::Texel { field: field(), source })?)
                }
            };
            texels.push(texel);
        }
        Ok(texels)
    }
}
