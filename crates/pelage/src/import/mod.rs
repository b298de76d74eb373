//! Meshes, materials, textures, cameras and lights from files. \[glTF\] \[OBJ\]
//!
//! Files come from strangers: every number is checked before it is used, every reference stays under the folder
//! of the file that makes it, and every cap is named in the error that it causes.

mod error;
mod files;
mod gltf;
mod image;
mod obj;
mod strand;
mod weld;

use std::path::{Path, PathBuf};

use pelage_geom::{Material, Mesh, Texture};
use pelage_tracer::{Camera, Light};

pub use error::{Fault, ImportError, Place, Warning};
pub(crate) use files::{Files, extension};
pub(crate) use gltf::text as gltf_text;
pub(crate) use image::Textures;
pub use image::srgb_to_linear;
pub use strand::Strand;

/// Which axis points upwards in a file that does not say (OBJ).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// +Y, as in glTF.
    #[default]
    Y,
    /// +Z.
    Z,
}

/// Caps on what a file may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of any one file.
    pub file_bytes: u64,
    /// Pixels of any one image.
    pub image_pixels: u64,
    /// Pixels of all images together.
    pub total_pixels: u64,
    /// Nodes of a glTF scene.
    pub nodes: u64,
    /// Depth of the tree of nodes.
    pub depth: u64,
    /// Faces of all meshes together, instances counted each.
    pub faces: u64,
    /// Numbers read from the accessors of a glTF file, each time that they are read.
    pub numbers: u64,
}

impl Default for Limits {
    /// 1 GiB a file, 64 Mpx an image and 256 Mpx together, 10⁶ nodes 1024 deep, 8·10⁶ faces, 2²⁷ numbers.
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            image_pixels: 64 << 20,
            total_pixels: 256 << 20,
            nodes: 1_000_000,
            depth: 1024,
            faces: 8_000_000,
            numbers: 1 << 27,
        }
    }
}

/// How files are read.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// The vertical axis of an OBJ file.
    pub up: Up,
    /// Metres in one unit of the file; positive.
    pub unit: f32,
    /// Folders, besides the file's own, that references may lead to.
    pub allow_dirs: Vec<PathBuf>,
    /// Whether to read as well what only texels are made from: lines, vertex colours, and alpha textures.
    pub content: bool,
    /// Caps on what a file may ask for.
    pub limits: Limits,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { up: Up::Y, unit: 1.0, allow_dirs: Vec::new(), content: false, limits: Limits::default() }
    }
}

/// What a file holds, in scene space: metres, +Y up, linear colours.
#[derive(Clone, Debug, Default)]
pub struct Imported {
    /// Validated meshes with at least one face; vertices at equal positions are one vertex.
    pub meshes: Vec<Mesh>,
    /// Curves with a thickness, where [`ImportOptions::content`] asks for them.
    pub strands: Vec<Strand>,
    /// What the faces' and the strands' [`pelage_geom::MaterialId`]s index.
    pub materials: Vec<Material>,
    /// What the materials' [`pelage_geom::TextureId`]s index.
    pub textures: Vec<Texture>,
    /// Cameras by name; the name may be empty.
    pub cameras: Vec<(String, Camera)>,
    /// Lights with a place or a direction.
    pub lights: Vec<Light>,
    /// What was left out, and where.
    pub warnings: Vec<Warning>,
}

impl Imported {
    /// The smallest and largest coordinates of all meshes, or `None` without any; strands do not count.
    pub fn bounds(&self) -> Option<[glam::Vec3; 2]> {
        self.meshes
            .iter()
            .filter_map(Mesh::bounds)
            .reduce(|[lo, hi], [other_lo, other_hi]| [lo.min(other_lo), hi.max(other_hi)])
    }

    /// Adds what another file holds, its indices moved behind this one's.
    pub fn append(&mut self, mut other: Self) {
        let (materials, textures) = (self.materials.len() as u32, self.textures.len() as u32);
        for face in other.meshes.iter_mut().flat_map(|m| &mut m.faces) {
            face.material.0 += materials;
        }
        for strand in &mut other.strands {
            strand.material.0 += materials;
        }
        for material in &mut other.materials {
            let maps = [&mut material.base_color_texture, &mut material.alpha.texture];
            for texture in maps.into_iter().flatten() {
                texture.0 += textures;
            }
        }
        self.meshes.append(&mut other.meshes);
        self.strands.append(&mut other.strands);
        self.materials.append(&mut other.materials);
        self.textures.append(&mut other.textures);
        self.cameras.append(&mut other.cameras);
        self.lights.append(&mut other.lights);
        self.warnings.append(&mut other.warnings);
    }
}

/// Reads a `.obj`, `.gltf` or `.glb` file.
///
/// What can be rendered without (a texture that is missing, a keyword that is not supported) is a [`Warning`];
/// geometry that cannot be read is an error.
///
/// # Errors
/// [`ImportError`] with the file, the line, byte or field, and the reason.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let files = Files::around(path, &options.allow_dirs, options.limits)?;
    let imported = match extension(path).as_str() {
        "obj" => obj::read(path, &files, options)?,
        "gltf" | "glb" => gltf::read(path, &files, options)?,
        _ => {
            return Err(Fault::Extension { expected: ".obj, .gltf or .glb" }.at(path, Place::File));
        }
    };
    if imported.meshes.is_empty() && imported.strands.is_empty() {
        return Err(Fault::NoFaces.at(path, Place::File));
    }
    for mesh in &imported.meshes {
        mesh.validate().map_err(|e| Fault::Mesh(e).at(path, Place::File))?;
    }
    Ok(imported)
}
