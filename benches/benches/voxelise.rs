//! `pelage_texel::build` and the modules under it: a fur texel at two depths.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use pelage::texel::{BuildOptions, Fur, Procedure, build};

fn voxelise(criterion: &mut Criterion) {
    let geometry = Arc::new(Fur::long().geometry());
    let mut group = criterion.benchmark_group("voxelise");
    group.sample_size(10);
    for depth in [5, 6] {
        let options = BuildOptions { depth, ..BuildOptions::standard() };
        group.bench_function(format!("fur/depth {depth}"), |bencher| {
            bencher.iter(|| black_box(build("fur", geometry.clone(), &options, &|_| ())));
        });
    }
    group.finish();
}

criterion_group!(benches, voxelise);
criterion_main!(benches);
