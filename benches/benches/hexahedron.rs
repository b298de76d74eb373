//! A ray against a whole box: met, missed, and met from inside.

mod boxes;

use std::hint::black_box;

use boxes::{COUNT, KINDS, Random};
use criterion::{Criterion, criterion_group, criterion_main};
use pelage::geom::Hexahedron;

fn passages(c: &mut Criterion) {
    let mut group = c.benchmark_group("hexahedron");
    for (kind, make) in KINDS {
        for shape in ["cuboid", "prism"] {
            let mut random = Random(4);
            let inputs: Vec<_> = (0..COUNT)
                .map(|_| {
                    let map = make(&mut random);
                    let [a, b, c, _, e, f, g, _] = map.corners;
                    let hexahedron = match shape {
                        "cuboid" => Hexahedron::cuboid(map),
                        _ => Hexahedron::prism([a, b, c], [e, f, g]),
                    };
                    let inside = hexahedron.map().point(0.5 * random.inside());
                    let [lo, hi] = hexahedron.bounds();
                    // On the bounds' surface, as a BVH's candidates are: many of them miss.
                    let near = lo + (hi - lo) * random.inside().with_z(1.0);
                    (hexahedron, random.ray_through(inside), random.ray_through(near))
                })
                .collect();
            let mut at = inputs.iter().cycle();
            let mut next = || at.next().unwrap_or(&inputs[0]);
            group.bench_function(format!("met/{shape}/{kind}"), |b| {
                b.iter(|| {
                    let (hexahedron, ray, _) = next();
                    black_box(hexahedron.passages(ray, 0.0, f64::INFINITY))
                });
            });
            group.bench_function(format!("candidate/{shape}/{kind}"), |b| {
                b.iter(|| {
                    let (hexahedron, _, ray) = next();
                    black_box(hexahedron.passages(ray, 0.0, f64::INFINITY))
                });
            });
            group.bench_function(format!("from inside/{shape}/{kind}"), |b| {
                b.iter(|| {
                    let (hexahedron, ray, _) = next();
                    black_box(hexahedron.passages(ray, 4.0, f64::INFINITY))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, passages);
criterion_main!(benches);
