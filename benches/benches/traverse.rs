//! `pelage_texel::traverse`: what a ray, and a cell of it, costs on fur.
//!
//! Throughput is in occupied cells; the time itself is that of all the rays.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use pelage::texel::{BuildOptions, Fur, Level, build};

/// Rays over the tile's top, all the way down.
fn rays(level: &Level, across: Vec3) -> Vec<[Vec3; 2]> {
    const SIDE: u32 = 32;
    let scale = level.resolution() as f32;
    let start =
        |i: u32| Vec3::new((i % SIDE) as f32 + 0.37, (i / SIDE) as f32 + 0.71, SIDE as f32) / SIDE as f32;
    (0..SIDE * SIDE).map(|i| [start(i) * scale, (start(i) + across) * scale]).collect()
}

fn traverse(criterion: &mut Criterion) {
    let options = BuildOptions { depth: 7, fine_rays: 4, coarse_rays: 4, ..BuildOptions::standard() };
    let texel = match build("fur", Fur::long(), &options, &|_| ()) {
        Ok(texel) => texel,
        Err(error) => panic!("{error}"),
    };
    let mut group = criterion.benchmark_group("traverse");
    for l in [3, 5, 7] {
        let level = texel.level(l);
        for (name, across) in [("vertical", Vec3::NEG_Z), ("diagonal", Vec3::new(1.3, 0.7, -1.0))] {
            let rays = rays(level, across);
            let cells = rays.iter().map(|&[from, to]| level.walk(from, to).count() as u64).sum();
            group.throughput(Throughput::Elements(cells));
            group.bench_function(format!("{name}/level {l}"), |bencher| {
                bencher.iter(|| {
                    let walk =
                        |&[from, to]: &[Vec3; 2]| level.walk(from, to).map(|step| step.leave).sum::<f32>();
                    black_box(rays.iter().map(walk).sum::<f32>())
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, traverse);
criterion_main!(benches);
