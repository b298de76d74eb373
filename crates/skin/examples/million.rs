//! A million boxes tessellated, groomed and certified: `cargo run --release -p pelage-skin --example million`.
//!
//! Prints the seconds of each stage, and the peak of the memory where the system tells it.

use std::time::Instant;

use pelage_geom::glam::Vec3;
use pelage_skin::groom::{
    Clump, Comb, Field, GroomOptions, Mask, Noise, Operation, Region, Smooth, Step, groom,
};
use pelage_skin::{Folds, Mending, Motion, SkinError, SkinOptions, extrude, surface};

fn main() -> Result<(), SkinError> {
    let begin = Instant::now();
    let mut last = begin;
    let mut tell = |stage: &str| {
        println!("{stage:12} {:.2} s", last.elapsed().as_secs_f64());
        last = Instant::now();
    };
    let torus = surface::torus(1.0, 0.4, 1600, 625);
    tell("tessellate");
    let options = SkinOptions { folds: Folds::Keep, ..SkinOptions::new(0.02) };
    let skin = extrude(&torus, &|_face| true, &options)?;
    tell("extrude");
    let region = Region::Sphere { centre: Vec3::X, radius: 0.3, falloff: 0.3 };
    let steps = [
        Step::everywhere(Operation::Comb(Comb { along: Field::Vector(Vec3::NEG_Y), angle: 50.0 })),
        Step { operation: Operation::Scale(0.4), masks: vec![Mask::new(region)] },
        Step::everywhere(Operation::Noise(Noise { height: 0.3, tilt: 20.0, size: 0.05, seed: 1 })),
        Step::everywhere(Operation::Clump(Clump { size: 0.03, amount: 0.3, seed: 2 })),
        Step::everywhere(Operation::Smooth(Smooth { steps: 2, amount: 0.5 })),
    ];
    let mut skin = groom(&skin, &steps, &GroomOptions::default())?.skin;
    tell("groom");
    skin.validate(6)?;
    tell("certify");
    let vectors: Vec<Vec3> = skin.top.iter().zip(&skin.base).map(|(t, b)| 0.9 * (*t - *b)).collect();
    skin.update(Motion::Vectors(&vectors), &Mending::default())?;
    tell("update");
    println!("{:12} {:.2} s for {} boxes: {}", "all", begin.elapsed().as_secs_f64(), skin.len(), skin.report);
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        status.lines().filter(|line| line.starts_with("VmHWM")).for_each(|line| println!("{line}"));
    }
    Ok(())
}
