//! Fur and other volumetric textures on any mesh, rendered by a multithreaded CPU cone tracer.
//!
//! From a mesh in memory to a picture in memory, with no file, no printing and no threads but the caller's:
//!
//! ```
//! use pelage::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = surface::cube_sphere(1.0, 4);
//! let skin = extrude(&mesh, &|_face| true, &SkinOptions::new(0.2))?;
//! let fur = Fur { count: 2000, ..Fur::short() };
//! let texel = build("fur", fur, &BuildOptions { depth: 4, ..BuildOptions::preview() }, &|_| {})?;
//! let coats = vec![Coat { skin, texels: texel.into(), tint: Vec3::new(1.0, 0.6, 0.3), wears_material: false }];
//! let (lights, environment) = (vec![staging::sun()], staging::sky());
//! let materials = vec![Material::default()];
//! let scene = Scene::new(Description { meshes: vec![mesh], coats, materials, textures: vec![], lights, environment })?;
//! let camera = staging::camera(scene.bounds().unwrap_or_default(), &View::default(), 1.0);
//! let film = render(&scene, &camera, &Settings { size: [32, 32], ..Settings::default() }, &|_| Continue(()))?;
//! # assert!(film.get(16, 16).is_some_and(|pixel| pixel.alpha > 0.99 && pixel.color.x > pixel.color.z));
//! # assert!(film.get(0, 0).is_some_and(|pixel| pixel.alpha < 0.5));
//! # Ok(())
//! # }
//! ```
//!
//! From files to a file:
//!
//! ```no_run
//! use std::{ops::ControlFlow::Continue, path::Path};
//! use pelage::{compile::Loaded, output::check_output, scene_file::SceneFile};
//! # fn main() -> Result<(), pelage::Error> {
//! let picture = Path::new("fluff.png");
//! let format = check_output(picture)?;
//! let loaded = Loaded::new(SceneFile::open(Path::new("fluff.toml"))?)?;
//! let (texels, skins) = (loaded.bake(&|_| {})?, loaded.extrude()?);
//! let prepared = loaded.compile(&texels, skins)?;
//! let film = prepared.render(&|_| Continue(()))?;
//! prepared.write(&film, picture, format)?;
//! # Ok(())
//! # }
//! ```
//!
//! # The rooms
//!
//! | | |
//! |---|---|
//! | [`import`] | OBJ and glTF files to meshes, materials, cameras and lights |
//! | [`bake`] | models become the content of texels |
//! | [`scene_file`], [`choices`] | the description of a scene: TOML files and flags |
//! | [`compile`] | a description becomes a scene, stage by stage |
//! | [`check`] | everything that is wrong with a scene at once |
//! | [`staging`] | camera, light and exposure where there are none |
//! | [`compose`], [`output`] | a background behind the film; PNG and EXR files |
//! | [`texel_file`], [`contact_sheet`] | texels to and from files; a picture of one from all sides, at every level |
//! | [`expand`] | a scene as explicit triangles: glTF, OBJ and PLY files |
//! | [`outline`] | the boxes of skins as lines |
//! | [`geom`], [`skin`], [`texel`], [`tracer`] | the crates that do the work, re-exported |
//!
//! Nothing here prints, exits, or panics on input. Every error says which file, where in it, and why, in one line;
//! [`Error::blame`] sorts them.
#![warn(missing_docs)]

pub mod bake;
mod build;
pub mod check;
pub mod choices;
pub mod compile;
pub mod compose;
pub mod contact_sheet;
mod error;
pub mod expand;
pub mod import;
mod names;
pub mod outline;
pub mod output;
pub mod scene_file;
pub mod schema;
pub mod staging;
pub mod texel_file;

pub use pelage_geom as geom;
pub use pelage_skin as skin;
pub use pelage_texel as texel;
pub use pelage_tracer as tracer;

pub use build::build;
pub use error::{Blame, Error, Field, FieldError, Span};

/// The names that a program which renders from memory needs.
pub mod prelude {
    pub use std::ops::ControlFlow::{Break, Continue};

    pub use pelage_geom::glam::{Vec2, Vec3};
    pub use pelage_geom::{Face, Material, MaterialId, Mesh, Texture, TextureId};
    pub use pelage_skin::{SkinOptions, extrude, surface};
    pub use pelage_texel::{BuildOptions, Fur, Geometry, Grass, Leaves, Procedure};
    pub use pelage_tracer::{Camera, Coat, Description, Environment, Film, Light, Scene, Settings, render};

    pub use crate::build;
    pub use crate::staging::{self, View};
}
