//! Ellipsoids of normals: projected area, carrying them through a Jacobian, sampling what is seen.

mod boxes;

use std::hint::black_box;

use boxes::{COUNT, KINDS, Random};
use criterion::{Criterion, criterion_group, criterion_main};
use pelage::geom::glam::DVec3;
use pelage::geom::{Ellipsoid, Footprint, texel_footprint};

fn ellipsoids(c: &mut Criterion) {
    let mut group = c.benchmark_group("ellipsoid");
    let mut random = Random(5);
    let inputs: Vec<_> = (0..COUNT)
        .map(|i| {
            let axis = random.direction().as_vec3();
            let ellipsoid = match i % 3 {
                0 => Ellipsoid::needle(axis),
                1 => Ellipsoid::flake(axis),
                _ => Ellipsoid::isotropic(),
            };
            let (_, make) = KINDS[i % 2];
            let jacobian = make(&mut random).jacobian(random.inside().as_vec3());
            (ellipsoid, random.direction().as_vec3(), [random.unit() as f32, random.unit() as f32], jacobian)
        })
        .collect();
    let mut at = inputs.iter().cycle();
    let mut next = || at.next().unwrap_or(&inputs[0]);
    group.bench_function("projected area", |b| {
        b.iter(|| {
            let (ellipsoid, w, ..) = next();
            black_box(ellipsoid.projected_area(*w))
        });
    });
    group.bench_function("push", |b| {
        b.iter(|| {
            let (ellipsoid, .., jacobian) = next();
            black_box(ellipsoid.push(jacobian))
        });
    });
    group.bench_function("sample visible", |b| {
        b.iter(|| {
            let (ellipsoid, w, x, _) = next();
            black_box(ellipsoid.sample_visible(*w, *x))
        });
    });
    group.bench_function("sample visible, 16 of one", |b| {
        b.iter(|| {
            let (ellipsoid, w, x, _) = next();
            let visible = ellipsoid.visible(*w);
            let sum: DVec3 = (0..16).map(|i| visible.sample([x[0], i as f32 / 16.0]).as_dvec3()).sum();
            black_box(sum)
        });
    });
    group.bench_function("eigen", |b| {
        b.iter(|| {
            let (ellipsoid, ..) = next();
            black_box(ellipsoid.0.eigen())
        });
    });
    group.bench_function("footprint", |b| {
        b.iter(|| {
            let (_, w, _, jacobian) = next();
            black_box(texel_footprint(Footprint::Auto, jacobian, *w, 0.01))
        });
    });
    group.finish();
}

criterion_group!(benches, ellipsoids);
criterion_main!(benches);
