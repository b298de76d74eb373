//! A skin of 4096 boxes: made, certified, groomed, and moved as an animation or an interactive groomer would.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use glam::Vec3;
use pelage::skin::groom::{Comb, Field, GroomOptions, Operation, Step, groom};
use pelage::skin::{Layout, Mending, Motion, Skin, SkinOptions, extrude, surface};

const DEPTH: u32 = 6;

fn torus(layout: Layout) -> Option<Skin> {
    let options = SkinOptions { layout, ..SkinOptions::new(0.05) };
    extrude(&surface::torus(1.0, 0.4, 128, 32), &|_face| true, &options).ok()
}

fn make(c: &mut Criterion) {
    let mut group = c.benchmark_group("skin");
    group.bench_function("extrude", |b| b.iter(|| torus(Layout::Uv)));
    group.sample_size(10).bench_function("lay out conformally", |b| b.iter(|| torus(Layout::Conformal)));
}

fn change(c: &mut Criterion) {
    let Some(skin) = torus(Layout::Uv) else { return };
    let mut group = c.benchmark_group("skin");
    group.bench_function("certify", |b| b.iter(|| black_box(&skin).validate(DEPTH).is_ok()));
    let comb = Step::everywhere(Operation::Comb(Comb { along: Field::Vector(Vec3::NEG_Y), angle: 50.0 }));
    let (steps, options) = ([comb], GroomOptions::default());
    group.bench_function("comb", |b| b.iter(|| groom(black_box(&skin), &steps, &options).is_ok()));

    let vectors: Vec<Vec3> = skin.top.iter().zip(&skin.base).map(|(t, b)| 0.8 * (*t - *b)).collect();
    let moved: Vec<Vec3> = skin.base.iter().map(|p| *p + 0.1 * (3.0 * p.x).sin() * Vec3::Y).collect();
    for (name, motion) in [
        ("update vectors", Motion::Vectors(&vectors)),
        ("update surface", Motion::Surface(&moved)),
        ("update both", Motion::Both { base: &moved, vectors: &vectors }),
    ] {
        group.bench_function(name, |b| {
            let update = |skin: &mut Skin| skin.update(motion, &Mending::default()).is_ok();
            b.iter_batched_ref(|| skin.clone(), update, BatchSize::SmallInput);
        });
    }
}

criterion_group!(benches, make, change);
criterion_main!(benches);
