//! A scene as explicit triangles in one file, for other programs: every coat's content carried into its boxes, and the
//! opaque meshes.
//!
//! Colours go as vertex colours, so that no texture is needed: linear in glTF, as its definition has it, and as sRGB in
//! PLY and OBJ, as their readers take them. What is large is the number of triangles: the size of the file is known
//! before it is written, and a limit is kept.

mod glb;
mod obj;
mod ply;

use std::fmt;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use pelage_tracer::reference::{Carried, Expansion};

use crate::import::extension;
use crate::output::{OutputError, check_place, replace};

/// The model formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFormat {
    /// Binary glTF: positions, normals, 16-bit linear vertex colours.
    Glb,
    /// Wavefront OBJ: positions with sRGB colours.
    Obj,
    /// Binary little-endian PLY: positions, normals, 8-bit sRGB colours.
    Ply,
}

/// Why there is no file of explicit triangles. A file of that name is what it was before.
#[derive(Debug, thiserror::Error)]
pub enum ExpandError {
    /// The name ends in no known extension.
    #[error("{}: unknown model format: expected .glb, .obj or .ply", path.display())]
    Extension {
        /// The name asked for.
        path: PathBuf,
    },
    /// There is nothing in the scene.
    #[error("{}: the scene has no triangles", path.display())]
    Nothing {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file would be larger than it may be.
    #[error(
        "{}: {triangles} triangles would take {}, the limit is {}: a larger --tolerance or --limit, or fewer skins",
        path.display(), Bytes(*bytes), Bytes(*limit)
    )]
    TooLarge {
        /// The name asked for.
        path: PathBuf,
        /// How many triangles there are.
        triangles: u64,
        /// How large it would be at most, in bytes.
        bytes: u64,
        /// How large it may be, by the limit or by the format.
        limit: u64,
    },
    /// The callback asked to stop.
    #[error("{}: not written: interrupted", path.display())]
    Stopped {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// A size for people: three digits and a binary unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
        if self.0 < 1024 {
            return write!(f, "{} bytes", self.0);
        }
        let mut size = self.0 as f64 / 1024.0;
        let mut unit = 0;
        while size >= 1000.0 && unit + 1 < UNITS.len() {
            size /= 1024.0;
            unit += 1;
        }
        let digits = if size < 10.0 { 2 } else { usize::from(size < 100.0) };
        write!(f, "{size:.digits$} {}", UNITS[unit])
    }
}

/// The format that a file's name asks for, if the file could be created: for asking before a long expansion.
///
/// # Errors
/// An unknown extension, a folder of that name, or a folder that cannot be written to.
pub fn check_model(path: &Path) -> Result<ModelFormat, ExpandError> {
    let format = match extension(path).as_str() {
        "glb" => ModelFormat::Glb,
        "obj" => ModelFormat::Obj,
        "ply" => ModelFormat::Ply,
        _ => return Err(ExpandError::Extension { path: path.to_owned() }),
    };
    check_place(path)?;
    Ok(format)
}

impl ModelFormat {
    /// The size of the file in bytes, at most: exact but for OBJ, whose numbers are as long as they are.
    pub fn size(self, expansion: &Expansion) -> u64 {
        let triangles = expansion.triangles();
        match self {
            Self::Glb => glb::size(expansion),
            Self::Obj => {
                obj::HEADER.len() as u64 + triangles * obj::TRIANGLE + 64 * expansion.parts().len() as u64
            }
            Self::Ply => ply::header(triangles).len() as u64 + triangles * ply::TRIANGLE,
        }
    }

    /// What the format itself can hold, in bytes: the lengths of GLB and the indices of PLY have 32 bits.
    fn most(self) -> u64 {
        match self {
            Self::Glb => u64::from(u32::MAX),
            Self::Obj => u64::MAX,
            Self::Ply => u64::from(u32::MAX) / 3 * ply::TRIANGLE,
        }
    }
}

/// Writes an expansion to a file, if it takes no more than `limit` bytes. `progress` is told the fraction written;
/// [`ControlFlow::Break`] stops.
///
/// # Errors
/// [`ExpandError`]; a file of that name is then what it was before.
pub fn write_model(
    expansion: &Expansion,
    path: &Path,
    format: ModelFormat,
    limit: u64,
    progress: &dyn Fn(f32) -> ControlFlow<()>,
) -> Result<(), ExpandError> {
    let triangles = expansion.triangles();
    if triangles == 0 {
        return Err(ExpandError::Nothing { path: path.to_owned() });
    }
    let (bytes, limit) = (format.size(expansion), limit.min(format.most()));
    if bytes > limit {
        return Err(ExpandError::TooLarge { path: path.to_owned(), triangles, bytes, limit });
    }
    let mut stopped = false;
    let mut done = 0_u64;
    let mut tell = || {
        done += 1;
        // Every few thousand triangles is often enough.
        if done.is_multiple_of(4096) && progress(done as f32 / triangles as f32).is_break() {
            stopped = true;
            return Err(io::Error::from(io::ErrorKind::Interrupted));
        }
        Ok(())
    };
    let written = replace(path, |file| match format {
        ModelFormat::Glb => glb::write(expansion, file, &mut tell),
        ModelFormat::Obj => obj::write(expansion, file, &mut tell),
        ModelFormat::Ply => ply::write(expansion, file, &mut tell),
    });
    if stopped { Err(ExpandError::Stopped { path: path.to_owned() }) } else { Ok(written?) }
}

/// Writes every triangle of the parts that have any with `write`.
fn each(
    expansion: &Expansion,
    part: usize,
    file: &mut dyn Write,
    tell: &mut dyn FnMut() -> io::Result<()>,
    write: &mut dyn FnMut(&mut dyn Write, &Carried) -> io::Result<()>,
) -> io::Result<()> {
    expansion.visit(part, |triangle| {
        write(file, triangle)?;
        tell()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_for_people() {
        let shown = [0, 1023, 1024, 10 << 20, (1 << 30) + (1 << 29), 1 << 42].map(|n| Bytes(n).to_string());
        assert_eq!(shown, ["0 bytes", "1023 bytes", "1.00 KiB", "10.0 MiB", "1.50 GiB", "4.00 TiB"]);
    }
}
