//! The table of fidelity: how much light white coats send, over what their geometry sends.
//!
//! For each content, skin, elevation of the eye and width of a box in pixels it prints the cone picture's mean alpha
//! over the reference's, and, under a sun from the side, 13° from the view and behind, the mean radiance over the
//! reference's, in brackets the excess over that of the light from the side, and the root mean square difference of
//! the pixels over the same.
//!
//! `cargo run --release -p pelage-tests --example fidelity`, with these environment variables:
//!
//! | variable | default | meaning |
//! |---|---|---|
//! | `NAMES` | `sheet,leaves,grass,fur` | contents |
//! | `SKINS` | `flat,bent` | skins |
//! | `WIDTHS` | `256,64,22,8,3,1` | pixels a box |
//! | `DEPTH` | `7` | depth of the texels |
//! | `SAMPLES` | `32` | samples a pixel of the reference |
//! | `LEVEL` | | always this level |
//! | `LIT` | that of the settings | voxels lit on their own a pixel |
//! | `SHADOWS` | `1` | 0: no shadows |
//! | `SKY` | `0` | 1: an even white sky in place of the suns |

use std::env;
use std::str::FromStr;
use std::time::Instant;

use pelage::geom::glam::Vec3;
use pelage::tracer::reference::Lighting;
use pelage::tracer::{Environment, Lod, Settings};
use pelage_tests::stage::{Content, Shot, bent, coat, flat, judge, suns};
use pelage_tests::texel;

/// A variable's value, or what stands for it.
fn option<T: FromStr>(name: &str) -> Option<T> {
    let text = env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text}: it cannot be read")))
}

fn list(name: &str, default: &str) -> Vec<String> {
    let text = option::<String>(name).unwrap_or_else(|| default.into());
    text.split(',').map(str::to_owned).collect()
}

fn main() {
    let contents = list("NAMES", "sheet,leaves,grass,fur");
    let widths = list("WIDTHS", "256,64,22,8,3,1");
    let skins = list("SKINS", "flat,bent");
    let samples = option("SAMPLES").unwrap_or(32);
    let settings = Settings {
        lod: option("LEVEL").map_or_else(Lod::default, Lod::Level),
        lit_voxels: option("LIT").unwrap_or(Settings::default().lit_voxels),
        shadows: option("SHADOWS") != Some(0),
        ..Settings::default()
    };
    let sky = Lighting { lights: vec![], environment: Environment::uniform(Vec3::ONE) };
    for name in &contents {
        let content = Content::ALL.into_iter().find(|c| format!("{c:?}").eq_ignore_ascii_case(name));
        let content = content.unwrap_or_else(|| panic!("NAMES: there is no content `{name}`"));
        let start = Instant::now();
        let texel = texel(&content.geometry(), option("DEPTH").unwrap_or(7), true);
        println!(
            "{name}: built in {:.1} s, {:.1} MB",
            start.elapsed().as_secs_f32(),
            texel.memory() as f32 / 1e6
        );
        for name_of_skin in &skins {
            let skin = if name_of_skin == "flat" { flat() } else { bent() };
            let mut scene = coat(skin, texel.clone());
            for elevation in [25.0, 60.0] {
                let lightings =
                    if option("SKY") == Some(1) { vec![sky.clone()] } else { suns(elevation).into() };
                for width in &widths {
                    let pixels = width.parse().unwrap_or_else(|_| panic!("WIDTHS: `{width}` is no number"));
                    let shot = Shot::new(elevation, pixels, if pixels > 100.0 { 80 } else { 56 });
                    let outcomes = judge(&mut scene, &shot, &lightings, &settings, samples);
                    print!("{name:>6} {name_of_skin} from {elevation}°, box {width:>3} px:");
                    print!(" alpha {:.3}, energy", outcomes[0].alpha);
                    for o in outcomes {
                        print!("  {:.3} ({:+.3}) ±{:.3}", o.energy, o.excess, o.rmse);
                    }
                    println!();
                }
            }
        }
    }
}
