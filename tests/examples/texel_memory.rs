//! Bytes of texels, and what keeping their fine levels compact costs in a picture.
//!
//!     cargo run --release -p pelage-tests --example texel_memory -- 7 fur:long grass:meadow
//!
//! builds each kind at level 7 (128³) and prints bytes by occupied voxel of the finest level, all levels together, as measured and compact, in memory and
//! in a file without its source, and the RMSE of pictures of both (linear radiance), with 8 lit voxels a pixel and with 100.

use std::error::Error;
use std::ops::ControlFlow::Continue;
use std::sync::Arc;

use pelage::prelude::*;
use pelage::scene_file::TexelEntry;
use pelage::texel::file::FileOptions;
use pelage::texel::{Texel, build_exact};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let depth = args.next().ok_or("a depth and kinds, as in `7 fur:long grass:meadow`")?.parse()?;
    println!("kind             finest voxels   memory           file             pixels  RMSE 8    RMSE 100");
    for word in args {
        let TexelEntry::Grown { kind, .. } = TexelEntry::from_word(&word)? else {
            return Err("a kind is needed, not a file".into());
        };
        let options = BuildOptions { depth, ..BuildOptions::standard() };
        let exact = build_exact(&word, kind, &options, &|_| ())?.without_source();
        let compact = exact.clone().compacted();
        let finest = exact.level(depth).len().max(1);
        let each = |bytes: usize| bytes as f64 / finest as f64;
        let sizes = [&exact, &compact].map(|texel| -> Result<_, Box<dyn Error>> {
            let mut file = Vec::new();
            texel.write(&mut file, &FileOptions::default())?;
            Ok([each(texel.memory()), each(file.len())])
        });
        let [before, after] = sizes;
        let ([memory, file], [less_memory, less_file]) = (before?, after?);
        print!(
            "{word:<16} {finest:>13}   {memory:>5.1} → {less_memory:>5.1}    {file:>5.1} → {less_file:>5.1}"
        );
        let texels = [Arc::new(exact), Arc::new(compact)];
        for pixels in [0.7, 2.0] {
            let [few, many] = [8, 100].map(|lit| difference(&texels, pixels, lit));
            print!("    {pixels}     {:.5}   {:.5}", few?, many?);
        }
        println!();
    }
    Ok(())
}

/// RMSE between pictures of the two, a voxel of the finest level as wide as so many pixels.
fn difference(texels: &[Arc<Texel>; 2], pixels: f32, lit_voxels: u32) -> Result<f32, Box<dyn Error>> {
    const SIDE: u32 = 100;
    let draw = |texel: &Arc<Texel>| -> Result<Film, Box<dyn Error>> {
        let mesh = surface::plane(1.0, 1, 1);
        let skin = extrude(&mesh, &|_| true, &SkinOptions { tiling: Some(1.0), ..SkinOptions::new(1.0) })?;
        let coats = vec![Coat { skin, texels: texel.clone().into(), tint: Vec3::ONE, wears_material: false }];
        let (lights, environment) = (vec![staging::sun()], staging::sky());
        let (meshes, materials, textures) = (vec![mesh], vec![Material::default()], vec![]);
        let scene = Scene::new(Description { meshes, coats, materials, textures, lights, environment })?;
        // So much of the box is seen, from a distance of 10, that a voxel has its size.
        let edge = 0.5_f32.powi(texel.depth() as i32);
        let width = (SIDE as f32 / pixels * edge).min(1.0);
        let target = Vec3::new(0.0, 0.5, 0.0);
        let eye = target + 10.0 * Vec3::new(0.3, 0.6, 1.0).normalize();
        let camera = Camera::look_at(eye, target, Vec3::Y, 2.0 * (0.05 * width).atan());
        let settings = Settings { size: [SIDE; 2], lit_voxels, ..Settings::default() };
        Ok(render(&scene, &camera, &settings, &|_| Continue(()))?)
    };
    let [a, b] = [draw(&texels[0])?, draw(&texels[1])?];
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a.color - b.color).length_squared() / 3.0);
    Ok((squares.sum::<f32>() / a.pixels.len() as f32).sqrt())
}
