//! A ray against one bilinear wall: shared faces, walls inside a box, and the paper's nested Newton beside them.

mod boxes;

use std::hint::black_box;

use boxes::{COUNT, KINDS, Random};
use criterion::{Criterion, criterion_group, criterion_main};
use pelage::geom::{DTrilinear, RaySpace, paper, wall_hits};

fn walls(c: &mut Criterion) {
    let mut group = c.benchmark_group("wall");
    for (kind, make) in KINDS {
        let mut random = Random(3);
        let inputs: Vec<_> = (0..COUNT)
            .map(|i| {
                let map = DTrilinear::from(make(&mut random));
                let target = map.point(random.inside());
                let ray = random.ray_through(target);
                (map, ray, RaySpace::new(&map, &ray), i % 3, random.unit())
            })
            .collect();
        let mut at = inputs.iter().cycle();
        let mut next = || at.next().unwrap_or(&inputs[0]);
        group.bench_function(format!("shared/{kind}"), |b| {
            b.iter(|| {
                let (map, ray, ..) = next();
                let [p00, p10, p01, p11, ..] = map.corners;
                black_box(wall_hits(ray, [p00, p10, p01, p11]))
            });
        });
        group.bench_function(format!("inside/{kind}"), |b| {
            b.iter(|| {
                let (_, _, space, axis, at) = next();
                black_box(space.wall(*axis, *at))
            });
        });
        group.bench_function(format!("ray space/{kind}"), |b| {
            b.iter(|| {
                let (map, ray, ..) = next();
                black_box(RaySpace::new(map, ray))
            });
        });
        group.bench_function(format!("paper/{kind}"), |b| {
            b.iter(|| {
                let (map, ray, _, axis, at) = next();
                black_box(paper::reach_wall(map, *axis, *at, ray, 4.0, 1e-9, 32))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, walls);
criterion_main!(benches);
