//! What the tolerance of the curved path costs, in alpha and in time.
//!
//!     cargo run --release -p pelage-tests --example tolerance -- scene.toml
//!
//! renders a scene without light at several tolerances (voxels) and prints, against a hundredth of a voxel: how much more of
//! the picture is covered, the mean difference of alpha as a part of the mean, and the seconds. Alpha says nothing of a coat before a ground that is seen: `visible = false` takes that away.

use std::error::Error;
use std::ops::ControlFlow::Continue;
use std::path::Path;

use pelage::compile::Loaded;
use pelage::scene_file::SceneFile;
use pelage::tracer::{Film, Settings, render};
use pelage_tests::mean_alpha;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("a scene file")?;
    let loaded = Loaded::new(SceneFile::open(Path::new(&file))?)?;
    let (texels, skins) = (loaded.bake(&|_| ())?, loaded.extrude()?);
    let prepared = loaded.compile(&texels, skins)?;
    let picture = |path_tolerance: f32| {
        let settings = Settings { path_tolerance, shadows: false, ..prepared.settings };
        render(&prepared.scene, &prepared.camera, &settings, &|_| Continue(()))
    };
    let exact = picture(0.01)?;
    let difference = |film: &Film| {
        let sum: f32 = film.pixels.iter().zip(&exact.pixels).map(|(a, b)| (a.alpha - b.alpha).abs()).sum();
        sum / film.pixels.len() as f32 / mean_alpha(&exact)
    };
    println!("tolerance   more covered   mean difference   seconds");
    for tolerance in [0.02, 0.05, 0.1, 0.25] {
        let begun = std::time::Instant::now();
        let film = picture(tolerance)?;
        let seconds = begun.elapsed().as_secs_f32();
        let more = mean_alpha(&film) / mean_alpha(&exact) - 1.0;
        println!(
            "{tolerance:9}   {:+10.3} %   {:13.3} %   {seconds:5.2}",
            100.0 * more,
            100.0 * difference(&film)
        );
    }
    Ok(())
}
