//! Bytes of texels, and what keeping their fine levels compact costs in a picture.
//!
//!     cargo run --release -p pelage-tests --example texel_memory -- 7 fur:long grass:meadow model.obj
//!
//! builds each kind or model at level 7 (128³) and prints, as measured → compact, bytes by occupied voxel of the finest level, all levels together, in
//! memory and in a file without its source; and for a voxel of .7 and of 2 pixels the RMSE of pictures (linear radiance): *set*, compact against
//! measured with the default settings; *all*, the same with 16 rays a pixel and all their voxels lit, where neither rays nor the choice of voxels are
//! drawn anew; *noise*, what the default settings leave out, both pictures of the texel as it was measured.

use std::error::Error;
use std::ops::ControlFlow::Continue;
use std::path::Path;
use std::sync::Arc;

use pelage::bake::{ContentOptions, content, read};
use pelage::prelude::*;
use pelage::scene_file::TexelEntry;
use pelage::texel::file::FileOptions;
use pelage::texel::{Texel, build_exact};
use pelage::tracer::Rays;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let depth = args.next().ok_or("a depth and kinds, as in `7 fur:long grass:meadow`")?.parse()?;
    println!(
        "kind             finest voxels   memory           file             pixels  set      all      noise"
    );
    for word in args {
        let exact = measured(&word, depth)?.without_source();
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
        let name = Path::new(&word).file_stem().unwrap_or_default().to_string_lossy();
        print!(
            "{name:<16} {finest:>13}   {memory:>5.1} → {less_memory:>5.1}    {file:>5.1} → {less_file:>5.1}"
        );
        let texels = [Arc::new(exact), Arc::new(compact)];
        for pixels in [0.7, 2.0] {
            let few = Settings { size: [SIDE; 2], ..Settings::default() };
            let all = Settings { rays: Rays::Sixteen, lit_voxels: 1000, ..few };
            let [a, b, c, d] = [(0, few), (1, few), (0, all), (1, all)]
                .map(|(which, settings): (usize, _)| picture(&texels[which], pixels, &settings));
            let [a, b, c, d] = [a?, b?, c?, d?];
            print!("    {pixels}     {:.5}  {:.5}  {:.5}", rmse(&a, &b), rmse(&c, &d), rmse(&a, &c));
        }
        println!();
    }
    Ok(())
}

/// The texel of a kind, or of a model in a file, as it is measured.
fn measured(word: &str, depth: u32) -> Result<Texel, Box<dyn Error>> {
    let options = BuildOptions { depth, ..BuildOptions::standard() };
    let path = Path::new(word);
    if path.extension().is_some() {
        let cut = ContentOptions { resolution: 1 << depth, ..ContentOptions::default() };
        let content = content(path, &read(path)?, &cut, &|_| ())?;
        return Ok(build_exact(
            word,
            content.geometry,
            &BuildOptions { periodic: false, ..options },
            &|_| (),
        )?);
    }
    let TexelEntry::Grown { kind, .. } = TexelEntry::from_word(word)? else {
        return Err("a kind is needed, or a model".into());
    };
    Ok(build_exact(word, kind, &options, &|_| ())?)
}

/// Pixels along each side of a picture.
const SIDE: u32 = 100;

/// A picture in which a voxel of the finest level is as wide as so many pixels.
fn picture(texel: &Arc<Texel>, pixels: f32, settings: &Settings) -> Result<Film, Box<dyn Error>> {
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
    Ok(render(&scene, &camera, settings, &|_| Continue(()))?)
}

fn rmse(a: &Film, b: &Film) -> f32 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a.color - b.color).length_squared() / 3.0);
    (squares.sum::<f32>() / a.pixels.len() as f32).sqrt()
}
