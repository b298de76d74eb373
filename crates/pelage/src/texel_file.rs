//! Texel files on disk. Their bytes are [`pelage_texel::file`]'s.

use std::io::Write;
use std::path::Path;

use pelage_texel::Texel;
use pelage_texel::file::{FileOptions, Limits, TexelFile};

use crate::error::Error;
use crate::import::{Fault, Files, ImportOptions, Place, extension};
use crate::output::{OutputError, check_place, replace};

/// Reads a texel file and validates what it holds.
///
/// # Errors
/// The file cannot be read, or holds no sound texel.
pub fn read_texel(path: &Path) -> Result<TexelFile, Error> {
    let files = Files::around(path, &[], ImportOptions::default().limits)?;
    let bytes = files.read(path).map_err(|fault| fault.at(path, Place::File))?;
    let file = TexelFile::read(&bytes[..], &Limits::default());
    file.map_err(|source| Error::TexelFile { path: path.to_owned(), source })
}

/// Whether a texel file of this name could be created: for asking before a long bake.
///
/// # Errors
/// Another extension than `.texel`, a folder of that name, or a folder that cannot be written to.
pub fn check_texel(path: &Path) -> Result<(), Error> {
    if extension(path) != "texel" {
        return Err(Fault::Extension { expected: ".texel" }.at(path, Place::File).into());
    }
    Ok(check_place(path)?)
}

/// Writes a texel file: it appears whole or not at all.
///
/// # Errors
/// A texel or options out of their domain; what the system says, and a file of that name is then what it was before.
pub fn write_texel(texel: &Texel, path: &Path, options: &FileOptions) -> Result<(), Error> {
    let mut bytes = Vec::new();
    let encoded = texel.write(&mut bytes, options);
    encoded.map_err(|source| Error::TexelFile { path: path.to_owned(), source })?;
    replace(path, |file| file.write_all(&bytes)).map_err(|error: OutputError| error.into())
}
