//! The `pelage` program from outside: exit codes, messages, files. A file for each subcommand.

mod bench;
mod check;
mod compare;
mod folder;
mod gltf;
mod render;
mod schema;
mod texel_bake;
mod texel_file;
mod texel_grow;
mod validate;
