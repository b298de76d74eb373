//! From scene points back to box coordinates, in both precisions, and the certificate of det J.

mod boxes;

use std::hint::black_box;

use boxes::{COUNT, KINDS, Random};
use criterion::{Criterion, criterion_group, criterion_main};
use pelage::geom::{DTrilinear, Hexahedron, certify, paper};

fn inverse(c: &mut Criterion) {
    let mut group = c.benchmark_group("inverse");
    for (kind, make) in KINDS {
        let mut random = Random(1);
        let inputs: Vec<_> = (0..COUNT)
            .map(|_| {
                let map = make(&mut random);
                let u = random.inside();
                (map, DTrilinear::from(map), map.point(u.as_vec3()), DTrilinear::from(map).point(u))
            })
            .collect();
        let mut at = inputs.iter().cycle();
        let mut next = || at.next().unwrap_or(&inputs[0]);
        group.bench_function(format!("f32/{kind}"), |b| {
            b.iter(|| {
                let (map, _, x, _) = next();
                black_box(map.inverse(*x, 1e-5))
            });
        });
        group.bench_function(format!("f64/{kind}"), |b| {
            b.iter(|| {
                let (_, map, _, x) = next();
                black_box(map.inverse(*x, 1e-9))
            });
        });
        group.bench_function(format!("paper/{kind}"), |b| {
            b.iter(|| {
                let (_, map, _, x) = next();
                black_box(paper::inv_t(map, *x, 1e-9, 32))
            });
        });
    }
    group.finish();
}

fn certificate(c: &mut Criterion) {
    let mut group = c.benchmark_group("certificate");
    for (kind, make) in KINDS {
        let mut random = Random(2);
        let maps: Vec<_> = (0..COUNT).map(|_| make(&mut random)).collect();
        let cuboids: Vec<_> = maps.iter().map(|&map| Hexahedron::cuboid(map)).collect();
        let prisms: Vec<_> = maps
            .iter()
            .map(|map| {
                let [a, b, c, _, e, f, g, _] = map.corners;
                Hexahedron::prism([a, b, c], [e, f, g])
            })
            .collect();
        for (shape, hexahedra) in [("cuboid", &cuboids), ("prism", &prisms)] {
            let mut at = hexahedra.iter().cycle();
            group.bench_function(format!("{shape}/{kind}"), |b| {
                b.iter(|| black_box(at.next().map(|hexahedron| certify(hexahedron, 6))));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, inverse, certificate);
criterion_main!(benches);
