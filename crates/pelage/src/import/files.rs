//! Reading the files that a scene refers to, and only those.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use super::{Fault, ImportError, Limits, Place};

/// The extension of a path in lower case, or nothing.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The files under the folder of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Files {
    /// Canonical; the first is the scene's own.
    folders: Vec<PathBuf>,
    pub(crate) limits: Limits,
}

impl Files {
    /// The files that `scene` may refer to.
    pub(crate) fn around(scene: &Path, allowed: &[PathBuf], limits: Limits) -> Result<Self, ImportError> {
        let own = match scene.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let folders = std::iter::once(own)
            .chain(allowed.iter().map(PathBuf::as_path))
            .map(|folder| {
                let fault = |e| Fault::Io(e).at(folder, Place::File);
                let canonical = folder.canonicalize().map_err(fault)?;
                let not_a_folder = || fault(std::io::ErrorKind::NotADirectory.into());
                if canonical.is_dir() { Ok(canonical) } else { Err(not_a_folder()) }
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { folders, limits })
    }

    /// The whole of a regular file of permitted size.
    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, Fault> {
        let metadata = fs::metadata(path)?;
        // Asked before the file is opened: opening a pipe waits, and a device may never end.
        if !metadata.is_file() {
            return Err(Fault::NotRegular);
        }
        let limit = self.limits.file_bytes;
        let too_large = |found| Fault::Limit { what: "bytes of the file", found, limit };
        if metadata.len() > limit {
            return Err(too_large(metadata.len()));
        }
        let mut bytes = Vec::new();
        // Files of /proc claim to be empty and are not; the cap holds for what is read as well.
        fs::File::open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > limit { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
    }

    /// The path that a relative reference leads to, with symbolic links followed, if it is under a permitted
    /// folder.
    pub(crate) fn resolve(&self, reference: &str) -> Result<PathBuf, Fault> {
        let outside = || Fault::Outside(reference.to_owned());
        // Exporters on Windows write backslashes.
        let relative = PathBuf::from(reference.replace('\\', "/"));
        let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        // Without further folders, a path with `..` is refused before the file system is asked anything.
        if relative.is_absolute() || (self.folders.len() == 1 && !relative.components().all(plain)) {
            return Err(outside());
        }
        let path = self.folders[0].join(relative).canonicalize()?;
        if self.folders.iter().any(|folder| path.starts_with(folder)) { Ok(path) } else { Err(outside()) }
    }
}
